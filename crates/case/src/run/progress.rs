//! Progress of a run.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::output::{Collection, FileChecksum};
use crate::run::energy_monitor::EnergyMonitor;
use crate::simulation::stage_progress::StageProgress;
use crate::{Budget, TimeStep};
use colluvium_constitutive::Warning;

/// Progress of a run: all data of a restart other than the state of the solver.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct RunProgress {
    /// Whether the first stage has begun.
    pub(crate) has_begun: bool,
    /// Position in the stages.
    pub(crate) stages: StageProgress,
    /// Whether all stages have ended and the searches for factors of safety have begun.
    pub(crate) is_searching: bool,
    /// Wall-clock time so far (s).
    pub(crate) wall: f64,
    /// Number of frames written.
    pub(crate) frames: u64,
    /// Number of rows of the table of measures.
    pub(crate) rows: u64,
    /// ParaView collection of the frames written.
    pub(crate) collection: Collection,
    /// Checksums of the frame files, by name.
    pub(crate) frame_checksums: BTreeMap<String, FileChecksum>,
    /// Step numbers of the frames in the collection.
    pub(crate) frame_steps: Vec<u64>,
    /// Mass, momentum and energies at the start.
    pub(crate) start: Option<Budget>,
    /// Bound on the last step (s).
    pub(crate) time_step: Option<f64>,
    /// Bound on the first step (s).
    pub(crate) first_time_step: Option<f64>,
    /// Warning that the step has become a small part of the first step.
    pub(crate) collapse: Option<Warning>,
    /// First warning of the solver.
    pub(crate) warning: Option<Warning>,
    /// Monitor of the energy of the stage.
    pub(crate) energy: EnergyMonitor,
    /// Warning about the energy of earlier stages.
    pub(crate) energy_warning: Option<Warning>,
    /// Numbers of stages that ended without their optional equilibrium, with the warnings.
    pub(crate) missed_equilibria: Vec<(usize, Warning)>,
    /// End times of the completed stages (s).
    pub(crate) stage_ends: Vec<f64>,
    /// Number of steps that each criterion limited.
    pub(crate) step_bounds: Vec<StepBoundCount>,
}

/// Number of steps with the same limiting criterion, and the smallest of them.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct StepBoundCount {
    /// Number of steps that this bound limited.
    pub(crate) steps: u64,
    /// Smallest step.
    pub(crate) min_step: TimeStep,
    /// Time of the smallest step (s).
    pub(crate) time: f64,
}

impl RunProgress {
    /// Counts a step from `time` (s) under its limiting criterion.
    pub(crate) fn count(&mut self, bound: &TimeStep, time: f64) {
        self.time_step = Some(bound.dt);
        match self.step_bounds.iter_mut().find(|known| known.min_step.limit == bound.limit) {
            Some(known) => {
                known.steps += 1;
                if bound.dt < known.min_step.dt {
                    (known.min_step, known.time) = (*bound, time);
                }
            }
            None => self.step_bounds.push(StepBoundCount { steps: 1, min_step: *bound, time }),
        }
    }
}
