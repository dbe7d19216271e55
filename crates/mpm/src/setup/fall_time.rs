//! Height of bodies and time of a fall.

use colluvium_case::Case;
use colluvium_case::description::Body;

/// Height of a body along gravity at the start (m); zero without gravity.
pub fn body_height(case: &Case, body: &Body) -> f64 {
    let (low, high) = body.shape.bounds(case.dimension());
    let along = (0..case.dimension()).map(|axis| (high[axis] - low[axis]) * case.gravity[axis].abs());
    let gravity = case.gravity_magnitude();
    if gravity > 0.0 { along.sum::<f64>() / gravity } else { 0.0 }
}

/// Time of a free fall through the height of the bodies, `√(H/g)` (s); `None` without gravity.
pub fn time_of_fall(case: &Case) -> Option<f64> {
    let highest = case.bodies.iter().filter(|body| !body.rigid).map(|body| body_height(case, body));
    let time = (highest.fold(0.0, f64::max) / case.gravity_magnitude()).sqrt();
    (time.is_finite() && time > 0.0).then_some(time)
}
