//! Smoothing of stress by Shepard's interpolation or moving least squares (SPH sheet §2.10).

use colluvium_constitutive::SymTensor;
use rayon::prelude::*;

use crate::config::{DensityReset, Regularisation};
use crate::solver::{SphSolver, TASK};

/// Pivots below this share of the largest entry make the moments of a particle ill-conditioned (sheet §2.10).
const CONDITION: f64 = 1e-8;

impl<const D: usize> SphSolver<D> {
    /// Replaces the stresses of laws in rate form by the average over the particles of the same body; others find
    /// theirs anew.
    pub(crate) fn smooth_stress(&mut self, form: Regularisation) {
        let mut smoothed = std::mem::take(&mut self.tensors);
        smoothed.resize(self.particles.len, SymTensor::ZERO);
        for group in self.groups.iter().filter(|group| group.material.is_in_rate_form()) {
            let (range, start) = (group.range(), group.start);
            smoothed[range.clone()].par_iter_mut().enumerate().with_min_len(64).for_each(|(k, stress)| {
                *stress = self.average(start + k, &range, form);
            });
            self.particles.stress[range.clone()].copy_from_slice(&smoothed[range]);
        }
        self.tensors = smoothed;
    }

    /// Replaces the densities of fluids by their averages (sheet §2.10).
    pub(crate) fn smooth_density(&mut self, form: DensityReset) {
        let mut smoothed = std::mem::take(&mut self.scalars);
        smoothed.clear();
        smoothed.extend_from_slice(&self.particles.density[..self.particles.len]);
        let form = if form == DensityReset::Mls { Regularisation::Mls } else { Regularisation::Shepard };
        for group in self.groups.iter().filter(|group| group.fluid) {
            let (range, start) = (group.range(), group.start);
            smoothed[range.clone()].par_iter_mut().enumerate().with_min_len(TASK).for_each(|(k, density)| {
                let p = &self.particles;
                let linear = (form == Regularisation::Mls).then(|| self.linear_weights(start + k, &range));
                let (mut total, mut sum) = (0.0, 0.0);
                self.around(start + k, &range, |j, weight, apart| {
                    let factor = linear
                        .flatten()
                        .map_or(1.0, |b| b[0] + (0..D).map(|c| b[c + 1] * apart[c]).sum::<f64>());
                    total += weight * factor;
                    sum += p.density[j] * weight * factor;
                });
                *density = sum / total;
            });
        }
        self.particles.density[..smoothed.len()].copy_from_slice(&smoothed);
        self.scalars = smoothed;
    }

    fn average(&self, i: usize, body: &std::ops::Range<usize>, form: Regularisation) -> SymTensor {
        let linear = (form == Regularisation::Mls).then(|| self.linear_weights(i, body)).flatten();
        let (mut total, mut sum) = (0.0, SymTensor::ZERO);
        self.around(i, body, |j, weight, apart| {
            let factor = linear.map_or(1.0, |b| b[0] + (0..D).map(|c| b[c + 1] * apart[c]).sum::<f64>());
            total += weight * factor;
            sum += self.particles.stress[j] * (weight * factor);
        });
        sum * (1.0 / total)
    }

    /// First row of the inverse moments of `(1, (x_i - x_j) / h)`; `None` where they are ill-conditioned.
    pub(crate) fn linear_weights(&self, i: usize, body: &std::ops::Range<usize>) -> Option<[f64; 4]> {
        let mut system = [[0.0; 5]; 4];
        let mut count = 0;
        self.around(i, body, |_, weight, apart| {
            let mut basis = [1.0, 0.0, 0.0, 0.0];
            basis[1..=D].copy_from_slice(apart);
            count += 1;
            for a in 0..=D {
                for b in 0..=D {
                    system[a][b] += weight * basis[a] * basis[b];
                }
            }
        });
        system[0][4] = 1.0;
        if count < D + 3 {
            return None;
        }
        // The matrix is positive definite: no pivoting.
        let largest = (0..=D).map(|k| system[k][k]).fold(0.0, f64::max);
        for column in 0..=D {
            if !(system[column][column] > CONDITION * largest) {
                return None;
            }
            for row in column + 1..=D {
                let factor = system[row][column] / system[column][column];
                for k in column..5 {
                    system[row][k] -= factor * system[column][k];
                }
            }
        }
        let mut solution = [0.0; 4];
        for row in (0..=D).rev() {
            let known: f64 = (row + 1..=D).map(|k| system[row][k] * solution[k]).sum();
            solution[row] = (system[row][4] - known) / system[row][row];
        }
        Some(solution)
    }

    /// Calls `visit(j, V_j W, (x_i - x_j) / h)` for the particle itself and its neighbours of the same body, across
    /// the ends of periods too. Images in mirrors are no particles of the body (sheet §2.10).
    fn around(&self, i: usize, body: &std::ops::Range<usize>, mut visit: impl FnMut(usize, f64, &[f64; D])) {
        let p = &self.particles;
        visit(i, p.mass[i] / p.density[i] * self.smoothing.value(0.0), &[0.0; D]);
        for &j in self.neighbours.of(i) {
            let place = &p.position[j as usize];
            let Some(j) = self.particle_of(j as usize).filter(|j| body.contains(j)) else { continue };
            let h = p.length[i];
            let apart: [f64; D] = std::array::from_fn(|c| (p.position[i][c] - place[c]) / h);
            let r = h * apart.iter().map(|c| c * c).sum::<f64>().sqrt();
            let weight = p.mass[j] / p.density[j] * self.smoothing.value(r);
            // Beyond the support a neighbour must not count: which ones are listed depends on the past.
            if weight > 0.0 {
                visit(j, weight, &apart);
            }
        }
    }
}
