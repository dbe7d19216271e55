//! Solvers that a program steps itself: typed construction, the loop over the stages, views of the points.
//!
//! A [`TypedMethod`] with its options builds a [`Simulation`], which steps its solver through the stages of the case as a run does, without
//! output and measures. The room knows the description and the solver interface; a run does not know it.

mod body_force;
mod configured_method;
mod point_column;

use std::io::{Read, Write};
use std::ops::{Deref, DerefMut};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::run::step_size::{is_negligible, stable_step};
use crate::solver::{Advance, Solver, SolverError, TimeStep, restore_value, save_value};
use crate::{Case, CaseErrors};

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
    progress: StageProgress,
    /// Notes of the method on ignored parts of the case.
    notes: Vec<String>,
    has_failed: bool,
}

/// Position in the stages, as a checkpoint contains it.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct StageProgress {
    /// Index of the stage.
    stage: usize,
    /// Start times of the stages so far (s).
    stage_starts: Vec<f64>,
    /// Consecutive checks at which the bodies were at rest.
    checks_at_rest: u32,
    /// Whether the stage has ended.
    stage_has_ended: bool,
}

impl<S: Solver> Simulation<S> {
    /// Solver at the start of the first stage; `notes` are those of the method on ignored parts of the case.
    pub(crate) fn new(case: Arc<Case>, mut solver: S, notes: Vec<String>) -> Result<Self, CaseErrors> {
        let start = solver.time();
        solver
            .begin_stage(0, start)
            .map_err(|error| CaseErrors::from_error(crate::CaseError::new("stages[0]", error.to_string())))?;
        let progress = StageProgress { stage_starts: vec![start], ..StageProgress::default() };
        Ok(Self { case, solver, progress, notes, has_failed: false })
    }

    /// Case of the simulation.
    pub fn case(&self) -> &Case {
        &self.case
    }

    /// Time (s).
    pub fn time(&self) -> f64 {
        self.solver.time()
    }

    /// Index of the current stage.
    pub fn stage(&self) -> usize {
        self.progress.stage
    }

    /// Notes of the method on parts of the case that it ignores.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// Solver, to which this type also dereferences.
    pub fn solver(&self) -> &S {
        &self.solver
    }

    /// Whether the last stage has ended.
    pub fn is_complete(&self) -> bool {
        self.progress.stage_has_ended && self.progress.stage + 1 == self.case.stages.len()
    }

