//! Dashpots along the normal in steps of finite length: what makes the restitution that of the law (sheet: dem §2.3).

use super::{Elastic, Law, Touch};
use crate::vector::Number;

/// Dashpot (N s/m) of a contact in a step of `dt` (s), which is its first where it `is_new`.
#[inline]
pub fn in_step<const D: usize, const R: usize>(
    law: &Law,
    base: &Elastic,
    touch: &Touch<D, R>,
    is_new: bool,
    dt: f64,
) -> f64 {
    let mut damping = lagged(base.damping, touch.mass, law.lag * dt);
    if is_new {
        damping = at_onset(damping, touch, dt, law.is_hertz());
    }
    if !law.clamp && law.attraction.is_none() {
        damping = at_release(&Elastic { damping, ..*base }, touch, dt, law.is_hertz());
    }
    damping
}

/// Dashpot (N s/m) whose force with a velocity `lag` / 2 (s) behind damps a pair of this effective mass (kg) as `dashpot` does with the
/// velocity of the time: the lag takes `dashpot × lag / 2` from the mass in the equation of motion, and the damping ratio is over its root.
#[inline(always)]
pub fn lagged<T: Number>(dashpot: T, mass: T, lag: T) -> T {
    let share = T::of(0.25) * dashpot * lag / mass;
    dashpot * ((T::of(1.0) + share * share).root() - share)
}

/// Dashpot in the first step of a contact: the impulse over a step of `dt` (s) is that of the time since the grains met, `overlap / |v_n|`,
/// and of the half step that follows. Stands unchanged where the grains met earlier or separate.
#[inline(always)]
pub fn at_onset<const D: usize, const R: usize, T: Number>(
    dashpot: T,
    touch: &Touch<D, R, T>,
    dt: T,
    is_hertz: bool,
) -> T {
    let (way, one) = (-touch.separation * dt, T::of(1.0));
    // Grains that met a step ago are seen on either side of that.
    let time = touch.overlap / way;
    let time = time.above(one, one, time);
    (way + way).above(touch.overlap, dashpot * factor(time, is_hertz), dashpot)
}

/// Dashpot in the last step of a contact that pulls as it opens: the impulse is that of the half step before and of the time until the
/// overlap ends. Stands unchanged where it does not end within the step.
#[inline(always)]
pub fn at_release<const D: usize, const R: usize, T: Number>(
    base: &Elastic<T>,
    touch: &Touch<D, R, T>,
    dt: T,
    is_hertz: bool,
) -> T {
    let kick = dt / touch.mass;
    let way = |dashpot: T| dt * (touch.separation + kick * (base.force - dashpot * touch.separation));
    let whole = way(base.damping);
    // With no more than lets it end.
    let excess = (whole - touch.overlap * T::of(1.0 + 1e-9)) / (dt * kick * touch.separation);
    let share = base.damping * factor(touch.overlap / whole, is_hertz);
    let most = base.damping + excess;
    let ending = whole.above(touch.overlap, share.above(most, most, share), base.damping);
    touch.separation.above(T::of(0.0), ending, base.damping)
}

/// Factor on the dashpot of a contact that lasts for half a step and `time` steps on one side of the step: the dashpot is constant, or goes
/// with the fourth root of the overlap.
#[inline(always)]
fn factor<T: Number>(time: T, is_hertz: bool) -> T {
    let both = time + T::of(0.5);
    if is_hertz { T::of(0.8) * both * (both / time).root().root() } else { both }
}
