//! Penetration limit of obstacles: a particle that its stress has not repelled is stopped before the surface.
//!
//! A particle of thin and fast flow has no stress to mirror. It is stopped as in an inelastic impact, with Coulomb friction: the step is
//! that with the velocity that keeps the particle before the surface.

use colluvium_points::surface::{ContactQuery, NearestPoint};
use serde::{Deserialize, Serialize};

use crate::obstacles::obstacle_faces::ObstacleFaces;
use crate::obstacles::thin_obstacles::ParticlePath;
use crate::points::particles::{Bodies, ParticleGroup};
use crate::points::vector_algebra::{dot, square};

/// Least distance of a particle from an obstacle (spacings).
const MIN_DISTANCE: f64 = 0.05;

/// Relative tolerance of the distance at which particles are stopped.
const DISTANCE_TOLERANCE: f64 = 1e-3;

/// Largest number of successive stops of a particle in a step.
const MAX_STOPS: usize = 4;

/// Energies that obstacles remove from particles (J).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObstacleEnergies {
    /// Work of friction at obstacles (J).
    pub friction: f64,
    /// Kinetic energy of the normal velocity, lost in impact.
    pub normal_loss: f64,
    /// Work of moving obstacles on the particles (J).
    pub work: f64,
}

impl ObstacleEnergies {
    /// Adds the energies of another obstacle or step.
    pub fn add(&mut self, other: &Self) {
        self.friction += other.friction;
        self.normal_loss += other.normal_loss;
        self.work += other.work;
    }
}

impl<const D: usize> ObstacleFaces<D> {
    /// Stops particles at obstacle surfaces at the `end` (s) of a step of `dt` (s), and adds the energies removed. Returns whether a
    /// particle was stopped. `hits` receives each impact on a measured obstacle: particle, obstacle, position (m) and impulse on the
    /// obstacle (N s).
    pub fn limit_penetration(
        &mut self,
        bodies: &mut Bodies<D>,
        obstacle_energies: &mut [ObstacleEnergies],
        (end, dt, spacing): (f64, f64, f64),
        mut hits: impl FnMut(usize, u32, &[f64; D], [f64; D]),
    ) -> bool {
        self.move_to(end);
        let obstacle_displacement = self.max_displacement(end - dt, end);
        let (mut any, mut found) = (false, std::mem::take(&mut self.contacts));
        let Bodies { particles: p, groups, .. } = bodies;
        let free = groups.iter().filter(|group| group.prescribed_velocity.is_none() && group.rigid.is_none());
        for i in free.flat_map(ParticleGroup::range) {
            let before = self.faces(i).iter().map(|face| face.distance).fold(f64::INFINITY, f64::min);
            let path_length = 2.0 * dt * square(&p.velocity[i]).sqrt() + obstacle_displacement;
            // Schemes with stages use predicted positions, which may lie within the distance.
            let kept =
                if before > 0.0 { (MIN_DISTANCE * spacing).min(before) } else { MIN_DISTANCE * spacing };
            if before > kept + path_length {
                continue;
            }
            let mut hit = StoppedParticle {
                x: p.position[i],
                v: p.velocity[i],
                energy_losses: ObstacleEnergies::default(),
            };
            let mass = p.mass[i];
            let own = &*self;
            let mut record = |obstacle: u32, x: &[f64; D], slower: [f64; D]| {
                if own.is_recorded(obstacle) {
                    hits(i, obstacle, x, slower.map(|v| mass * v));
                }
            };
            let start = std::array::from_fn(|c| hit.x[c] - dt * hit.v[c]);
            let distances = (kept, kept + path_length);
            let path = ParticlePath { start, end: hit.x, dt, spacing };
            if !self.stop_at_obstacles(i, &mut hit, &mut found, (distances, path), &mut record) {
                continue;
            }
            any = true;
            if let Some(previous) = p.previous.get_mut(i) {
                (0..D).for_each(|c| previous[c] += hit.v[c] - p.velocity[i][c]);
            }
            (p.position[i], p.velocity[i]) = (hit.x, hit.v);
            obstacle_energies[i].add(&ObstacleEnergies {
                friction: p.mass[i] * hit.energy_losses.friction,
                normal_loss: p.mass[i] * hit.energy_losses.normal_loss,
                work: p.mass[i] * hit.energy_losses.work,
            });
        }
        self.contacts = found;
        any
    }

    /// Stops a particle whose `path` comes closer to an obstacle than the first of two `distances` (m): the distance kept, and that at which
    /// obstacles are searched. Returns whether it was stopped. `record` receives the number of the obstacle, position and velocity change.
    fn stop_at_obstacles(
        &self,
        i: usize,
        hit: &mut StoppedParticle<D>,
        found: &mut ContactQuery<D>,
        (distances, path): ((f64, f64), ParticlePath<D>),
        record: &mut impl FnMut(u32, &[f64; D], [f64; D]),
    ) -> bool {
        let (mut any, kept) = (false, distances.0);
        for _ in 0..MAX_STOPS {
            let mut deepest: Option<(NearestPoint<D>, u32)> = None;
            let x = hit.x;
            self.contacts_on_path(i, &ParticlePath { end: x, ..path }, distances, found, |place, number| {
                let nearer = deepest.as_ref().is_none_or(|(deepest, _)| place.distance < deepest.distance);
                if nearer && place.distance < (1.0 - DISTANCE_TOLERANCE) * kept {
                    deepest = Some((*place, number));
                }
            });
            let Some((place, number)) = deepest else { break };
            let (before, solid) = (hit.v, &self.solids[number as usize]);
            let friction = solid.laws.law_at(&place.position).friction();
            hit.move_out_of_obstacle(
                &place.normal,
                kept - place.distance,
                friction,
                &solid.velocity_at(&x),
                path.dt,
            );
            record(number, &hit.x, std::array::from_fn(|c| before[c] - hit.v[c]));
            any = true;
        }
        any
    }
}

