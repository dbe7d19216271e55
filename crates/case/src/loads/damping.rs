//! Damping of velocities in a step, for every method.

/// Velocity at the end of a step that Rayleigh damping `share` (damping times step) slows, from those at the start and at
/// the end without it: the damping force is that of the mean of both, so that it is of second order and no step is too long.
pub fn rayleigh_damped_velocity(start: f64, end: f64, share: f64) -> f64 {
    (end - 0.5 * share * start) / (1.0 + 0.5 * share)
}

/// Sign, and zero of zero.
pub fn sign_or_zero(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}
