//! Obstacles on the nodes: those in the solid or on its surface have the velocity that it allows (sheet: snow-mpm §3.7).

use colluvium_case::description::Obstacle;
use colluvium_case::{
    Case, CaseError, ObstacleLaw, ObstaclesOnTheirWay, Standing, TimeStep, holding, slowed_for_obstacles,
};
use colluvium_grid::{Face, Faces};

use crate::background::Background;

/// Obstacles whose reactions are added up, at most.
pub const BEARERS: usize = 8;

/// The obstacles of a case.
pub struct Obstacles<const D: usize> {
    /// Faces of those at rest.
    rest: Faces,
    moving: ObstaclesOnTheirWay<Face, D>,
    /// Names of those whose reaction is measured.
    bearers: Vec<String>,
}

impl<const D: usize> Obstacles<D> {
    /// The obstacles of `case` on the nodes of a grid.
    ///
    /// # Errors
    /// Where the reactions of too many are measured.
    pub fn new(
        case: &Case,
        standing: &[Standing<'_, D>],
        background: &Background<D>,
    ) -> Result<Self, CaseError> {
        let bearers = bearers(case)?;
        let face = |obstacle: &Obstacle, law: &ObstacleLaw, normal| Face {
            bearer: bearers.iter().position(|name| *name == obstacle.name).map(|number| number as u8),
            ..Face::at_rest(normal, law.friction(), law.lets_go())
        };
        let Background { grid, layout, axis, low, high, .. } = background;
        let acts = |obstacle: &Obstacle, law: &ObstacleLaw| face(obstacle, law, [0.0; 3]);
        let moving = ObstaclesOnTheirWay::new(standing, (*low, *high), acts);
        let rest = if moving.iter().count() == standing.len() {
            Faces::default()
        } else {
            Faces::in_space(grid, layout, axis, |place, found| {
                let held = holding(standing, place, grid.cell);
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
        slowed_for_obstacles(critical, self.moving.iter(), (time, 0.5 * cell, 1))
    }

    /// Finds the faces of the active nodes for a step of so long from a time (s).
    pub fn place(&mut self, step: (f64, f64), background: &Background<D>, faces: &mut Faces) {
        self.moving.place(step);
        let Background { grid, layout, axis, .. } = background;
        faces.find_anew(grid, layout, axis, &self.rest, |place, found| {
            let held = self.moving.holding(place, grid.cell);
            found.extend(held.map(|(face, normal, velocity)| Face { normal, velocity, ..face }));
        });
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
