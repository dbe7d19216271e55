//! Size of the time step.

use std::sync::atomic::Ordering;

use crate::description::Stage;
use crate::run::{RunError, RunOptions};
use crate::{Solver, TimeStep};

/// Whether the run is to end at the next step.
pub(super) fn stop_requested(options: &RunOptions) -> bool {
    options.stop_flag.as_ref().is_some_and(|stop| stop.load(Ordering::Relaxed))
}

/// Stable time step of the solver in the stage, which ends at `end` (s).
pub(crate) fn stable_step(solver: &mut dyn Solver, stage: &Stage, end: f64) -> Result<TimeStep, RunError> {
    let limit = solver.limit();
    if limit.is_below_precision(end) {
        let TimeStep { dt, limit, .. } = limit;
        return Err(RunError::StepTooSmall { time: solver.time(), dt, limit, end });
    }
    if limit.dt.is_finite() && limit.dt > 0.0 {
        return Ok(limit);
    }
    if limit.dt == f64::INFINITY {
        return Err(RunError::NoMotion { stage: stage.name.clone(), time: solver.time() });
    }
    Err(RunError::TimeStep { time: solver.time(), dt: limit.dt, limit: limit.limit })
}

/// Whether the remaining time `left` (s) is negligible beside `limit` (s).
pub(crate) fn is_negligible(left: f64, limit: f64) -> bool {
    left <= 1e-9 * limit
}
