//! What limits the step of some points.

use colluvium_case::StepLimit;

/// What limits the step of some points, and how far they have moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// One over the longest step (1/s).
    pub rate: f64,
    /// What limits it.
    pub limit: StepLimit,
    /// Index of the point in its body.
    pub index: usize,
    /// Largest move along an axis in the last step (m).
    pub moved: f64,
    /// Whether a point has left a body that lets it.
    pub left: bool,
}

impl Pace {
    /// Of no points.
    pub const NONE: Self = Self { rate: 0.0, limit: StepLimit::NOTHING, index: 0, moved: 0.0, left: false };

    /// Takes what limits more, of equals what came first.
    pub fn take(&mut self, rate: f64, limit: StepLimit, index: usize) {
        if rate > self.rate {
            (self.rate, self.limit, self.index) = (rate, limit, index);
        }
    }
}
