//! Walls: mirrors, layers of particles, and periodic boundaries (sheet: sph §2.13).
//!
//! [`FlatWalls`] are the flat walls of a stage. Mirrors and periodic boundaries add images of particles behind the particles in the arrays;
//! other walls consist of layers of particles behind these. Wall particles have the mirrored state of each particle, or extrapolate stress
//! and velocity from the soil (`extrapolated_walls`). Held smooth bodies act as smooth walls of any shape (`smooth_bodies`).
//! [`ObstacleFaces`] are rigid geometry of any shape, without particles.

pub(crate) mod delayed_friction;
pub(crate) mod extrapolated_walls;
pub(crate) mod rigid_support;

#[cfg(test)]
mod tests;

pub use crate::boundary::build::{check_walls, flat_walls, has_friction, is_mirror, wall_particle_count};
pub use crate::boundary::flat_wall::{FlatWall, WallContact};
pub use crate::boundary::flat_walls::FlatWalls;
pub use crate::boundary::image_particle::ImageParticle;
pub use crate::obstacles::obstacle_faces::ObstacleFaces;
pub use crate::obstacles::penetration_limit::ObstacleEnergies;
pub use crate::obstacles::smooth_bodies::SmoothBodies;

use crate::config::WallStress;
use crate::context::SolverContext;
use crate::points::packed_particles::set_velocity;
use crate::points::particles::{Bodies, Derivatives, PairData, ParticleGroup, Particles};
use crate::points::vector_algebra::mirrored_stress;

/// Boundaries around the particles. In the arrays of [`Particles`] the particles are followed by the images, then by the particles of the
/// walls.
#[derive(Clone, Debug, Default)]
pub struct Walls<const D: usize> {
    /// The flat walls of the stage.
    pub planes: FlatWalls<D>,
    /// Images of the particles near mirrors and periodic boundaries.
    pub images: Vec<ImageParticle<D>>,
    /// Index ranges of the smooth bodies.
    pub smooth_bodies: SmoothBodies,
    /// Rigid geometry, common to all stages, at rest or moving.
    pub obstacles: ObstacleFaces<D>,
}

impl<const D: usize> Walls<D> {
    /// Returns the walls of a stage, without images.
    pub fn new(planes: FlatWalls<D>, obstacles: ObstacleFaces<D>) -> Self {
        Self { planes, obstacles, ..Self::default() }
    }

    /// Returns a copy of the walls without images.
    pub fn empty_like(&self) -> Self {
        Self::new(self.planes.clone(), self.obstacles.empty_like())
    }

    /// Index of the first wall particle, behind `len` particles.
    pub fn first(&self, len: usize) -> usize {
        len + self.images.len()
    }

    /// Moves planes and obstacles to `time` (s).
    fn move_to(&mut self, time: f64) {
        self.planes.move_to(time);
        self.obstacles.move_to(time);
    }

    /// Finds the images of particles at `positions` within `reach` (m) of mirrors and periodic boundaries at
    /// `time` (s).
    pub fn find_images(&mut self, positions: &[[f64; D]], time: f64, reach: f64) {
        self.move_to(time);
        self.planes.images(positions, reach, &mut self.images);
    }

    /// Moves images and wall particles to `time` (s).
    pub fn place_at_time(&mut self, time: f64, particles: &mut Particles<D>) {
        self.move_to(time);
        self.planes.move_images(&mut self.images);
        self.place_all(particles);
    }

    /// Writes the positions of images and wall particles at the present position of the walls.
    pub fn place_all(&self, particles: &mut Particles<D>) {
        let len = particles.len();
        for (image, slot) in self.images.iter().zip(len..) {
            let x = particles.position[image.source as usize];
            particles.position[slot] = std::array::from_fn(|c| image.axis_sign[c] * x[c] + image.shift[c]);
        }
        self.planes.place_particles(&mut particles.position[self.first(len)..]);
    }

    /// Sets the time-dependent wall velocities of the step from `start` to `end` (s).
    pub fn update_time_histories(&mut self, start: f64, end: f64) {
        if self.planes.update_time_histories(start, end) {
            self.planes.move_images(&mut self.images);
        }
    }

