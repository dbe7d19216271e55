//! Stress and velocity of walls that take them from the soil around (SPH sheet §2.13 b).

use colluvium_constitutive::SymTensor;
use rayon::prelude::*;

use super::{SphSolver, square};
use crate::config::WallStress;
use crate::lanes::set_velocity;
use crate::pairs::{geostatic, sheared};
use crate::walls::Contact;

/// Less soil than this around a particle of a wall counts for nothing (sheet §2.13).
const LEAST_SOIL: f64 = 1e-12;

impl<const D: usize> SphSolver<D> {
    fn is_pairwise(&self) -> bool {
        self.options.wall_stress == WallStress::Pairwise
    }

    /// Stress and velocity of walls that do not answer pairwise.
    pub(crate) fn interpolate_walls(&mut self) {
        if self.is_pairwise() {
            return;
        }
        let first = self.particles.len + self.images.len();
        let mut stress = std::mem::take(&mut self.tensors);
        stress.resize(self.walls.particles.len(), SymTensor::ZERO);
        stress.par_iter_mut().enumerate().with_min_len(64).for_each(|(k, stress)| {
            *stress = self.wall_stress(first, k);
        });
        let p = &mut self.particles;
        p.stress[first..].copy_from_slice(&stress);
        self.tensors = stress;
        self.weigh_walls();
        self.move_walls();
    }

    /// Calls `visit(particle, V W, x_wall - x)` for the soil around particle `wall`, across the ends of periods too;
    /// returns the sum of `V W`.
    fn around_wall(&self, wall: usize, mut visit: impl FnMut(usize, f64, &[f64; D])) -> f64 {
        let p = &self.particles;
        let mut total = 0.0;
        for &j in self.neighbours.of(wall) {
            let place = &p.position[j as usize];
            let Some(j) = self.particle_of(j as usize).filter(|&j| !self.smooth.contain(j)) else { continue };
            let apart: [f64; D] = std::array::from_fn(|c| p.position[wall][c] - place[c]);
            let weight = p.mass[j] / p.density[j] * self.smoothing.value(square(&apart).sqrt());
            if weight > 0.0 {
                total += weight;
                visit(j, weight, &apart);
            }
        }
        total
    }

    fn wall_stress(&self, first: usize, k: usize) -> SymTensor {
        let gravity = self.gravity_at(0.0);
        let size = square(&gravity).sqrt();
        let carries = self.options.wall_stress == WallStress::Extrapolated && size > 0.0;
        let up = gravity.map(|g| -g / size);
        let mut stress = SymTensor::ZERO;
        let total = self.around_wall(first + k, |j, weight, apart| {
            stress += self.particles.stress[j] * weight;
            if carries {
                let rise: f64 = (0..D).map(|c| up[c] * apart[c]).sum();
                // Tension positive: higher places bear less.
                let unit_weight = self.particles.density[j] * size;
                stress += geostatic(unit_weight * rise, self.options.wall_k0, &up) * weight;
            }
        });
        if total < LEAST_SOIL {
            return SymTensor::ZERO;
        }
        let stress = stress * (1.0 / total);
        let face = &self.walls.faces[self.walls.face_of[k] as usize];
        if face.contact == Contact::FreeSlip { sheared(&stress, face.axis, -1.0) } else { stress }
    }

    /// Densities, masses and speeds of sound of walls that do not answer pairwise: the soil's. Without soil around it a wall weighs nothing.
    pub(crate) fn weigh_walls(&mut self) {
        if self.is_pairwise() {
            return;
        }
        let first = self.particles.len + self.images.len();
        let volume = self.options.spacing.powi(D as i32);
        for wall in first..self.particles.position.len() {
            let (mut density, mut sound) = (0.0, 0.0);
            let total = self.around_wall(wall, |j, weight, _| {
                density += weight * self.particles.density[j];
                sound += weight * self.particles.sound[j];
            });
            let p = &mut self.particles;
            (p.density[wall], p.mass[wall], p.sound[wall]) = if total < LEAST_SOIL {
                (1.0, 0.0, 0.0)
            } else {
                (density / total, density / total * volume, sound / total)
            };
        }
    }

    /// Velocities of interpolated walls: the soil's, reversed in the frame of the wall.
    pub(crate) fn move_walls(&mut self) {
        if self.is_pairwise() {
            return;
        }
        let first = self.particles.len + self.images.len();
        for wall in first..self.particles.position.len() {
            let mut velocity = [0.0; D];
            let total = self.around_wall(wall, |j, weight, _| {
                (0..D).for_each(|c| velocity[c] += weight * self.particles.velocity[j][c]);
            });
            let face = &self.walls.faces[self.walls.face_of[wall - first] as usize];
            let pace = face.pace();
            let v: [f64; D] = std::array::from_fn(|c| {
                let soil = velocity[c] / total;
                match face.contact {
                    _ if total < LEAST_SOIL => pace[c],
                    Contact::FreeSlip if c != face.axis => soil,
                    _ => 2.0 * pace[c] - soil,
                }
            });
            self.particles.velocity[wall] = v;
            set_velocity(&mut self.particles.records[wall], &v);
        }
    }
}
