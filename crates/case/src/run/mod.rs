//! The run: stages, steps, measures, frames, checkpoints.

mod checkpoint;
mod energy_monitor;
mod error;
mod factor_of_safety;
pub(crate) mod output;
mod progress;
mod run_timing;
pub(crate) mod step_size;
mod verify;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::description::Stage;
use crate::output::Table;
use crate::run::output::recorder::RunRecorder;
use crate::run::step_size::{is_negligible, stable_step, stop_requested};
use crate::{Budget, Case, CaseError, CaseErrors, Method, Snapshot, Solver};
use progress::RunProgress;

pub use crate::run::factor_of_safety::{
    SafetyResult, SearchCost, SearchOutcome, StrengthTrial, TrialVerdict,
};
pub use crate::run::output::measure_row::{check_names, column_names};
pub use crate::run::output::run_folder::remove_run;
pub use crate::run::run_timing::{RunTiming, frame_memory};
pub use checkpoint::last_state;
pub use error::RunError;
pub use verify::{VerificationResult, changed_inputs, verify};

/// Shortest wall-clock time between two summaries of a run in progress.
const SUMMARY_INTERVAL: Duration = Duration::from_secs(1);

/// Wall-clock time between two lines of progress without a terminal.
const PROGRESS_INTERVAL: Duration = Duration::from_secs(5);

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
    /// Whether to show a progress bar; without a terminal on standard error, a line every few seconds.
    pub progress: bool,
    /// Whether to keep the frames in memory, in [`RunReport::frames`]. After a resume, frames before the checkpoint are read from their
    /// files and have only the fields in `output.fields`.
    pub keep_frames: bool,
    /// Whether to keep the [`Solver::specimen`] at the end, in [`RunReport::specimen`].
    pub keep_specimen: bool,
    /// Flag that another thread sets to stop the run at the next step; the run then writes a checkpoint.
    pub stop_flag: Option<Arc<AtomicBool>>,
    /// Commit of the program, for the summary.
    pub commit: Option<String>,
    /// Function that receives warnings during the run. They are in [`RunReport::warnings_at_end`] too.
    pub on_warning: Option<fn(&str)>,
    /// Warnings about the case from before the run, for the summary.
    pub warnings: Vec<String>,
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
    /// Totals at the start; [`Budget::UNKNOWN`] for methods without totals.
    pub start: Budget,
    /// Totals at the end; [`Budget::UNKNOWN`] for methods without totals.
    pub end: Budget,
    /// Number of steps, including those before a restart.
    pub steps: u64,
    /// Warnings about the run and its final state.
    pub warnings_at_end: Vec<String>,
    /// Notes of the method about the run, which are no warnings ([`Solver::notes`]).
    pub notes: Vec<String>,
    /// Warnings that [`RunOptions::on_warning`] has received during the run.
    pub reported_warnings: Vec<String>,
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
    let solver = method.build(case).map_err(CaseErrors::from_error)?;
    start(case, solver, Some(method), options)
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
    start(case, solver, Some(method), options)
}

/// Runs a case like [`run_method`], with an existing solver: for cases without changes of material strength.
///
/// # Errors
/// As [`run_method`], and when a stage weakens materials or a factor of safety is to be found.
pub fn run(case: &Case, solver: Box<dyn Solver>, options: &RunOptions) -> Result<RunReport, RunError> {
    let needs = |path: String| CaseErrors::from_error(CaseError::new(path, "needs `run_method`"));
    if let Some(number) = case.stages.iter().position(|stage| stage.weakening.is_some()) {
        return Err(needs(format!("stages[{number}].weakening")).into());
    }
    if let Some((name, _)) = case.factors_of_safety().next() {
        return Err(needs(format!("measures.{name}")).into());
    }
    start(case, solver, None, options)
}

/// Runs a case from its start or its checkpoint, on the number of threads of the options.
fn start(
    case: &Case,
    solver: Box<dyn Solver>,
    method: Option<&dyn Method>,
    options: &RunOptions,
) -> Result<RunReport, RunError> {
    // Runs on a thread of the pool: from any other thread each loop of a step would wake a thread of the pool and wait for it.
    rayon::scope(|_| run_on_thread_pool(case, solver, method, options))
}

