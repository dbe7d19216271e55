//! The solver: its data and one step (SPH sheet §3.3).

use std::sync::Arc;

use colluvium_case::{Case, SolverError, TimeStep};
use colluvium_constitutive::{BLOCK, Mat3, Motion, SymTensor};
use colluvium_points::{CellList, NeighbourList};
use rayon::prelude::*;

use crate::SphOptions;
use crate::config::{Momentum, Regularisation, Tensile, WallStress};
use crate::kernel::Smoothing;
use crate::pairs::Pairs;
use crate::particles::{Group, Matrix, Particles, in_space};
use crate::tensile::repulsion;
use crate::walls::{Image, Walls};

/// Steps between two sorts by cell.
const STEPS_PER_SORT: u64 = 100;
/// Steps between two evaluations of the speeds of sound and the time step.
const STEPS_PER_TIME_STEP: u64 = 10;
/// Margin of the neighbour lists over the radius of the support: lists last until a particle has moved by
/// half of it.
const SKIN: f64 = 0.1;
/// Least number of particles per task.
const TASK: usize = 64;

/// Distance from equilibrium and its pieces.
#[derive(Clone, Copy, Debug, Default)]
pub struct Audit {
    /// Square of the sum of the unbalanced forces (N²).
    pub unbalanced: f64,
    /// Square of the external forces (N²).
    pub external: f64,
    /// Kinetic energy (J).
    pub kinetic: f64,
    /// Work of gravity since the stage began (J).
    pub work: f64,
}

/// Explicit SPH in `D` dimensions.
pub struct SphSolver<const D: usize> {
    pub(crate) case: Arc<Case>,
    pub(crate) options: SphOptions,
    pub(crate) smoothing: Smoothing<D>,
    pub(crate) particles: Particles<D>,
    pub(crate) groups: Vec<Group>,
    pub(crate) walls: Walls<D>,
    pub(crate) images: Vec<Image<D>>,
    pub(crate) neighbours: NeighbourList<D>,
    pub(crate) cells: CellList<D>,
    /// Positions for which the neighbour list was made; empty where there is none (m).
    pub(crate) listed: Vec<[f64; D]>,
    pub(crate) smoothed: Vec<SymTensor>,
    pub(crate) gravity: [f64; D],
    pub(crate) stage: usize,
    pub(crate) stage_start: f64,
    pub(crate) time: f64,
    pub(crate) step: u64,
    /// Length of the step before, zero at the start (s).
    pub(crate) last_step: f64,
    pub(crate) limit: Option<TimeStep>,
    pub(crate) limit_age: u64,
    pub(crate) audit: Audit,
}

fn square<const D: usize>(vector: &[f64; D]) -> f64 {
    vector.iter().map(|c| c * c).sum()
}

impl<const D: usize> SphSolver<D> {
    /// One step; the numbers are those of the sheet's §3.3.
    pub(crate) fn advance(&mut self, dt: f64) -> Result<(), SolverError> {
        if self.limit.is_none() {
            self.critical_step();
        }
        self.refresh_neighbours()?; // 1
        self.regularise(dt)?; // 10, of the step before
        self.load_fluxes(); // 3
        self.accelerate(dt); // 4
        self.kick(dt); // 5
        self.find_rates(); // 6
        self.update_stress(dt)?; // 7, 8
        self.drift(dt)?; // 9
        self.time += dt;
        self.step += 1;
        self.last_step = dt;
        self.limit_age += 1;
        Ok(())
    }

    /// Sorts when it is time, renews images and lists when particles have moved, and moves the images.
    fn refresh_neighbours(&mut self) -> Result<(), SolverError> {
        if self.step.is_multiple_of(STEPS_PER_SORT) {
            self.sort()?;
        }
        let skin = SKIN * self.smoothing.radius();
        let moved = |(x, old): (&[f64; D], &[f64; D])| -> bool {
            let apart: [f64; D] = std::array::from_fn(|c| x[c] - old[c]);
            !(4.0 * square(&apart) <= skin * skin)
        };
        let p = &mut self.particles;
        let current = self.listed.len() == p.len && !p.position[..p.len].iter().zip(&self.listed).any(moved);
        if !current {
            let reach = self.smoothing.radius() + skin;
            self.walls.images(&p.position[..p.len], reach, &mut self.images);
            let first_wall = p.len + self.images.len();
            let total = first_wall + self.walls.particles.len();
            p.resize(total);
            p.position[first_wall..].copy_from_slice(&self.walls.particles);
            p.place_images(&self.images);
            self.listed.clear();
            self.listed.extend_from_slice(&p.position[..p.len]);
            let rows = if self.options.wall_stress == WallStress::Pairwise { p.len } else { total };
            let built = self.neighbours.build_first(&p.position, rows, reach);
            built.map_err(|error| self.failed(0, format!("neighbour search: {error}")))?;
        } else {
            p.place_images(&self.images);
        }
        Ok(())
    }

