//! Walls: mirrors, layers of particles, and the ends of periodic domains (sheet: sph §2.13).
//!
//! [`FlatWalls`] are the flat walls of a stage. Mirrors and the ends of periods put images of particles behind the
//! particles; other walls consist of layers of particles behind these. To each particle they answer with what it is
//! itself, or they take stress and velocity from the soil around (`soil`). Bodies that are held and smooth
//! answer as smooth walls of any shape do (`smooth_bodies`). [`ObstacleFaces`] are rigid geometry of any shape, without particles.

#[cfg(test)]
mod tests;

pub use crate::boundary::build::{check_walls, flat_walls, has_friction, is_mirror, wall_particle_count};
pub use crate::boundary::flat_wall::{FlatWall, WallContact};
pub use crate::boundary::flat_walls::FlatWalls;
pub use crate::boundary::image_particle::ImageParticle;
pub use crate::obstacles::obstacle_faces::{DummySite, ObstacleFace, ObstacleFaces, dummy_sites};
pub use crate::obstacles::penetration_limit::ObstacleEnergies;
pub use crate::obstacles::smooth_bodies::SmoothBodies;

use crate::config::WallStress;
use crate::context::SolverContext;
use crate::pairs::simd_pairs::set_velocity;
use crate::points::particles::{Bodies, Derivatives, PairData, ParticleGroup, Particles};
use crate::points::vector_algebra::mirrored_stress;

/// What stands around the particles. The images come behind the particles in the arrays of [`Particles`], then the
/// particles of the walls.
#[derive(Clone, Debug, Default)]
pub struct Walls<const D: usize> {
    /// The flat walls of the stage.
    pub planes: FlatWalls<D>,
    /// Images of the particles near mirrors and the ends of periods.
    pub images: Vec<ImageParticle<D>>,
    /// Where the smooth bodies stand.
    pub smooth: SmoothBodies,
    /// Rigid geometry, the same in all stages, at rest or on its way.
    pub obstacles: ObstacleFaces<D>,
}

impl<const D: usize> Walls<D> {
    /// Those of a stage, with nothing beside them yet.
    pub fn new(planes: FlatWalls<D>, obstacles: ObstacleFaces<D>) -> Self {
        Self { planes, obstacles, ..Self::default() }
    }

    /// The same planes without images.
    pub fn empty_like(&self) -> Self {
        Self::new(self.planes.clone(), self.obstacles.empty_like())
    }

    /// Number of the first particle of a wall, behind `len` particles.
    pub fn first(&self, len: usize) -> usize {
        len + self.images.len()
    }

    /// Planes and obstacles to where they are at `time` (s).
    fn move_to(&mut self, time: f64) {
        self.planes.move_to(time);
        self.obstacles.move_to(time);
    }

    /// Finds the images of particles at `positions` within `reach` (m) of mirrors and ends of periods, as these stand at
    /// `time` (s).
    pub fn find_images(&mut self, positions: &[[f64; D]], time: f64, reach: f64) {
        self.move_to(time);
        self.planes.images(positions, reach, &mut self.images);
    }

    /// Images and particles of walls to their places at `time` (s).
    pub fn place_at_time(&mut self, time: f64, particles: &mut Particles<D>) {
        self.move_to(time);
        self.planes.move_images(&mut self.images);
        self.place_all(particles);
    }

    /// Images and particles of walls to where the walls stand now.
    pub fn place_all(&self, particles: &mut Particles<D>) {
        let len = particles.len();
        for (image, slot) in self.images.iter().zip(len..) {
            let x = particles.position[image.source as usize];
            particles.position[slot] = std::array::from_fn(|c| image.flip[c] * x[c] + image.shift[c]);
        }
        self.planes.place_particles(&mut particles.position[self.first(len)..]);
    }

    /// Walls whose velocities vary in time get those of the step from `start` to `end` (s).
    pub fn update_time_histories(&mut self, start: f64, end: f64) {
        if self.planes.update_time_histories(start, end) {
            self.planes.move_images(&mut self.images);
        }
    }

    /// Velocities of the images.
    pub fn move_images(&self, bodies: &mut Bodies<D>) {
        let Bodies { particles, pair_data: shown, .. } = bodies;
        for (image, slot) in self.images.iter().zip(particles.len()..) {
            let v = particles.velocity[image.source as usize];
            particles.velocity[slot] =
                std::array::from_fn(|c| image.velocity_sign[c] * v[c] + image.velocity_shift[c]);
            set_velocity(&mut shown.records[slot], &particles.velocity[slot]);
        }
    }

    /// Particles of fluids behind smooth walls, as these stand at `time` (s), go on as their images in the face. In a mirror that
    /// is exact: what the particle would have done behind it its image does before it, and nothing changes but their names. A
    /// slow particle that sinks onto a mirror is pushed less the closer it is, and passes. Whether there were any.
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
                .filter(|group| group.fluid && group.held.is_none())
                .flat_map(ParticleGroup::range)
            {
                let x = p.position[i][axis];
                if !(if plane.upper { x > face } else { x < face }) {
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

    /// Everything else of the images.
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

    /// The particle that neighbour `j` is, or whose image in a period it is, of `len` particles; `None` for images in
    /// mirrors and particles of walls.
    #[inline]
    pub fn particle_of(&self, len: usize, j: usize) -> Option<usize> {
        let Some(number) = j.checked_sub(len) else { return Some(j) };
        let image = self.images.get(number)?;
        (image.flip == [1.0; D]).then_some(image.source as usize)
    }

    /// From which neighbour on they are walls that answer to the particle itself.
    pub fn first_dummy_particle(&self, setting: &SolverContext<D>, len: usize) -> usize {
        match setting.options.wall_stress {
            WallStress::Pairwise => self.first(len),
            WallStress::Interpolated | WallStress::Extrapolated => usize::MAX,
        }
    }
}
