//! Damping of velocities in a step, for all methods.

/// Velocity at the end of a step with Rayleigh damping. `share` is the damping coefficient times the step; the velocities are those at the
/// start, and at the end without damping. The damping force is that of their mean: second order, and stable for any step.
pub fn rayleigh_damped_velocity(start: f64, end: f64, share: f64) -> f64 {
    (end - 0.5 * share * start) / (1.0 + 0.5 * share)
}

/// Sign of a number, and zero for zero.
pub fn sign_or_zero(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}