    /// Sorts the particles of each body by cell.
    pub(crate) fn sort(&mut self) -> Result<(), SolverError> {
        for number in 0..self.groups.len() {
            let range = self.groups[number].range();
            let built = self.cells.build(&self.particles.position[range.clone()], self.smoothing.radius());
            built.map_err(|error| self.failed(range.start, format!("neighbour search: {error}")))?;
            let order = self.cells.order();
            if order.iter().enumerate().all(|(i, &old)| i == old as usize) {
                continue;
            }
            self.particles.permute(range, order);
            let group = &mut self.groups[number];
            group.states = group.states.permuted(order);
            self.listed.clear();
        }
        Ok(())
    }

    fn pairs(&self) -> Pairs<'_, D> {
        let answering = match self.options.wall_stress {
            WallStress::Pairwise => self.particles.len + self.images.len(),
            WallStress::Interpolated | WallStress::Extrapolated => usize::MAX,
        };
        Pairs {
            particles: &self.particles,
            neighbours: &self.neighbours,
            smoothing: &self.smoothing,
            options: &self.options,
            answering,
        }
    }

    /// What every particle brings to its pairs, walls and images included.
    fn load_fluxes(&mut self) {
        self.interpolate_walls();
        let (tensile, momentum) = (self.options.tensile, self.options.momentum);
        let by_square = momentum == Momentum::Rho2;
        let p = &mut self.particles;
        let one = |flux: &mut Matrix<D>, repelled: &mut Matrix<D>, stress: &SymTensor, density: f64| {
            let scale = if by_square { 1.0 / (density * density) } else { 1.0 / density };
            *flux = in_space(&(*stress * scale));
            if tensile != Tensile::None {
                *repelled = repulsion(tensile, stress, density);
            }
        };
        let real = p.flux.par_iter_mut().zip(&mut p.repulsion).zip(&p.stress).zip(&p.density);
        real.with_min_len(TASK * 8).for_each(|(((flux, repelled), stress), &density)| {
            if density > 0.0 {
                one(flux, repelled, stress, density);
            }
        });
        p.load_images(&self.images);
        p.move_images(&self.images);
    }

    /// Stress and velocity of walls that do not answer pairwise (sheet §2.13 b).
    fn interpolate_walls(&mut self) {
        if self.options.wall_stress == WallStress::Pairwise {
            return;
        }
        let first = self.particles.len + self.images.len();
        let mass =
            self.groups.first().map_or(0.0, |group| group.density) * self.options.spacing.powi(D as i32);
        let density = self.groups.first().map_or(0.0, |group| group.density);
        for wall in first..self.particles.position.len() {
            let (stress, sound) = self.wall_stress(wall, density);
            let p = &mut self.particles;
            (p.stress[wall], p.sound[wall], p.mass[wall], p.density[wall]) = (stress, sound, mass, density);
        }
        self.move_walls();
    }

    fn wall_stress(&self, wall: usize, density: f64) -> (SymTensor, f64) {
        let p = &self.particles;
        let (mut total, mut stress, mut sound) = (0.0, SymTensor::ZERO, 0.0);
        let gravity = self.gravity.map(|g| g * self.gravity_factor(0.0));
        let size = square(&gravity).sqrt();
        for &j in self.neighbours.of(wall) {
            let j = j as usize;
            if j >= p.len {
                break;
            }
            let apart: [f64; D] = std::array::from_fn(|c| p.position[wall][c] - p.position[j][c]);
            let weight = p.mass[j] / p.density[j] * self.smoothing.value(square(&apart).sqrt());
            total += weight;
            sound += weight * p.sound[j];
            stress += p.stress[j] * weight;
            if self.options.wall_stress == WallStress::Extrapolated && size > 0.0 {
                let up = gravity.map(|g| -g / size);
                let rise: f64 = (0..D).map(|c| up[c] * apart[c]).sum();
                // Tension positive: higher places bear less.
                let vertical = density * size * rise;
                let along = |c: usize| if c < D { up[c] * up[c] } else { 0.0 };
                let value =
                    |c: usize| vertical * (self.options.wall_k0 + (1.0 - self.options.wall_k0) * along(c));
                stress += SymTensor::diagonal(value(0), value(1), value(2)) * weight;
            }
        }
        if total < 1e-12 { (SymTensor::ZERO, 0.0) } else { (stress * (1.0 / total), sound / total) }
    }

    /// Velocities of interpolated walls: the soil's, reversed.
    fn move_walls(&mut self) {
        if self.options.wall_stress == WallStress::Pairwise {
            return;
        }
        for wall in self.particles.len + self.images.len()..self.particles.position.len() {
            let p = &self.particles;
            let (mut total, mut velocity) = (0.0, [0.0; D]);
            for &j in self.neighbours.of(wall) {
                let j = j as usize;
                if j >= p.len {
                    break;
                }
                let apart: [f64; D] = std::array::from_fn(|c| p.position[wall][c] - p.position[j][c]);
                let weight = p.mass[j] / p.density[j] * self.smoothing.value(square(&apart).sqrt());
                total += weight;
                for c in 0..D {
                    velocity[c] -= weight * p.velocity[j][c];
                }
            }
            let zero = total < 1e-12;
            self.particles.velocity[wall] = velocity.map(|v| if zero { 0.0 } else { v / total });
        }
    }

    /// Accelerations, gravity and local damping of the stage included.
    fn accelerate(&mut self, dt: f64) {
        let gravity = self.gravity.map(|g| g * self.gravity_factor(dt));
        let mut accelerations = std::mem::take(&mut self.particles.acceleration);
        accelerations.resize(self.particles.len, [0.0; D]);
        let pairs = self.pairs();
        accelerations.par_iter_mut().enumerate().with_min_len(TASK).for_each(|(i, a)| {
            let pull = pairs.acceleration(i);
            *a = std::array::from_fn(|c| pull[c] + gravity[c]);
        });
        self.particles.acceleration = accelerations;
        if self.case.stages[self.stage].equilibrium.is_some() {
            self.take_audit(&gravity, dt);
        }
    }

    fn take_audit(&mut self, gravity: &[f64; D], dt: f64) {
        let p = &self.particles;
        let mut audit = Audit { work: self.audit.work, ..Audit::default() };
        for i in 0..p.len {
            let (m, v) = (p.mass[i], &p.velocity[i]);
            audit.unbalanced += m * m * square(&p.acceleration[i]);
            audit.external += m * m * square(gravity);
            audit.kinetic += 0.5 * m * square(v);
            audit.work += m * dt * (0..D).map(|c| gravity[c] * v[c]).sum::<f64>();
        }
        self.audit = audit;
    }

    /// Velocities half a step ahead of the positions.
    fn kick(&mut self, dt: f64) {
        let local = self.case.stages[self.stage].damping;
        let step = 0.5 * (self.last_step + dt);
        let rate = self.options.damping / self.smoothing.length();
        let p = &mut self.particles;
        let moving = p.velocity.par_iter_mut().zip(&p.acceleration).zip(&p.sound);
        moving.with_min_len(TASK * 8).for_each(|((v, a), sound)| {
            let factor = if rate > 0.0 { (-rate * sound * dt).exp() } else { 1.0 };
            for c in 0..D {
                let resisted = if v[c] == 0.0 { 0.0 } else { local * a[c].abs() * v[c].signum() };
                v[c] = (v[c] + step * (a[c] - resisted)) * factor;
            }
        });
    }

    fn find_rates(&mut self) {
        self.particles.move_images(&self.images);
        self.move_walls();
        let mut gradient = std::mem::take(&mut self.particles.gradient);
        let mut divergence = std::mem::take(&mut self.particles.divergence);
        let pairs = self.pairs();
        let all = gradient.par_iter_mut().zip(&mut divergence).enumerate().with_min_len(TASK);
        all.for_each(|(i, (gradient, divergence))| {
            let rates = pairs.rates(i);
            *gradient = rates.gradient;
            *divergence = rates.divergence;
        });
        self.particles.gradient = gradient;
        self.particles.divergence = divergence;
    }

    /// Densities and stresses at the end of the step.
    fn update_stress(&mut self, dt: f64) -> Result<(), SolverError> {
        let p = &mut self.particles;
        let mut failure = None;
        for group in &mut self.groups {
            let range = group.range();
            let blocks = group.states.blocks_mut().par_iter_mut();
            let stress = p.stress[range.clone()].par_chunks_mut(BLOCK);
            let density = p.density[range.clone()].par_chunks_mut(BLOCK);
            let mass = p.mass[range.clone()].par_chunks(BLOCK);
            let gradient = p.gradient[range.clone()].par_chunks(BLOCK);
            let divergence = p.divergence[range.clone()].par_chunks(BLOCK);
            let material = &group.material;
            let initial = group.density;
            let all = blocks.zip(stress).zip(density).zip(mass).zip(gradient).zip(divergence).enumerate();
            let error =
                all.filter_map(|(number, (((((states, stress), density), mass), gradient), divergence))| {
                    let mut motions = [STILL; BLOCK];
                    for k in 0..stress.len() {
                        density[k] *= (-dt * divergence[k]).exp();
                        let here = range.start + number * BLOCK + k;
                        if !(density[k] > 0.2 * initial && density[k] < 5.0 * initial) {
                            return Some((
                                here,
                                format!("its density {} kg/m³ left 0.2 to 5 times the initial", density[k]),
                            ));
                        }
                        let size = (mass[k] / density[k]).powf(1.0 / D as f64);
                        match Motion::from_velocity_gradient(
                            &spatial_matrix(&gradient[k]),
                            dt,
                            density[k],
                            size,
                        ) {
                            Some(motion) => motions[k] = motion,
                            None => {
                                return Some((here, "its deformation in the step is singular".to_owned()));
                            }
                        }
                    }
                    let updated = material.update(&motions[..stress.len()], stress, states);
                    updated.err().map(|e| (range.start + number * BLOCK + e.index, e.source.to_string()))
                });
            let first = error.min_by_key(|(index, _)| *index);
            failure = failure.or(first);
        }
        failure.map_or(Ok(()), |(index, reason)| Err(self.failed(index, reason)))
    }

    /// Positions at the end of the step.
    fn drift(&mut self, dt: f64) -> Result<(), SolverError> {
        let domain = &self.case.domain;
        let longest = 0.2 * self.smoothing.length();
        // A soft material may be pressed into a wall as far as the wall's first particles.
        let margin = 0.5 * self.options.spacing;
        let p = &mut self.particles;
        let all = p.position[..p.len].par_iter_mut().zip(&p.velocity).zip(&p.stress).enumerate();
        let lost = all.with_min_len(TASK * 8).filter_map(|(i, ((x, v), stress))| {
            let far = !(square(v).sqrt() * dt <= longest);
            for c in 0..D {
                x[c] += dt * v[c];
            }
            let outside = (0..D).any(|c| x[c] < domain.min[c] - margin || x[c] > domain.max[c] + margin);
            if far {
                Some((i, "it moved by more than 0.2 smoothing lengths in a step"))
            } else if !stress.is_finite() {
                Some((i, "its stress is not finite"))
            } else if outside {
                Some((i, "it left the domain: enlarge the domain or add a wall on that side"))
            } else {
                None
            }
        });
        let first = lost.min_by_key(|(i, _)| *i);
        first.map_or(Ok(()), |(i, reason)| Err(self.failed(i, reason.to_owned())))
    }

    fn regularise(&mut self, dt: f64) -> Result<(), SolverError> {
        let form = self.options.regularisation;
        if form == Regularisation::None
            || self.step == 0
            || !self.step.is_multiple_of(self.options.regularisation_steps)
        {
            return Ok(());
        }
        self.smooth_stress(form);
        // The smoothed stress may lie beyond yield: a step without motion takes it back.
        self.particles.gradient.fill([[0.0; D]; D]);
        self.particles.divergence.fill(0.0);
        self.update_stress(dt)
    }

    pub(crate) fn failed(&self, index: usize, reason: String) -> SolverError {
        let position = self.particles.position.get(index).copied().unwrap_or([0.0; D]);
        SolverError::Point {
            step: self.step,
            time: self.time,
            point: u64::from(self.particles.id.get(index).copied().unwrap_or(0)),
            position: spatial(&position),
            reason,
        }
    }

    /// Factor on gravity at the end of a step of `dt`.
    pub(crate) fn gravity_factor(&self, dt: f64) -> f64 {
        self.case.stages[self.stage].gravity_factor(self.time + dt - self.stage_start)
    }

    /// The largest stable step from the current state (sheet §3.4).
    pub(crate) fn critical_step(&mut self) -> TimeStep {
        if self.limit.is_none() || self.limit_age >= STEPS_PER_TIME_STEP {
            let limit = self.find_limit();
            self.limit = Some(limit.or_fixed(self.options.time_step, self.options.courant));
            self.limit_age = 0;
        }
        self.limit.clone().expect("set above")
    }
}

/// No motion, to be replaced.
const STILL: Motion = Motion {
    deformation: Mat3::IDENTITY,
    gradient: Mat3::ZERO,
    dt: 0.0,
    density: 0.0,
    size: 0.0,
    pore: colluvium_constitutive::Pore { pressure: 0.0, saturation: 0.0 },
};

/// A vector of the space with three components.
pub(crate) fn spatial<const D: usize>(vector: &[f64; D]) -> [f64; 3] {
    std::array::from_fn(|c| if c < D { vector[c] } else { 0.0 })
}

fn spatial_matrix<const D: usize>(matrix: &Matrix<D>) -> Mat3 {
    Mat3(std::array::from_fn(|a| std::array::from_fn(|b| if a < D && b < D { matrix[a][b] } else { 0.0 })))
}

#[cfg(test)]
mod frame;
