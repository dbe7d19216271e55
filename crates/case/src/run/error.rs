//! Why runs fail.

use std::path::PathBuf;

use thiserror::Error;

use crate::output::OutputError;
use crate::{CaseErrors, SolverError, StepLimit};

/// Why a run failed.
#[derive(Debug, Error)]
pub enum RunError {
    /// The case is wrong.
    #[error(transparent)]
    Case(#[from] CaseErrors),
    /// The solver could not go on.
    #[error(transparent)]
    Solver(#[from] SolverError),
    /// The solver stopped after there was output.
    #[error("{source}; the last output is {frame}, t = {time} s")]
    Stopped {
        /// Why.
        source: SolverError,
        /// The last frame.
        frame: String,
        /// Its time (s).
        time: f64,
    },
    /// A file could not be written or read.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A quasi-static stage did not come to rest.
    #[error(
        "stages[{stage}]: no equilibrium within its duration of {duration} s (unbalanced force {unbalanced:.3e}, \
         kinetic energy {kinetic:.3e} of the external work)"
    )]
    NoEquilibrium {
        /// Number of the stage.
        stage: usize,
        /// Its duration (s).
        duration: f64,
        /// Unbalanced-force ratio at the end.
        unbalanced: f64,
        /// Kinetic-energy ratio at the end.
        kinetic: f64,
    },
    /// Nothing limits the time step: there is no material that moves.
    #[error(
        "stage {stage:?}, t = {time} s: nothing is left to move, all bodies are removed, rigid or have left"
    )]
    NothingMoves {
        /// Name of the stage.
        stage: String,
        /// Time (s).
        time: f64,
    },
    /// A step that is lost beside the time in double precision.
    #[error(
        "t = {time} s: a step of {dt:.3e} s, limited by: {limit}, is lost beside the end at {end} s, more than 2^53 steps away: \
         the run stands still (look at stiffness, density and sizes)"
    )]
    StepTooSmall {
        /// Time (s).
        time: f64,
        /// The step (s).
        dt: f64,
        /// What limits it.
        limit: StepLimit,
        /// The end of the stage (s).
        end: f64,
    },
    /// The solver has no usable time step.
    #[error("t = {time} s: no stable time step (found {dt} s, limited by: {limit})")]
    TimeStep {
        /// Time (s).
        time: f64,
        /// What the solver offers (s).
        dt: f64,
        /// Why.
        limit: StepLimit,
    },
    /// A trial of a search for a factor of safety could not go on.
    #[error("measures.{measure}: trial with the factor {factor}: {source}")]
    Trial {
        /// Name of the measure.
        measure: String,
        /// The factor.
        factor: f64,
        /// Why.
        source: Box<RunError>,
    },
    /// Bodies that do not yield do not come to rest, so that the duration of a trial cannot be found.
    #[error(
        "measures.{measure}.duration: cannot be found: with half of their weight taken away the bodies did not come to rest within \
         {time:.4} s of strong damping (unbalanced force {unbalanced:.1e} of the external one): give the longest duration of a trial (s)"
    )]
    NeverAtRest {
        /// Name of the measure.
        measure: String,
        /// Unbalanced-force ratio at the end.
        unbalanced: f64,
        /// How long it was waited for (s).
        time: f64,
    },
    /// The folder cannot be used.
    #[error("{}: {problem}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Why not.
        problem: String,
    },
}
