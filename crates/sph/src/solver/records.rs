//! What every particle shows its neighbours (SPH sheet §3.3, step 3).

use colluvium_case::SolverError;
use colluvium_constitutive::SymTensor;
use rayon::prelude::*;

use super::{SphSolver, TASK};
use crate::config::{Continuity, Momentum, Symmetrisation, Tensile};
use crate::lanes::hide;
use crate::pairs::Pairs;
use crate::tensile::repulsion;

impl<const D: usize> SphSolver<D> {
    /// What every particle shows its neighbours, walls and images included; step 3.
    pub(crate) fn load_records(&mut self) {
        if self.options.continuity == Continuity::Summation {
            // Images need their masses.
            self.particles.load_images(&self.images);
            let mut density = std::mem::take(&mut self.particles.density);
            self.sum_densities(&mut density);
            self.particles.density = density;
        }
        self.interpolate_walls();
        let tensile = self.options.tensile;
        if tensile != Tensile::None {
            let p = &mut self.particles;
            p.repulsion.resize(p.position.len(), SymTensor::ZERO);
            let all = p.repulsion.par_iter_mut().zip(&p.stress).zip(&p.density);
            all.with_min_len(TASK).for_each(|((slot, stress), &density)| {
                if density > 0.0 {
                    *slot = repulsion::<D>(tensile, stress, density);
                }
            });
        }
        self.find_spread();
        self.particles.load_images(&self.images);
        self.particles.move_images(&self.images);
        let mut records = std::mem::take(&mut self.particles.records);
        let (p, momentum) = (&self.particles, self.options.momentum);
        // The lanes do not correct: they leave the stress to those who do.
        let scale = |i: usize| match momentum {
            Momentum::Corrected => 0.0,
            _ => Pairs::<D>::flux_scale(momentum, p.density[i], p.spread[i]),
        };
        records.par_iter_mut().enumerate().with_min_len(TASK).for_each(|(i, record)| {
            if p.density[i] > 0.0 {
                *record = p.record(i, scale(i));
            }
        });
        self.smooth.particles().for_each(|i| hide::<D>(&mut records[i]));
        self.particles.records = records;
        self.find_corrections();
    }

    /// `Σ m W` of every particle (BN 2).
    fn sum_densities(&self, density: &mut [f64]) {
        let (len, pairs) = (self.particles.len, self.pairs());
        density[..len].par_iter_mut().enumerate().with_min_len(TASK).for_each(|(i, density)| {
            *density = pairs.summed_density(i, self.neighbours.of(i));
        });
    }

    /// What summation would make of the densities as the particles stand now.
    pub(crate) fn summed_densities(&self) -> Result<Vec<f64>, SolverError> {
        let mut probe = self.probe()?;
        probe.particles.load_images(&probe.images);
        let mut density = vec![0.0; probe.particles.len];
        probe.sum_densities(&mut density);
        Ok(density)
    }

    /// Corrections of the gradient, for the momentum equation that has them.
    fn find_corrections(&mut self) {
        if self.options.momentum != Momentum::Corrected {
            return;
        }
        let mut correction = std::mem::take(&mut self.particles.correction);
        let len = self.particles.len;
        correction.resize(len + self.images.len(), [[0.0; D]; D]);
        let pairs = self.pairs();
        correction[..len].par_iter_mut().enumerate().with_min_len(TASK).for_each(|(i, correction)| {
            *correction = pairs.correction(i, self.neighbours.of(i));
        });
        for (image, slot) in self.images.iter().zip(len..) {
            let l = correction[image.source as usize];
            let flip = image.flip;
            correction[slot] = std::array::from_fn(|a| std::array::from_fn(|b| flip[a] * l[a][b] * flip[b]));
        }
        self.particles.correction = correction;
    }

    /// Factors of the gradient of the smoothing length.
    fn find_spread(&mut self) {
        if !self.options.is_variable() || self.options.symmetrisation != Symmetrisation::GradH {
            return;
        }
        // Images need their smoothing lengths.
        self.particles.load_images(&self.images);
        let mut spread = std::mem::take(&mut self.particles.spread);
        let (len, pairs) = (self.particles.len, self.pairs());
        spread[..len].par_iter_mut().enumerate().with_min_len(TASK).for_each(|(i, spread)| {
            *spread = pairs.spread(i, self.neighbours.of(i));
        });
        self.particles.spread = spread;
    }
}
