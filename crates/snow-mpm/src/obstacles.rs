//! Obstacles on the nodes: those in the solid or on its surface have the velocity that it allows (sheet: snow-mpm §3.7).

use colluvium_case::description::Obstacle;
use colluvium_case::{
    Case, CaseError, MovingObstacle, ObstacleLaw, Standing, TimeStep, holding, slowed_for_obstacles,
};
use colluvium_grid::{Face, Faces};
use colluvium_points::surface::Frame;

use crate::background::Background;

/// Obstacles whose reactions are added up, at most.
pub const BEARERS: usize = 8;

/// The obstacles of a case.
pub struct Obstacles<const D: usize> {
    /// Faces of those at rest.
    rest: Faces,
    moving: Vec<Moving<D>>,
    /// Names of those whose reaction is measured.
    bearers: Vec<String>,
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

impl<const D: usize> Obstacles<D> {
    /// The obstacles of `case` on the nodes of a grid.
    ///
    /// # Errors
    /// Where the reactions of too many are measured.
    pub fn new(
        case: &Case,
        standing: Vec<Standing<'_, D>>,
        background: &Background<D>,
    ) -> Result<Self, CaseError> {
        let bearers = bearers(case)?;
        let face = |obstacle: &Obstacle, law: &ObstacleLaw, normal| Face {
            bearer: bearers.iter().position(|name| *name == obstacle.name).map(|number| number as u8),
            ..Face::at_rest(normal, law.friction(), law.lets_go())
        };
        let (mut resting, mut moving) = (Vec::new(), Vec::new());
        for standing in standing {
            let obstacle = standing.obstacle;
            match &obstacle.motion {
                None => resting.push(standing),
                Some(motion) => moving.push(Moving {
                    face: face(obstacle, standing.laws.at(&[0.0; D]), [0.0; 3]),
                    own: MovingObstacle::new(motion, &standing.surface, (background.low, background.high)),
                    next: motion.frame(0.0),
                }),
            }
        }
        let Background { grid, layout, axis, .. } = background;
        let rest = if resting.is_empty() {
            Faces::default()
        } else {
            Faces::in_space(grid, layout, axis, |place, found| {
                let held = holding(&resting, place, grid.cell);
                found.extend(held.map(|(obstacle, law, normal)| face(obstacle, &law, normal)));
            })
        };
        Ok(Self { rest, moving, bearers })
    }

    /// Faces of the obstacles at rest.
    pub fn rest(&self) -> &Faces {
        &self.rest
    }

    /// Names of those whose reaction is measured.
    pub fn bearers(&self) -> &[String] {
        &self.bearers
    }

    /// Whether any is on its way.
    pub fn are_moving(&self) -> bool {
        !self.moving.is_empty()
    }

    /// The step from `time` (s) in which none goes farther than half a `cell` (m), where that is shorter than the `critical` one.
    pub fn slowed(&self, critical: TimeStep, time: f64, cell: f64) -> TimeStep {
        slowed_for_obstacles(critical, self.moving.iter().map(|moving| &moving.own), (time, 0.5 * cell, 1))
    }

    /// Finds the faces of the active nodes for a step of `dt` (s) from `time` (s): where obstacles are at its start, with
    /// the velocity that takes them to where they are at its end.
    pub fn place(&mut self, (time, dt): (f64, f64), background: &Background<D>, faces: &mut Faces) {
        for moving in &mut self.moving {
            moving.own.go_to(time);
            moving.next = moving.own.motion.frame(time + dt);
        }
        let Background { grid, layout, axis, .. } = background;
        faces.find_anew(grid, layout, axis, &self.rest, |place, found| {
            found.extend(self.moving.iter().filter_map(|moving| moving.at(place, grid.cell, dt)));
        });
    }
}

impl<const D: usize> Moving<D> {
    /// How it acts on a node at `place` (m), if it does.
    fn at(&self, place: &[f64; D], cell: f64, dt: f64) -> Option<Face> {
        let (normal, velocity) = self.own.holding(place, cell, (&self.next, dt))?;
        Some(Face { normal, velocity, ..self.face })
    }
}

/// Names of the obstacles whose reactions the case measures.
fn bearers(case: &Case) -> Result<Vec<String>, CaseError> {
    let mut names: Vec<String> = Vec::new();
    for (measure, of) in case.measures.iter().filter_map(|(name, measure)| Some((name, measure.bearer()?))) {
        if names.iter().any(|name| name == of) {
            continue;
        }
        if names.len() == BEARERS {
            let problem = format!("snow-mpm adds up the reactions of {BEARERS} obstacles at most");
            return Err(CaseError::new(format!("measures.{measure}.of"), problem));
        }
        names.push(of.to_owned());
    }
    Ok(names)
}
