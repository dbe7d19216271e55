//! Walls on the nodes, from the boundaries of a case (MPM sheet §2.11).

use colluvium_case::description::{Boundary, Space, Wall as CaseWall};
use colluvium_case::{Case, CaseError, spatial};
use colluvium_grid::{Basis, Layout, Wall, WallKind, Walls};

use crate::points::Ground;
use crate::{MpmOptions, WallFriction, mesh};

/// The walls of a stage.
pub fn walls<const D: usize, const S: usize, B: Basis<S>>(
    case: &Case,
    stage: usize,
    ground: &Ground<'_, D>,
    layout: &Layout<D>,
    options: &MpmOptions,
) -> Result<Walls, CaseError> {
    if !ground.mesh.is_empty() {
        return mesh::walls(case, stage, ground.mesh, layout, options);
    }
    let grid = ground.grid;
    let nodes: Vec<usize> = grid.cells.iter().map(|cells| B::nodes(*cells)).collect();
    let mut walls = Vec::new();
    if case.space == Space::Axisymmetric && grid.origin[0] == 0.0 {
        let kind = WallKind::Smooth;
        walls.push(Wall {
            axis: 0,
            upper: false,
            node: B::GHOSTS,
            kind,
            separation: false,
            velocity: [0.0; 3],
        });
    }
    for (number, boundary) in case.active_boundaries(stage) {
        let axis = boundary.side.axis();
        let face = (boundary.position(&case.domain) - grid.origin[axis]) / grid.cell;
        let path = || format!("boundaries[{number}].position");
        if (face - face.round()).abs() > 1e-6 {
            let problem =
                format!("lies {face:.6} cells from the domain's side: a wall must lie on a grid line");
            return Err(CaseError::new(path(), problem));
        }
        let face = face.round() as usize;
        let inside = face > 0 && face < grid.cells[axis];
        if inside && !B::WALLS_INSIDE {
            let problem = format!("with {} shape functions walls must lie on the domain's sides", B::NAME);
            return Err(CaseError::new(path(), problem));
        }
        if let Some(kind) = kind(boundary, options) {
            walls.push(wall(boundary, node_on::<S, B>(face, grid.cells[axis]), kind));
        }
    }
    Ok(Walls::new(&nodes, walls))
}

/// Index, along an axis of so many cells, of the nodes on the face between cells `face - 1` and `face`.
pub fn node_on<const S: usize, B: Basis<S>>(face: usize, cells: usize) -> usize {
    if face == cells { B::nodes(cells) - 1 - B::GHOSTS } else { face + B::GHOSTS }
}

/// Refuses walls that would go by more than half a `cell` (m): nodes on a wall take its velocity, but its plane stays.
pub fn refuse_walls_that_leave(case: &Case, cell: f64) -> Result<(), CaseError> {
    for (number, boundary) in case.boundaries.iter().enumerate() {
        let normal = boundary.velocity.as_ref().and_then(|velocity| velocity.get(boundary.side.axis()));
        let stands =
            |stage: &usize| case.active_boundaries(*stage).iter().any(|(active, _)| *active == number);
        let time: f64 = (0..case.stages.len()).filter(stands).map(|stage| case.stages[stage].duration).sum();
        let way = normal.map_or(0.0, |speed| speed.abs() * time);
        if way > 0.5 * cell {
            let problem = format!(
                "the wall would go {way:.3e} m, more than half a cell or element ({:.3e} m), but its plane stays where it \
                 is and only its nodes have the velocity: drive a rigid body or a patch",
                0.5 * cell
            );
            return Err(CaseError::new(format!("boundaries[{number}].velocity"), problem));
        }
    }
    Ok(())
}

/// How the wall of a boundary acts; `None` for one that only brakes.
pub fn kind(boundary: &Boundary, options: &MpmOptions) -> Option<WallKind> {
    Some(match boundary.wall {
        CaseWall::Absorbing { .. } => return None,
        CaseWall::Rough => WallKind::Rough,
        CaseWall::Smooth => WallKind::Smooth,
        CaseWall::Frictional { friction_coefficient: sliding, .. } => match options.wall_friction {
            WallFriction::Impulse => WallKind::Frictional { coefficient: sliding },
            WallFriction::Acceleration => {
                WallKind::Plane { resting: sliding * options.static_friction_ratio, sliding }
            }
        },
    })
}

/// The wall of a boundary with its face at a node.
pub fn wall(boundary: &Boundary, node: usize, kind: WallKind) -> Wall {
    let velocity = boundary.velocity.as_deref().map_or([0.0; 3], spatial);
    let (axis, upper) = (boundary.side.axis(), boundary.side.is_max());
    let separation = boundary.separation || boundary.wall.lets_go();
    Wall { axis, upper, node, kind, separation, velocity }
}
