//! Obstacles, on the nodes or on the points (sheet: mpm §2.11; docs/theory/mpm.md, obstacles).

pub mod borne;
mod law;
pub mod rocks;

use colluvium_case::{Case, CaseError, Standing, holding};
use colluvium_grid::{Face, Faces};

use crate::background::Background;
use crate::obstacles::borne::Bearing;
use crate::{Formulation, Mass, MpmOptions, ObstacleContact, Transfer, WallFriction};

/// Refuses options that do not go with obstacles.
pub fn cleared(case: &Case, options: &MpmOptions) -> Result<(), CaseError> {
    let refuse = |key: &str, problem: &str| Err(CaseError::new(format!("methods.mpm.{key}"), problem));
    if options.obstacles == ObstacleContact::Points {
        if case.obstacles.is_empty() {
            return refuse("obstacles", "points needs an obstacle in the case");
        }
        if options.formulation != Formulation::UpdatedLagrangian {
            return refuse(
                "obstacles",
                "points needs points that move in space: formulation updated-lagrangian",
            );
        }
        return Ok(());
    }
    if case.obstacles.is_empty() {
        return Ok(());
    }
    for (name, measure) in &case.measures {
        if let Some(of) = measure.bearer()
            && case.obstacles.iter().any(|obstacle| obstacle.name == of)
            && let Some(what) = unaccounted(case, options)
        {
            let problem = format!(
                "with {what} mpm sums up the reaction of obstacles with `methods.mpm.obstacles` `points` only"
            );
            return Err(CaseError::new(format!("measures.{name}.of"), problem));
        }
    }
    if options.mesh.is_some() {
        return refuse("mesh", "nodes of a mesh are held by walls on its groups, not by obstacles");
    }
    if options.transfer == Transfer::Xpic {
        return refuse(
            "transfer",
            "xpic filters velocities axis by axis, and obstacles hold them along any direction",
        );
    }
    if options.wall_friction == WallFriction::Acceleration {
        return refuse("wall_friction", "acceleration is of walls: obstacles rub by impulses");
    }
    Ok(())
}

/// Why nobody adds up what obstacles on the nodes bear; none where it is done.
pub fn unaccounted(case: &Case, options: &MpmOptions) -> Option<&'static str> {
    if case.bodies.iter().any(|body| body.pore_fluid.is_some()) {
        Some("pore fluid")
    } else if options.mass == Mass::Consistent {
        Some("a consistent mass")
    } else if !options.contacts.is_empty() {
        Some("contacts")
    } else {
        None
    }
}

/// The faces of the nodes of a grid, whose nodes in an obstacle or on its surface have the velocity that it allows.
pub fn faces<const D: usize>(
    standing: &[Standing<'_, D>],
    background: &Background<D>,
    bearing: &Bearing,
) -> Faces {
    let Background { grid, layout, axis, .. } = background;
    if standing.is_empty() {
        return Faces::default();
    }
    Faces::in_space(grid, layout, axis, |place, found| {
        let held = holding(standing, place, grid.cell);
        found.extend(held.map(|(obstacle, normal)| Face {
            bearer: bearing.number(&obstacle.name),
            ..Face::at_rest(normal, obstacle.friction(), obstacle.lets_go())
        }));
    })
}
