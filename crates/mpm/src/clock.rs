//! Clock of a run: case, stage, time, step and its limit.

use std::sync::Arc;

use colluvium_case::description::Stage;
use colluvium_case::{Case, FailureReason, SolverError, TimeStep};

use crate::MpmOptions;

/// Time, step, stage and options of a run with its case; constant during a step.
pub struct Clock {
    /// Case of the run.
    pub(crate) case: Arc<Case>,
    /// Options of the method.
    pub(crate) options: MpmOptions,
    /// Share of FLIP in the stage.
    pub(crate) flip_fraction: f64,
    /// Full gravity (m/s²).
    pub(crate) gravity: [f64; 3],
    /// Index of the current stage.
    pub(crate) stage: usize,
    /// Start time of the stage (s).
    pub(crate) stage_start: f64,
    /// Time at the start of the step (s).
    pub(crate) time: f64,
    /// Time step (s).
    pub(crate) dt: f64,
    /// Number of completed steps.
    pub(crate) step: u64,
    /// Critical time step, once computed.
    pub(crate) limit: Option<TimeStep>,
    /// Courant number of the step limit.
    pub(crate) courant: f64,
    /// Number of steps since the limit was computed.
    pub(crate) limit_age: u64,
}

impl Clock {
    /// Returns the clock at time zero.
    pub fn new(case: &Case, options: &MpmOptions) -> Self {
        Self {
            flip_fraction: options.flip_share(&case.stages[0]),
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

    /// Current stage.
    pub fn stage(&self) -> &Stage {
        &self.case.stages[self.stage]
    }

    /// Whether constrained nodes keep their initial velocity of the step, so that walls act only on the velocity at its end.
    pub fn keeps_initial_velocity(&self) -> bool {
        self.options.fixed_nodes == crate::FixedNodes::Momentum
    }

    /// Fraction of the null-space velocities of the points that XPIC removes in the step.
    pub fn residual_share(&self) -> f64 {
        self.options.residual_time.map_or(1.0, |time| -(-self.dt / time).exp_m1())
    }

    /// Gravity at the end of the step (m/s²).
    pub fn gravity_at_end(&self) -> [f64; 3] {
        let factor = self.stage().gravity_factor(self.time + self.dt - self.stage_start);
        self.gravity.map(|g| g * factor)
    }

    /// Ends the step: increases time and number of steps.
    pub fn end(&mut self) {
        self.time += self.dt;
        self.step += 1;
        self.limit_age += 1;
    }

    /// Begins a step of `dt` (s); an error if the fixed time step exceeds the critical one.
    ///
    /// # Errors
    /// Where the case fixes a step that the state no longer allows.
    pub fn begin_step(&mut self, dt: f64) -> Result<(), SolverError> {
        self.dt = dt;
        match self.limit.as_ref().and_then(|limit| limit.fixed_step_problem(self.options.time_step)) {
            Some(problem) => {
                Err(self.step_error(FailureReason::FixedStep(format!("methods.mpm.time_step: {problem}"))))
            }
            None => Ok(()),
        }
    }

    /// Returns the error of a step.
    pub fn step_error(&self, reason: impl Into<FailureReason>) -> SolverError {
        SolverError::Step { step: self.step, time: self.time, reason: reason.into() }
    }
}
