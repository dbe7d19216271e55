//! Normal dashpots in steps of finite length, corrected to give the restitution of the law (sheet: dem §2.3).

use super::{ContactGeometry, NormalResponse, PairLaw};
use crate::points::vector::SimdNumber;

/// Steps (s) before and after the time of the forces, which act over half of each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepLengths<T = f64> {
    /// Last step (s); zero at the start.
    pub last: T,
    /// Following step (s).
    pub next_step: T,
    /// Step of which half is the delay of lagged velocities (s): the previous step.
    pub lag_step: T,
}

impl<T: SimdNumber> StepLengths<T> {
    /// Creates the lengths of the steps `last` and `next_step` (s).
    #[inline(always)]
    pub fn from_steps(last: T, next_step: T) -> Self {
        Self { last, next_step, lag_step: last }
    }

    /// Step lengths for the evaluation of contacts at the end of a step of the length `behind` (s).
    pub fn for_probe(behind: T) -> Self {
        Self { last: T::broadcast(0.0), next_step: T::broadcast(0.0), lag_step: behind }
    }

    /// Time over which a force acts (s).
    #[inline(always)]
    fn force_time(&self) -> T {
        T::broadcast(0.5) * (self.last + self.next_step)
    }

    /// Factor on the dashpot of a contact that starts or ends within the step. It lasts for `time` (s) on one side of the time of the
    /// forces and for half a step `half` (s) on the other. The dashpot is constant, or proportional to the fourth root of the overlap,
    /// which is linear in time.
    #[inline(always)]
    fn factor(&self, time: T, half: T, is_hertz: bool) -> T {
        let both = time + half;
        let share = both / self.force_time();
        if is_hertz { T::broadcast(0.8) * share * (both / time).root().root() } else { share }
    }
}

/// Dashpot of a contact in the step (N s/m); `is_new` marks its first step.
#[inline]
pub fn dashpot_in_step<const D: usize, const R: usize>(
    law: &PairLaw,
    base: &NormalResponse,
    geometry: &ContactGeometry<D, R>,
    is_new: bool,
    steps: &StepLengths,
) -> f64 {
    let mut damping = lagged_dashpot(base.damping, geometry.inverse_mass, law.velocity_lag * steps.lag_step);
    if is_new {
        damping = onset_dashpot(damping, geometry, steps, law.is_hertz());
    }
    if !law.no_tension && law.attraction.is_none() {
        damping = release_dashpot(&NormalResponse { damping, ..*base }, geometry, steps, law.is_hertz());
    }
    damping
}

/// Dashpot (N s/m) whose force with a velocity that is `lag/2` old (s) damps a pair as `dashpot` does with the current velocity. The delay
/// reduces the mass in the equation of motion by `dashpot × lag / 2`.
#[inline(always)]
pub fn lagged_dashpot<T: SimdNumber>(dashpot: T, inverse_mass: T, lag: T) -> T {
    let share = T::broadcast(0.25) * dashpot * lag * inverse_mass;
    dashpot * ((T::broadcast(1.0) + share * share).root() - share)
}

/// Dashpot in the first step of a contact (N s/m). Its impulse is that of the time since first contact, `overlap / |v_n|`, and of the
/// following half step. Unchanged where first contact was earlier or the grains separate.
#[inline(always)]
pub fn onset_dashpot<const D: usize, const R: usize, T: SimdNumber>(
    dashpot: T,
    geometry: &ContactGeometry<D, R, T>,
    steps: &StepLengths<T>,
    is_hertz: bool,
) -> T {
    let time = -geometry.overlap / geometry.separation_velocity;
    // First contact a step ago: the time is bounded by the last step.
    let time = time.select_above(steps.last, steps.last, time);
    let approach = -geometry.separation_velocity * steps.last;
    let factor = steps.factor(time, T::broadcast(0.5) * steps.next_step, is_hertz);
    (approach + approach).select_above(geometry.overlap, dashpot * factor, dashpot)
}

/// Change of the overlap in the next step under a normal response (m), positive where the overlap decreases.
#[inline(always)]
pub fn opening<const D: usize, const R: usize, T: SimdNumber>(
    base: &NormalResponse<T>,
    geometry: &ContactGeometry<D, R, T>,
    steps: &StepLengths<T>,
) -> T {
    let kick = steps.force_time() * geometry.inverse_mass;
    steps.next_step
        * (geometry.separation_velocity + kick * (base.force - base.damping * geometry.separation_velocity))
}

/// Dashpot in the last step of a contact that may be in tension while it opens (N s/m). Its impulse is that of the preceding half step and
/// of the time until the overlap ends. Unchanged where the overlap does not end within the step.
#[inline(always)]
pub fn release_dashpot<const D: usize, const R: usize, T: SimdNumber>(
    base: &NormalResponse<T>,
    geometry: &ContactGeometry<D, R, T>,
    steps: &StepLengths<T>,
    is_hertz: bool,
) -> T {
    let (dt, kick) = (steps.next_step, steps.force_time() * geometry.inverse_mass);
    let whole = opening(base, geometry, steps);
    // Dashpots with which the overlap just ends, and just persists.
    let [ends, stays] = [1.0 + 1e-9, 1.0 - 1e-9].map(|share| {
        base.damping
            + (whole - geometry.overlap * T::broadcast(share)) / (dt * kick * geometry.separation_velocity)
    });
    let time = geometry.overlap * dt / whole;
    let wanted = base.damping * steps.factor(time, T::broadcast(0.5) * steps.last, is_hertz);
    // A contact that persists loses as much again as one that opens at once: take the nearer of the two.
    let again = base.damping * T::broadcast(if is_hertz { HALF_STEP_OF_HERTZ } else { 0.5 });
    let largest = (wanted - ends).select_above(T::broadcast(0.5) * again, stays, ends);
    let ending = wanted.select_above(ends, largest, wanted);
    let ending = whole.select_above(geometry.overlap, ending, base.damping);
    geometry.separation_velocity.select_above(T::broadcast(0.0), ending, base.damping)
}

/// Impulse in the last half step of a dashpot that is proportional to the fourth root of the remaining time, over that of a constant
/// dashpot with its value one step before the end: 4/5 (1/2)^(5/4).
const HALF_STEP_OF_HERTZ: f64 = 0.336_358_566;
