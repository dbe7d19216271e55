//! Obstacles on nodes: nodes in the solid or on its surface have a velocity that it permits (sheet: snow-mpm §3.7).

use colluvium_case::description::Obstacle;
use colluvium_case::{
    Case, CaseError, MovingObstacle, MovingObstacles, ObstacleLaw, PlacedObstacle, TimeStep,
    constraining_obstacles, limit_step_by_obstacles,
};
use colluvium_grid::{NodeFace, NodeFaces};

use crate::background_grid::BackgroundGrid;

/// Largest number of obstacles whose reactions are recorded.
pub const MAX_RECORDED: usize = 8;

/// Obstacles of a case.
pub struct NodeObstacles<const D: usize> {
    /// Faces of the obstacles at rest.
    static_faces: NodeFaces,
    moving_obstacles: MovingObstacles<NodeFace, D>,
    /// Names of the obstacles whose reactions are recorded.
    recorded_obstacles: Vec<String>,
}

impl<const D: usize> NodeObstacles<D> {
    /// Obstacles of a case that constrain grid nodes.
    ///
    /// # Errors
    /// When the reactions of too many obstacles are measured.
    pub fn new(
        case: &Case,
        standing: &[PlacedObstacle<'_, D>],
        background: &BackgroundGrid<D>,
    ) -> Result<Self, CaseError> {
        let bearers = recorded_obstacles(case)?;
        let face = |obstacle: &Obstacle, law: &ObstacleLaw, normal| NodeFace {
            reaction_index: bearers.iter().position(|name| *name == obstacle.name).map(|number| number as u8),
            ..NodeFace::at_rest(normal, law.friction(), law.allows_separation())
        };
        let BackgroundGrid { grid, layout, basis_1d: axis, low, upper_corner, .. } = background;
        let acts = |obstacle: &Obstacle, law: &ObstacleLaw| face(obstacle, law, [0.0; 3]);
        let moving_obstacles = MovingObstacles::new(standing, (*low, *upper_corner), acts);
        let static_faces = if moving_obstacles.iter().count() == standing.len() {
            NodeFaces::default()
        } else {
            NodeFaces::from_positions(grid, layout, axis, |place, found| {
                let held = constraining_obstacles(standing, place, grid.cell);
                found.extend(held.map(|(obstacle, law, normal)| face(obstacle, &law, normal)));
            })
        };
        Ok(Self { static_faces, moving_obstacles, recorded_obstacles: bearers })
    }

    /// Faces of the obstacles that do not move.
    pub fn static_faces(&self) -> &NodeFaces {
        &self.static_faces
    }

    /// Names of the obstacles whose reactions are recorded.
    pub fn recorded_names(&self) -> &[String] {
        &self.recorded_obstacles
    }

    /// Whether any obstacle moves.
    pub fn are_moving(&self) -> bool {
        !self.moving_obstacles.is_empty()
    }

    /// Moving obstacles, in the order of the case.
    pub fn moving(&self) -> impl Iterator<Item = &MovingObstacle<D>> {
        self.moving_obstacles.iter()
    }

    /// Moving obstacles, in the order of the case, to be changed.
    pub fn moving_mut(&mut self) -> impl Iterator<Item = &mut MovingObstacle<D>> {
        self.moving_obstacles.iter_mut()
    }

    /// Critical step, reduced so that no obstacle moves by more than half a cell in the step from `time` on (s).
    pub fn limit_by_obstacle_motion(&self, critical: TimeStep, time: f64, cell: f64) -> TimeStep {
        limit_step_by_obstacles(critical, self.moving_obstacles.iter(), (time, 0.5 * cell, 1))
    }

    /// Finds the faces of the active nodes for a step with given start and length (s).
    pub fn update_faces(&mut self, step: (f64, f64), background: &BackgroundGrid<D>, faces: &mut NodeFaces) {
        self.moving_obstacles.update_positions(step);
        let BackgroundGrid { grid, layout, basis_1d: axis, .. } = background;
        faces.rebuild(grid, layout, axis, &self.static_faces, |place, found| {
            let held = self.moving_obstacles.constraining(place, grid.cell);
            found.extend(held.map(|(face, normal, velocity)| NodeFace { normal, velocity, ..face }));
        });
    }
}

/// Names of the obstacles whose reactions the case measures.
fn recorded_obstacles(case: &Case) -> Result<Vec<String>, CaseError> {
    let mut names: Vec<String> = Vec::new();
    for (measure, of) in
        case.measures.iter().filter_map(|(name, measure)| Some((name, measure.reaction_target()?)))
    {
        if names.iter().any(|name| name == of) {
            continue;
        }
        if names.len() == MAX_RECORDED {
            let problem = format!("snow-mpm records the reactions of {MAX_RECORDED} obstacles at most");
            return Err(CaseError::new(format!("measures.{measure}.target"), problem));
        }
        names.push(of.to_owned());
    }
    Ok(names)
}
