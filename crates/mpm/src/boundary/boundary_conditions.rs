//! What acts on nodes and points from outside: walls, obstacles, driven bodies, other bodies, loads, absorbing faces.

use colluvium_grid::NodeWalls;

use crate::boundary::absorbing_boundary::{AbsorbingBoundaries, Impedance};
use crate::boundary::nodal_loads::NodalLoad;
use crate::boundary::prescribed_motion::DrivenObject;
use crate::contact::contact_law::{FieldContacts, RowContact};
use crate::contact::rigid_contact::ContactSet;
use crate::obstacles::node_obstacles::NodeObstacles;
use crate::obstacles::reaction::ReactionRecorder;
use crate::obstacles::state::PenaltyObstacles;
use crate::transfer::background_grid::BackgroundGrid;

/// All that acts from outside, and what bodies do to each other.
pub struct BoundaryConditions<const D: usize> {
    pub(crate) walls: NodeWalls,
    /// Whether a wall stands on the lower and on the upper side of the domain, per axis.
    pub(crate) has_wall: [[bool; 2]; D],
    /// Obstacles on the nodes.
    pub(crate) node_obstacles: NodeObstacles<D>,
    /// What they bear; `None` where nobody adds that up.
    pub(crate) reaction_recorder: Option<ReactionRecorder>,
    /// Obstacles on the points; `None` where they are on the nodes.
    pub(crate) penalty_obstacles: Option<Box<PenaltyObstacles<D>>>,
    /// Rigid bodies and patches of prescribed velocity.
    pub(crate) driven: Vec<DrivenObject>,
    pub(crate) contacts: FieldContacts,
    /// Room for what the rows of nodes report of contacts, pair after pair.
    pub(crate) row_contacts: Vec<RowContact>,
    /// Room for what rigid bodies that move freely touch.
    pub(crate) rigid_contacts: ContactSet,
    /// When the loads of the case begin (s); infinite as long as their stage has not.
    pub(crate) load_starts: Vec<f64>,
    /// Loads on nodes.
    pub(crate) nodal_loads: Vec<NodalLoad>,
    pub(crate) absorbing: AbsorbingBoundaries,
    /// Of the bodies of the case; empty without absorbing boundaries.
    pub(crate) impedances: Vec<Impedance>,
}

impl<const D: usize> BoundaryConditions<D> {
    /// Takes the walls of a stage.
    pub fn set_walls(&mut self, background: &BackgroundGrid<D>, walls: NodeWalls) {
        let (nodes, ghosts) = (background.layout.nodes(), background.basis_1d.ghosts);
        let stands = |axis: usize, index: usize| walls.has_wall(axis, index);
        let sides = |axis: usize| [stands(axis, ghosts), stands(axis, nodes[axis] - 1 - ghosts)];
        self.has_wall = std::array::from_fn(sides);
        self.walls = walls;
    }
}
