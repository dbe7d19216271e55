//! Facets of obstacles as grains see them, and obstacles on their way (sheet: dem §2.10).

use std::sync::Arc;

use colluvium_case::description::ObstacleMotion;
use colluvium_points::Surface;
use colluvium_points::surface::{Nearest, Placed};

/// Facets of an obstacle that a grain can touch at once; of more the nearest count.
pub const SLOTS: usize = 6;

/// Key of a contact that has no facet.
pub const FREE: u64 = u64::MAX;

/// Where an entry of the list sees its facet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// Distance of the grain's centre (m).
    pub distance: f64,
    /// Normal towards the grain.
    pub normal: [f64; 3],
}

impl Facet {
    /// Out of reach.
    pub const NONE: Self = Self { distance: f64::INFINITY, normal: [0.0; 3] };

    /// What is known of a place.
    pub fn of<const D: usize>(place: &Nearest<D>) -> Self {
        let normal = std::array::from_fn(|c| place.normal.get(c).copied().unwrap_or(0.0));
        Self { distance: place.distance, normal }
    }

    /// Distance and normal in space.
    pub fn seen<const D: usize>(&self) -> (f64, [f64; D]) {
        (self.distance, std::array::from_fn(|c| self.normal[c]))
    }
}

/// An obstacle on a prescribed way.
#[derive(Clone, Debug)]
pub struct Moving<const D: usize> {
    motion: ObstacleMotion,
    /// Its surface where it is.
    pub placed: Placed<D>,
    /// A place on the line about which it turns (m).
    centre: [f64; D],
    /// Velocity of that place since the forces before (m/s).
    velocity: [f64; D],
    /// Angular velocity then (rad/s).
    spin: [f64; 3],
    /// How far from that place its surface reaches, at most (m).
    reach: f64,
    /// Corners of the domain (m).
    domain: ([f64; D], [f64; D]),
}

/// Distance of the farthest corner of a box from a place (m).
fn farthest<const D: usize>(centre: &[f64; D], (low, high): &([f64; D], [f64; D])) -> f64 {
    let far = |c: usize| (low[c] - centre[c]).abs().max((high[c] - centre[c]).abs());
    (0..D).map(|c| far(c).powi(2)).sum::<f64>().sqrt()
}

impl<const D: usize> Moving<D> {
    /// One that is where the case has it, in a domain with these corners (m).
    pub fn new(motion: &ObstacleMotion, surface: &Arc<dyn Surface<D>>, domain: ([f64; D], [f64; D])) -> Self {
        let centre: [f64; D] = std::array::from_fn(|c| motion.centre.get(c).copied().unwrap_or(0.0));
        let mut moving = Self {
            motion: motion.clone(),
            placed: Placed { surface: Arc::clone(surface), frame: motion.frame(0.0) },
            centre,
            velocity: [0.0; D],
            spin: [0.0; 3],
            reach: farthest(&centre, &surface.bounds()),
            domain,
        };
        moving.go_to(0.0, 0.0);
        moving
    }

    /// Brings it to where it is at `time` (s), a step of `last` (s) after the forces before.
    pub fn go_to(&mut self, time: f64, last: f64) {
        let motion = &self.motion;
        let at = |values: &[f64], c: usize| values.get(c).copied().unwrap_or(0.0);
        let (full, before) = (motion.full_time(time), motion.full_time(time - last));
        // Mean of the step, so that work is force times way.
        let pace = if last > 0.0 { (full - before) / last } else { motion.pace(time) };
        self.placed.frame = motion.frame(time);
        self.centre = std::array::from_fn(|c| at(&motion.centre, c) + full * at(&motion.velocity, c));
        self.velocity = std::array::from_fn(|c| pace * at(&motion.velocity, c));
        let rate = pace * motion.rotation.to_radians();
        let axis: [f64; 3] =
            if D == 2 { [0.0, 0.0, 1.0] } else { std::array::from_fn(|c| at(&motion.axis, c)) };
        let length = axis.iter().map(|c| c * c).sum::<f64>().sqrt();
        self.spin = if rate == 0.0 { [0.0; 3] } else { axis.map(|c| rate * c / length) };
    }

    /// Speed of the fastest place of its surface in the domain once its motion is at its full rate (m/s).
    pub fn fastest(&self) -> f64 {
        let reach = self.reach.min(farthest(&self.centre, &self.domain));
        let along = self.motion.velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
        along + self.motion.rotation.to_radians().abs() * reach
    }

    /// How far a place of its surface in the domain moves in a step of `dt` (s) from `time` (s), at most (m).
    pub fn way(&self, time: f64, dt: f64) -> f64 {
        self.fastest() * (self.motion.full_time(time + dt) - self.motion.full_time(time))
    }

    /// Velocity of its part at `x` (m/s).
    pub fn velocity(&self, x: &[f64; D]) -> [f64; D] {
        let arm: [f64; 3] = std::array::from_fn(|c| if c < D { x[c] - self.centre[c] } else { 0.0 });
        std::array::from_fn(|c| {
            let (a, b) = ((c + 1) % 3, (c + 2) % 3);
            self.velocity[c] + self.spin[a] * arm[b] - self.spin[b] * arm[a]
        })
    }

    /// Its angular velocity (rad/s).
    pub fn spin<const R: usize>(&self) -> [f64; R] {
        if R == 1 { [self.spin[2]; R] } else { std::array::from_fn(|c| self.spin[c]) }
    }
}
