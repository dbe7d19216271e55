//! Obstacles on the nodes: those in the solid or on its surface have the velocity that it allows (sheet: mpm §2.11).

use colluvium_case::description::{Measure, Obstacle, ObstacleWall};
use colluvium_case::{Case, CaseError, Standing, holding};
use colluvium_grid::{Face, Faces, WallKind};

use crate::background::Background;
use crate::{MpmOptions, Transfer, WallFriction};

/// Refuses options that do not go with obstacles.
pub fn cleared(case: &Case, options: &MpmOptions) -> Result<(), CaseError> {
    if case.obstacles.is_empty() {
        return Ok(());
    }
    for (name, measure) in &case.measures {
        if let Measure::Reaction { of } = measure
            && case.obstacles.iter().any(|obstacle| obstacle.name == *of)
        {
            let problem = "mpm does not sum up the reaction of an obstacle";
            return Err(CaseError::new(format!("measures.{name}.of"), problem));
        }
    }
    let refuse = |key: &str, problem: &str| Err(CaseError::new(format!("methods.mpm.{key}"), problem));
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

/// The faces of the nodes of a grid.
pub fn faces<const D: usize>(standing: &[Standing<'_, D>], background: &Background<D>) -> Faces {
    let Background { grid, layout, axis, .. } = background;
    if standing.is_empty() {
        return Faces::default();
    }
    Faces::in_space(grid, layout, axis, |place, found| {
        found.extend(holding(standing, place, grid.cell).map(|(obstacle, normal)| face(obstacle, normal)));
    })
}

fn face(obstacle: &Obstacle, normal: [f64; 3]) -> Face {
    let kind = match obstacle.wall {
        ObstacleWall::Rough => WallKind::Rough,
        ObstacleWall::Smooth => WallKind::Smooth,
        ObstacleWall::Frictional { friction_coefficient: coefficient, .. } => {
            WallKind::Frictional { coefficient }
        }
    };
    Face { normal, kind, separation: obstacle.lets_go() }
}
