//! Rebuild of the lists of neighbours.

use colluvium_case::{FailureReason, SolverError};

use crate::boundary::boundary_conditions::BoundaryConditions;
use crate::boundary::controlled_cell::ControlledCell;
use crate::boundary::periodic_cell::{PeriodicCell, apply, inverse};
use crate::clock::Clock;
use crate::contact::contact_laws::ContactLaws;
use crate::neighbours::grain_neighbours::{GrainNeighbours, SinceListBuild};
use crate::neighbours::{ListError, ListReach};
use crate::points::grain_extremes::GrainExtremes;
use crate::points::grains::Grains;
use crate::points::vector::{difference, dot};

/// Sorts the grains, and builds the pair lists and the list of grains near walls. The work on grains that cross a periodic boundary is added to
/// `boundary_work` (J).
pub fn build_lists<const D: usize, const R: usize>(
    clock: &Clock,
    laws: &ContactLaws,
    cell: &mut ControlledCell<D>,
    (grains, extremes): (&mut Grains<D, R>, &mut GrainExtremes),
    boundary: &mut BoundaryConditions<D>,
    neighbours: &mut GrainNeighbours<D, R>,
    boundary_work: &mut f64,
) -> Result<(), SolverError> {
    let columns = laws.columns;
    cell.geometry.reduce();
    wrap(clock, &cell.geometry, grains, boundary_work)?;
    extremes.radii = grains.radii();
    let gap = neighbours.gap(laws);
    let reach = ListReach { gap, radius: extremes.radii.1 };
    neighbours.walls.store_histories(&grains.id, columns);
    boundary.membranes.clear();
    let built = neighbours.pairs.build(grains, &cell.geometry, reach, columns);
    built.map_err(|error| list_error(clock, &error))?;
    let slabs = &neighbours.pairs.slabs;
    neighbours.walls.build(grains.view(), &grains.id, &boundary.walls, gap, slabs, columns);
    neighbours.find_facets(laws, grains, &boundary.walls);
    boundary.membranes.find_grains(clock, grains);
    neighbours.since_build =
        SinceListBuild { cell: Some(cell.geometry.h), grain_travel: 0.0, wall_travel: 0.0 };
    Ok(())
}

/// Moves grains into the periodic cell; an error if a grain has left the domain along another axis.
fn wrap<const D: usize, const R: usize>(
    clock: &Clock,
    cell: &PeriodicCell<D>,
    grains: &mut Grains<D, R>,
    boundary_work: &mut f64,
) -> Result<(), SolverError> {
    let (unit, _) = inverse(&cell.h);
    for i in 0..grains.len() {
        let s = cell.reduced(&unit, &grains.position[i]);
        let mut steps = [0; D];
        for axis in 0..D {
            let step = s[axis].floor();
            if step == 0.0 {
                continue;
            }
            if !cell.periodic[axis] {
                if !grains.is_held[i] && !(-1e-9..=1.0 + 1e-9).contains(&s[axis]) {
                    let reason = "has left the domain: enlarge it, or add a wall there".to_owned();
                    return Err(clock.grain_error(grains, i, FailureReason::LeftDomain(reason)));
                }
                continue;
            }
            steps[axis] = step as i32;
        }
        if steps == [0; D] {
            continue;
        }
        let shift = cell.shift(&steps);
        let jump = apply(&cell.velocity_gradient, &shift);
        let before = dot(&grains.velocity[i], &grains.velocity[i]);
        grains.position[i] = difference(&grains.position[i], &shift);
        grains.origin[i] = difference(&grains.origin[i], &shift);
        grains.velocity[i] = difference(&grains.velocity[i], &jump);
        if !grains.is_held[i] {
            let after = dot(&grains.velocity[i], &grains.velocity[i]);
            *boundary_work += 0.5 * grains.mass[i] * (after - before);
        }
    }
    Ok(())
}

/// Error of the solver for a failed build of the neighbour lists.
fn list_error(clock: &Clock, error: &ListError) -> SolverError {
    let reason = match error {
        ListError::Search(error) => FailureReason::coded(error.code(), error.to_string()),
        ListError::Narrow(axis, width, reach) => FailureReason::coded(
            "cell-too-narrow",
            format!(
                "the periodic cell is {width:.4e} m wide along {}, less than twice the range of a grain, {reach:.4e} m: a pair of grains would have two contacts",
                ["x", "y", "z"][*axis]
            ),
        ),
        ListError::Stretched(grain) => FailureReason::coded(
            "cell-too-narrow",
            format!(
                "a bond of grain {grain} is longer than the skin: give the bond a tensile_strength at which it breaks earlier"
            ),
        ),
    };
    SolverError::Step { step: clock.step, time: clock.time, reason }
}
