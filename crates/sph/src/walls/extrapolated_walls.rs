//! Walls with stress and velocity extrapolated from the soil (sheet: sph §2.13 b).

use colluvium_constitutive::SymTensor;
use colluvium_points::NeighbourList;
use rayon::prelude::*;

use crate::boundary::flat_wall::{FlatWall, WallContact};
use crate::clock::Clock;
use crate::config::WallStress;
use crate::context::SolverContext;
use crate::points::packed_particles::set_velocity;
use crate::points::particles::{Bodies, Particles};
use crate::points::vector_algebra::{geostatic_stress, separation, with_scaled_shear};
use crate::walls::Walls;

/// Least sum of soil weights around a wall particle for an extrapolation (sheet: sph §2.13).
const MIN_SOIL_WEIGHT: f64 = 1e-12;

/// Soil particles around the particles of walls.
struct SoilExtrapolation<'a, const D: usize> {
    setting: &'a SolverContext<D>,
    particles: &'a Particles<D>,
    walls: &'a Walls<D>,
    neighbours: &'a NeighbourList<D>,
}

impl<const D: usize> SoilExtrapolation<'_, D> {
    /// Calls `visit(particle, V W, x_wall - x)` for the soil around particle `wall`, periodic images included;
    /// returns the sum of `V W`.
    fn for_each_neighbour(&self, wall: usize, mut visit: impl FnMut(usize, f64, &[f64; D])) -> f64 {
        let (p, walls) = (self.particles, self.walls);
        let mut total = 0.0;
        for &j in self.neighbours.neighbours(wall) {
            let place = &p.position[j as usize];
            let particle = walls.particle_of(p.len(), j as usize);
            let Some(j) = particle.filter(|&j| !walls.smooth_bodies.contain(j)) else { continue };
            let (apart, square) = separation(place, &p.position[wall]);
            let weight = p.mass[j] / p.density[j] * self.setting.smoothing.value(square.sqrt());
            if weight > 0.0 {
                total += weight;
                visit(j, weight, &apart);
            }
        }
        total
    }

    /// Flat wall of particle `wall`.
    fn face(&self, wall: usize) -> &FlatWall<D> {
        let planes = &self.walls.planes;
        &planes.faces[planes.face_of[wall - self.walls.first(self.particles.len())] as usize]
    }

    /// Stress of a wall particle under `gravity` (Pa).
    fn stress(&self, wall: usize, gravity: &[f64; D]) -> SymTensor {
        let options = &self.setting.options;
        let size = gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
        let carries = options.wall_stress == WallStress::Extrapolated && size > 0.0;
        let up = gravity.map(|g| -g / size);
        let mut stress = SymTensor::ZERO;
        let total = self.for_each_neighbour(wall, |j, weight, apart| {
            stress += self.particles.stress[j] * weight;
            if carries {
                let rise: f64 = (0..D).map(|c| up[c] * apart[c]).sum();
                // Tension positive: compression decreases upwards.
                let unit_weight = self.particles.density[j] * size;
                stress += geostatic_stress(unit_weight * rise, options.wall_k0, &up) * weight;
            }
        });
        if total < MIN_SOIL_WEIGHT {
            return SymTensor::ZERO;
        }
        let stress = stress * (1.0 / total);
        let face = self.face(wall);
        if face.contact == WallContact::FreeSlip {
            with_scaled_shear(&stress, face.axis, -1.0)
        } else {
            stress
        }
    }

    /// Density, mass and speed of sound of the soil around a wall particle. Without soil its mass is zero.
    fn density_mass_and_sound(&self, wall: usize) -> [f64; 3] {
        let (mut density, mut sound) = (0.0, 0.0);
        let total = self.for_each_neighbour(wall, |j, weight, _| {
            density += weight * self.particles.density[j];
            sound += weight * self.particles.sound[j];
        });
        let volume = self.setting.options.spacing.powi(D as i32);
        if total < MIN_SOIL_WEIGHT {
            [1.0, 0.0, 0.0]
        } else {
            [density / total, density / total * volume, sound / total]
        }
    }

    /// Velocity of the soil at a wall particle, reversed in the frame of the wall (m/s).
    fn velocity(&self, wall: usize) -> [f64; D] {
        let mut velocity = [0.0; D];
        let total = self.for_each_neighbour(wall, |j, weight, _| {
            (0..D).for_each(|c| velocity[c] += weight * self.particles.velocity[j][c]);
        });
        let face = self.face(wall);
        let pace = face.mean_velocity();
        std::array::from_fn(|c| {
            let soil = velocity[c] / total;
            match face.contact {
                _ if total < MIN_SOIL_WEIGHT => pace[c],
                WallContact::FreeSlip if c != face.axis => soil,
                _ => 2.0 * pace[c] - soil,
            }
        })
    }
}

impl<const D: usize> Walls<D> {
    /// Extrapolation of the stress and velocity of the soil to wall particles.
    fn soil_extrapolation<'a>(
        &'a self,
        setting: &'a SolverContext<D>,
        particles: &'a Particles<D>,
        neighbours: &'a NeighbourList<D>,
    ) -> SoilExtrapolation<'a, D> {
        SoilExtrapolation { setting, particles, walls: self, neighbours }
    }

    /// Extrapolates stress, mass and velocity of the soil to wall particles.
    pub fn extrapolate_from_soil(
        &self,
        setting: &SolverContext<D>,
        clock: &Clock,
        bodies: &mut Bodies<D>,
        neighbours: &NeighbourList<D>,
    ) {
        if setting.options.wall_stress == WallStress::Pairwise {
            return;
        }
        let first = self.first(bodies.particles.len());
        let gravity = setting.gravity_at(clock, 0.0);
        let soil = self.soil_extrapolation(setting, &bodies.particles, neighbours);
        let stresses = &mut bodies.pair_data.wall_stresses;
        stresses.resize(self.planes.particles.len(), SymTensor::ZERO);
        stresses.par_iter_mut().enumerate().with_min_len(64).for_each(|(k, stress)| {
            *stress = soil.stress(first + k, &gravity);
        });
        bodies.particles.stress[first..].copy_from_slice(&bodies.pair_data.wall_stresses);
        self.extrapolate_densities(setting, bodies, neighbours);
        self.extrapolate_velocities(setting, bodies, neighbours);
    }

    /// Extrapolates density, mass and speed of sound of the soil to wall particles.
    pub fn extrapolate_densities(
        &self,
        setting: &SolverContext<D>,
        bodies: &mut Bodies<D>,
        neighbours: &NeighbourList<D>,
    ) {
        if setting.options.wall_stress == WallStress::Pairwise {
            return;
        }
        for wall in self.first(bodies.particles.len())..bodies.particles.position.len() {
            let weight =
                self.soil_extrapolation(setting, &bodies.particles, neighbours).density_mass_and_sound(wall);
            let p = &mut bodies.particles;
            [p.density[wall], p.mass[wall], p.sound[wall]] = weight;
        }
    }

    /// Extrapolates the velocity of the soil to wall particles.
    pub fn extrapolate_velocities(
        &self,
        setting: &SolverContext<D>,
        bodies: &mut Bodies<D>,
        neighbours: &NeighbourList<D>,
    ) {
        if setting.options.wall_stress == WallStress::Pairwise {
            return;
        }
        for wall in self.first(bodies.particles.len())..bodies.particles.position.len() {
            let velocity = self.soil_extrapolation(setting, &bodies.particles, neighbours).velocity(wall);
            bodies.particles.velocity[wall] = velocity;
            set_velocity(&mut bodies.pair_data.records[wall], &velocity);
        }
    }
}
