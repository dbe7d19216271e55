//! Smoothing of stress by Shepard's interpolation or moving least squares, and renewal of density (sheet: sph §2.10).

use std::ops::Range;

use colluvium_case::SolverError;
use colluvium_constitutive::SymTensor;
use rayon::prelude::*;

use crate::clock::Clock;
use crate::config::{DensityReset, Regularisation};
use crate::context::SolverContext;
use crate::kernel::Smoothing;
use crate::neighbours::verlet_lists::VerletLists;
use crate::points::particles::{Bodies, MIN_PARTICLES_PER_TASK, Particles};
use crate::stress::stress_update::return_to_yield;
use crate::walls::Walls;

/// Least pivot over the largest entry of the moments of a particle, below which they are ill-conditioned (sheet: sph §2.10).
const MIN_PIVOT_RATIO: f64 = 1e-8;

/// Averaged fields before they are assigned to the particles; empty without smoothing.
#[derive(Default)]
pub struct SmoothedFields {
    stress: Vec<SymTensor>,
    density: Vec<f64>,
}

impl SmoothedFields {
    /// Smooths stress and renews density; step 10, of the previous step. Returns whether the state changed.
    pub fn regularise<const D: usize>(
        &mut self,
        setting: &SolverContext<D>,
        clock: &Clock,
        bodies: &mut Bodies<D>,
        walls: &Walls<D>,
        lists: &VerletLists<D>,
        dt: f64,
    ) -> Result<bool, SolverError> {
        let options = &setting.options;
        let renews = options.density_reset != DensityReset::None && clock.is_due(options.density_reset_steps);
        if renews {
            self.smooth_density(options.density_reset, setting, bodies, walls, lists);
        }
        let smooths = is_regularisation_due(setting, clock);
        if smooths {
            self.smooth_stress(options.regularisation, setting, bodies, walls, lists);
            return_to_yield(setting, clock, bodies, dt)?;
        }
        Ok(renews || smooths)
    }

    /// Replaces the stresses of bodies with laws in rate form by averages over neighbours in the same body.
    pub fn smooth_stress<const D: usize>(
        &mut self,
        form: Regularisation,
        setting: &SolverContext<D>,
        bodies: &mut Bodies<D>,
        walls: &Walls<D>,
        lists: &VerletLists<D>,
    ) {
        self.stress.resize(bodies.particles.len(), SymTensor::ZERO);
        for group in bodies.groups.iter().filter(|group| group.material.is_hypoelastic()) {
            let (range, start) = (group.range(), group.start);
            let near = BodyNeighbours::new(setting, &bodies.particles, walls, lists);
            self.stress[range.clone()].par_iter_mut().enumerate().with_min_len(64).for_each(|(k, stress)| {
                *stress = near.average(start + k, &range, form);
            });
            bodies.particles.stress[range.clone()].copy_from_slice(&self.stress[range]);
        }
    }

    /// Replaces the densities of fluids by their averages (sheet: sph §2.10).
    fn smooth_density<const D: usize>(
        &mut self,
        form: DensityReset,
        setting: &SolverContext<D>,
        bodies: &mut Bodies<D>,
        walls: &Walls<D>,
        lists: &VerletLists<D>,
    ) {
        let p = &mut bodies.particles;
        self.density.clear();
        self.density.extend_from_slice(&p.density[..p.id.len()]);
        for group in bodies.groups.iter().filter(|group| group.fluid) {
            let (range, start) = (group.range(), group.start);
            let near = BodyNeighbours::new(setting, p, walls, lists);
            self.density[range.clone()]
                .par_iter_mut()
                .enumerate()
                .with_min_len(MIN_PARTICLES_PER_TASK)
                .for_each(|(k, density)| {
                    let i = start + k;
                    let linear = (form == DensityReset::Mls).then(|| near.linear_weights(i, &range));
                    let (mut total, mut sum) = (0.0, 0.0);
                    near.for_each_neighbour(i, &range, |j, weight, apart| {
                        let factor = linear
                            .flatten()
                            .map_or(1.0, |b| b[0] + (0..D).map(|c| b[c + 1] * apart[c]).sum::<f64>());
                        total += weight * factor;
                        sum += near.particles.density[j] * weight * factor;
                    });
                    *density = sum / total;
                });
        }
        p.density[..self.density.len()].copy_from_slice(&self.density);
    }
}

/// Whether stresses are smoothed in this step.
pub fn is_regularisation_due<const D: usize>(setting: &SolverContext<D>, clock: &Clock) -> bool {
    let options = &setting.options;
    options.regularisation != Regularisation::None && clock.is_due(options.regularisation_steps)
}

/// Neighbours of a particle in the same body.
pub struct BodyNeighbours<'a, const D: usize> {
    smoothing: &'a Smoothing<D>,
    particles: &'a Particles<D>,
    walls: &'a Walls<D>,
    lists: &'a VerletLists<D>,
}

