//! Errors of a solver.

use thiserror::Error;

use crate::solver::equilibrium::MissedEquilibrium;
use crate::solver::failure_reason::FailureReason;
use crate::solver::time_step::TimeStepError;

/// Error that stops a run.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SolverError {
    /// Point whose state the method cannot continue: refused by its law, not finite, too fast, inverted, outside the grid.
    #[error("step {step}, t = {time:.6} s, point {point} at {position:.4?} m: {reason}")]
    Point {
        /// Step of the error.
        step: u64,
        /// Time at the start of that step (s).
        time: f64,
        /// Id of the first such point.
        point: u64,
        /// Its position (m).
        position: [f64; 3],
        /// Reason.
        reason: FailureReason,
    },
    /// Step that failed.
    #[error("step {step}, t = {time:.6} s: {reason}")]
    Step {
        /// Number of the step.
        step: u64,
        /// Time at its start (s).
        time: f64,
        /// Reason.
        reason: FailureReason,
    },
    /// Time step with which the solver cannot advance.
    #[error(transparent)]
    TimeStep(#[from] TimeStepError),
    /// Quasi-static stage without equilibrium at its end.
    #[error(transparent)]
    NoEquilibrium(MissedEquilibrium),
    /// Checkpoint that does not fit this case or this version.
    #[error("checkpoint: {0}")]
    Checkpoint(String),
}

impl SolverError {
    /// Stable code of the error, which `docs/messages.md` of the repository explains.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::Point { reason, .. } | Self::Step { reason, .. } => reason.code(),
            Self::TimeStep(error) => error.code(),
            Self::NoEquilibrium(_) => "no-equilibrium",
            Self::Checkpoint(_) => "state-mismatch",
        }
    }

    /// Error with its position translated by `origin` (m).
    #[cfg(feature = "output")]
    pub(crate) fn on_map(mut self, origin: [f64; 3]) -> Self {
        if let Self::Point { position, .. } = &mut self {
            (0..3).for_each(|c| position[c] += origin[c]);
        }
        self
    }
}

impl From<std::io::Error> for SolverError {
    fn from(error: std::io::Error) -> Self {
        Self::Checkpoint(error.to_string())
    }
}
