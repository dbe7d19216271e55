//! What limits the step of some points.

use colluvium_case::StepLimit;

/// What limits the step of some points, and how far they have moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepBound {
    /// One over the longest step (1/s).
    pub rate: f64,
    /// What limits it.
    pub limit: StepLimit,
    /// Index of the point in its body.
    pub index: usize,
    /// Largest move along an axis in the last step (m).
    pub max_move: f64,
    /// Whether a point has left a body that lets it.
    pub any_outside: bool,
}

impl StepBound {
    /// Of no points.
    pub const NONE: Self =
        Self { rate: 0.0, limit: StepLimit::NOTHING, index: 0, max_move: 0.0, any_outside: false };

    /// Takes what limits more, of equals what came first.
    pub fn tighten(&mut self, rate: f64, limit: StepLimit, index: usize) {
        if rate > self.rate {
            (self.rate, self.limit, self.index) = (rate, limit, index);
        }
    }
}
