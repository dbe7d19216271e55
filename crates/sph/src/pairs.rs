//! Sums over the neighbours: acceleration and velocity gradient (SPH sheet §2.6, §2.8, §2.11, §2.13).
//!
//! Every particle gathers from its own neighbours in the order of their numbers, so that the result does
//! not depend on the number of threads.

use colluvium_points::NeighbourList;

use crate::config::{Continuity, Momentum, SphOptions, Tensile, VelocityGradient};
use crate::kernel::Smoothing;
use crate::operators::{correction, product};
use crate::particles::{Matrix, Particles};

/// Keeps the viscosity finite for particles that meet (sheet §2.8).
const SOFTENING: f64 = 0.01;

/// What the sums need.
pub struct Pairs<'a, const D: usize> {
    /// The particles.
    pub particles: &'a Particles<D>,
    /// Their neighbours.
    pub neighbours: &'a NeighbourList<D>,
    /// The kernel.
    pub smoothing: &'a Smoothing<D>,
    /// The options.
    pub options: &'a SphOptions,
    /// From this number on a neighbour is a wall that answers with the stress and the mirrored velocity of
    /// the particle itself.
    pub answering: usize,
}

/// The velocity gradient of a particle and its trace after the continuity equation.
pub struct Rates<const D: usize> {
    /// `∂v_a/∂x_b` (1/s).
    pub gradient: Matrix<D>,
    /// `-ρ̇/ρ` (1/s).
    pub divergence: f64,
}

/// Artificial repulsion.
#[derive(Clone, Copy)]
struct Repulsion {
    exponent: f64,
    /// `1 / W(Δx)`.
    scale: f64,
}

impl<const D: usize> Pairs<'_, D> {
    fn repulsion(&self) -> Option<Repulsion> {
        match self.options.tensile {
            Tensile::None => None,
            Tensile::ArtificialStress { exponent, .. } | Tensile::ArtificialPressure { exponent, .. } => {
                Some(Repulsion { exponent, scale: 1.0 / self.smoothing.value(self.options.spacing) })
            }
        }
    }

    /// Acceleration of particle `i` by its neighbours (m/s²): steps 3 and 4 of the sheet's §3.3.
    #[inline]
    pub fn acceleration(&self, i: usize) -> [f64; D] {
        let p = self.particles;
        let (x, v, flux, repelled) = (p.position[i], p.velocity[i], p.flux[i], p.repulsion[i]);
        let (density, sound, h) = (p.density[i], p.sound[i], self.smoothing.length());
        let (linear, quadratic) = (self.options.viscosity_linear, self.options.viscosity_quadratic);
        let by_both = self.options.momentum != Momentum::Rho2;
        let sign = if self.options.momentum == Momentum::Difference { -1.0 } else { 1.0 };
        let own_weight = if by_both { 1.0 / density } else { 1.0 };
        let repulsion = self.repulsion();
        let mut sum = [0.0; D];
        for &j in self.neighbours.of(i) {
            let j = j as usize;
            let apart: [f64; D] = std::array::from_fn(|c| p.position[j][c] - x[c]);
            let square: f64 = apart.iter().map(|c| c * c).sum();
            let r = square.sqrt();
            let weight = self.smoothing.weight(r);
            if weight == 0.0 {
                continue;
            }
            let answers = j >= self.answering;
            // A wall answers with what the particle itself is; its velocity is the opposite.
            let k = if answers { i } else { j };
            let other_weight = if by_both { 1.0 / p.density[k] } else { 1.0 };
            let other = p.flux[k];
            let mut pair: Matrix<D> = std::array::from_fn(|a| {
                std::array::from_fn(|b| sign * flux[a][b] * other_weight + other[a][b] * own_weight)
            });
            if let Some(Repulsion { exponent, scale }) = repulsion {
                let factor = (self.smoothing.value(r) * scale).powf(exponent);
                for a in 0..D {
                    for b in 0..D {
                        pair[a][b] += factor * (repelled[a][b] + p.repulsion[k][a][b]);
                    }
                }
            }
            let closing: f64 = (0..D)
                .map(|c| (if answers { -2.0 * v[c] } else { p.velocity[j][c] - v[c] }) * apart[c])
                .sum();
            let mut viscosity = 0.0;
            if closing < 0.0 {
                let pi = h * closing / (square + SOFTENING * h * h);
                let (mean_sound, mean_density) = (0.5 * (sound + p.sound[k]), 0.5 * (density + p.density[k]));
                viscosity = (linear * mean_sound * pi - quadratic * pi * pi) / mean_density;
            }
            let force = product(&pair, &apart);
            let scale = p.mass[k] * weight;
            for c in 0..D {
                sum[c] += scale * (force[c] + viscosity * apart[c]);
            }
        }
        sum
    }

    /// Velocity gradient of particle `i`: step 6 of the sheet's §3.3.
    #[inline]
    pub fn rates(&self, i: usize) -> Rates<D> {
        let p = self.particles;
        let (x, v, density) = (p.position[i], p.velocity[i], p.density[i]);
        let form = match (self.options.velocity_gradient, self.options.momentum) {
            (VelocityGradient::Compatible, Momentum::Rho2) => VelocityGradient::DensityDifference,
            (VelocityGradient::Compatible, _) => VelocityGradient::Difference,
            (form, _) => form,
        };
        let by_mass = form == VelocityGradient::DensityDifference;
        let corrected = form == VelocityGradient::Corrected;
        let continuity_by_mass = self.options.continuity == Continuity::Mass;
        let mut gradient = [[0.0; D]; D];
        let mut moment = [[0.0; D]; D];
        let mut divergence = 0.0;
        for &j in self.neighbours.of(i) {
            let j = j as usize;
            let apart: [f64; D] = std::array::from_fn(|c| p.position[j][c] - x[c]);
            let weight = self.smoothing.weight(apart.iter().map(|c| c * c).sum::<f64>().sqrt());
            if weight == 0.0 {
                continue;
            }
            let answers = j >= self.answering;
            let k = if answers { i } else { j };
            let (of_mass, of_volume) = (p.mass[k] / density * weight, p.mass[k] / p.density[k] * weight);
            let scale = if by_mass { of_mass } else { of_volume };
            let relative: [f64; D] =
                std::array::from_fn(|c| if answers { -2.0 * v[c] } else { p.velocity[j][c] - v[c] });
            let mut trace = 0.0;
            for a in 0..D {
                trace += relative[a] * apart[a];
                for b in 0..D {
                    gradient[a][b] += scale * relative[a] * apart[b];
                }
            }
            divergence += trace * if continuity_by_mass { of_mass } else { of_volume };
            if corrected {
                for a in 0..D {
                    for b in 0..D {
                        moment[a][b] += of_volume * apart[a] * apart[b];
                    }
                }
            }
        }
        if corrected && let Some(l) = correction(&moment) {
            gradient = gradient.map(|row| product(&l, &row));
        }
        Rates { gradient, divergence }
    }
}
