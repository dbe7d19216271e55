//! External actions on nodes and points: walls, obstacles, driven bodies, contact, loads, absorbing boundaries.

use colluvium_case::{BodyForce, MovingObstacle};
use colluvium_grid::NodeWalls;

use crate::background_grid::BackgroundGrid;
use crate::boundary::absorbing_boundary::AbsorbingBoundaries;
use crate::boundary::nodal_loads::NodalLoad;
use crate::contact::contact_law::{FieldContacts, RowContact};
use crate::contact::rigid_contact::ContactSet;
use crate::momentum::driven_object::DrivenObject;
use crate::obstacles::node_obstacles::NodeObstacles;
use crate::obstacles::reaction::ReactionRecorder;
use crate::obstacles::state::PenaltyObstacles;
use crate::points::bodies::Bodies;
use crate::points::vectors::power;

/// Boundary conditions and contacts of a run.
pub struct BoundaryConditions<const D: usize> {
    /// Walls at grid nodes.
    pub(crate) walls: NodeWalls,
    /// Whether the domain has a wall at the lower and the upper end of each axis.
    pub(crate) has_wall: [[bool; 2]; D],
    /// Obstacles on the nodes.
    pub(crate) node_obstacles: NodeObstacles<D>,
    /// Reactions of the obstacles that act on nodes; `None` if they are not recorded.
    pub(crate) reaction_recorder: Option<ReactionRecorder>,
    /// Obstacles that act on points; `None` if they act on nodes.
    pub(crate) penalty_obstacles: Option<Box<PenaltyObstacles<D>>>,
    /// Rigid bodies and patches of prescribed velocity.
    pub(crate) driven: Vec<DrivenObject>,
    /// Contacts between velocity fields.
    pub(crate) contacts: FieldContacts,
    /// Contact sums of each row of nodes for each pair of fields, as memory that a step reuses.
    pub(crate) row_contacts: Vec<RowContact>,
    /// Workspace for the contacts of free rigid bodies.
    pub(crate) rigid_contacts: ContactSet,
    /// Start times of the loads of the case (s); infinite before their stage.
    pub(crate) load_starts: Vec<f64>,
    /// Loads on nodes.
    pub(crate) nodal_loads: Vec<NodalLoad>,
    /// Absorbing boundaries with viscous dashpots.
    pub(crate) absorbing: AbsorbingBoundaries,
    /// Body force of the program; none unless it sets one.
    pub(crate) body_force: Option<BodyForce<D>>,
}

impl<const D: usize> BoundaryConditions<D> {
    /// Moving obstacles, in the order of the case.
    pub fn moving_obstacles(&self) -> impl Iterator<Item = &MovingObstacle<D>> {
        let on_points = self.penalty_obstacles.iter().flat_map(|all| all.moving_obstacles());
        on_points.chain(self.node_obstacles.moving_obstacles.iter())
    }

    /// Moving obstacles, in the order of the case, to be changed.
    pub fn moving_obstacles_mut(&mut self) -> impl Iterator<Item = &mut MovingObstacle<D>> {
        let on_points = self.penalty_obstacles.iter_mut().flat_map(|all| all.moving_obstacles_mut());
        on_points.chain(self.node_obstacles.moving_obstacles.iter_mut())
    }

    /// Sets the walls of a stage.
    pub fn set_walls(&mut self, background: &BackgroundGrid<D>, walls: NodeWalls) {
        let (nodes, ghosts) = (background.layout.nodes(), background.basis_1d.ghosts);
        let stands = |axis: usize, index: usize| walls.has_wall(axis, index);
        let sides = |axis: usize| [stands(axis, ghosts), stands(axis, nodes[axis] - 1 - ghosts)];
        self.has_wall = std::array::from_fn(sides);
        self.walls = walls;
    }
}

/// Work of loads and prescribed motions in the step (J).
pub(crate) fn work_of_loads<const D: usize>(bodies: &Bodies<D>, driven: &[DrivenObject], dt: f64) -> f64 {
    let mut work = 0.0;
    for set in &bodies.sets {
        work += dt * power(&set.points.traction, &set.points.velocity);
        work += dt * power(&set.points.body_force, &set.points.velocity);
    }
    for driven in driven {
        let free = driven.free_rigid_body.as_ref().map_or([false; 6], |free_body| free_body.free_components);
        let velocity: [f64; 3] = std::array::from_fn(|c| if free[c] { 0.0 } else { driven.velocity()[c] });
        work -= (0..3).map(|c| driven.state.force[c] * velocity[c] * dt).sum::<f64>();
    }
    work
}
