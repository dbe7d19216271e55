//! Solvers that a program steps itself: typed construction, the loop over the stages, views of the points.
//!
//! A [`TypedMethod`] with its options builds a [`Simulation`], which steps its solver through the stages of the case as a run does, without
//! output and measures. A run uses the same order of stages and the same steps.

mod body_force;
mod configured_method;
mod point_column;
pub(crate) mod stage_progress;
pub(crate) mod step_size;

use std::io::{Read, Write};
use std::ops::{Deref, DerefMut};
use std::sync::{Arc, OnceLock};

use crate::files::checksum::FileChecksum;
use crate::measure::ScalarOutput;
use crate::simulation::stage_progress::StageProgress;
use crate::simulation::step_size::{is_negligible, stable_step, step_solver};
use crate::solver::{Advance, FailureReason, Solver, SolverError, TimeStep, restore_value, save_value};
use crate::{Case, CaseErrors, measure};
use colluvium_constitutive::Warning;

pub use crate::simulation::body_force::{BodyForce, InvalidBodyForce, check_saved_body_force};
pub use crate::simulation::configured_method::{ConfigurableMethod, ConfiguredMethod, TypedMethod};
pub use crate::simulation::point_column::PointColumn;

/// Solver of a case that a program steps.
///
/// It follows the stages of the case: a step ends at the end of a stage, and the next step begins the next stage. There is no step after the
/// last stage. Rows of measures and frames are not recorded: read the solver, to which this type dereferences. After an error the state of
/// the solver is undefined, and each further step is refused.
pub struct Simulation<S> {
    case: Arc<Case>,
    solver: S,
    /// Functions that return the solver as a trait object.
    access: SolverAccess<S>,
    progress: StageProgress,
    /// Notes of the method on ignored parts of the case.
    notes: Vec<Warning>,
    has_failed: bool,
    /// Fingerprint of the case, for checkpoints.
    fingerprint: OnceLock<u64>,
}

/// Functions that return a solver as a trait object: shared, and to be changed.
type SolverAccess<S> = (fn(&S) -> &dyn Solver, fn(&mut S) -> &mut dyn Solver);

impl<S> Simulation<S> {
    /// Solver at the start of the first stage; `notes` are those of the method on ignored parts of the case.
    pub(crate) fn new(
        case: Arc<Case>,
        mut solver: S,
        access: SolverAccess<S>,
        notes: Vec<Warning>,
    ) -> Result<Self, CaseErrors> {
        let dynamic = access.1(&mut solver);
        let start = dynamic.time();
        dynamic
            .begin_stage(0, start)
            .map_err(|error| CaseErrors::from_error(crate::CaseError::new("stages[0]", error.to_string())))?;
        let mut progress = StageProgress::default();
        progress.begin(0, dynamic);
        Ok(Self { case, solver, access, progress, notes, has_failed: false, fingerprint: OnceLock::new() })
    }

    /// Case of the simulation.
    pub fn case(&self) -> &Case {
        &self.case
    }

    /// Solver as a trait object.
    fn dynamic(&self) -> &dyn Solver {
        self.access.0(&self.solver)
    }

    /// Solver as a trait object that can be changed.
    fn dynamic_mut(&mut self) -> &mut dyn Solver {
        self.access.1(&mut self.solver)
    }

    /// Time (s).
    pub fn time(&self) -> f64 {
        self.dynamic().time()
    }

    /// Index of the current stage.
    pub fn stage(&self) -> usize {
        self.progress.stage
    }

    /// Notes of the method on parts of the case that it ignores.
    pub fn notes(&self) -> &[Warning] {
        &self.notes
    }

    /// Measures of the case in the present state: name, unit and value. Profiles and factors of safety, which belong to a run, are not among
    /// them.
    pub fn measures(&self) -> Vec<ScalarOutput> {
        measure::read_solver(&self.case, self.dynamic())
    }

    /// Solver, to which this type also dereferences.
    pub fn solver(&self) -> &S {
        &self.solver
    }

    /// Whether the last stage has ended.
    pub fn is_complete(&self) -> bool {
        self.progress.is_complete(&self.case)
    }

    /// Largest stable step from the current state (s), with its limit. It is constant until the next step.
    pub fn limit(&mut self) -> TimeStep {
        self.dynamic_mut().limit()
    }

    /// Takes the largest stable step, shortened to the end of the stage.
    ///
    /// # Errors
    /// When a point cannot be continued, after the last stage, and after an earlier error.
    pub fn step(&mut self) -> Result<Advance, SolverError> {
        self.step_at_most(f64::INFINITY)
    }

    /// Takes a step of at most `at_most` (s), shortened to the end of the stage.
    ///
    /// # Errors
    /// As [`Simulation::step`], and when `at_most` is not positive.
    pub fn step_at_most(&mut self, at_most: f64) -> Result<Advance, SolverError> {
        if !(at_most > 0.0) {
            return Err(self.refusal(format!("a step of {at_most} s is not positive")));
        }
        if self.has_failed {
            return Err(self.refusal(FailureReason::HasFailed));
        }
        if self.is_complete() {
            return Err(self.refusal(FailureReason::IsComplete));
        }
        let time = self.time();
        if time + at_most == time {
            return Err(self.refusal(format!("a step of {at_most:e} s does not change the time")));
        }
        // Also where a law or a force of the program panics in the step.
        self.has_failed = true;
        let done = self.step_in_stage(at_most);
        self.has_failed = done.is_err();
        done
    }

