//! Body force of a program on the points, and its work.

use colluvium_case::BodyForce;

use crate::points::bodies::{Bodies, PointFailure};

/// Computes the body force at the positions and velocities of the points and a time (s).
///
/// # Errors
/// The index of the body and the first point at which it is not finite; nothing else has changed then.
pub fn update_body_forces<const D: usize>(
    force: &BodyForce<D>,
    bodies: &mut Bodies<D>,
    time: f64,
) -> Result<(), (usize, PointFailure)> {
    for (number, body) in bodies.bodies.iter_mut().enumerate() {
        let points = &mut body.points;
        points.body_force.resize(points.id.len(), [0.0; D]);
        let computed = force.accelerations(&points.position, &points.velocity, time, &mut points.body_force);
        computed.map_err(|invalid| {
            let failure = PointFailure { index: invalid.point, reason: invalid.to_string().into() };
            (number, failure)
        })?;
    }
    Ok(())
}

/// Work of the body force on a displacement from the origin to the positions of the points (J); zero without. The difference over a step
/// is the work in the step.
pub fn body_force_potential<const D: usize>(bodies: &Bodies<D>) -> f64 {
    let of_point = |(mass, (force, x)): (&f64, (&[f64; D], &[f64; D]))| {
        mass * (0..D).map(|c| force[c] * x[c]).sum::<f64>()
    };
    let of_body = bodies.bodies.iter().map(|body| &body.points);
    of_body
        .flat_map(|points| points.mass.iter().zip(points.body_force.iter().zip(&points.position)))
        .map(of_point)
        .sum()
}
