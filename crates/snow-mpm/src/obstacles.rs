//! Obstacles on the nodes: those in the solid or on its surface have the velocity that it allows (sheet: snow-mpm §3.7).

use colluvium_case::description::{Obstacle, ObstacleWall};
use colluvium_case::{Standing, spatial};
use colluvium_grid::{Face, Faces, WallKind};

use crate::background::Background;

/// How deep points may lie in an obstacle at the start, and nodes above its surface that count as on it, over the cell.
pub const SLACK: f64 = 1e-9;

/// How deep under the surface nodes are held, over the cell: points do not get below that.
const DEPTH: f64 = 6.0;

/// The faces of the nodes of a grid.
pub fn faces<const D: usize>(standing: &[Standing<'_, D>], background: &Background<D>) -> Faces {
    let Background { grid, layout, axis, .. } = background;
    if standing.is_empty() {
        return Faces::default();
    }
    Faces::in_space(grid, layout, axis, |place, found| {
        for Standing { obstacle, surface, .. } in standing {
            let gap = surface.gap(place, DEPTH * grid.cell);
            if let Some(gap) = gap.filter(|gap| gap.distance <= SLACK * grid.cell) {
                found.push(face(obstacle, spatial(&gap.normal)));
            }
        }
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
