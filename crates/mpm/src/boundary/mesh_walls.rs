//! Walls on the nodes of a mesh (sheet: mpm §2.5b, §2.11).

use std::collections::BTreeSet;

use colluvium_case::description::{Boundary, Space};
use colluvium_case::{Case, CaseError};
use colluvium_grid::{Layout, Mesh, NodeWall, NodeWalls, WallKind};

use crate::MpmOptions;
use crate::boundary::walls;
use colluvium_case::CaseErrorKind;

/// Walls of a stage on a mesh: the nodes of a physical group, or those on or outside a plane.
pub fn mesh_walls<const D: usize>(
    case: &Case,
    stage: usize,
    mesh: &Mesh<D>,
    layout: &Layout<D>,
    options: &MpmOptions,
) -> Result<NodeWalls, CaseError> {
    let mut walls = Vec::new();
    if case.space == Space::Axisymmetric {
        let on_axis = nodes_where(mesh, |x| x[0] <= 1e-9 * mesh.height());
        let kind = WallKind::Smooth;
        let axis =
            NodeWall { axis: 0, is_upper: false, node: 0, kind, separation: false, velocity: [0.0; 3] };
        walls.push((axis, on_axis));
    }
    for (number, boundary) in case.active_boundaries(stage) {
        let nodes = match &boundary.group {
            Some(name) => group(mesh, number, name)?,
            None => on_plane(case, mesh, number, boundary)?,
        };
        if let Some(kind) = walls::wall_kind(boundary, options) {
            if kind != WallKind::Rough {
                reject_oblique_group(mesh, number, boundary, &nodes)?;
            }
            walls.push((walls::node_wall(boundary, 0, kind), nodes));
        }
    }
    Ok(NodeWalls::for_mesh_nodes(layout.strides(), layout.len(), walls))
}

/// Rejects a physical group with a face that is not normal to the axis of the wall.
fn reject_oblique_group<const D: usize>(
    mesh: &Mesh<D>,
    number: usize,
    boundary: &Boundary,
    nodes: &[u32],
) -> Result<(), CaseError> {
    let Some(name) = &boundary.group else { return Ok(()) };
    let (axis, slack) = (boundary.side.axis(), 1e-6 * mesh.height());
    let group_nodes: BTreeSet<u32> = nodes.iter().copied().collect();
    for (element, opposite) in mesh.boundary(|_| true) {
        let face: Vec<u32> = mesh.facet_nodes(element, opposite).collect();
        if !face.iter().all(|node| group_nodes.contains(node)) {
            continue;
        }
        let first = &mesh.nodes()[face[0] as usize];
        if face.iter().any(|&node| (mesh.nodes()[node as usize][axis] - first[axis]).abs() > slack) {
            let problem = format!(
                "the face of {name:?} at {first:?} m is not normal to the axis of the boundary's side, along which a smooth or frictional \
                 wall acts: give that surface as an obstacle with `methods.mpm.obstacles` `points`, or make the wall rough"
            );
            return Err(CaseError::new(
                format!("boundaries[{number}].group"),
                CaseErrorKind::coded("wall-off-grid", problem),
            ));
        }
    }
    Ok(())
}

/// Numbers of the mesh nodes whose positions satisfy a condition.
fn nodes_where<const D: usize>(mesh: &Mesh<D>, picks: impl Fn(&[f64; D]) -> bool) -> Vec<u32> {
    (0u32..).zip(mesh.nodes()).filter(|(_, x)| picks(x)).map(|(number, _)| number).collect()
}

/// Nodes of a physical group of the mesh.
fn group<const D: usize>(mesh: &Mesh<D>, number: usize, name: &str) -> Result<Vec<u32>, CaseError> {
    mesh.group(name).map(<[u32]>::to_vec).ok_or_else(|| {
        let known: Vec<&str> = mesh.groups().collect();
        let problem = format!("{name:?} is not a physical group of the mesh, which has {known:?}");
        CaseError::new(format!("boundaries[{number}].group"), problem)
    })
}

/// Nodes of the mesh on the plane of a boundary or outside it; an error if no node is on the plane.
fn on_plane<const D: usize>(
    case: &Case,
    mesh: &Mesh<D>,
    number: usize,
    boundary: &Boundary,
) -> Result<Vec<u32>, CaseError> {
    let (axis, face) = (boundary.side.axis(), boundary.wall_coordinate(&case.domain));
    let slack = 1e-6 * mesh.height();
    let sign = if boundary.side.is_max() { 1.0 } else { -1.0 };
    let nodes = nodes_where(mesh, |x| sign * (x[axis] - face) >= -slack);
    let touches = nodes.iter().any(|&n| (mesh.nodes()[n as usize][axis] - face).abs() <= slack);
    if touches {
        return Ok(nodes);
    }
    let problem =
        CaseErrorKind::coded("wall-off-grid", format!("no node of the mesh lies on the wall at {face} m"));
    Err(CaseError::new(format!("boundaries[{number}].position"), problem))
}
