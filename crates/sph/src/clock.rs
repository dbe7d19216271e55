//! Time, stage and time step.

use colluvium_case::{FailureReason, SolverError, TimeStep};
use serde::{Deserialize, Serialize};

/// Steps between two evaluations of the speeds of sound and the time step.
pub const STEPS_PER_TIME_STEP: u64 = 10;

/// Time, step and stage of a run.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Clock {
    /// Index into `Case::stages`.
    pub stage: usize,
    /// Time when the stage began (s).
    pub stage_start: f64,
    /// Time (s).
    pub time: f64,
    /// Number of completed steps.
    pub step: u64,
    /// Length of the step before, zero at the start (s).
    pub last_step: f64,
    /// Stable time step, or the fixed step of the case.
    pub limit: Option<TimeStep>,
    /// Steps since the limit was computed.
    pub limit_age: u64,
    /// Time of the last particle shift (s).
    pub last_shift_time: f64,
}

impl Clock {
    /// Advances the clock by a step of `dt` (s).
    pub fn end_step(&mut self, dt: f64) {
        self.time += dt;
        self.step += 1;
        self.last_step = dt;
        self.limit_age += 1;
    }

    /// Whether an action that is repeated every `every` steps is due in this step.
    pub fn is_due(&self, every: u64) -> bool {
        self.step > 0 && self.step.is_multiple_of(every)
    }

    /// Whether the stable step must be recomputed.
    pub fn is_limit_due(&self) -> bool {
        self.limit.is_none() || self.limit_age >= STEPS_PER_TIME_STEP
    }

    /// Sets the time step to the critical step, or to the fixed step of the case (s), and returns it.
    pub fn set_limit(&mut self, critical: TimeStep, fixed: Option<f64>) -> TimeStep {
        // The first limit of a stage does not include its forces and is for one step.
        let age = if self.limit.is_none() { STEPS_PER_TIME_STEP - 1 } else { 0 };
        let limit = critical.or_fixed(fixed);
        (self.limit, self.limit_age) = (Some(limit), age);
        limit
    }

    /// Problem of a fixed step of the case (s) that exceeds the critical step.
    pub fn fixed_step_problem(&self, fixed: Option<f64>) -> Option<String> {
        self.limit.as_ref()?.fixed_step_problem(fixed)
    }

    /// Error of a step that failed.
    pub fn step_error(&self, reason: impl Into<FailureReason>) -> SolverError {
        SolverError::Step { step: self.step, time: self.time, reason: reason.into() }
    }
}
