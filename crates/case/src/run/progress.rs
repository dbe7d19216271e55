//! Where a run stands.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::output::{Collection, FileChecksum};
use crate::run::energy_monitor::EnergyMonitor;
use crate::{Budget, TimeStep};

/// Where a run stands: everything but the solver that a restart needs.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct RunProgress {
    pub(crate) begun: bool,
    pub(crate) stage: usize,
    /// When the stages so far began (s).
    pub(crate) stage_starts: Vec<f64>,
    pub(crate) checks_at_rest: u32,
    /// Wall-clock time so far (s).
    pub(crate) wall: f64,
    pub(crate) frames: u64,
    pub(crate) rows: u64,
    pub(crate) collection: Collection,
    /// Seals of the files of the frames, by name.
    pub(crate) seals: BTreeMap<String, FileChecksum>,
    /// Steps done at each frame of the collection.
    pub(crate) frame_steps: Vec<u64>,
    /// Totals at the start.
    pub(crate) start: Option<Budget>,
    /// Bound on the last step (s).
    pub(crate) time_step: Option<f64>,
    /// Bound on the first step (s).
    pub(crate) first_time_step: Option<f64>,
    /// What was said when the step had become a small part of the first one.
    pub(crate) collapse: Option<String>,
    /// What the solver warned of first.
    pub(crate) warning: Option<String>,
    /// The energy of the stage.
    pub(crate) energy: EnergyMonitor,
    /// What was to be said of the energy of the stages before.
    pub(crate) energy_warning: Option<String>,
    /// Stages that ended before they came to rest, which they need not, and what was said.
    pub(crate) missed_equilibria: Vec<(usize, String)>,
    /// When the stages that are over ended (s).
    pub(crate) stage_ends: Vec<f64>,
    /// What has bounded the steps so far.
    pub(crate) step_bounds: Vec<StepBoundCount>,
}

/// How often something bounded the step, and where most.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct StepBoundCount {
    pub(crate) steps: u64,
    /// The least bound.
    pub(crate) min_step: TimeStep,
    /// When it was (s).
    pub(crate) time: f64,
}

impl RunProgress {
    /// Counts a step from `time` (s) for what bounds it.
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

    /// When the stage began (s).
    pub(crate) fn stage_start(&self) -> f64 {
        self.stage_starts.last().copied().unwrap_or(0.0)
    }
}
