//! Obstacles on the nodes: those at rest, whose nodes are found once, and those on their way.

use std::sync::Arc;

use colluvium_case::description::Obstacle;
use colluvium_case::{ObstacleLaw, ObstaclesOnTheirWay, Standing, holding};
use colluvium_grid::{Face, Faces, Walls};

use super::borne::Bearing;
use crate::background::Background;

/// The obstacles of a case that act on the nodes.
pub struct Held<const D: usize> {
    /// Faces of those at rest.
    pub rest: Arc<Faces>,
    /// Those on their way.
    pub moving: ObstaclesOnTheirWay<Face, D>,
}

impl<const D: usize> Held<D> {
    /// Those of a case: nodes in an obstacle or on its surface have the velocity that it allows.
    pub fn new(standing: &[Standing<'_, D>], background: &Background<D>, bearing: &Bearing) -> Self {
        let face = |obstacle: &Obstacle, law: &ObstacleLaw, normal| Face {
            bearer: bearing.number(&obstacle.name),
            ..Face::at_rest(normal, law.friction(), law.lets_go())
        };
        let Background { grid, layout, axis, upper, .. } = background;
        let acts = |obstacle: &Obstacle, law: &ObstacleLaw| face(obstacle, law, [0.0; 3]);
        let moving = ObstaclesOnTheirWay::new(standing, (grid.origin, *upper), acts);
        if moving.iter().count() == standing.len() {
            return Self { rest: Arc::default(), moving };
        }
        let rest = Faces::in_space(grid, layout, axis, |place, found| {
            let held = holding(standing, place, grid.cell);
            found.extend(held.map(|(obstacle, law, normal)| face(obstacle, &law, normal)));
        });
        Self { rest: Arc::new(rest), moving }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.rest.is_empty() && self.moving.is_empty()
    }

    /// Finds the faces of the active nodes for a step of so long from a time (s).
    pub fn place(&mut self, step: (f64, f64), background: &Background<D>, walls: &mut Walls) {
        if self.moving.is_empty() {
            return;
        }
        self.moving.place(step);
        let Background { grid, layout, axis, .. } = background;
        walls.faces_mut().find_anew(grid, layout, axis, &self.rest, |place, found| {
            let held = self.moving.holding(place, grid.cell);
            found.extend(held.map(|(face, normal, velocity)| Face { normal, velocity, ..face }));
        });
    }
}