    /// Largest stable step from the current state (s), with its limit. It is constant until the next step.
    pub fn limit(&mut self) -> TimeStep {
        self.solver.limit()
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
            return Err(self.refusal("an earlier step has failed: build a new solver".to_owned()));
        }
        if self.is_complete() {
            let problem = "the last stage has ended: add a stage to the case, or make the last one longer";
            return Err(self.refusal(problem.to_owned()));
        }
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
        let first = self.solver.step_count();
        while !is_negligible(time - self.time(), self.shortest_span()) {
            self.step_at_most(time - self.time())?;
        }
        Ok(self.solver.step_count() - first)
    }

    /// Saves the state. A simulation of the same case continues from it bit-identically.
    ///
    /// # Errors
    /// When writing fails, and after an earlier error.
    pub fn save(&self, out: &mut dyn Write) -> Result<(), SolverError> {
        if self.has_failed {
            return Err(self.refusal("the state after a failed step cannot be saved".to_owned()));
        }
        save_value(&self.progress, out)?;
        self.solver.save(out)
    }

    /// Restores a state of [`Simulation::save`] of the same case.
    ///
    /// # Errors
    /// When the bytes are no such state; the simulation can then not be continued.
    pub fn restore(&mut self, input: &mut dyn Read) -> Result<(), SolverError> {
        let restored = self.restore_stage_and_solver(input);
        self.has_failed = restored.is_err();
        restored
    }

    /// Restores the position in the stages and the solver.
    fn restore_stage_and_solver(&mut self, input: &mut dyn Read) -> Result<(), SolverError> {
        let progress: StageProgress = restore_value(input)?;
        let known = progress.stage < self.case.stages.len();
        let (Some(start), true) = (progress.stage_starts.get(progress.stage).copied(), known) else {
            return Err(SolverError::Checkpoint("it is of a case with other stages".to_owned()));
        };
        self.solver.restore(input)?;
        self.solver.begin_stage(progress.stage, start)?;
        self.progress = progress;
        Ok(())
    }

    /// Takes a step within a stage, after the start of the next stage where one has ended.
    fn step_in_stage(&mut self, at_most: f64) -> Result<Advance, SolverError> {
        if self.progress.stage_has_ended {
            self.begin_next_stage()?;
        }
        let case = Arc::clone(&self.case);
        let stage = &case.stages[self.progress.stage];
        let end = self.progress.stage_starts[self.progress.stage] + stage.duration;
        let solver = &mut self.solver;
        // Runs on a thread of the pool: from any other thread each loop of a step would wake a thread of the pool and wait for it.
        let done = rayon::scope(|_| {
            let limit =
                stable_step(solver, stage, end).map_err(|error| solver_error(solver, &error.to_string()))?;
            let time = solver.time();
            let done = solver.step(at_most.min(end - time))?;
            if !(solver.time() > time) {
                let reason =
                    format!("the step of {:e} s ({}) does not change the time", done.dt, limit.limit);
                return Err(solver_error(solver, &reason));
            }
            Ok(done)
        })?;
        let is_over = is_negligible(end - self.time(), self.shortest_span());
        if self.is_at_rest() {
            self.end_stage()?;
        } else if is_over {
            self.check_equilibrium()?;
            self.end_stage()?;
        }
        Ok(done)
    }

    /// Begins the stage after one that has ended.
    fn begin_next_stage(&mut self) -> Result<(), SolverError> {
        let (stage, start) = (self.progress.stage + 1, self.solver.time());
        self.solver.begin_stage(stage, start)?;
        self.progress.stage = stage;
        self.progress.stage_starts.push(start);
        self.progress.checks_at_rest = 0;
        self.progress.stage_has_ended = false;
        Ok(())
    }

    /// Ends the stage, and resets what it resets.
    fn end_stage(&mut self) -> Result<(), SolverError> {
        self.solver.end_stage(&self.case.stages[self.progress.stage])?;
        self.progress.stage_has_ended = true;
        Ok(())
    }

    /// Whether the bodies have been at rest for the consecutive checks that the stage requires.
    fn is_at_rest(&mut self) -> bool {
        let Some(criterion) = &self.case.stages[self.progress.stage].equilibrium else { return false };
        if !self.solver.step_count().is_multiple_of(self.solver.steps_between_checks()) {
            return false;
        }
        let complete = self.case.ramps_are_complete(&self.progress.stage_starts, self.solver.time())
            && self.solver.ramps_are_complete();
        let rests = self.solver.equilibrium().is_some_and(|now| {
            now.unbalanced_force < criterion.unbalanced_force && now.kinetic_ratio < criterion.kinetic_energy
        });
        self.progress.checks_at_rest = if complete && rests { self.progress.checks_at_rest + 1 } else { 0 };
        self.progress.checks_at_rest >= criterion.hold
    }

    /// Refuses the end of a stage that requires equilibrium without it.
    fn check_equilibrium(&self) -> Result<(), SolverError> {
        let stage = &self.case.stages[self.progress.stage];
        match &stage.equilibrium {
            Some(criterion) if criterion.required => Err(self.refusal(format!(
                "stage {:?} has ended after {} s without equilibrium: give it more time or damping, or set \
                 `required` of its equilibrium to false",
                stage.name, stage.duration
            ))),
            _ => Ok(()),
        }
    }

    /// Duration (s) beside which the rest of a stage is negligible.
    fn shortest_span(&mut self) -> f64 {
        self.solver.limit().dt.min(self.case.stages[self.progress.stage].duration)
    }

    /// Error at the current step and time.
    fn refusal(&self, reason: String) -> SolverError {
        SolverError::Step { step: self.solver.step_count(), time: self.solver.time(), reason }
    }
}

/// Error of a solver at its current step and time.
fn solver_error(solver: &impl Solver, reason: &str) -> SolverError {
    SolverError::Step { step: solver.step_count(), time: solver.time(), reason: reason.to_owned() }
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
