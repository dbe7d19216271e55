//! A run as a value that advances from event to event.

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::CaseErrorKind;
use crate::output::Table;
use crate::run::factor_of_safety::StrengthSearch;
use crate::run::output::measure_row::check_names;
use crate::run::output::recorder::{RecordedOutput, RunRecorder};
use crate::run::progress::RunProgress;
use crate::run::{ObservedEvent, RunEnd, RunError, RunEvent, RunOptions, RunReport, SafetyResult};
use crate::simulation::step_size::{is_negligible, stable_step, step_solver};
use crate::simulation::{ConfigurableMethod, ConfiguredMethod};
use crate::{Case, CaseError, CaseErrors, Method, Snapshot, Solver};
use colluvium_constitutive::Warning;

/// Shortest wall-clock time between two summaries of a run in progress.
pub(super) const SUMMARY_INTERVAL: Duration = Duration::from_secs(1);

/// Run of a case with a method, which advances from event to event.
///
/// It follows the stages of the case, records measures, frames and checkpoints, and searches for the factors of safety among the measures.
/// A run that is dropped before its end leaves its folder as a killed one does: it can be resumed from its last checkpoint.
///
/// With one of the methods of this workspace it is a `Run<'static>`, which can be moved to another thread.
pub struct Run<'m> {
    pub(super) case: Arc<Case>,
    pub(super) options: Arc<RunOptions>,
    pub(super) solver: Box<dyn Solver>,
    pub(super) method: Option<&'m dyn Method>,
    /// Stage whose strength reduction is in the materials of the solver.
    weakened_stage: Option<usize>,
    pub(super) recorder: RunRecorder,
    pub(super) progress: RunProgress,
    pub(super) phase: Phase,
    /// Events that have not been handed over.
    pub(super) events: VecDeque<RunEvent>,
    /// Error that ends the run, until it is handed over.
    pub(super) failure: Option<RunError>,
    pub(super) start_instant: Instant,
    last_save: Instant,
    last_summary: Instant,
    pub(super) first_step: u64,
    pub(super) safety: BTreeMap<String, SafetyResult>,
    /// Points of the last failing trial, by the name of the measure.
    pub(super) failing_points: BTreeMap<String, Snapshot>,
    /// Wall-clock time of the searches.
    pub(super) search_time: Duration,
    /// Wall-clock time of earlier sessions (s).
    previous_wall_time: f64,
    /// Warnings about the run.
    pub(super) warnings_at_end: Vec<Warning>,
}

/// Part of a run that [`Run::advance`] does next.
pub(super) enum Phase {
    /// Start, or restart from a checkpoint.
    Start,
    /// Start of a stage, or its continuation after a restart.
    StageStart { stage: usize, is_resumed: bool },
    /// Steps and output of the current stage.
    Stage,
    /// Search for a factor of safety by its number; without a state at its start.
    Search { number: usize, search: Option<Box<StrengthSearch>> },
    /// End of the run.
    Ended(RunEnd),
    /// End by an error.
    Failed,
}

impl<M: ConfigurableMethod> ConfiguredMethod<M> {
    /// Run of a case, which is checked as its file would be, with these options in place of those that it has for the method.
    ///
    /// # Errors
    /// As [`Run::new`].
    pub fn run(&self, case: &Case, options: RunOptions) -> Result<Run<'static>, RunError> {
        Run::new(Arc::new(self.checked_case(case)?), M::instance(), options)
    }
}

impl<'m> Run<'m> {
    /// Run of a case with a method, from its start, or from its checkpoint where the options ask for it.
    ///
    /// # Errors
    /// When the case is invalid or the folder of the options cannot be used, before any file is written.
    pub fn new(mut case: Arc<Case>, method: &'m dyn Method, options: RunOptions) -> Result<Self, RunError> {
        if case.gravity.is_empty() {
            Arc::make_mut(&mut case).default_gravity();
        }
        // All errors, of which building reports the first.
        case.validate()?;
        let solver = method.build(&case).map_err(CaseErrors::from_error)?;
        Self::open(case, Some(method), solver, options)
    }

