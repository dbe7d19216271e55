//! Obstacles on the nodes: those at rest, whose nodes are found once, and those that move.

use std::sync::Arc;

use colluvium_case::description::Obstacle;
use colluvium_case::{MovingObstacles, ObstacleLaw, PlacedObstacle, constraining_obstacles};
use colluvium_grid::{NodeFace, NodeFaces, NodeWalls};

use crate::background_grid::BackgroundGrid;
use crate::obstacles::reaction::ReactionRecorder;

/// Obstacles of a case that act on the nodes.
pub struct NodeObstacles<const D: usize> {
    /// Faces of the obstacles that do not move.
    pub static_faces: Arc<NodeFaces>,
    /// Moving obstacles.
    pub moving_obstacles: MovingObstacles<NodeFace, D>,
}

impl<const D: usize> NodeObstacles<D> {
    /// Obstacles of a case that act on nodes: the velocities of nodes in an obstacle or on its surface are constrained.
    pub fn new(
        placed: &[PlacedObstacle<'_, D>],
        background: &BackgroundGrid<D>,
        recorder: &ReactionRecorder,
    ) -> Self {
        let face = |obstacle: &Obstacle, law: &ObstacleLaw, normal| NodeFace {
            reaction_index: recorder.number(&obstacle.name),
            ..NodeFace::at_rest(normal, law.friction(), law.allows_separation())
        };
        let BackgroundGrid { grid, layout, basis_1d: axis, upper_corner, .. } = background;
        let acts = |obstacle: &Obstacle, law: &ObstacleLaw| face(obstacle, law, [0.0; 3]);
        let moving_obstacles = MovingObstacles::new(placed, (grid.origin, *upper_corner), acts);
        if moving_obstacles.iter().count() == placed.len() {
            return Self { static_faces: Arc::default(), moving_obstacles };
        }
        let rest = NodeFaces::from_positions(grid, layout, axis, |place, found| {
            let constraining = constraining_obstacles(placed, place, grid.cell);
            found.extend(constraining.map(|(obstacle, law, normal)| face(obstacle, &law, normal)));
        });
        Self { static_faces: Arc::new(rest), moving_obstacles }
    }

    /// Whether there are no obstacles.
    pub fn is_empty(&self) -> bool {
        self.static_faces.is_empty() && self.moving_obstacles.is_empty()
    }

    /// Finds the faces of the active nodes for a `step` of a length from a time (s).
    pub fn update_faces(&mut self, step: (f64, f64), background: &BackgroundGrid<D>, walls: &mut NodeWalls) {
        if self.moving_obstacles.is_empty() {
            return;
        }
        self.moving_obstacles.update_positions(step);
        let BackgroundGrid { grid, layout, basis_1d: axis, .. } = background;
        walls.faces_mut().rebuild(grid, layout, axis, &self.static_faces, |place, found| {
            let constraining = self.moving_obstacles.constraining(place, grid.cell);
            found.extend(constraining.map(|(face, normal, velocity)| NodeFace { normal, velocity, ..face }));
        });
    }
}
