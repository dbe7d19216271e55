//! Obstacles on the nodes: those at rest, whose nodes are found once, and those on their way.

use std::slice::from_ref;
use std::sync::Arc;

use colluvium_case::{MovingObstacle, ObstacleLaw, Standing, holding};
use colluvium_grid::{Face, Faces, Walls};
use colluvium_points::surface::Frame;

use super::borne::Bearing;
use crate::background::Background;

/// The obstacles of a case that act on the nodes.
#[derive(Default)]
pub struct Held<const D: usize> {
    /// Faces of those at rest.
    pub rest: Arc<Faces>,
    moving: Vec<Moving<D>>,
}

/// An obstacle on its way.
struct Moving<const D: usize> {
    /// How it acts.
    face: Face,
    /// Where it is at the start of a step.
    own: MovingObstacle<D>,
    /// Where it is at the end.
    next: Frame<D>,
}

impl<const D: usize> Held<D> {
    /// Those of a case: nodes in an obstacle or on its surface have the velocity that it allows.
    pub fn new(standing: &[Standing<'_, D>], background: &Background<D>, bearing: &Bearing) -> Self {
        let face = |name: &str, law: &ObstacleLaw, normal| Face {
            bearer: bearing.number(name),
            ..Face::at_rest(normal, law.friction(), law.lets_go())
        };
        let domain = (background.grid.origin, background.upper);
        let moving = standing.iter().filter_map(|Standing { obstacle, surface, laws, .. }| {
            let motion = obstacle.motion.as_ref()?;
            Some(Moving {
                face: face(&obstacle.name, laws.at(&[0.0; D]), [0.0; 3]),
                own: MovingObstacle::new(motion, surface, domain),
                next: motion.frame(0.0),
            })
        });
        let moving: Vec<_> = moving.collect();
        if moving.len() == standing.len() {
            return Self { rest: Arc::default(), moving };
        }
        let Background { grid, layout, axis, .. } = background;
        let rest = Faces::in_space(grid, layout, axis, |place, found| {
            let resting = standing.iter().filter(|own| own.obstacle.motion.is_none());
            let held = resting.flat_map(|own| holding(from_ref(own), place, grid.cell));
            found.extend(held.map(|(obstacle, law, normal)| face(&obstacle.name, &law, normal)));
        });
        Self { rest: Arc::new(rest), moving }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.rest.is_empty() && self.moving.is_empty()
    }

    /// Those on their way.
    pub fn moving(&self) -> impl Iterator<Item = &MovingObstacle<D>> {
        self.moving.iter().map(|moving| &moving.own)
    }

    /// Finds the faces of the active nodes for a step of `dt` (s) from `time` (s): where obstacles are at its start, with the velocity
    /// that takes them to where they are at its end.
    pub fn place(&mut self, (time, dt): (f64, f64), background: &Background<D>, walls: &mut Walls) {
        if self.moving.is_empty() {
            return;
        }
        for moving in &mut self.moving {
            moving.own.go_to(time);
            moving.next = moving.own.motion.frame(time + dt);
        }
        let Background { grid, layout, axis, .. } = background;
        walls.faces_mut().find_anew(grid, layout, axis, &self.rest, |place, found| {
            let at = |Moving { face, own, next }: &Moving<D>| {
                let (normal, velocity) = own.holding(place, grid.cell, (next, dt))?;
                Some(Face { normal, velocity, ..*face })
            };
            found.extend(self.moving.iter().filter_map(at));
        });
    }
}