    /// Run like [`Run::new`], with the solver from [`Method::plan_and_build`].
    ///
    /// # Errors
    /// As [`Run::new`].
    pub fn with_plan(
        case: Arc<Case>,
        method: &'m dyn Method,
        solver: Box<dyn Solver>,
        options: RunOptions,
    ) -> Result<Self, RunError> {
        Self::open(case, Some(method), solver, options)
    }

    /// Run like [`Run::new`], with an existing solver at time zero: for cases without changes of material strength.
    ///
    /// # Errors
    /// As [`Run::new`], and when a stage weakens materials or a factor of safety is to be found.
    pub fn with_solver(
        case: Arc<Case>,
        solver: Box<dyn Solver>,
        options: RunOptions,
    ) -> Result<Self, RunError> {
        let refuse = |path: String| {
            let problem = "needs a run with its method, which builds a solver for each strength";
            CaseErrors::from_error(CaseError::new(path, CaseErrorKind::coded("needs-other-key", problem)))
        };
        if let Some(number) = case.stages.iter().position(|stage| stage.weakening.is_some()) {
            return Err(refuse(format!("stages[{number}].weakening")).into());
        }
        if let Some((name, _)) = case.factors_of_safety().next() {
            return Err(refuse(format!("measures.{name}")).into());
        }
        Self::open(case, None, solver, options)
    }

    /// Checks the case, and prepares the folder of the run.
    fn open(
        case: Arc<Case>,
        method: Option<&'m dyn Method>,
        solver: Box<dyn Solver>,
        mut options: RunOptions,
    ) -> Result<Self, RunError> {
        case.validate()?;
        check_names(&case, &*solver)?;
        if let (Some(method), true) = (method, options.method.is_empty()) {
            options.method = method.name().to_owned();
        }
        let options = Arc::new(options);
        let now = Instant::now();
        Ok(Self {
            recorder: RunRecorder::open(Arc::clone(&case), Arc::clone(&options))?,
            case,
            options,
            solver,
            method,
            weakened_stage: None,
            progress: RunProgress::default(),
            phase: Phase::Start,
            events: VecDeque::new(),
            failure: None,
            start_instant: now,
            last_save: now,
            last_summary: now,
            first_step: 0,
            safety: BTreeMap::new(),
            failing_points: BTreeMap::new(),
            search_time: Duration::ZERO,
            previous_wall_time: 0.0,
            warnings_at_end: Vec::new(),
        })
    }

    /// Case of the run.
    pub fn case(&self) -> &Case {
        &self.case
    }

    /// Solver in its present state.
    pub fn solver(&self) -> &dyn Solver {
        &*self.solver
    }

    /// Time (s).
    pub fn time(&self) -> f64 {
        self.solver.time()
    }

    /// Index of the current stage.
    pub fn stage(&self) -> usize {
        self.progress.stages.stage
    }

    /// Measures over time.
    pub fn table(&self) -> &Table {
        &self.recorder.table
    }

    /// Advances to the next event, which is handed to the observer of the options first; `None` after the end.
    ///
    /// # Errors
    /// When the solver, the disk or an equilibrium fails. The files of the run are then complete up to the last output, and marked as
    /// failed. Each further call fails.
    pub fn advance(&mut self) -> Result<Option<RunEvent>, RunError> {
        while self.events.is_empty() && !matches!(self.phase, Phase::Ended(_) | Phase::Failed) {
            // Runs on a thread of the pool: from any other thread each loop of a step would wake a thread of the pool and wait for it.
            if let Err(error) = rayon::scope(|_| self.advance_phase()) {
                self.fail(error);
            }
        }
        match (self.events.pop_front(), &self.phase) {
            (None, Phase::Failed) => Err(self.failure.take().unwrap_or(RunError::HasFailed)),
            (event, _) => {
                event.iter().for_each(|event| self.observe(event));
                Ok(event)
            }
        }
    }

