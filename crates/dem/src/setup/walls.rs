//! Walls and obstacles of a stage.

use std::sync::Arc;

use colluvium_case::description::Boundary;
use colluvium_case::{Case, MovingObstacle, ObstacleLaws, spatial};
use colluvium_points::Surface;

use crate::boundary::walls::RigidWall;
use crate::contact::PairLaw;
use crate::contact::contact_laws::StageLaws;

/// Contact laws of the regions of obstacle `number`, which follow those of all walls and obstacles.
fn laws_of_regions(case: &Case, laws: &StageLaws, number: usize) -> Vec<Vec<PairLaw>> {
    let before: usize = case.obstacles[..number].iter().map(|obstacle| obstacle.regions.len()).sum();
    let first = case.boundaries.len() + case.obstacles.len() + before;
    laws.walls[first..first + case.obstacles[number].regions.len()].to_vec()
}

/// Walls present in a stage, obstacles after the boundaries of the case.
pub(super) fn stage_walls<const D: usize>(
    case: &Case,
    laws: &StageLaws,
    obstacles: &[(Arc<dyn Surface<D>>, ObstacleLaws)],
    stage: usize,
) -> Vec<RigidWall<D>> {
    let corner = |values: &[f64]| std::array::from_fn(|axis| values[axis]);
    let domain: ([f64; D], [f64; D]) = (corner(&case.domain.min), corner(&case.domain.max));
    let wall = |(number, boundary): (usize, &Boundary)| RigidWall {
        surface: None,
        motion: None,
        boundary: number,
        name: boundary.name().to_owned(),
        axis: boundary.side.axis(),
        is_upper: boundary.side.is_max(),
        position: boundary.wall_coordinate(&case.domain),
        velocity: boundary.velocity.as_ref().map_or([0.0; D], |v| {
            let v = spatial(v);
            std::array::from_fn(|c| v[c])
        }),
        program_velocity: None,
        laws: laws.walls[number].clone(),
        obstacle_laws: None,
        regions: Vec::new(),
        reaction: [[0.0; D]; 2],
        moment: [0.0; 3],
    };
    let obstacle = |(number, (surface, of_obstacle)): (usize, &(Arc<dyn Surface<D>>, ObstacleLaws))| {
        let described = &case.obstacles[number];
        let motion = described.motion.as_ref();
        RigidWall {
            surface: Some(Arc::clone(surface)),
            obstacle_laws: (!of_obstacle.is_uniform()).then(|| of_obstacle.clone()),
            regions: laws_of_regions(case, laws, number),
            motion: motion.map(|motion| MovingObstacle::new(motion, surface, domain)),
            boundary: case.boundaries.len() + number,
            name: described.name.clone(),
            axis: 0,
            is_upper: false,
            position: 0.0,
            velocity: [0.0; D],
            program_velocity: None,
            laws: laws.walls[case.boundaries.len() + number].clone(),
            reaction: [[0.0; D]; 2],
            moment: [0.0; 3],
        }
    };
    let obstacles = obstacles.iter().enumerate().map(obstacle);
    case.active_boundaries(stage).into_iter().map(wall).chain(obstacles).collect()
}
