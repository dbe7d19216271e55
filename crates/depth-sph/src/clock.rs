//! Clock of a flow.

/// Time and number of steps of a flow.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Clock {
    /// Time (s).
    pub time: f64,
    /// Number of completed steps.
    pub step: u64,
}

impl Clock {
    /// Ends a step of `dt` (s).
    pub fn end(&mut self, dt: f64) {
        self.time += dt;
        self.step += 1;
    }
}