/// Runs a case on the current thread pool.
fn run_on_thread_pool(
    case: &Case,
    solver: Box<dyn Solver>,
    method: Option<&dyn Method>,
    options: &RunOptions,
) -> Result<RunReport, RunError> {
    case.validate()?;
    check_names(case, &*solver)?;
    let recorder = RunRecorder::open(case, options)?;
    let mut run = RunLoop {
        case,
        options,
        solver,
        method,
        weakened_stage: None,
        recorder,
        progress: RunProgress::default(),
        progress_bar: progress_bar(case, options),
        start_instant: Instant::now(),
        last_save: Instant::now(),
        last_report: Instant::now(),
        last_progress_line: Instant::now(),
        first_step: 0,
        safety: BTreeMap::new(),
        failing_points: BTreeMap::new(),
        search_time: Duration::ZERO,
        previous_wall_time: 0.0,
        warnings_at_end: Vec::new(),
        reported_warnings: Vec::new(),
    };
    let result = run.run_stages().map_err(|error| run.with_last_output(error));
    let ending = match &result {
        Ok(RunEnd::Completed) => "completed",
        Ok(RunEnd::Interrupted) => "interrupted",
        Err(_) => "failed",
    };
    let reason = result.as_ref().err().map(ToString::to_string);
    let finished = run.write_ending(ending, reason.as_deref());
    let ending = result?;
    finished?;
    Ok(run.report(ending))
}

/// State of a run between its steps.
struct RunLoop<'a> {
    case: &'a Case,
    options: &'a RunOptions,
    solver: Box<dyn Solver>,
    method: Option<&'a dyn Method>,
    /// Stage whose strength reduction is in the materials of the solver.
    weakened_stage: Option<usize>,
    recorder: RunRecorder<'a>,
    progress: RunProgress,
    progress_bar: ProgressBar,
    start_instant: Instant,
    last_save: Instant,
    last_report: Instant,
    /// Time of the last line of progress.
    last_progress_line: Instant,
    first_step: u64,
    safety: BTreeMap<String, SafetyResult>,
    /// Points of the last failing trial, by the name of the measure.
    failing_points: BTreeMap<String, Snapshot>,
    /// Wall-clock time of the searches.
    search_time: Duration,
    /// Wall-clock time of earlier sessions (s).
    previous_wall_time: f64,
    /// Warnings about the run.
    warnings_at_end: Vec<String>,
    /// Warnings that were reported during the run.
    reported_warnings: Vec<String>,
}

/// Progress bar of a run; hidden where the options request none.
fn progress_bar(case: &Case, options: &RunOptions) -> ProgressBar {
    if !options.progress {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:30} {percent:>3} %  {msg}  {elapsed} of about {duration}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    let bar = ProgressBar::new((case.end_time() * 1e9) as u64).with_style(style);
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}

