//! Time, stage and the step.

use colluvium_case::{SolverError, TimeStep};
use serde::{Deserialize, Serialize};

/// Steps between two evaluations of the speeds of sound and the time step.
pub const STEPS_PER_TIME_STEP: u64 = 10;

/// Where a run stands.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Clock {
    /// Index into `Case::stages`.
    pub stage: usize,
    /// Time when the stage began (s).
    pub stage_start: f64,
    /// Time (s).
    pub time: f64,
    /// Steps done.
    pub step: u64,
    /// Length of the step before, zero at the start (s).
    pub last_step: f64,
    /// The step that is stable, or that the case fixes.
    pub limit: Option<TimeStep>,
    /// Steps since it was found.
    pub limit_age: u64,
    /// Time up to which particles have been shifted for their way (s).
    pub last_shift_time: f64,
}

impl Clock {
    /// Counts a step of `dt` (s).
    pub fn end_step(&mut self, dt: f64) {
        self.time += dt;
        self.step += 1;
        self.last_step = dt;
        self.limit_age += 1;
    }

    /// Whether what happens every so many steps happens in this one.
    pub fn is_due(&self, every: u64) -> bool {
        self.step > 0 && self.step.is_multiple_of(every)
    }

    /// Whether the stable step is to be found anew.
    pub fn is_limit_due(&self) -> bool {
        self.limit.is_none() || self.limit_age >= STEPS_PER_TIME_STEP
    }

    /// Takes the critical step, or the one that the case fixes (s); which it is.
    pub fn set_limit(&mut self, critical: TimeStep, fixed: Option<f64>) -> TimeStep {
        // The first of a stage knows nothing of its forces: it is for one step.
        let age = if self.limit.is_none() { STEPS_PER_TIME_STEP - 1 } else { 0 };
        let limit = critical.or_fixed(fixed);
        (self.limit, self.limit_age) = (Some(limit), age);
        limit
    }

    /// What is wrong with the step that the case fixes (s), where it is longer than the critical one.
    pub fn fixed_step_problem(&self, fixed: Option<f64>) -> Option<String> {
        self.limit.as_ref()?.fixed_step_problem(fixed)
    }

    /// The error of a step that cannot be done.
    pub fn step_error(&self, reason: String) -> SolverError {
        SolverError::Step { step: self.step, time: self.time, reason }
    }
}
