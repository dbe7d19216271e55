//! Clock: case, options, present stage and time.

use std::sync::Arc;

use colluvium_case::{Case, FailureReason, SolverError, spatial};

use crate::config::{DemOptions, GrainStage};
use crate::points::grains::Grains;
use crate::points::vector::add;

/// Time, step and stage of a run, with its case and options.
#[derive(Debug)]
pub struct Clock {
    /// Case of the run.
    pub case: Arc<Case>,
    /// Options of the method.
    pub options: DemOptions,
    /// Index of the present stage.
    pub stage: usize,
    /// Time at which the stage began (s).
    pub stage_start: f64,
    /// Time (s).
    pub time: f64,
    /// Number of steps since the start.
    pub step: u64,
    /// Length of the last step, zero at the start (s).
    pub last_step: f64,
    /// Factor on the last step by deep Hertz contacts.
    pub deep_contact_factor: f64,
}

impl Clock {
    /// Clock at the start of the first stage.
    pub fn new(case: &Case, options: DemOptions) -> Self {
        Self {
            case: Arc::new(case.clone()),
            options,
            stage: 0,
            stage_start: 0.0,
            time: 0.0,
            step: 0,
            last_step: 0.0,
            deep_contact_factor: 1.0,
        }
    }

    /// Options of the current stage, if there are any.
    pub fn stage_options(&self) -> Option<&GrainStage> {
        self.options.stages.get(&self.case.stages[self.stage].name)
    }

    /// Time since the start of the stage (s).
    pub fn elapsed(&self) -> f64 {
        self.time - self.stage_start
    }

    /// Ends a step of `dt` (s).
    pub fn end(&mut self, dt: f64) {
        self.time += dt;
        self.step += 1;
        self.last_step = dt;
    }

    /// Gravity at the time `ahead` after the current one (m/s²).
    pub fn gravity_at<const D: usize>(&self, ahead: f64) -> [f64; D] {
        let stage = &self.case.stages[self.stage];
        let own = self.stage_options();
        let gravity = spatial(own.and_then(|options| options.gravity.as_ref()).unwrap_or(&self.case.gravity));
        let elapsed = self.time + ahead - self.stage_start;
        let factor = stage.gravity_factor(elapsed);
        let mut gravity: [f64; D] = std::array::from_fn(|c| factor * gravity[c]);
        if let Some(shaking) = own.and_then(|options| options.shaking.as_ref()) {
            let shaken: [f64; D] = std::array::from_fn(|c| shaking.acceleration[c]);
            add(&mut gravity, shaking.factor(elapsed, stage.duration), &shaken);
        }
        gravity
    }

    /// Index of a body of the case.
    pub fn body_index(&self, body: &str) -> Option<u32> {
        Some(self.case.bodies.iter().position(|own| own.name == body)? as u32)
    }

    /// Error at a grain, by its index.
    pub fn grain_error<const D: usize, const R: usize>(
        &self,
        grains: &Grains<D, R>,
        grain: usize,
        reason: impl Into<FailureReason>,
    ) -> SolverError {
        SolverError::Point {
            step: self.step,
            time: self.time,
            point: u64::from(grains.id.get(grain).copied().unwrap_or(0)),
            position: grains.position.get(grain).map_or([0.0; 3], |x| spatial(x)),
            reason: reason.into(),
        }
    }
}
