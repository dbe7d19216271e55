//! Rigid walls: planes and obstacles (sheet: dem §2.10).

use std::sync::Arc;

use colluvium_case::{MovingObstacle, ObstacleLaws, ProgramMotion};
use colluvium_points::Surface;

use crate::contact::PairLaw;

/// Rigid wall: a plane across an axis, or an obstacle.
#[derive(Clone, Debug)]
pub struct RigidWall<const D: usize> {
    /// Surface of an obstacle at its initial position; `None` for a plane across an axis.
    pub surface: Option<Arc<dyn Surface<D>>>,
    /// Prescribed motion of a moving obstacle.
    pub motion: Option<MovingObstacle<D>>,
    /// Index into the boundaries of the case, and after them its obstacles.
    pub boundary: usize,
    /// Name.
    pub name: String,
    /// Axis normal to the plane.
    pub axis: usize,
    /// Whether the wall bounds the grains from above.
    pub is_upper: bool,
    /// Coordinate of the plane along its axis (m).
    pub position: f64,
    /// Velocity (m/s).
    pub velocity: [f64; D],
    /// Velocity that a program prescribes (m/s), which replaces that of the boundary and of a servo from the next forces on.
    pub program_velocity: Option<[f64; D]>,
    /// Contact law for each kind of grains; for an obstacle with regions, that outside the regions.
    pub laws: Vec<PairLaw>,
    /// Regions of an obstacle, which select the law by position.
    pub obstacle_laws: Option<ObstacleLaws>,
    /// Law for each kind in each of the regions.
    pub regions: Vec<Vec<PairLaw>>,
    /// Force on the wall in the last step (N), and impulse since the start (N s).
    pub reaction: [[f64; D]; 2],
    /// Moment of the force in the last step about the origin of coordinates (N m); computed for obstacles only.
    pub moment: [f64; 3],
}

/// Reaction of a wall.
#[derive(Clone, Copy, Debug)]
pub struct WallReaction<const D: usize> {
    /// Force (N).
    pub force: [f64; D],
    /// Moment of the force about the origin of coordinates (N m); computed for obstacles only.
    pub moment: [f64; 3],
}

impl<const D: usize> WallReaction<D> {
    /// Zero reaction.
    pub const ZERO: Self = Self { force: [0.0; D], moment: [0.0; 3] };
}

impl<const D: usize> RigidWall<D> {
    /// Distance of a point from a plane (m), and the unit normal from the plane to the point.
    #[inline]
    pub fn distance(&self, x: &[f64; D]) -> (f64, [f64; D]) {
        let mut normal = [0.0; D];
        let sign = if self.is_upper { -1.0 } else { 1.0 };
        normal[self.axis] = sign;
        (sign * (x[self.axis] - self.position), normal)
    }

    /// Motion that a program prescribes for a moving obstacle.
    pub fn program_motion(&self) -> Option<ProgramMotion> {
        self.motion.as_ref().and_then(|moving| moving.program_motion)
    }

    /// Sets the motion that a program prescribes for a moving obstacle.
    pub fn set_program_motion(&mut self, motion: Option<ProgramMotion>) {
        if let Some(moving) = &mut self.motion {
            moving.program_motion = motion;
        }
    }

    /// Surface of an obstacle at its current position; `None` for a plane across an axis.
    pub fn current_surface(&self) -> Option<&dyn Surface<D>> {
        match &self.motion {
            Some(moving) => Some(&moving.surface),
            None => self.surface.as_deref(),
        }
    }

    /// Contact law of the wall for a grain of a kind at `x` (m), whose distance and normal are given.
    #[inline]
    pub fn law(&self, kind: usize, x: &[f64; D], (distance, normal): &(f64, [f64; D])) -> &PairLaw {
        let region = self
            .obstacle_laws
            .as_ref()
            .map_or(0, |places| places.region(&contact_position(x, *distance, normal)));
        self.regions.get(region).map_or(&self.laws[kind], |laws| &laws[kind])
    }

    /// Axis normal to a plane wall, and sign of the inward direction along it.
    pub fn inward_normal(&self) -> (usize, f64) {
        (self.axis, if self.is_upper { -1.0 } else { 1.0 })
    }

    /// Outward force of the grains on a plane (N).
    pub fn outward_force(&self) -> f64 {
        let (axis, inward) = self.inward_normal();
        -inward * self.reaction[0][axis]
    }

    /// Velocity of the wall at `x` (m/s).
    #[inline]
    pub fn velocity_at(&self, x: &[f64; D]) -> [f64; D] {
        self.motion.as_ref().map_or(self.velocity, |moving| moving.velocity(x))
    }

    /// Whether a point is within `reach` of the wall (m).
    pub fn is_near(&self, x: &[f64; D], reach: f64) -> bool {
        match self.current_surface() {
            None => self.distance(x).0 < reach,
            Some(surface) => surface.gap(x, reach).is_some(),
        }
    }
}

/// Contact point of a grain at `x` on a wall (m), with the lever arm `arm` (m).
#[inline]
pub fn contact_position<const D: usize>(x: &[f64; D], arm: f64, normal: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|c| x[c] - arm * normal[c])
}
