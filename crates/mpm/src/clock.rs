//! What is solved and when: case, stage, time, step and its limit.

use std::sync::Arc;

use colluvium_case::description::Stage;
use colluvium_case::{Case, SolverError, TimeStep};

use crate::MpmOptions;

/// The clock of a run, and what it runs. In a step it is only read.
pub struct Clock {
    pub(crate) case: Arc<Case>,
    pub(crate) options: MpmOptions,
    /// Share of FLIP in the stage.
    pub(crate) flip: f64,
    /// Full gravity (m/s²).
    pub(crate) gravity: [f64; 3],
    pub(crate) stage: usize,
    /// When the stage began (s).
    pub(crate) stage_start: f64,
    /// At the start of the step (s).
    pub(crate) time: f64,
    /// The step (s).
    pub(crate) dt: f64,
    /// Number of steps before this one.
    pub(crate) step: u64,
    pub(crate) limit: Option<TimeStep>,
    /// Courant number of steps of the limit.
    pub(crate) courant: f64,
    /// Steps since the limit was found.
    pub(crate) limit_age: u64,
}

impl Clock {
    /// At time zero.
    pub fn new(case: &Case, options: &MpmOptions) -> Self {
        Self {
            flip: options.flip_share(&case.stages[0]),
            gravity: case.gravity3(),
            case: Arc::new(case.clone()),
            options: options.clone(),
            stage: 0,
            stage_start: 0.0,
            time: 0.0,
            dt: 0.0,
            step: 0,
            limit: None,
            courant: options.courant,
            limit_age: 0,
        }
    }

    /// The stage that runs.
    pub fn stage(&self) -> &Stage {
        &self.case.stages[self.stage]
    }

    /// Whether a node that is held keeps its momentum at the start of the step.
    pub fn keeps_initial_velocity(&self) -> bool {
        self.options.fixed_nodes == crate::FixedNodes::Momentum
    }

    /// Share of what the grid cannot see of the points' velocities that XPIC takes in the step.
    pub fn residual_share(&self) -> f64 {
        self.options.residual_time.map_or(1.0, |time| -(-self.dt / time).exp_m1())
    }

    /// Gravity at the end of the step (m/s²).
    pub fn gravity_at_end(&self) -> [f64; 3] {
        let factor = self.stage().gravity_factor(self.time + self.dt - self.stage_start);
        self.gravity.map(|g| g * factor)
    }

    /// Ends the step.
    pub fn end(&mut self) {
        self.time += self.dt;
        self.step += 1;
        self.limit_age += 1;
    }

    /// Begins a step of `dt` (s).
    ///
    /// # Errors
    /// Where the case fixes a step that the state no longer allows.
    pub fn begin(&mut self, dt: f64) -> Result<(), SolverError> {
        self.dt = dt;
        match self.limit.as_ref().and_then(|limit| limit.fixed_step_problem(self.options.time_step)) {
            Some(problem) => Err(self.step_error(format!("methods.mpm.time_step: {problem}"))),
            None => Ok(()),
        }
    }

    /// The error of a step.
    pub fn step_error(&self, reason: String) -> SolverError {
        SolverError::Step { step: self.step, time: self.time, reason }
    }
}
