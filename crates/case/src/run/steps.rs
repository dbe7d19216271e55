//! How long steps are.

use super::RunError;
use crate::{Solver, TimeStep};

/// The solver's stable step in the stage of that name.
pub(super) fn stable_step(solver: &mut dyn Solver, stage: &str) -> Result<TimeStep, RunError> {
    let limit = solver.time_step();
    if limit.dt.is_finite() && limit.dt > 0.0 {
        return Ok(limit);
    }
    if limit.dt == f64::INFINITY {
        return Err(RunError::NothingMoves { stage: stage.to_owned(), time: solver.time() });
    }
    Err(RunError::TimeStep { time: solver.time(), dt: limit.dt, limit: limit.limit })
}

/// The step from `time` towards `until`: at most `limit`, the last two alike so that none is a
/// sliver; `None` once there, to a part of `limit`, which is therefore no longer than what is waited for.
pub(super) fn step_towards(time: f64, until: f64, limit: f64) -> Option<f64> {
    let rest = until - time;
    if rest <= 1e-9 * limit {
        None
    } else if rest <= limit * (1.0 + 1e-9) {
        Some(rest)
    } else if rest < 2.0 * limit * (1.0 - 1e-9) {
        Some(0.5 * rest)
    } else {
        Some(limit)
    }
}
