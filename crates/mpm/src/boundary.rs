//! What acts on nodes and points from outside: walls, obstacles, driven bodies, other bodies, loads, absorbing faces.

use colluvium_grid::Walls;

use crate::absorbing::{Absorbing, Impedance};
use crate::background::Background;
use crate::contact::{Contacts, RowTouch};
use crate::driven::Driven;
use crate::meet::Grips;
use crate::nodal::NodalLoad;
use crate::obstacles::borne::Bearing;
use crate::obstacles::nodes::Held;
use crate::obstacles::rocks::Rocks;

/// All that acts from outside, and what bodies do to each other.
pub struct Boundary<const D: usize> {
    pub(crate) walls: Walls,
    /// Whether a wall stands on the lower and on the upper side of the domain, per axis.
    pub(crate) closed: [[bool; 2]; D],
    /// Obstacles on the nodes.
    pub(crate) held: Held<D>,
    /// What they bear; `None` where nobody adds that up.
    pub(crate) bearing: Option<Bearing>,
    /// Obstacles on the points; `None` where they are on the nodes.
    pub(crate) rocks: Option<Box<Rocks<D>>>,
    /// Rigid bodies and patches of prescribed velocity.
    pub(crate) driven: Vec<Driven>,
    pub(crate) contacts: Contacts,
    /// Room for what the rows of nodes report of contacts, pair after pair.
    pub(crate) touched: Vec<RowTouch>,
    /// Room for what rigid bodies that move freely touch.
    pub(crate) grips: Grips,
    /// When the loads of the case begin (s); infinite as long as their stage has not.
    pub(crate) load_starts: Vec<f64>,
    /// Loads on nodes.
    pub(crate) nodal: Vec<NodalLoad>,
    pub(crate) absorbing: Absorbing,
    /// Of the bodies of the case; empty without absorbing boundaries.
    pub(crate) impedances: Vec<Impedance>,
}

impl<const D: usize> Boundary<D> {
    /// Takes the walls of a stage.
    pub fn set_walls(&mut self, background: &Background<D>, walls: Walls) {
        let (nodes, ghosts) = (background.layout.nodes(), background.axis.ghosts);
        let stands = |axis: usize, index: usize| walls.has_wall(axis, index);
        let sides = |axis: usize| [stands(axis, ghosts), stands(axis, nodes[axis] - 1 - ghosts)];
        self.closed = std::array::from_fn(sides);
        self.walls = walls;
    }
}
