//! Body force of a program on the points.

use colluvium_case::SolverError;

use crate::boundary::boundary_conditions::BoundaryConditions;
use crate::clock::Clock;
use crate::points::bodies::{Bodies, point_error};

/// Computes the body forces of the deformable points at the start of a step.
pub(crate) fn update_body_forces<const D: usize>(
    clock: &Clock,
    bodies: &mut Bodies<D>,
    boundary: &BoundaryConditions<D>,
) -> Result<(), SolverError> {
    let Some(body_force) = &boundary.body_force else { return Ok(()) };
    for set in bodies.sets.iter_mut().filter(|set| set.rigid.is_none()) {
        let points = &mut set.points;
        let forces = &mut points.body_force;
        if let Err(invalid) = body_force.accelerations(&points.position, &points.velocity, clock.time, forces)
        {
            return Err(point_error(clock, set, invalid.point, invalid.to_string()));
        }
        for (force, mass) in forces.iter_mut().zip(&points.mass) {
            *force = force.map(|acceleration| mass * acceleration);
        }
    }
    Ok(())
}
