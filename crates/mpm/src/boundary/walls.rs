//! Walls on the nodes, from the boundaries of a case (sheet: mpm §2.11).

use colluvium_case::description::{Boundary, Space, Wall as CaseWall};
use colluvium_case::{Case, CaseError, spatial};
use colluvium_grid::{NodeWall, NodeWalls, WallKind};

use crate::background_grid::BackgroundGrid;
use crate::boundary::mesh_walls::mesh_walls;
use crate::{MpmOptions, WallFriction};
use colluvium_case::CaseErrorKind;

/// Returns the walls of a stage.
pub fn walls<const D: usize>(
    case: &Case,
    stage: usize,
    BackgroundGrid { grid, mesh, layout, basis_1d: basis, .. }: &BackgroundGrid<D>,
    options: &MpmOptions,
) -> Result<NodeWalls, CaseError> {
    if !mesh.is_empty() {
        return mesh_walls(case, stage, mesh, layout, options);
    }
    let nodes: Vec<usize> = grid.cells.iter().map(|cells| basis.nodes(*cells)).collect();
    let mut walls = Vec::new();
    if case.space == Space::Axisymmetric && grid.origin[0] == 0.0 {
        let kind = WallKind::Smooth;
        walls.push(NodeWall {
            axis: 0,
            is_upper: false,
            node: basis.ghosts,
            kind,
            separation: false,
            velocity: [0.0; 3],
        });
    }
    for (number, boundary) in case.active_boundaries(stage) {
        let axis = boundary.side.axis();
        let face = (boundary.wall_coordinate(&case.domain) - grid.origin[axis]) / grid.cell;
        let path = || format!("boundaries[{number}].position");
        if (face - face.round()).abs() > 1e-6 {
            let problem =
                format!("lies {face:.6} cells from the side of the domain: a wall must lie on a grid line");
            return Err(CaseError::new(path(), CaseErrorKind::coded("wall-off-grid", problem)));
        }
        let face = face.round() as usize;
        let inside = face > 0 && face < grid.cells[axis];
        if inside && !basis.allows_interior_walls {
            let problem =
                format!("with {} shape functions, walls must lie on the sides of the domain", basis.name);
            return Err(CaseError::new(path(), CaseErrorKind::coded("wall-off-grid", problem)));
        }
        if let Some(kind) = wall_kind(boundary, options) {
            walls.push(node_wall(boundary, basis.face_node(face, grid.cells[axis]), kind));
        }
    }
    Ok(NodeWalls::new(&nodes, walls))
}

/// Rejects walls that would move by more than half a `cell` (m): nodes on a wall take its velocity, but its plane is fixed.
pub fn reject_walls_that_leave(case: &Case, cell: f64) -> Result<(), CaseError> {
    for (number, (boundary, time)) in case.boundaries.iter().zip(case.boundary_durations()).enumerate() {
        let normal = boundary.velocity.as_ref().and_then(|velocity| velocity.get(boundary.side.axis()));
        let travel = normal.map_or(0.0, |speed| speed.abs() * time);
        if travel > 0.5 * cell {
            let problem = format!(
                "the wall would move {travel:.3e} m, more than half a cell or element ({:.3e} m). A wall gives \
                 its velocity to its nodes, but its plane does not move: use a rigid body or a patch with a \
                 prescribed motion",
                0.5 * cell
            );
            return Err(CaseError::new(format!("boundaries[{number}].velocity"), problem));
        }
    }
    Ok(())
}

/// Kind of the wall of a boundary; `None` for a boundary that only damps.
pub fn wall_kind(boundary: &Boundary, options: &MpmOptions) -> Option<WallKind> {
    Some(match boundary.wall {
        CaseWall::Absorbing { .. } => return None,
        CaseWall::Rough => WallKind::Rough,
        CaseWall::Smooth => WallKind::Smooth,
        CaseWall::Frictional { friction_coefficient: sliding, .. } => match options.wall_friction {
            WallFriction::Impulse => WallKind::Frictional { coefficient: sliding },
            WallFriction::Acceleration => WallKind::StaticAndSliding {
                static_coefficient: sliding * options.static_friction_ratio,
                sliding_coefficient: sliding,
            },
        },
    })
}

/// Returns the wall of a boundary with its face at a node.
pub fn node_wall(boundary: &Boundary, node: usize, kind: WallKind) -> NodeWall {
    let velocity = boundary.velocity.as_deref().map_or([0.0; 3], spatial);
    let (axis, is_upper) = (boundary.side.axis(), boundary.side.is_max());
    let separation = boundary.separation || boundary.wall.allows_separation();
    NodeWall { axis, is_upper, node, kind, separation, velocity }
}
