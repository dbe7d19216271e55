//! Obstacles on the nodes: those in the solid or on its surface have the velocity that it allows (sheet: snow-mpm §3.7).

use colluvium_case::description::{Obstacle, ObstacleWall};
use colluvium_case::{Standing, holding};
use colluvium_grid::{Face, Faces, WallKind};

use crate::background::Background;

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
