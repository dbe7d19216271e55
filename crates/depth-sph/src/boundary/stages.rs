//! Stages of a case for depth-integrated SPH.

use colluvium_case::Case;
use colluvium_case::description::{Stage, Wall};

use crate::points::image_nodes::PlanBoundaries;

/// Whether a stage only equilibrates stress.
pub(crate) fn is_equilibration_stage(stage: &Stage) -> bool {
    stage.equilibrium.is_some() || stage.damping > 0.0 || stage.gravity_ramp > 0.0
}

/// Side walls and periodic boundaries of a stage.
pub(crate) fn plan_boundaries<const D: usize>(case: &Case, stage: usize) -> PlanBoundaries<D> {
    let mut ends = PlanBoundaries::default();
    for (_, boundary) in case.active_boundaries(stage) {
        let axis = boundary.side.axis();
        if axis >= D || matches!(boundary.wall, Wall::Absorbing { .. }) {
            continue;
        }
        let position = boundary.wall_coordinate(&case.domain);
        let slot = &mut ends.walls[axis][usize::from(boundary.side.is_max())];
        // The innermost wall of a side applies.
        *slot = Some(match *slot {
            Some(other) if boundary.side.is_max() => other.min(position),
            Some(other) => other.max(position),
            None => position,
        });
    }
    for axis in 0..D {
        if case.domain.is_periodic(axis) {
            ends.periods[axis] = Some((case.domain.min[axis], case.domain.max[axis]));
        }
    }
    ends
}
