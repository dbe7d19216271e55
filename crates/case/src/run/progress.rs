//! Where a run stands.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::output::{Collection, FileChecksum};
use crate::run::energy_monitor::EnergyMonitor;
use crate::{Budget, TimeStep};

/// Where a run stands: everything but the solver that a restart needs.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(super) struct RunProgress {
    pub(super) begun: bool,
    pub(super) stage: usize,
    /// When the stages so far began (s).
    pub(super) stage_starts: Vec<f64>,
    pub(super) checks_at_rest: u32,
    /// Wall-clock time so far (s).
    pub(super) wall: f64,
    pub(super) frames: u64,
    pub(super) rows: u64,
    pub(super) collection: Collection,
    /// Seals of the files of the frames, by name.
    pub(super) seals: BTreeMap<String, FileChecksum>,
    /// Steps done at each frame of the collection.
    pub(super) frame_steps: Vec<u64>,
    /// Totals at the start.
    pub(super) start: Option<Budget>,
    /// Bound on the last step (s).
    pub(super) time_step: Option<f64>,
    /// Bound on the first step (s).
    pub(super) first_time_step: Option<f64>,
    /// What was said when the step had become a small part of the first one.
    pub(super) collapse: Option<String>,
    /// What the solver warned of first.
    pub(super) warning: Option<String>,
    /// The energy of the stage.
    pub(super) energy: EnergyMonitor,
    /// What was to be said of the energy of the stages before.
    pub(super) energy_warning: Option<String>,
    /// Stages that ended before they came to rest, which they need not, and what was said.
    pub(super) missed_equilibria: Vec<(usize, String)>,
    /// When the stages that are over ended (s).
    pub(super) stage_ends: Vec<f64>,
    /// What has bounded the steps so far.
    pub(super) step_bounds: Vec<StepBoundCount>,
}

/// How often something bounded the step, and where most.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct StepBoundCount {
    pub(super) steps: u64,
    /// The least bound.
    pub(super) min_step: TimeStep,
    /// When it was (s).
    pub(super) time: f64,
}

impl RunProgress {
    /// Counts a step from `time` (s) for what bounds it.
    pub(super) fn count(&mut self, bound: &TimeStep, time: f64) {
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

    /// When the stage began (s).
    pub(super) fn stage_start(&self) -> f64 {
        self.stage_starts.last().copied().unwrap_or(0.0)
    }
}
