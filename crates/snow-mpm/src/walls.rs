//! Walls: half-spaces whose nodes they hold (sheet: snow-mpm §3.7), from the boundaries of a case.

use std::sync::Arc;

use colluvium_case::description::{Boundary, Wall as CaseWall};
use colluvium_case::{Case, spatial};
use colluvium_grid::{Faces, Wall, WallKind, Walls};

use crate::background::Background;

/// A half-space with its face normal to an axis.
struct Face {
    /// How it acts; its node is where the face stood last.
    wall: Wall,
    /// Coordinate of the face when the stage began (m).
    start: f64,
    /// Time at which it stood there (s).
    since: f64,
}

/// The walls of a stage.
#[derive(Default)]
pub struct Boundaries {
    faces: Vec<Face>,
    walls: Walls,
    nodes: Vec<usize>,
}

impl Boundaries {
    /// Those that stand in a stage, beside obstacles.
    pub fn new<const D: usize>(
        case: &Case,
        stage: usize,
        background: &Background<D>,
        obstacles: Arc<Faces>,
    ) -> Self {
        let face = |(_, boundary): (usize, &Boundary)| Face {
            wall: wall(boundary),
            start: boundary.position(&case.domain),
            // Walls move from the beginning of the run.
            since: 0.0,
        };
        let faces = case.active_boundaries(stage).into_iter().map(face).collect();
        let cells = &background.grid.cells;
        let nodes = cells.iter().map(|cells| background.axis.nodes(*cells)).collect();
        let mut boundaries = Self { faces, walls: Walls::default().with_faces(obstacles), nodes };
        boundaries.set(background);
        boundaries.place(0.0, background);
        boundaries
    }

    fn set<const D: usize>(&mut self, _background: &Background<D>) {
        let walls = Walls::new(&self.nodes, self.faces.iter().map(|face| face.wall).collect());
        self.walls = walls.with_faces(Arc::clone(self.walls.faces()));
    }

    /// Puts moving walls where they are at a time (s).
    pub fn place<const D: usize>(&mut self, time: f64, background: &Background<D>) {
        let mut changed = false;
        for face in &mut self.faces {
            let axis = face.wall.axis;
            let place = face.start + face.wall.velocity[axis] * (time - face.since);
            let below = background.node_below(axis, place);
            let node = match face.wall.upper {
                false => below,
                // The first node at or above the face.
                true if lies_at(background, axis, below, place) => below,
                true => (below + 1).min(self.nodes[axis] - 1),
            };
            changed |= node != face.wall.node;
            face.wall.node = node;
        }
        if changed {
            self.set(background);
        }
    }

    /// The obstacles on the nodes.
    pub fn obstacles(&self) -> Arc<Faces> {
        Arc::clone(self.walls.faces())
    }

    /// The same, to be changed.
    pub fn obstacles_mut(&mut self) -> &mut Faces {
        self.walls.faces_mut()
    }

    /// The walls, where they are.
    pub fn walls(&self) -> &Walls {
        &self.walls
    }

    /// Whether a wall stands across the side of the domain, upper or lower, of an axis, so that a point beyond is held.
    pub fn closes(&self, axis: usize, upper: bool) -> bool {
        self.faces.iter().any(|face| face.wall.axis == axis && face.wall.upper == upper)
    }
}

/// Whether a node along `axis` lies at a place (m), but for round-off.
fn lies_at<const D: usize>(background: &Background<D>, axis: usize, node: usize, place: f64) -> bool {
    let local = (place - background.grid.origin[axis]) / background.grid.cell;
    (background.axis.coordinate(node, background.grid.cells[axis]) - local).abs() < 1e-6
}

/// How the wall of a boundary acts.
fn wall(boundary: &Boundary) -> Wall {
    let kind = match boundary.wall {
        CaseWall::Rough => WallKind::Rough,
        CaseWall::Smooth | CaseWall::Absorbing { .. } => WallKind::Smooth,
        CaseWall::Frictional { friction_coefficient: coefficient, .. } => {
            WallKind::Frictional { coefficient }
        }
    };
    Wall {
        axis: boundary.side.axis(),
        upper: boundary.side.is_max(),
        node: 0,
        kind,
        separation: boundary.separation || boundary.wall.lets_go(),
        velocity: boundary.velocity.as_deref().map_or([0.0; 3], spatial),
    }
}
