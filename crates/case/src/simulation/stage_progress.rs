//! Position of a solver in the stages of its case.

use serde::{Deserialize, Serialize};

use crate::Case;
use crate::solver::{MissedEquilibrium, Solver, SolverError};

/// Position in the stages, as a checkpoint contains it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct StageProgress {
    /// Index of the stage.
    pub(crate) stage: usize,
    /// Start times of the stages so far (s).
    pub(crate) starts: Vec<f64>,
    /// Consecutive checks at which the bodies were at rest.
    checks_at_rest: u32,
    /// Whether the stage has ended.
    pub(crate) has_ended: bool,
}

impl StageProgress {
    /// Start time of the stage (s).
    pub(crate) fn start(&self) -> f64 {
        self.starts.last().copied().unwrap_or(0.0)
    }

    /// Time of the end of the stage (s), unless the bodies are at rest before.
    pub(crate) fn end(&self, case: &Case) -> f64 {
        self.start() + case.stages[self.stage].duration
    }

    /// Moves to a stage, which begins at the time of the solver.
    pub(crate) fn begin(&mut self, stage: usize, solver: &dyn Solver) {
        self.stage = stage;
        self.starts.push(solver.time());
        self.checks_at_rest = 0;
        self.has_ended = false;
    }

    /// Ends the stage in the solver, which resets what the stage resets.
    pub(crate) fn end_stage(&mut self, case: &Case, solver: &mut dyn Solver) -> Result<(), SolverError> {
        solver.end_stage(&case.stages[self.stage])?;
        self.has_ended = true;
        Ok(())
    }

    /// Whether the last stage has ended.
    pub(crate) fn is_complete(&self, case: &Case) -> bool {
        self.has_ended && self.stage + 1 == case.stages.len()
    }

    /// Whether the bodies have been at rest for the consecutive checks that the stage requires. Called after each step.
    pub(crate) fn is_at_rest(&mut self, case: &Case, solver: &dyn Solver) -> bool {
        let Some(criterion) = &case.stages[self.stage].equilibrium else { return false };
        if !solver.step_count().is_multiple_of(solver.steps_between_checks()) {
            return false;
        }
        let ramps_are_complete =
            case.ramps_are_complete(&self.starts, solver.time()) && solver.ramps_are_complete();
        let rests = solver.equilibrium().is_some_and(|now| {
            now.unbalanced_force < criterion.unbalanced_force && now.kinetic_ratio < criterion.kinetic_energy
        });
        self.checks_at_rest = if ramps_are_complete && rests { self.checks_at_rest + 1 } else { 0 };
        self.checks_at_rest >= criterion.hold
    }

    /// Equilibrium that the stage requests and has missed at the end of its duration; `None` where it requests none.
    ///
    /// # Errors
    /// When the stage requires it.
    pub(crate) fn missed_equilibrium(
        &self,
        case: &Case,
        solver: &dyn Solver,
    ) -> Result<Option<MissedEquilibrium>, SolverError> {
        let stage = &case.stages[self.stage];
        let Some(criterion) = &stage.equilibrium else { return Ok(None) };
        let last = solver.equilibrium();
        let missed = MissedEquilibrium {
            stage: self.stage,
            duration: stage.duration,
            unbalanced: last.map_or(f64::NAN, |last| last.unbalanced_force),
            kinetic: last.map_or(f64::NAN, |last| last.kinetic_ratio),
        };
        if criterion.required { Err(SolverError::NoEquilibrium(missed)) } else { Ok(Some(missed)) }
    }
}