/// Particle that an obstacle stops, with its position and velocity.
struct StoppedParticle<const D: usize> {
    x: [f64; D],
    v: [f64; D],
    /// Energies lost, over the mass (J/kg).
    energy_losses: ObstacleEnergies,
}

impl<const D: usize> StoppedParticle<D> {
    /// Moves the particle by `lacks` along the normal of an obstacle (m) with the velocity `course` (m/s), and corrects its velocity with
    /// friction.
    fn move_out_of_obstacle(
        &mut self,
        normal: &[f64; D],
        lacks: f64,
        friction: f64,
        course: &[f64; D],
        dt: f64,
    ) {
        (0..D).for_each(|c| self.x[c] += lacks * normal[c]);
        let before = self.v;
        let seen: [f64; D] = std::array::from_fn(|c| before[c] - course[c]);
        let closing = dot(&seen, normal);
        let after = (closing + lacks / dt).min(closing.max(0.0));
        let slip: [f64; D] = std::array::from_fn(|c| seen[c] - closing * normal[c]);
        let speed = dot(&slip, &slip).sqrt();
        let rubs = if friction == 0.0 { 0.0 } else { (friction * (after - closing)).min(speed) };
        // No frictional impulse without slip, not even with infinite friction.
        let rubs = if after > closing && speed > 0.0 { rubs } else { 0.0 };
        let left = if speed > 0.0 { 1.0 - rubs / speed } else { 1.0 };
        self.energy_losses.normal_loss += 0.5 * (closing * closing - after * after);
        self.energy_losses.friction += 0.5 * speed * speed * (1.0 - left * left);
        self.v = std::array::from_fn(|c| course[c] + left * slip[c] + after * normal[c]);
        self.energy_losses.work += (0..D).map(|c| course[c] * (self.v[c] - before[c])).sum::<f64>();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impact_on_a_moving_obstacle_is_frame_independent_and_its_work_is_recorded() {
        let (normal, course) = ([0.0, 1.0], [0.7, 2.0]);
        let mut still =
            StoppedParticle { x: [1.0, -0.2], v: [3.0, -4.0], energy_losses: ObstacleEnergies::default() };
        let mut carried =
            StoppedParticle { x: [1.0, -0.2], v: [3.7, -2.0], energy_losses: ObstacleEnergies::default() };
        still.move_out_of_obstacle(&normal, 0.3, 0.5, &[0.0; 2], 0.1);
        carried.move_out_of_obstacle(&normal, 0.3, 0.5, &course, 0.1);
        assert!((0..2).all(|c| (carried.v[c] - course[c] - still.v[c]).abs() < 1e-14), "{:?}", carried.v);
        assert!((carried.energy_losses.friction - still.energy_losses.friction).abs() < 1e-14);
        let gained = 0.5 * dot(&carried.v, &carried.v) - 0.5 * (3.7 * 3.7 + 4.0);
        let ObstacleEnergies { friction, normal_loss: stopped, work } = carried.energy_losses;
        assert!((gained - (work - friction - stopped)).abs() < 1e-13, "{gained} {work}");
    }

    #[test]
    fn an_impact_reverses_penetration_and_removes_the_recorded_energy() {
        let normal = [0.0, 1.0];
        for friction in [0.0, 0.5, f64::INFINITY] {
            let mut hit = StoppedParticle {
                x: [1.0, -0.2],
                v: [3.0, -4.0],
                energy_losses: ObstacleEnergies::default(),
            };
            hit.move_out_of_obstacle(&normal, 0.3, friction, &[0.0; 2], 0.1);
            assert!((hit.x[1] - 0.1).abs() < 1e-15 && (hit.v[1] + 1.0).abs() < 1e-14, "{:?}", hit.v);
            assert!((hit.v[0] - (3.0 - (friction * 3.0).min(3.0))).abs() < 1e-14 || friction == 0.0);
            let lost = 12.5 - 0.5 * dot(&hit.v, &hit.v);
            assert!(
                (lost - hit.energy_losses.friction - hit.energy_losses.normal_loss).abs() < 1e-12,
                "{friction}"
            );
        }
        // A separating particle is not accelerated.
        let mut hit =
            StoppedParticle { x: [0.0, 0.0], v: [1.0, 2.0], energy_losses: ObstacleEnergies::default() };
        hit.move_out_of_obstacle(&normal, 0.1, 0.5, &[0.0; 2], 0.1);
        assert_eq!((hit.v, hit.energy_losses), ([1.0, 2.0], ObstacleEnergies::default()));
    }
}
