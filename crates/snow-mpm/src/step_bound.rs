//! Bound of the time step.

use colluvium_case::StepLimit;

/// Bound of the time step of a set of points, and their displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepBound {
    /// Inverse of the longest step (1/s).
    pub rate: f64,
    /// Cause of the bound.
    pub limit: StepLimit,
    /// Index of the limiting point in its body.
    pub index: usize,
    /// Largest displacement along an axis in the last step (m).
    pub max_move: f64,
    /// Whether a point has left a body that allows it.
    pub any_outside: bool,
}

impl StepBound {
    /// Bound without points.
    pub const NONE: Self =
        Self { rate: 0.0, limit: StepLimit::NOTHING, index: 0, max_move: 0.0, any_outside: false };

    /// Tightens the bound to a higher rate; at equal rates the first one remains.
    pub fn tighten(&mut self, rate: f64, limit: StepLimit, index: usize) {
        if rate > self.rate {
            (self.rate, self.limit, self.index) = (rate, limit, index);
        }
    }
}