    /// Hands an event to the observer.
    fn observe(&self, event: &RunEvent) {
        if let Some(observer) = &self.options.observer {
            observer.observe(&ObservedEvent {
                event,
                method: &self.options.method,
                time: self.time(),
                end_time: self.case.end_time(),
                step: self.solver.step_count(),
            });
        }
    }

    /// Advances to the end, and returns the results.
    ///
    /// # Errors
    /// As [`Run::advance`].
    pub fn finish(mut self) -> Result<RunReport, RunError> {
        // One change to a thread of the pool for the whole run.
        rayon::scope(|_| {
            while self.advance()?.is_some() {}
            Ok(self.report())
        })
    }

    /// Writes a checkpoint and ends the run, which can be resumed. Without effect after the end.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn interrupt(&mut self) -> Result<(), RunError> {
        match self.phase {
            Phase::Start | Phase::Search { .. } => self.end(RunEnd::Interrupted),
            Phase::StageStart { .. } | Phase::Stage => {
                self.save()?;
                self.end(RunEnd::Interrupted);
            }
            Phase::Ended(_) | Phase::Failed => {}
        }
        match self.failure.take() {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }

    /// Does the next part of the run.
    fn advance_phase(&mut self) -> Result<(), RunError> {
        match std::mem::replace(&mut self.phase, Phase::Failed) {
            Phase::Start => self.start(),
            Phase::StageStart { stage, is_resumed } => self.begin_stage(stage, is_resumed),
            Phase::Stage => {
                self.phase = Phase::Stage;
                self.advance_stage()
            }
            Phase::Search { number, search } => self.advance_search(number, search),
            over @ (Phase::Ended(_) | Phase::Failed) => {
                self.phase = over;
                Ok(())
            }
        }
    }

    /// Starts the run, or continues from the checkpoint in its folder.
    fn start(&mut self) -> Result<(), RunError> {
        let mut is_resumed = false;
        if self.options.resume
            && let Some(progress) = self.recorder.resume(&mut *self.solver)?
        {
            self.progress = progress;
            self.previous_wall_time = self.progress.wall;
            is_resumed = self.progress.has_begun;
        }
        self.first_step = self.solver.step_count();
        let (case, stages) = (&self.case, &self.progress.stages);
        let stage = if is_resumed && stages.has_ended { stages.stage + 1 } else { stages.stage };
        self.phase = Phase::StageStart { stage, is_resumed: is_resumed && !stages.has_ended };
        if is_resumed && stages.is_complete(case) {
            // The state is that at the end of the last stage.
            let (last, start) = (stages.stage, stages.start());
            self.weaken(last)?;
            self.solver.resume_stage(last, start)?;
            return self.begin_searches();
        }
        Ok(())
    }

    /// Begins a stage, or continues it after a restart.
    fn begin_stage(&mut self, stage: usize, is_resumed: bool) -> Result<(), RunError> {
        if !is_resumed {
            self.progress.stages.begin(stage, &*self.solver);
        }
        let start = self.progress.stages.start();
        self.weaken(stage)?;
        if is_resumed {
            self.solver.resume_stage(stage, start)?;
        } else {
            self.solver.begin_stage(stage, start)?;
        }
        self.events.push_back(RunEvent::StageBegan { stage });
        if !is_resumed || self.solver.time() == start {
            self.begin_energy();
        }
        if !self.progress.has_begun {
            self.progress.has_begun = true;
            let written = self.recorder.begin(&*self.solver, &mut self.progress)?;
            self.push_output(written);
            self.check_solver_warning();
        }
        self.phase = Phase::Stage;
        self.write_interim_summary()
    }