    /// Takes stable steps until `time` (s), the last one shortened. Returns their number.
    ///
    /// # Errors
    /// As [`Simulation::step`]; when `time` is not finite, has passed, or lies after the end of the last stage.
    pub fn step_to(&mut self, time: f64) -> Result<u64, SolverError> {
        if !time.is_finite() {
            return Err(self.refusal(format!("the time {time} s is not finite")));
        }
        if time < self.time() {
            return Err(self.refusal(format!("the time {time} s has passed")));
        }
        let first = self.dynamic().step_count();
        while !is_negligible(time - self.time(), self.shortest_span()) {
            self.step_at_most(time - self.time())?;
        }
        Ok(self.dynamic().step_count() - first)
    }

    /// Saves the state. A simulation of the same case continues from it bit-identically.
    ///
    /// # Errors
    /// When writing fails, and after an earlier error.
    pub fn save(&self, out: &mut dyn Write) -> Result<(), SolverError> {
        if self.has_failed {
            return Err(self.refusal("the state after a failed step cannot be saved"));
        }
        let mut state = Vec::new();
        save_value(&self.progress, &mut state)?;
        self.dynamic().save(&mut state)?;
        let checksum = FileChecksum::of_bytes(&state).fnv1a;
        for number in [self.case_fingerprint(), state.len() as u64, checksum] {
            out.write_all(&number.to_le_bytes())?;
        }
        Ok(out.write_all(&state)?)
    }

    /// Fingerprint of the case with its files, as at the first call.
    fn case_fingerprint(&self) -> u64 {
        *self.fingerprint.get_or_init(|| self.case.fingerprint())
    }

    /// Restores a state of [`Simulation::save`] of the same case.
    ///
    /// # Errors
    /// When the state is that of another case, or damaged: the present state is then unchanged. When the solver cannot continue from the
    /// state: the simulation can then not be continued.
    pub fn restore(&mut self, input: &mut dyn Read) -> Result<(), SolverError> {
        let mut number = || {
            let mut bytes = [0; 8];
            input.read_exact(&mut bytes).map(|()| u64::from_le_bytes(bytes))
        };
        let (fingerprint, length, checksum) = (number()?, number()?, number()?);
        if fingerprint != self.case_fingerprint() {
            return Err(SolverError::Checkpoint("it is of another case".to_owned()));
        }
        let mut state = Vec::new();
        input.take(length).read_to_end(&mut state)?;
        if state.len() as u64 != length || FileChecksum::of_bytes(&state).fnv1a != checksum {
            return Err(SolverError::Checkpoint("it is damaged or incomplete".to_owned()));
        }
        self.has_failed = true;
        self.restore_stage_and_solver(&mut state.as_slice())?;
        self.has_failed = false;
        Ok(())
    }

    /// Restores the position in the stages and the solver.
    fn restore_stage_and_solver(&mut self, input: &mut dyn Read) -> Result<(), SolverError> {
        let progress: StageProgress = restore_value(input)?;
        let known = progress.stage < self.case.stages.len();
        let (Some(start), true) = (progress.starts.get(progress.stage).copied(), known) else {
            return Err(SolverError::Checkpoint("it is of a case with other stages".to_owned()));
        };
        self.dynamic_mut().restore(input)?;
        self.dynamic_mut().resume_stage(progress.stage, start)?;
        self.progress = progress;
        Ok(())
    }

    /// Takes a step within a stage, after the start of the next stage where one has ended.
    fn step_in_stage(&mut self, at_most: f64) -> Result<Advance, SolverError> {
        let case = Arc::clone(&self.case);
        let (progress, solver) = (&mut self.progress, self.access.1(&mut self.solver));
        if progress.has_ended {
            let next = progress.stage + 1;
            solver.begin_stage(next, solver.time())?;
            progress.begin(next, solver);
        }
        let (stage, end) = (&case.stages[progress.stage], progress.end(&case));
        // Runs on a thread of the pool: from any other thread each loop of a step would wake a thread of the pool and wait for it.
        let done = rayon::scope(|_| {
            stable_step(solver, stage, end)?;
            let left = end - solver.time();
            step_solver(solver, at_most.min(left), end)
        })?;
        let is_over = is_negligible(end - solver.time(), solver.limit().dt.min(stage.duration));
        let is_at_rest = progress.is_at_rest(&case, solver);
        if is_over && !is_at_rest {
            progress.missed_equilibrium(&case, solver)?;
        }
        if is_over || is_at_rest {
            progress.end_stage(&case, solver)?;
        }
        Ok(done)
    }

    /// Duration (s) beside which the rest of a stage is negligible.
    fn shortest_span(&mut self) -> f64 {
        self.dynamic_mut().limit().dt.min(self.case.stages[self.progress.stage].duration)
    }

    /// Error at the current step and time.
    fn refusal(&self, reason: impl Into<FailureReason>) -> SolverError {
        let (step, time) = (self.dynamic().step_count(), self.dynamic().time());
        SolverError::Step { step, time, reason: reason.into() }
    }
}

impl<S> Deref for Simulation<S> {
    type Target = S;

    fn deref(&self) -> &S {
        &self.solver
    }
}

impl<S> DerefMut for Simulation<S> {
    fn deref_mut(&mut self) -> &mut S {
        &mut self.solver
    }
}
