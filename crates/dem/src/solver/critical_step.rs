//! Critical time step (sheet: dem §3.5).

use colluvium_case::{MovingObstacle, StepLimit, TimeStep};

use crate::solver::DemSolver;

/// Largest displacement of the fastest grain in a step, over the smallest radius (sheet: dem §3.5).
const MAX_TRAVEL: f64 = 0.1;

/// Overlap over the smaller radius beyond which Hertz contacts take shorter steps: that of an impact which lasts for 20 steps of the
/// fraction of the Rayleigh wave (sheet: dem §3.5).
const DEEP_OVERLAP: f64 = 0.008;

/// Step limit by the duration of contacts.
const CONTACT: StepLimit = StepLimit::new("contact");

/// Step limit by the displacement of the fastest grain.
const TRAVEL: StepLimit = StepLimit::new("travel");

/// Largest growth factor of the step of Hertz contacts from one step to the next: by 1 % over a collision, whose restitution has errors
/// where its steps change, although the overlap and the speed decrease.
const GROWTH: f64 = 1.0005;

impl<const D: usize, const R: usize> DemSolver<D, R> {
    /// Factor on the step of Hertz contacts that stiffen with their overlap: the frequency is proportional to its fourth root. The
    /// overlap is that of the deepest contact after an impact of the fastest grains, so that it hardly changes during the impact.
    pub(super) fn deep_contact_factor(&self) -> f64 {
        let square = self.energy_balance.overlap * self.energy_balance.overlap;
        let energy =
            square * self.energy_balance.overlap.sqrt() + self.laws.impact * self.max_speed * self.max_speed;
        let share = if self.laws.impact > 0.0 && energy > DEEP_OVERLAP * DEEP_OVERLAP * DEEP_OVERLAP.sqrt() {
            (DEEP_OVERLAP * DEEP_OVERLAP * DEEP_OVERLAP.sqrt() / energy).powf(0.1)
        } else {
            1.0
        };
        share.min(GROWTH * self.deep_share)
    }

    /// Critical step at present (sheet: dem §3.5).
    pub(crate) fn critical_step(&self) -> TimeStep {
        let least = self.radii.0;
        let moving = self.walls.iter().filter_map(|wall| wall.moving.as_ref());
        let fastest = moving.map(MovingObstacle::max_speed).fold(self.max_speed, f64::max);
        let way = if fastest > 0.0 { MAX_TRAVEL * least / fastest } else { f64::INFINITY };
        let of_contacts =
            self.options.time_step.unwrap_or_else(|| self.laws.step[0] * self.deep_contact_factor());
        let (dt, limit) = match (way < of_contacts, self.options.time_step) {
            (true, _) => (way, TRAVEL),
            (false, Some(_)) => (of_contacts, StepLimit::FIXED),
            (false, None) => (of_contacts, CONTACT),
        };
        TimeStep { dt, limit, point: None, position: [0.0; 3] }
    }
}
