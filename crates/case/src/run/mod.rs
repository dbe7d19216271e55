//! The run: stages, steps, measures, frames, checkpoints.
//!
//! A [`Run`] is a value that advances from event to event; [`run_method`] and its relatives run a case to its end.

mod checkpoint;
mod ending;
mod energy_monitor;
mod error;
mod factor_of_safety;
mod observer;
pub(crate) mod output;
mod progress;
mod recorded_run;
mod run_loop;
mod run_timing;
mod verify;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::output::Table;
use crate::{Budget, Case, Method, PlanRaster, Snapshot, Solver};

pub use crate::run::factor_of_safety::{
    SafetyResult, SearchCost, SearchOutcome, StrengthTrial, TrialVerdict,
};
pub use crate::run::observer::{ObservedEvent, Observer, RunEvent};
pub use crate::run::output::measure_row::{check_names, column_names};
pub use crate::run::output::run_folder::remove_run;
pub use crate::run::recorded_run::{RecordedRun, RunStatus, open, recorded_warnings};
use crate::run::run_loop::Phase;
pub use crate::run::run_loop::Run;
pub use crate::run::run_timing::{RunTiming, frame_memory};
pub use checkpoint::last_state;
use colluvium_constitutive::Warning;
pub use error::RunError;
pub use verify::{VerificationResult, changed_inputs, verify};

/// Options of a run.
#[derive(Clone, Debug, Default)]
pub struct RunOptions {
    /// Name of the method, for the summary.
    pub method: String,
    /// Folder for all files; without one no file is written.
    pub output_folder: Option<PathBuf>,
    /// Whether to continue the run whose checkpoint is in the folder.
    pub resume: bool,
    /// Whether to remove the files of an earlier run from the folder.
    pub overwrite: bool,
    /// Whether to keep the frames in memory, in [`RunReport::frames`]. After a resume, frames before the checkpoint are read from their
    /// files and have only the fields in `output.fields`.
    pub keep_frames: bool,
    /// Whether to keep the [`Solver::specimen`] at the end, in [`RunReport::specimen`].
    pub keep_specimen: bool,
    /// Flag that another thread sets to stop the run at the next step; the run then writes a checkpoint.
    pub stop_flag: Option<Arc<AtomicBool>>,
    /// Receives each event of the run, on the thread of the run.
    pub observer: Option<Observer>,
    /// Commit of the program, for the summary.
    pub commit: Option<String>,
    /// Warnings about the case from before the run, for the summary.
    pub warnings: Vec<Warning>,
}

impl RunOptions {
    /// Whether another thread has set the flag to stop.
    pub(crate) fn stop_is_requested(&self) -> bool {
        self.stop_flag.as_ref().is_some_and(|stop| stop.load(Ordering::Relaxed))
    }
}

/// End of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RunEnd {
    /// All stages and searches for a factor of safety are complete.
    Completed,
    /// The run was stopped on request.
    Interrupted,
}

/// Results of a run.
#[derive(Clone, Debug)]
pub struct RunReport {
    /// End of the run.
    pub ending: RunEnd,
    /// Points at the end.
    pub snapshot: Snapshot,
    /// Measures over time.
    pub table: Table,
    /// Frames, if the options requested them.
    pub frames: Vec<Snapshot>,
    /// Rasters at the end, with their nodes on the map; empty for methods without rasters.
    pub rasters: Vec<PlanRaster>,
    /// Totals at the start; [`Budget::UNKNOWN`] for methods without totals.
    pub start: Budget,
    /// Totals at the end; [`Budget::UNKNOWN`] for methods without totals.
    pub end: Budget,
    /// Number of steps, including those before a restart.
    pub steps: u64,
    /// Warnings about the run and its final state.
    pub warnings_at_end: Vec<Warning>,
    /// Notes of the method about the run, which are no warnings ([`Solver::notes`]).
    pub notes: Vec<Warning>,
    /// Wall-clock time of this run (s).
    pub wall: f64,
    /// Point updates per second of wall-clock time.
    pub updates_per_second: f64,
    /// Results of the searches for a factor of safety, by the name of the measure.
    pub safety: BTreeMap<String, SafetyResult>,
    /// Points at the end of the failing trial with the least factor of each search; `trial_displacement` is the displacement since the
    /// start of the trial.
    pub failed_trials: BTreeMap<String, Snapshot>,
    /// Specimen from which another case can start, if the options requested it.
    pub specimen: Option<String>,
}

/// Runs a case with a method from its start, or from its checkpoint, to the end, and searches for the factors of safety among its measures.
///
/// # Errors
/// When the case is invalid, before any file is written; when the solver, the disk or an equilibrium fails. Earlier output remains, marked
/// as failed, with the last valid frame.
pub fn run_method(method: &dyn Method, case: &Case, options: &RunOptions) -> Result<RunReport, RunError> {
    Run::new(Arc::new(case.clone()), method, options.clone())?.finish()
}

/// Runs a case like [`run_method`], with the solver from [`Method::plan_and_build`].
///
/// # Errors
/// As [`run_method`].
pub fn run_with_plan(
    method: &dyn Method,
    case: &Case,
    solver: Box<dyn Solver>,
    options: &RunOptions,
) -> Result<RunReport, RunError> {
    Run::with_plan(Arc::new(case.clone()), method, solver, options.clone())?.finish()
}

/// Runs a case like [`run_method`], with an existing solver: for cases without changes of material strength.
///
/// # Errors
/// As [`run_method`], and when a stage weakens materials or a factor of safety is to be found.
pub fn run(case: &Case, solver: Box<dyn Solver>, options: &RunOptions) -> Result<RunReport, RunError> {
    Run::with_solver(Arc::new(case.clone()), solver, options.clone())?.finish()
}

#[cfg(test)]
mod tests;
