//! Errors of runs.

use std::path::PathBuf;

use thiserror::Error;

use crate::output::OutputError;
use crate::{CaseErrors, SolverError};

/// Name of a file, followed by a comma; empty without a file.
fn named(file: &str) -> String {
    if file.is_empty() { String::new() } else { format!("{file}, ") }
}

/// Reason for the failure of a run.
#[derive(Debug, Error)]
pub enum RunError {
    /// Invalid case.
    #[error(transparent)]
    Case(#[from] CaseErrors),
    /// Failure of the solver.
    #[error(transparent)]
    Solver(#[from] SolverError),
    /// Failure of the solver after the first output.
    #[error("{source}; the last output is {}t = {time} s", named(frame))]
    Stopped {
        /// Error of the solver.
        source: SolverError,
        /// Name of the file of the last frame; empty where none is written.
        frame: String,
        /// Time of the last frame (s).
        time: f64,
    },
    /// Failure to write or read a file.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Advance of a run that has failed before.
    #[error("the run has failed before: start a new one, or resume it from its folder")]
    HasFailed,
    /// Failure of a trial in a search for a factor of safety.
    #[error("measures.{measure}: trial with the factor {factor}: {source}")]
    Trial {
        /// Name of the measure.
        measure: String,
        /// Strength reduction factor `F` of the trial.
        factor: f64,
        /// Error of the trial.
        source: Box<RunError>,
    },
    /// No rest of the bodies without yielding, so that the duration of a trial cannot be determined.
    #[error(
        "measures.{measure}.duration: cannot be determined: with half of their weight removed the bodies \
         did not come to rest within {time:.4} s under strong damping (unbalanced force {unbalanced:.1e} of \
         the external force). Give the longest duration of a trial (s)"
    )]
    NeverAtRest {
        /// Name of the measure.
        measure: String,
        /// Unbalanced-force ratio at the end.
        unbalanced: f64,
        /// Time at the end of the wait (s).
        time: f64,
    },
    /// Unusable folder of the run.
    #[error("{}: {problem}", path.display())]
    Folder {
        /// Path of the folder.
        path: PathBuf,
        /// Code of the problem.
        code: &'static str,
        /// Problem with the folder.
        problem: String,
    },
}

impl RunError {
    /// Stable code of the error, which `docs/messages.md` of the repository explains; of several errors of a case that of the first.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::Case(errors) => errors.first().code(),
            Self::Solver(source) | Self::Stopped { source, .. } => source.code(),
            Self::Output(error) => error.code,
            Self::HasFailed => "run-has-failed",
            Self::Trial { .. } => "search-trial-failed",
            Self::NeverAtRest { .. } => "search-never-at-rest",
            Self::Folder { code, .. } => code,
        }
    }
}