    /// Updates the velocities of the images.
    pub fn move_images(&self, bodies: &mut Bodies<D>) {
        let Bodies { particles, pair_data, .. } = bodies;
        for (image, slot) in self.images.iter().zip(particles.len()..) {
            let v = particles.velocity[image.source as usize];
            particles.velocity[slot] =
                std::array::from_fn(|c| image.velocity_sign[c] * v[c] + image.velocity_shift[c]);
            set_velocity(&mut pair_data.records[slot], &particles.velocity[slot]);
        }
    }

    /// Replaces fluid particles behind smooth walls at `time` (s) by their images in front of the face; returns whether there were any. In
    /// a mirror this is exact: the image continues the motion of the particle, and only their names change. A slow particle that sinks onto
    /// a mirror is repelled less the closer it is, and passes.
    pub fn reflect_escaped(&self, bodies: &mut Bodies<D>, rates: &mut Derivatives<D>, time: f64) -> bool {
        let mut any = false;
        let Bodies { particles: p, groups, .. } = bodies;
        for plane in self
            .planes
            .mirrors
            .iter()
            .chain(&self.planes.faces)
            .filter(|plane| plane.contact == WallContact::FreeSlip)
        {
            let (axis, face) = (plane.axis, plane.face_at(time));
            let image = ImageParticle::of_particle(0).flipped(0, plane);
            for i in groups
                .iter()
                .filter(|group| group.fluid && group.prescribed_velocity.is_none())
                .flat_map(ParticleGroup::range)
            {
                let x = p.position[i][axis];
                if !(if plane.is_upper { x > face } else { x < face }) {
                    continue;
                }
                any = true;
                p.position[i][axis] = 2.0 * face - x;
                p.velocity[i][axis] =
                    image.velocity_sign[axis] * p.velocity[i][axis] + image.velocity_shift[axis];
                if let Some(previous) = p.previous.get_mut(i) {
                    previous[axis] = image.velocity_sign[axis] * previous[axis] + image.velocity_shift[axis];
                }
                p.stress[i] = mirrored_stress(&p.stress[i], &image.stress_sign);
                if let Some(acceleration) = rates.acceleration.get_mut(i) {
                    acceleration[axis] = -acceleration[axis];
                }
                if let Some(gradient) = rates.gradient.get_mut(i) {
                    *gradient = image.gradient(gradient);
                }
            }
        }
        any
    }

    /// Updates all other fields of the images.
    pub fn load_images(&self, bodies: &mut Bodies<D>) {
        let Bodies { particles: p, pair_data: PairData { grad_h_factor: spread, repulsion, .. }, .. } =
            bodies;
        for (image, slot) in self.images.iter().zip(p.len()..) {
            let source = image.source as usize;
            p.mass[slot] = p.mass[source];
            p.density[slot] = p.density[source];
            p.sound[slot] = p.sound[source];
            p.length[slot] = p.length[source];
            spread[slot] = spread[source];
            p.stress[slot] = mirrored_stress(&p.stress[source], &image.stress_sign);
            if !repulsion.is_empty() {
                repulsion[slot] = mirrored_stress(&repulsion[source], &image.stress_sign);
            }
        }
    }

    /// Particle of neighbour `j`, itself or as a periodic image, of `len` particles; `None` for images in
    /// mirrors and wall particles.
    #[inline]
    pub fn particle_of(&self, len: usize, j: usize) -> Option<usize> {
        let Some(number) = j.checked_sub(len) else { return Some(j) };
        let image = self.images.get(number)?;
        (image.axis_sign == [1.0; D]).then_some(image.source as usize)
    }

    /// Index of the first neighbour that is a dummy particle with a mirrored state.
    pub fn first_dummy_particle(&self, setting: &SolverContext<D>, len: usize) -> usize {
        match setting.options.wall_stress {
            WallStress::Pairwise => self.first(len),
            WallStress::Interpolated | WallStress::Extrapolated => usize::MAX,
        }
    }
}
