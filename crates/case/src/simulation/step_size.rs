//! Size of the time step.

use crate::description::Stage;
use crate::solver::{Advance, Solver, SolverError, TimeStep, TimeStepError};

/// Stable time step of the solver in the stage, which ends at `end` (s).
pub(crate) fn stable_step(solver: &mut dyn Solver, stage: &Stage, end: f64) -> Result<TimeStep, SolverError> {
    let step = solver.limit();
    let (TimeStep { dt, limit, .. }, time) = (step, solver.time());
    if step.is_below_precision(end) {
        return Err(TimeStepError::TooSmall { time, dt, limit, end }.into());
    }
    if dt.is_finite() && dt > 0.0 {
        return Ok(step);
    }
    if dt == f64::INFINITY {
        return Err(TimeStepError::NoMotion { stage: stage.name.clone(), time }.into());
    }
    Err(TimeStepError::Unstable { time, dt, limit }.into())
}

/// Takes a step of at most `at_most` (s) in a stage that ends at `end` (s).
///
/// # Errors
/// When the solver fails, and when the step does not change the time.
pub(crate) fn step_solver(solver: &mut dyn Solver, at_most: f64, end: f64) -> Result<Advance, SolverError> {
    let time = solver.time();
    let done = solver.step(at_most)?;
    if !(solver.time() > time) {
        return Err(TimeStepError::TooSmall { time, dt: done.dt, limit: done.limit, end }.into());
    }
    Ok(done)
}

/// Whether the remaining time `left` (s) is negligible beside `limit` (s).
pub(crate) fn is_negligible(left: f64, limit: f64) -> bool {
    left <= 1e-9 * limit
}