impl RunLoop<'_> {
    /// Runs the stages from the progress of a restart, or from the start.
    fn run_stages(&mut self) -> Result<RunEnd, RunError> {
        if self.options.resume
            && let Some(progress) = self.recorder.resume(&mut *self.solver)?
        {
            self.progress = progress;
            self.previous_wall_time = self.progress.wall;
        }
        self.first_step = self.solver.step_count();
        let resumed = self.progress.has_begun;
        let last = self.case.stages.len() - 1;
        if self.progress.stage > last {
            // A search was interrupted: the state of the solver is that at the end of the last stage.
            self.weaken(last)?;
            self.solver.begin_stage(last, self.progress.stage_start())?;
        }
        for stage in self.progress.stage..self.case.stages.len() {
            if !resumed || stage != self.progress.stage {
                self.progress.stage = stage;
                self.progress.stage_starts.push(self.solver.time());
                self.progress.checks_at_rest = 0;
            }
            self.weaken(stage)?;
            self.solver.begin_stage(stage, self.progress.stage_start())?;
            if !resumed || self.solver.time() == self.progress.stage_start() {
                self.begin_energy();
            }
            if !self.progress.has_begun {
                self.progress.has_begun = true;
                self.recorder.begin(&*self.solver, &mut self.progress)?;
                self.check_solver_warning();
            }
            self.write_interim_summary()?;
            if self.stage(&self.case.stages[stage])? == RunEnd::Interrupted {
                self.save()?;
                return Ok(RunEnd::Interrupted);
            }
            self.progress.stage_ends.push(self.solver.time());
            let done = &self.case.stages[stage];
            self.solver.end_stage(done)?;
            if self.case.factors_of_safety().any(|(_, search)| search.after == done.name) {
                self.recorder.keep_state(&done.name, self.solver.checkpoint_bytes()?)?;
            }
        }
        self.search()
    }

    /// Adds the time of the last frame and its name to an error of the solver.
    fn with_last_output(&self, error: RunError) -> RunError {
        let error = match error {
            RunError::Solver(source) => RunError::Solver(source.on_map(self.case.origin())),
            error => error,
        };
        match (error, self.progress.collection.frames.last()) {
            (RunError::Solver(source), Some((time, frame))) => {
                RunError::Stopped { source, frame: frame.clone(), time: *time }
            }
            (error, _) => error,
        }
    }

    /// Transfers the state to a solver with the material strengths of the stage.
    fn weaken(&mut self, stage: usize) -> Result<(), RunError> {
        let by = self.case.stages.iter().take(stage + 1).rposition(|stage| stage.weakening.is_some());
        let (Some(method), true) = (self.method, by != self.weakened_stage) else { return Ok(()) };
        let state = self.solver.checkpoint_bytes()?;
        let case = self.case.with_weakening(stage).map_err(CaseErrors::from_error)?;
        self.solver = method.build(&case).map_err(CaseErrors::from_error)?;
        self.solver.restore(&mut state.as_slice())?;
        self.weakened_stage = by;
        Ok(())
    }

    /// Advances the solver through a stage.
    fn stage(&mut self, stage: &Stage) -> Result<RunEnd, RunError> {
        let end = self.progress.stage_start() + stage.duration;
        let span = stage.duration.min(self.recorder.shortest_interval());
        loop {
            if stop_requested(self.options) {
                return Ok(RunEnd::Interrupted);
            }
            let limit = stable_step(&mut *self.solver, stage, end)?;
            let until = self.recorder.next_output(&self.progress).min(end);
            let time = self.solver.time();
            if is_negligible(until - time, limit.dt.min(span)) {
                self.output()?;
                if until >= end {
                    return self.finish_stage(stage);
                }
                continue;
            }
            self.check_step_collapse(&limit);
            self.progress.count(&limit, time);
            let done = self.solver.step(until - time)?;
            if !(self.solver.time() > time) {
                return Err(RunError::StepTooSmall { time, dt: done.dt, limit: done.limit, end });
            }
            self.show_progress(&done);
            if self.recorder.is_unscheduled_row_due(self.solver.time(), &self.progress) {
                self.output()?;
            }
            if self.at_rest(stage) {
                return Ok(RunEnd::Completed);
            }
            if self.last_save.elapsed().as_secs_f64() > self.case.output.checkpoint {
                self.save()?;
            }
        }
    }

    /// Ends a stage at its duration; an error if the stage requires equilibrium.
    fn finish_stage(&mut self, stage: &Stage) -> Result<RunEnd, RunError> {
        let Some(criterion) = &stage.equilibrium else { return Ok(RunEnd::Completed) };
        let last = self.solver.equilibrium();
        let missed = RunError::NoEquilibrium {
            stage: self.progress.stage,
            duration: stage.duration,
            unbalanced: last.map_or(f64::NAN, |e| e.unbalanced_force),
            kinetic: last.map_or(f64::NAN, |e| e.kinetic_ratio),
        };
        if criterion.required {
            return Err(missed);
        }
        self.note_missed_equilibrium(&missed);
        Ok(RunEnd::Completed)
    }

    /// Whether the bodies have been at rest for the required number of consecutive checks.
    fn at_rest(&mut self, stage: &Stage) -> bool {
        let Some(criterion) = &stage.equilibrium else { return false };
        if !self.solver.step_count().is_multiple_of(self.solver.steps_between_checks()) {
            return false;
        }
        let loaded = self.case.ramps_are_complete(&self.progress.stage_starts, self.solver.time());
        let grown = loaded && self.solver.ramps_are_complete();
        let holds = self.solver.equilibrium().is_some_and(|e| {
            e.unbalanced_force < criterion.unbalanced_force && e.kinetic_ratio < criterion.kinetic_energy
        });
        self.progress.checks_at_rest = if grown && holds { self.progress.checks_at_rest + 1 } else { 0 };
        self.progress.checks_at_rest >= criterion.hold
    }

    /// Wall-clock time of all sessions (s).
    fn wall(&self) -> f64 {
        self.previous_wall_time + self.start_instant.elapsed().as_secs_f64()
    }

    /// Writes a checkpoint, and a summary of the incomplete run where one is due.
    fn save(&mut self) -> Result<(), RunError> {
        self.progress.wall = self.wall();
        self.recorder.save(&*self.solver, &self.progress)?;
        self.last_save = Instant::now();
        self.write_interim_summary_if_due()
    }

    /// Writes the row and the frame whose output times have been reached.
    fn output(&mut self) -> Result<(), RunError> {
        let (rows, frames) = (self.progress.rows, self.progress.frames);
        self.recorder.output(&*self.solver, &mut self.progress)?;
        if self.progress.rows > rows {
            self.check_solver_warning();
        }
        if self.progress.frames > frames { self.write_interim_summary_if_due() } else { Ok(()) }
    }

    /// Writes the summary of an incomplete run, which remains if the run is killed.
    fn write_interim_summary(&mut self) -> Result<(), RunError> {
        self.last_report = Instant::now();
        self.summary("running", None, &self.warnings_so_far())
    }

    /// Writes the summary of an incomplete run if [`SUMMARY_INTERVAL`] has passed since the last one.
    fn write_interim_summary_if_due(&mut self) -> Result<(), RunError> {
        if self.last_report.elapsed() < SUMMARY_INTERVAL { Ok(()) } else { self.write_interim_summary() }
    }

    /// Writes the summary of the run with its status.
    fn summary(&self, status: &str, reason: Option<&str>, remarks: &[String]) -> Result<(), RunError> {
        let run = (self.wall(), &self.safety, remarks);
        self.recorder.summary(status, reason, &*self.solver, &self.progress, run)
    }

    /// Writes the last output, the summary and the warnings at the end of a run.
    fn write_ending(&mut self, ending: &str, reason: Option<&str>) -> Result<(), RunError> {
        self.progress_bar.finish_and_clear();
        let completed = ending == "completed";
        let last = if completed { self.last_output() } else { Ok(()) };
        self.warnings_at_end = self.warnings_so_far();
        if completed {
            self.warnings_at_end.extend(self.recorder.probes_without_points());
        }
        self.recorder.reserved_space = None;
        match last {
            Ok(()) => self.summary(ending, reason, &self.warnings_at_end),
            Err(error) => {
                self.summary("failed", Some(&error.to_string()), &self.warnings_at_end)?;
                Err(error)
            }
        }
    }

    /// Writes the last output of a complete run.
    fn last_output(&mut self) -> Result<(), RunError> {
        self.recorder.output_last(&*self.solver, &mut self.progress)?;
        if self.solver.has_specimen() {
            // Final state: without wall-clock times the file is identical for the same case.
            self.recorder.save(&*self.solver, &RunProgress { wall: 0.0, ..self.progress.clone() })?;
        }
        Ok(self.recorder.rasters(&*self.solver)?)
    }

    /// Report of the run in memory.
    fn report(&mut self, ending: RunEnd) -> RunReport {
        let session = self.start_instant.elapsed().as_secs_f64();
        let steps = self.solver.step_count();
        let updates = (steps - self.first_step) as f64 * self.solver.point_count() as f64;
        RunReport {
            ending,
            snapshot: self.case.snapshot_on_map(self.solver.snapshot()),
            table: std::mem::take(&mut self.recorder.table),
            frames: std::mem::take(&mut self.recorder.kept_frames),
            start: self.progress.start.unwrap_or(Budget::UNKNOWN),
            end: self.solver.totals(),
            steps,
            warnings_at_end: std::mem::take(&mut self.warnings_at_end),
            notes: self.solver.notes(),
            reported_warnings: std::mem::take(&mut self.reported_warnings),
            wall: self.wall(),
            updates_per_second: updates / (session - self.search_time.as_secs_f64()),
            safety: std::mem::take(&mut self.safety),
            failed_trials: std::mem::take(&mut self.failing_points),
            specimen: if self.options.keep_specimen { self.solver.specimen() } else { None },
        }
    }
}

#[cfg(test)]
mod tests;