impl<'a, const D: usize> BodyNeighbours<'a, D> {
    /// Returns the neighbours among `particles`.
    pub fn new(
        setting: &'a SolverContext<D>,
        particles: &'a Particles<D>,
        walls: &'a Walls<D>,
        lists: &'a VerletLists<D>,
    ) -> Self {
        Self { smoothing: &setting.smoothing, particles, walls, lists }
    }

    /// Average stress of the neighbours of a particle in its body, by the kernel or moving least squares.
    fn average(&self, i: usize, body: &Range<usize>, form: Regularisation) -> SymTensor {
        let linear = (form == Regularisation::Mls).then(|| self.linear_weights(i, body)).flatten();
        let (mut total, mut sum) = (0.0, SymTensor::ZERO);
        self.for_each_neighbour(i, body, |j, weight, apart| {
            let factor = linear.map_or(1.0, |b| b[0] + (0..D).map(|c| b[c + 1] * apart[c]).sum::<f64>());
            total += weight * factor;
            sum += self.particles.stress[j] * (weight * factor);
        });
        sum * (1.0 / total)
    }

    /// First row of the inverse moments of `(1, (x_i - x_j) / h)`; `None` if they are ill-conditioned.
    pub fn linear_weights(&self, i: usize, body: &Range<usize>) -> Option<[f64; 4]> {
        let mut system = [[0.0; 5]; 4];
        let mut count = 0;
        self.for_each_neighbour(i, body, |_, weight, apart| {
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
            if !(system[column][column] > MIN_PIVOT_RATIO * largest) {
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

    /// Calls `visit` with `j`, `V_j W` and `(x_i - x_j) / h` for the particle itself and its neighbours in the same body, periodic images
    /// included. Images in mirrors are no particles of the body (sheet: sph §2.10).
    fn for_each_neighbour(
        &self,
        i: usize,
        body: &Range<usize>,
        mut visit: impl FnMut(usize, f64, &[f64; D]),
    ) {
        let p = self.particles;
        let kernel = self.smoothing.with_length(p.length[i]);
        visit(i, p.mass[i] / p.density[i] * kernel.value(0.0), &[0.0; D]);
        for &j in self.lists.neighbours.neighbours(i) {
            let place = &p.position[j as usize];
            let Some(j) = self.walls.particle_of(p.len(), j as usize).filter(|j| body.contains(j)) else {
                continue;
            };
            let h = p.length[i];
            let apart: [f64; D] = std::array::from_fn(|c| (p.position[i][c] - place[c]) / h);
            let r = h * apart.iter().map(|c| c * c).sum::<f64>().sqrt();
            let weight = p.mass[j] / p.density[j] * kernel.value(r);
            // Neighbours beyond the support must not count: which of them are listed depends on the history.
            if weight > 0.0 {
                visit(j, weight, &apart);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use colluvium_case::Case;
    use serde_json::json;

    use super::*;
    use crate::setup::rates_only;
    use crate::setup::rates_only::PrescribedParticle;
    use crate::solver::{SphSolver, diffuse_stress};

    /// Disordered particles under a stress field and gravity.
    fn disordered_solver(stress: impl Fn(u32, &[f64; 2]) -> SymTensor) -> SphSolver<2> {
        let text = json!({
            "title": "average", "space": "plane-strain", "domain": { "min": [-1, -1], "max": [2, 2] }, "gravity": [0, -10],
            "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.25 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 1] } }],
            "stages": [{ "name": "s", "duration": 1 }],
            "methods": { "sph": { "spacing": 0.05, "stress_diffusion": 0.1, "stress_diffusion_k0": 0.4 } }
        });
        let case = Case::from_json(&text.to_string()).unwrap();
        let given = |id: u32, x: &[f64; 2]| {
            let shift = [0.02 * noise(id, 0), 0.02 * noise(id, 1)];
            let stress = stress(id, &[x[0] + shift[0], x[1] + shift[1]]);
            PrescribedParticle { displacement: shift, velocity: [0.0; 2], compression: 1.0, stress }
        };
        let mut solver = rates_only::solver::<2>(&case, given);
        solver.critical_step();
        solver.update_lists(true).unwrap();
        solver.update_accelerations(0.0);
        solver
    }

    fn smooth(solver: &mut SphSolver<2>, form: Regularisation) {
        let SphSolver { setting, bodies, walls, lists, averages, .. } = solver;
        averages.smooth_stress(form, setting, bodies, walls, lists);
    }

    fn diffuse(solver: &mut SphSolver<2>, dt: f64) {
        let SphSolver { setting, clock, bodies, walls, lists, rates, .. } = solver;
        diffuse_stress(setting, clock, bodies, walls, lists, rates, dt);
    }

    fn noise(id: u32, component: u32) -> f64 {
        (f64::from(2 * id + component + 1) * 0.618_033_988_749_894_9).fract() - 0.5
    }

    /// Largest stress change since the start (Pa).
    fn max_stress_change(solver: &SphSolver<2>, before: &[SymTensor]) -> f64 {
        let pairs = solver.bodies.particles.stress.iter().zip(before);
        pairs.map(|(now, old)| (*now - *old).norm()).fold(0.0, f64::max)
    }

    fn linear(_: u32, x: &[f64; 2]) -> SymTensor {
        let [a, b] = *x;
        SymTensor([1e3 + 2e3 * a, -1e3 * b, 5e2 * (a + b), 3e3 * a - 2e3 * b, 0.0, 0.0])
    }

    #[test]
    fn shepards_average_is_exact_for_constants_and_least_squares_for_linear_stress() {
        let constant = SymTensor([1e3, -2e3, 5e2, 3e3, 0.0, 0.0]);
        for (form, exact) in [(Regularisation::Shepard, false), (Regularisation::Mls, true)] {
            let mut solver = disordered_solver(|_, _| constant);
            smooth(&mut solver, form);
            assert!(max_stress_change(&solver, &vec![constant; 400]) < 1e-9, "{form:?}");
            let mut solver = disordered_solver(linear);
            let before = solver.bodies.particles.stress[..400].to_vec();
            smooth(&mut solver, form);
            let change = max_stress_change(&solver, &before);
            assert_eq!(change < 1e-9, exact, "{form:?}: {change}");
        }
    }

    /// Particles with a larger spacing and smoothing lengths scaled with it have the same averages.
    #[test]
    fn averages_use_the_current_smoothing_lengths() {
        let smoothed = |stretch: f64, form: Regularisation| {
            let text = json!({
                "title": "stretch", "space": "plane-strain", "domain": { "min": [-1, -1], "max": [2, 2] }, "gravity": [0, 0],
                "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.25 } },
                "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 1] } }],
                "stages": [{ "name": "s", "duration": 1 }],
                "methods": { "sph": { "spacing": 0.05, "smoothing_length": "density" } }
            });
            let case = Case::from_json(&text.to_string()).unwrap();
            let given = |id: u32, x: &[f64; 2]| PrescribedParticle {
                displacement: [0, 1].map(|c| (stretch - 1.0) * x[c] + 0.02 * stretch * noise(id, c as u32)),
                velocity: [0.0; 2],
                compression: stretch.powi(-2),
                stress: SymTensor::diagonal(1e3, -2e3, 5e2) * noise(id, 0),
            };
            let mut solver = rates_only::solver::<2>(&case, given);
            solver.critical_step();
            solver.update_lists(true).unwrap();
            smooth(&mut solver, form);
            let p = &solver.bodies.particles;
            let mut found: Vec<_> = p.id.iter().copied().zip(p.stress[..p.len()].to_vec()).collect();
            found.sort_unstable_by_key(|(id, _)| *id);
            found
        };
        for form in [Regularisation::Shepard, Regularisation::Mls] {
            for stretch in [0.9, 1.2] {
                for ((_, a), (_, b)) in smoothed(1.0, form).iter().zip(smoothed(stretch, form)) {
                    assert!((*a - b).norm() < 1e-9, "{form:?}, {stretch}: {a:?} {b:?}");
                }
            }
        }
    }

    /// Geostatic stress: ρ g y vertically, and 0.4 of it horizontally.
    #[test]
    fn diffusion_leaves_geostatic_stress_alone() {
        let geostatic = |_: u32, x: &[f64; 2]| {
            let vertical = -1e4 * (1.0 - x[1]);
            SymTensor::diagonal(0.4 * vertical, vertical, 0.4 * vertical)
        };
        let mut solver = disordered_solver(geostatic);
        let before = solver.bodies.particles.stress[..400].to_vec();
        diffuse(&mut solver, 1e-3);
        assert!(max_stress_change(&solver, &before) < 1e-9);
    }

    #[test]
    fn diffusion_keeps_the_mean_stress() {
        let mut solver =
            disordered_solver(|id, _| SymTensor::diagonal(1e3, -2e3, 5e2) * (1.0 + noise(id, 0)));
        let before = solver.bodies.particles.stress[..400].to_vec();
        diffuse(&mut solver, 1e-3);
        assert!(max_stress_change(&solver, &before) > 1.0);
        let total = |stresses: &[SymTensor]| stresses.iter().fold(SymTensor::ZERO, |sum, s| sum + *s);
        let drift = total(&solver.bodies.particles.stress[..400]) - total(&before);
        assert!(drift.norm() < 1e-9 * 400.0, "{drift:?}");
    }
}
