//! Walls from the boundaries of a case: half-spaces that constrain their nodes (sheet: snow-mpm §3.7).

use std::sync::Arc;

use colluvium_case::description::{Boundary, Wall as CaseWall};
use colluvium_case::{Case, spatial};
use colluvium_grid::{NodeFaces, NodeWall, NodeWalls, WallKind};

use crate::background_grid::BackgroundGrid;

/// Half-space with its face normal to an axis.
struct WallHalfSpace {
    /// Wall condition; its node is at the last position of the face.
    wall: NodeWall,
    /// Coordinate of the face at the time `motion_start` (m).
    start: f64,
    /// Time from which the face moves (s).
    motion_start: f64,
}

/// Walls of a stage.
#[derive(Default)]
pub struct BoundaryConditions {
    faces: Vec<WallHalfSpace>,
    walls: NodeWalls,
    nodes: Vec<usize>,
}

impl BoundaryConditions {
    /// Returns the walls of a stage, with the faces of obstacles.
    pub fn new<const D: usize>(
        case: &Case,
        stage: usize,
        background: &BackgroundGrid<D>,
        obstacles: Arc<NodeFaces>,
    ) -> Self {
        let face = |(_, boundary): (usize, &Boundary)| WallHalfSpace {
            wall: node_wall(boundary),
            start: boundary.wall_coordinate(&case.domain),
            // Walls move from the beginning of the run.
            motion_start: 0.0,
        };
        let faces = case.active_boundaries(stage).into_iter().map(face).collect();
        let cells = &background.grid.cells;
        let nodes = cells.iter().map(|cells| background.basis_1d.nodes(*cells)).collect();
        let mut boundaries = Self { faces, walls: NodeWalls::default().with_faces(obstacles), nodes };
        boundaries.set(background);
        boundaries.move_to(0.0, background);
        boundaries
    }

    /// Sets the walls of the nodes from the faces of the domain.
    fn set<const D: usize>(&mut self, _background: &BackgroundGrid<D>) {
        let walls = NodeWalls::new(&self.nodes, self.faces.iter().map(|face| face.wall).collect());
        self.walls = walls.with_faces(Arc::clone(self.walls.faces()));
    }

    /// Moves the walls to their positions at a time (s).
    pub fn move_to<const D: usize>(&mut self, time: f64, background: &BackgroundGrid<D>) {
        let mut changed = false;
        for face in &mut self.faces {
            let axis = face.wall.axis;
            let place = face.start + face.wall.velocity[axis] * (time - face.motion_start);
            let below = background.node_below(axis, place);
            let node = match face.wall.is_upper {
                false => below,
                // The first node at or above the face.
                true if is_node_at(background, axis, below, place) => below,
                true => (below + 1).min(self.nodes[axis] - 1),
            };
            changed |= node != face.wall.node;
            face.wall.node = node;
        }
        if changed {
            self.set(background);
        }
    }

    /// Faces of the obstacles on the nodes.
    pub fn obstacles(&self) -> Arc<NodeFaces> {
        Arc::clone(self.walls.faces())
    }

    /// Mutable faces of the obstacles on the nodes.
    pub fn obstacles_mut(&mut self) -> &mut NodeFaces {
        self.walls.faces_mut()
    }

    /// Walls, at their current positions.
    pub fn walls(&self) -> &NodeWalls {
        &self.walls
    }

    /// Whether a wall bounds the upper or lower end of the domain along an axis, which returns points that are outside it.
    pub fn has_wall(&self, axis: usize, upper: bool) -> bool {
        self.faces.iter().any(|face| face.wall.axis == axis && face.wall.is_upper == upper)
    }
}

/// Whether a node along `axis` is at a coordinate (m), with a tolerance for round-off.
fn is_node_at<const D: usize>(background: &BackgroundGrid<D>, axis: usize, node: usize, place: f64) -> bool {
    let local = (place - background.grid.origin[axis]) / background.grid.cell;
    (background.basis_1d.coordinate(node, background.grid.cells[axis]) - local).abs() < 1e-6
}

/// Wall condition of a boundary.
fn node_wall(boundary: &Boundary) -> NodeWall {
    let kind = match boundary.wall {
        CaseWall::Rough => WallKind::Rough,
        CaseWall::Smooth | CaseWall::Absorbing { .. } => WallKind::Smooth,
        CaseWall::Frictional { friction_coefficient: coefficient, .. } => {
            WallKind::Frictional { coefficient }
        }
    };
    NodeWall {
        axis: boundary.side.axis(),
        is_upper: boundary.side.is_max(),
        node: 0,
        kind,
        separation: boundary.separation || boundary.wall.allows_separation(),
        velocity: boundary.velocity.as_deref().map_or([0.0; 3], spatial),
    }
}
