//! Critical time step (sheet: dem §3.5).

use colluvium_case::{MovingObstacle, StepLimit, TimeStep};

use crate::boundary::walls::RigidWall;
use crate::clock::Clock;
use crate::contact::contact_laws::ContactLaws;
use crate::output::energy_balance::EnergyBalance;
use crate::points::grain_extremes::GrainExtremes;

/// Largest displacement of the fastest grain in a step, over the smallest radius (sheet: dem §3.5).
const MAX_TRAVEL: f64 = 0.1;

/// Overlap over the smaller radius above which Hertz contacts need a shorter step (sheet: dem §3.5). It is that of an impact which lasts
/// for 20 steps of the fraction of the Rayleigh time.
const DEEP_OVERLAP: f64 = 0.008;

/// Step limit by the duration of contacts.
const CONTACT: StepLimit = StepLimit::new("contact");

/// Step limit by the displacement of the fastest grain.
const GRAIN_DISPLACEMENT: StepLimit = StepLimit::new("travel");

/// Largest growth factor of the time step of Hertz contacts from one step to the next. It limits the growth to 1 % during a collision,
/// because changing steps cause errors of restitution.
const GROWTH: f64 = 1.0005;

/// Factor on the step of Hertz contacts that stiffen with their overlap: the frequency is proportional to its fourth root. The
/// overlap is that of the deepest contact after an impact of the fastest grains, so that it hardly changes during the impact.
pub fn deep_contact_factor(
    clock: &Clock,
    laws: &ContactLaws,
    extremes: &GrainExtremes,
    balance: &EnergyBalance,
) -> f64 {
    let (overlap, impact) = (balance.overlap, laws.stage.impact);
    let square = overlap * overlap;
    let energy = square * overlap.sqrt() + impact * extremes.max_speed * extremes.max_speed;
    let share = if impact > 0.0 && energy > DEEP_OVERLAP * DEEP_OVERLAP * DEEP_OVERLAP.sqrt() {
        (DEEP_OVERLAP * DEEP_OVERLAP * DEEP_OVERLAP.sqrt() / energy).powf(0.1)
    } else {
        1.0
    };
    share.min(GROWTH * clock.deep_contact_factor)
}

/// Critical step at present (sheet: dem §3.5).
pub fn critical_step<const D: usize>(
    clock: &Clock,
    laws: &ContactLaws,
    extremes: &GrainExtremes,
    walls: &[RigidWall<D>],
    balance: &EnergyBalance,
) -> TimeStep {
    let smallest = extremes.radii.0;
    let moving = walls.iter().filter_map(|wall| wall.motion.as_ref());
    let fastest = moving.map(MovingObstacle::max_speed).fold(extremes.max_speed, f64::max);
    let of_travel = if fastest > 0.0 { MAX_TRAVEL * smallest / fastest } else { f64::INFINITY };
    let fixed = clock.options.time_step;
    let of_contacts =
        fixed.unwrap_or_else(|| laws.stage.step[0] * deep_contact_factor(clock, laws, extremes, balance));
    let (dt, limit) = match (of_travel < of_contacts, fixed) {
        (true, _) => (of_travel, GRAIN_DISPLACEMENT),
        (false, Some(_)) => (of_contacts, StepLimit::FIXED_STEP),
        (false, None) => (of_contacts, CONTACT),
    };
    TimeStep { dt, limit, point: None, position: [0.0; 3] }
}