    /// Takes a step of the stage, or records the output that is due.
    fn advance_stage(&mut self) -> Result<(), RunError> {
        if self.options.stop_is_requested() {
            self.save()?;
            self.end(RunEnd::Interrupted);
            return Ok(());
        }
        let case = Arc::clone(&self.case);
        let stage = &case.stages[self.progress.stages.stage];
        let end = self.progress.stages.end(&case);
        let limit = stable_step(&mut *self.solver, stage, end)?;
        let until = self.recorder.next_output(&self.progress).min(end);
        let time = self.solver.time();
        let span = stage.duration.min(self.recorder.shortest_interval());
        if is_negligible(until - time, limit.dt.min(span)) {
            self.output()?;
            if until >= end {
                let missed = self.progress.stages.missed_equilibrium(&case, &*self.solver)?;
                missed.into_iter().for_each(|missed| self.note_missed_equilibrium(&missed));
                return self.end_stage(false);
            }
            return Ok(());
        }
        self.check_step_collapse(&limit);
        self.progress.count(&limit, time);
        let done = step_solver(&mut *self.solver, until - time, end)?;
        self.events.push_back(RunEvent::Step(done));
        if self.recorder.is_unscheduled_row_due(self.solver.time(), &self.progress) {
            self.output()?;
        }
        if self.progress.stages.is_at_rest(&case, &*self.solver) {
            return self.end_stage(true);
        }
        if self.last_save.elapsed().as_secs_f64() > case.output.checkpoint {
            self.save()?;
        }
        Ok(())
    }

    /// Ends the stage.
    fn end_stage(&mut self, at_rest: bool) -> Result<(), RunError> {
        let case = Arc::clone(&self.case);
        let stage = self.progress.stages.stage;
        self.progress.stage_ends.push(self.solver.time());
        self.progress.stages.end_stage(&case, &mut *self.solver)?;
        let name = &case.stages[stage].name;
        if case.factors_of_safety().any(|(_, search)| search.after == *name) {
            self.recorder.keep_state(name, self.solver.checkpoint_bytes()?)?;
        }
        self.events.push_back(RunEvent::StageEnded { stage, at_rest });
        if self.progress.stages.is_complete(&case) {
            return self.begin_searches();
        }
        self.phase = Phase::StageStart { stage: stage + 1, is_resumed: false };
        Ok(())
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

    /// Wall-clock time of all sessions (s).
    pub(super) fn wall(&self) -> f64 {
        self.previous_wall_time + self.start_instant.elapsed().as_secs_f64()
    }

    /// Writes a checkpoint, and a summary of the incomplete run where one is due.
    pub(super) fn save(&mut self) -> Result<(), RunError> {
        self.progress.wall = self.wall();
        self.recorder.save(&*self.solver, &self.progress)?;
        self.last_save = Instant::now();
        self.write_interim_summary_if_due()
    }

    /// Writes the row and the frame whose output times have been reached.
    fn output(&mut self) -> Result<(), RunError> {
        let written = self.recorder.output(&*self.solver, &mut self.progress)?;
        if written.row {
            self.check_solver_warning();
        }
        let has_frame = written.frame.is_some();
        self.push_output(written);
        if has_frame { self.write_interim_summary_if_due() } else { Ok(()) }
    }

    /// Adds the events of an output.
    pub(super) fn push_output(&mut self, RecordedOutput { row, frame }: RecordedOutput) {
        self.events.extend(row.then_some(RunEvent::Row));
        self.events.extend(frame.map(RunEvent::Frame));
    }

    /// Writes the summary of an incomplete run, which remains if the run is killed.
    fn write_interim_summary(&mut self) -> Result<(), RunError> {
        self.last_summary = Instant::now();
        self.summary("running", None, &self.warnings_so_far())
    }

    /// Writes the summary of an incomplete run if [`SUMMARY_INTERVAL`] has passed since the last one.
    fn write_interim_summary_if_due(&mut self) -> Result<(), RunError> {
        if self.last_summary.elapsed() < SUMMARY_INTERVAL { Ok(()) } else { self.write_interim_summary() }
    }

    /// Writes the summary of the run with its status.
    pub(super) fn summary(
        &self,
        status: &str,
        reason: Option<&str>,
        remarks: &[Warning],
    ) -> Result<(), RunError> {
        let run = (self.wall(), &self.safety, remarks);
        self.recorder.summary(status, reason, &*self.solver, &self.progress, run)
    }
}
