//! How long steps are.

use super::RunError;
use crate::{Solver, TimeStep};

/// The solver's stable step in the stage of that name.
pub(super) fn stable_step(solver: &mut dyn Solver, stage: &str) -> Result<TimeStep, RunError> {
    let limit = solver.limit();
    if limit.dt.is_finite() && limit.dt > 0.0 {
        return Ok(limit);
    }
    if limit.dt == f64::INFINITY {
        return Err(RunError::NothingMoves { stage: stage.to_owned(), time: solver.time() });
    }
    Err(RunError::TimeStep { time: solver.time(), dt: limit.dt, limit: limit.limit })
}

/// Whether the time that is left (s) is nothing beside a step of at most `limit` (s), which is therefore no longer than what is
/// waited for.
pub(super) fn is_there(left: f64, limit: f64) -> bool {
    left <= 1e-9 * limit
}
