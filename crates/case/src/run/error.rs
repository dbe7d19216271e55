//! Errors of runs.

use std::path::PathBuf;

use thiserror::Error;

use crate::output::OutputError;
use crate::{CaseErrors, SolverError, StepLimit};

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
    #[error("{source}; the last output is {frame}, t = {time} s")]
    Stopped {
        /// Error of the solver.
        source: SolverError,
        /// Name of the last frame.
        frame: String,
        /// Time of the last frame (s).
        time: f64,
    },
    /// Failure to write or read a file.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Quasi-static stage without equilibrium at its end.
    #[error(
        "stages[{stage}]: no equilibrium within its duration of {duration} s (unbalanced force {unbalanced:.3e}, \
         kinetic energy {kinetic:.3e} of the external work)"
    )]
    NoEquilibrium {
        /// Number of the stage.
        stage: usize,
        /// Duration of the stage (s).
        duration: f64,
        /// Unbalanced-force ratio at the end.
        unbalanced: f64,
        /// Kinetic-energy ratio at the end.
        kinetic: f64,
    },
    /// No limit of the time step, because no material is left that moves.
    #[error(
        "stage {stage:?}, t = {time} s: no material is left that moves: all bodies are removed, are rigid \
         or have left the domain"
    )]
    NoMotion {
        /// Name of the stage.
        stage: String,
        /// Time (s).
        time: f64,
    },
    /// Time step below the precision of the time in double precision.
    #[error(
        "t = {time} s: a step of {dt:.3e} s, limited by: {limit}, is below the precision of the time: the \
         end at {end} s is more than 2^53 steps away. The run cannot advance. Check stiffness, density and \
         sizes"
    )]
    StepTooSmall {
        /// Time (s).
        time: f64,
        /// Time step (s).
        dt: f64,
        /// Limit of the time step.
        limit: StepLimit,
        /// End of the stage (s).
        end: f64,
    },
    /// No usable time step.
    #[error("t = {time} s: no stable time step (found {dt} s, limited by: {limit})")]
    TimeStep {
        /// Time (s).
        time: f64,
        /// Time step of the solver (s).
        dt: f64,
        /// Limit of the time step.
        limit: StepLimit,
    },
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
        /// Problem with the folder.
        problem: String,
    },
}
