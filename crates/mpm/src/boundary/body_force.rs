//! Body force of a program on the points: an acceleration by position, velocity and time.

use colluvium_case::SolverError;

use crate::boundary::boundary_conditions::BoundaryConditions;
use crate::clock::Clock;
use crate::points::bodies::{Bodies, point_error};

/// Acceleration (m/s²) at a position (m), a velocity (m/s) and a time (s), in addition to gravity.
pub type BodyForce<const D: usize> = dyn Fn(&[f64; D], &[f64; D], f64) -> [f64; D] + Send + Sync;

/// Computes the body forces of the deformable points at the start of a step; on an error they are unchanged.
pub(crate) fn update_body_forces<const D: usize>(
    clock: &Clock,
    bodies: &mut Bodies<D>,
    boundary: &BoundaryConditions<D>,
) -> Result<(), SolverError> {
    let Some(acceleration) = &boundary.body_force else { return Ok(()) };
    let mut forces = Vec::with_capacity(bodies.sets.len());
    for set in &bodies.sets {
        let mut of_set = Vec::with_capacity(set.len());
        for p in (0..set.len()).filter(|_| set.rigid.is_none()) {
            let points = &set.points;
            let a = acceleration(&points.position[p], &points.velocity[p], clock.time);
            if !a.iter().all(|a| a.is_finite()) {
                let reason = format!("the body force of the program gives the acceleration {a:?} m/s²");
                return Err(point_error(clock, set, p, reason));
            }
            of_set.push(a.map(|a| points.mass[p] * a));
        }
        forces.push(of_set);
    }
    for (set, forces) in bodies.sets.iter_mut().zip(forces) {
        set.points.body_force = forces;
    }
    Ok(())
}
