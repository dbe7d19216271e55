//! Bound of the time step from some points.

use colluvium_case::StepLimit;

/// Bound of the time step by a group of points, with their displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepBound {
    /// Inverse of the longest step (1/s).
    pub rate: f64,
    /// Limit that gives the longest step.
    pub limit: StepLimit,
    /// Index of the limiting point in its body.
    pub point_index: usize,
    /// Largest displacement along an axis in the last step (m).
    pub max_move: f64,
    /// Whether a point of a body with `remove_outside` has left the domain.
    pub any_outside: bool,
}

impl StepBound {
    /// Bound of the time step without points.
    pub const UNBOUNDED: Self =
        Self { rate: 0.0, limit: StepLimit::NO_MOTION, point_index: 0, max_move: 0.0, any_outside: false };

    /// Replaces the limit by a stricter one; among equal ones the first remains.
    pub fn restrict(&mut self, rate: f64, limit: StepLimit, index: usize) {
        if rate > self.rate {
            (self.rate, self.limit, self.point_index) = (rate, limit, index);
        }
    }
}
