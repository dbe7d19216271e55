//! Meshes of triangles and tetrahedra in place of the structured grid (sheet: mpm §2.5b, §2.11, §3.1, §3.2).

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;

use colluvium_case::description::{Body, Boundary, Space, Wall as CaseWall};
use colluvium_case::{Case, CaseError};
use colluvium_grid::{Basis1d, Grid, Layout, Mesh, NodeWall, NodeWalls, WallKind};
use colluvium_points::Sample;

use crate::boundary::walls;
use crate::config::{InternalForceIntegration, MeshSource, ShapeFunctions, VolumetricStrain};
use crate::points::point_set::PointSet;
use crate::setup;
use crate::{LagrangianFormulation, MpmOptions, VelocityTransfer};

/// Rejects features that meshes do not support.
pub fn check_supported(case: &Case, options: &MpmOptions) -> Result<(), CaseError> {
    let refuse = |key: &str, problem: &str| Err(CaseError::new(format!("methods.mpm.{key}"), problem));
    not_axis_by_axis(case, options)?;
    let grouped = case.boundaries.iter().position(|boundary| boundary.group.is_some());
    let Some(source) = &options.mesh else {
        return match grouped {
            Some(number) => {
                let problem = "needs methods.mpm.mesh from a file: a structured grid has no groups of nodes";
                Err(CaseError::new(format!("boundaries[{number}].group"), problem))
            }
            None => Ok(()),
        };
    };
    if let (Some(number), MeshSource::Box) = (grouped, source) {
        let problem = "needs methods.mpm.mesh from a file: a box has no groups of nodes";
        return Err(CaseError::new(format!("boundaries[{number}].group"), problem));
    }
    if case.dimension() == 1 {
        return refuse("mesh", "needs two or three dimensions");
    }
    if options.shape != ShapeFunctions::Linear {
        let problem = "a mesh of triangles or tetrahedra has linear shape functions only: gimp, cpdi and splines need \
             a structured grid";
        return refuse("shape", problem);
    }
    if options.transfer == VelocityTransfer::Apic {
        return refuse("transfer", "apic is not available on a mesh: use tpic");
    }
    if options.formulation == LagrangianFormulation::TotalLagrangian {
        return refuse("formulation", "total-lagrangian is not available on a mesh");
    }
    if !(1..=3).contains(&options.points_per_cell) {
        let problem = format!(
            "{} is not in 1..=3 (1, 3 or 6 points a triangle; 1, 4 or 10 a tetrahedron)",
            options.points_per_cell
        );
        return refuse("points_per_cell", &problem);
    }
    Ok(())
}

/// Rejects absorbing sides, periodic domains and free surfaces where they require a structured grid of products over the axes.
fn not_axis_by_axis(case: &Case, options: &MpmOptions) -> Result<(), CaseError> {
    let refuse = |path: &str, problem: &str| Err(CaseError::new(path, problem));
    let special = options.mesh.is_some()
        || options.formulation == LagrangianFormulation::TotalLagrangian
        || matches!(options.shape, ShapeFunctions::Cpdi | ShapeFunctions::Cpdi2);
    let absorbing = |boundary: &Boundary| matches!(boundary.wall, CaseWall::Absorbing { .. });
    if let Some(number) = case.boundaries.iter().position(absorbing).filter(|_| special) {
        let problem = "an absorbing boundary needs a structured grid with shape linear, ugimp, cpgimp, quadratic or cubic";
        return refuse(&format!("boundaries[{number}].wall"), problem);
    }
    let shared = options.volumetric_strain == VolumetricStrain::Nodal
        || options.integration != InternalForceIntegration::Points;
    if !case.domain.periodic.is_empty() && (special || shared) {
        let problem = "is not available with a mesh, total-lagrangian, cpdi, cpdi2, nodal volumetric strain or \
                       integration by cells";
        return refuse("domain.periodic", problem);
    }
    if options.free_surface.is_some() && options.formulation == LagrangianFormulation::TotalLagrangian {
        return refuse("methods.mpm.free_surface", "is not available with total-lagrangian");
    }
    Ok(())
}

/// Returns grid, mesh and order of the nodes of a case; without a mesh it is empty.
pub fn grid_mesh_and_layout<const D: usize>(
    case: &Case,
    options: &MpmOptions,
    axis: &Basis1d,
) -> Result<(Grid<D>, Arc<Mesh<D>>, Layout<D>), CaseError> {
    let Some(source) = &options.mesh else {
        let grid = setup::grid::<D>(case, options)?;
        let layout = setup::layout(case, &grid, axis, options)?;
        return Ok((grid, Arc::default(), layout));
    };
    let mesh = match source {
        MeshSource::Box => Mesh::of_grid(&setup::grid::<D>(case, options)?)
            .map_err(|error| CaseError::new("methods.mpm.mesh", error.to_string()))?,
        MeshSource::File { file } => read(Path::new(file))?,
    };
    let Some(grid) = mesh.cells() else {
        return Err(CaseError::new("methods.mpm.mesh", "is empty"));
    };
    let beyond = |x: &[f64; D], c: usize| {
        let (low, high) = (case.domain.min[c], case.domain.max[c]);
        let slack = 1e-9 * (high - low);
        x[c] < low - slack || x[c] > high + slack
    };
    if let Some(x) = mesh.nodes().iter().find(|x| (0..D).any(|c| beyond(x, c))) {
        let problem = format!("the mesh has a node at {x:?} m, outside the domain");
        return Err(CaseError::new("domain", problem));
    }
    let layout = Layout::of_mesh(&mesh, &grid);
    Ok((grid, Arc::new(mesh), layout))
}

fn read<const D: usize>(file: &Path) -> Result<Mesh<D>, CaseError> {
    let fail =
        |problem: String| CaseError::new("methods.mpm.mesh.file", format!("{}: {problem}", file.display()));
    let bytes = std::fs::read(file).map_err(|error| fail(format!("cannot be read: {error}")))?;
    Mesh::from_msh(&bytes).map_err(|error| fail(error.to_string()))
}

/// Barycentric coordinates of the points of an element, `count (count + 1) …` of them on a lattice: 1, 3 or 6 in a
/// triangle, 1, 4 or 10 in a tetrahedron.
fn lattice_coordinates<const D: usize>(count: usize) -> Vec<[f64; 4]> {
    // Of the rules of second order with three and four points.
    let inset = if D == 2 { 1.0 / 3.0 } else { 0.5 * (5f64.sqrt() - 1.0) / 2.0 };
    let sum = (count - 1) as f64 + (D + 1) as f64 * inset;
    let mut points = Vec::new();
    let mut index = [0usize; 4];
    'all: loop {
        let used: usize = index[1..=D].iter().sum();
        if used < count {
            index[0] = count - 1 - used;
            points.push(std::array::from_fn(|k| if k <= D { (index[k] as f64 + inset) / sum } else { 0.0 }));
        }
        for k in 1..=D {
            index[k] += 1;
            if index[k] < count {
                continue 'all;
            }
            index[k] = 0;
        }
        return points;
    }
}

/// Number of points of a body in each element.
pub fn points_per_element<const D: usize>(options: &MpmOptions) -> usize {
    lattice_coordinates::<D>(options.points_per_cell).len()
}

/// Points of a body: those of every element that lie in its shape.
pub fn sample_body<const D: usize>(mesh: &Mesh<D>, options: &MpmOptions, body: &Body) -> Vec<Sample<D>> {
    let points = lattice_coordinates::<D>(options.points_per_cell);
    let mut samples = Vec::new();
    for (number, element) in mesh.elements().iter().enumerate() {
        for local in &points {
            let position = mesh.position(number as u32, &local[..=D]);
            if body.shape.contains(&position) {
                samples.push(Sample { position, volume: element.volume / points.len() as f64 });
            }
        }
    }
    samples
}

/// Returns the walls of a stage: the nodes of a group, or those on and beyond a plane.
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
        let axis = NodeWall { axis: 0, upper: false, node: 0, kind, separation: false, velocity: [0.0; 3] };
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

/// Rejects a group with a face that is not normal to the axis of its side, along which alone such a wall acts.
fn reject_oblique_group<const D: usize>(
    mesh: &Mesh<D>,
    number: usize,
    boundary: &Boundary,
    nodes: &[u32],
) -> Result<(), CaseError> {
    let Some(name) = &boundary.group else { return Ok(()) };
    let (axis, slack) = (boundary.side.axis(), 1e-6 * mesh.height());
    let held: BTreeSet<u32> = nodes.iter().copied().collect();
    for (element, opposite) in mesh.boundary(|_| true) {
        let face: Vec<u32> = mesh.facet_nodes(element, opposite).collect();
        if !face.iter().all(|node| held.contains(node)) {
            continue;
        }
        let first = &mesh.nodes()[face[0] as usize];
        if face.iter().any(|&node| (mesh.nodes()[node as usize][axis] - first[axis]).abs() > slack) {
            let problem = format!(
                "the face of {name:?} at {first:?} m is not normal to the axis of the boundary's side, along which a smooth or frictional \
                 wall acts: give that surface as an obstacle with `methods.mpm.obstacles` `points`, or make the wall rough"
            );
            return Err(CaseError::new(format!("boundaries[{number}].group"), problem));
        }
    }
    Ok(())
}

fn nodes_where<const D: usize>(mesh: &Mesh<D>, picks: impl Fn(&[f64; D]) -> bool) -> Vec<u32> {
    (0u32..).zip(mesh.nodes()).filter(|(_, x)| picks(x)).map(|(number, _)| number).collect()
}

fn group<const D: usize>(mesh: &Mesh<D>, number: usize, name: &str) -> Result<Vec<u32>, CaseError> {
    mesh.group(name).map(<[u32]>::to_vec).ok_or_else(|| {
        let known: Vec<&str> = mesh.groups().collect();
        let problem = format!("{name:?} is not a physical group of the mesh, which has {known:?}");
        CaseError::new(format!("boundaries[{number}].group"), problem)
    })
}

fn on_plane<const D: usize>(
    case: &Case,
    mesh: &Mesh<D>,
    number: usize,
    boundary: &Boundary,
) -> Result<Vec<u32>, CaseError> {
    let (axis, face) = (boundary.side.axis(), boundary.position(&case.domain));
    let slack = 1e-6 * mesh.height();
    let sign = if boundary.side.is_max() { 1.0 } else { -1.0 };
    let nodes = nodes_where(mesh, |x| sign * (x[axis] - face) >= -slack);
    let touches = nodes.iter().any(|&n| (mesh.nodes()[n as usize][axis] - face).abs() <= slack);
    if touches {
        return Ok(nodes);
    }
    let problem = format!("no node of the mesh lies on the wall at {face} m");
    Err(CaseError::new(format!("boundaries[{number}].position"), problem))
}

/// Loaded area (m²; m in the plane, per radian in axisymmetry) of each point of a set: facets of the filled elements on the loaded side,
/// divided among the points next to them (sheet: mpm §2.11). Where a load varies, an area counts with the share of the load on it.
pub fn loaded_areas<const D: usize>(
    case: &Case,
    number: usize,
    mesh: &Mesh<D>,
    set: &PointSet<D>,
) -> Result<Vec<f64>, CaseError> {
    let element_of = elements_of(mesh, set);
    let count = counts(mesh, &element_of);
    let mut share = vec![0.0; count.len()];
    for facet in loaded_facets(case, number, mesh, &count)? {
        let points = f64::from(count[facet.element as usize]);
        share[facet.element as usize] += facet.areas.iter().sum::<f64>() / points;
    }
    Ok(element_of.into_iter().map(|element| share[element as usize]).collect())
}

/// Nodes on the loaded side: number and loaded area (sheet: mpm §2.11).
pub fn loaded_nodes<const D: usize>(
    case: &Case,
    number: usize,
    mesh: &Mesh<D>,
    set: &PointSet<D>,
) -> Result<BTreeMap<usize, f64>, CaseError> {
    let mut areas = BTreeMap::new();
    for facet in loaded_facets(case, number, mesh, &counts(mesh, &elements_of(mesh, set)))? {
        for (node, area) in facet.nodes.into_iter().zip(facet.areas) {
            *areas.entry(node as usize).or_insert(0.0) += area;
        }
    }
    Ok(areas)
}

/// Facet on a loaded side.
struct LoadedFacet<const D: usize> {
    /// Element behind the facet.
    element: u32,
    nodes: [u32; D],
    /// Integral over it of each node's function times the share of the load (m², m, or per radian).
    areas: [f64; D],
}

fn elements_of<const D: usize>(mesh: &Mesh<D>, set: &PointSet<D>) -> Vec<u32> {
    set.points.position.iter().filter_map(|x| mesh.locate(x)).collect()
}

/// Number of points in each element.
fn counts<const D: usize>(mesh: &Mesh<D>, element_of: &[u32]) -> Vec<u32> {
    let mut count = vec![0u32; mesh.elements().len()];
    element_of.iter().for_each(|&e| count[e as usize] += 1);
    count
}

/// Returns facets on the loaded side of the elements with points.
fn loaded_facets<const D: usize>(
    case: &Case,
    number: usize,
    mesh: &Mesh<D>,
    count: &[u32],
) -> Result<Vec<LoadedFacet<D>>, CaseError> {
    let load = &case.loads[number];
    let Some(side) = load.side() else { return Ok(Vec::new()) };
    let (axis, sign) = (side.axis(), if side.is_max() { 1.0 } else { -1.0 });
    let place = |n: u32| mesh.nodes()[n as usize];
    let filled = |e: u32| count[e as usize] > 0;
    let reach = |e: u32| mesh.elements()[e as usize].nodes[..=D].iter().map(|&n| sign * place(n)[axis]);
    let all = 0..count.len() as u32;
    let outermost = all.filter(|&e| filled(e)).flat_map(reach).fold(f64::NEG_INFINITY, f64::max);
    let slack = 1e-6 * mesh.height();
    let share = |x: &[f64; D]| {
        let radius = if case.space == Space::Axisymmetric { x[0] } else { 1.0 };
        load.profile_factor(x) * radius
    };
    let mut facets = Vec::new();
    for (element, opposite) in mesh.boundary(filled) {
        let mut nodes = [0; D];
        nodes.iter_mut().zip(mesh.facet_nodes(element, opposite)).for_each(|(node, n)| *node = n);
        let corners = nodes.map(place);
        if corners.iter().all(|x| sign * x[axis] >= outermost - slack) {
            let area = mesh.facet_area(element, opposite);
            let areas = facet_means(&corners, share).map(|mean| area * mean);
            facets.push(LoadedFacet { element, nodes, areas });
        }
    }
    if facets.is_empty() {
        let problem = "the body has no facet of the mesh on that side";
        return Err(CaseError::new(format!("loads[{number}].side"), problem));
    }
    Ok(facets)
}

/// Means over a facet of the linear function of each corner times `share`, from as many places within it as there are
/// corners: those of Gauss on an edge, and halfway between centre and corners in a triangle. Exact where `share` is linear.
fn facet_means<const D: usize>(corners: &[[f64; D]; D], share: impl Fn(&[f64; D]) -> f64) -> [f64; D] {
    let way = if D == 2 { 1.0 / 3f64.sqrt() } else { 0.5 };
    let mut means = [0.0; D];
    for near in 0..D {
        let weights: [f64; D] = std::array::from_fn(|k| {
            let own = if k == near { way } else { 0.0 };
            own + (1.0 - way) / D as f64
        });
        let place = std::array::from_fn(|c| (0..D).map(|k| weights[k] * corners[k][c]).sum());
        let part = share(&place) / D as f64;
        (0..D).for_each(|k| means[k] += weights[k] * part);
    }
    means
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loads_on_facets_are_the_integrals_of_their_nodal_functions() {
        // ∫ N_i (2 + x) over an edge of unit length: 2/2 + 1/6 and 2/2 + 1/3.
        let [first, second] = facet_means(&[[0.0, 5.0], [1.0, 5.0]], |x| 2.0 + x[0]);
        assert!((first - 7.0 / 6.0).abs() < 1e-15 && (second - 8.0 / 6.0).abs() < 1e-15);
        // ∫ N_i y over a triangle, over its area: (1 + δ)/12 for the corner where y is one.
        let triangle = [[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
        let found = facet_means(&triangle, |x| x[1]);
        assert!(found.iter().zip([1.0, 1.0, 2.0]).all(|(f, e)| (f - e / 12.0).abs() < 1e-15), "{found:?}");
    }

    #[test]
    fn points_lie_where_the_sheet_says() {
        assert_eq!([1, 2, 3].map(|n| lattice_coordinates::<2>(n).len()), [1, 3, 6]);
        assert_eq!([1, 2, 3].map(|n| lattice_coordinates::<3>(n).len()), [1, 4, 10]);
        let close = |a: f64, b: f64| (a - b).abs() < 1e-7;
        for point in lattice_coordinates::<2>(2) {
            assert!(point[..3].iter().all(|c| close(*c, 1.0 / 6.0) || close(*c, 2.0 / 3.0)), "{point:?}");
        }
        for point in lattice_coordinates::<3>(2) {
            assert!(point.iter().all(|c| close(*c, 0.585_410_2) || close(*c, 0.138_196_6)), "{point:?}");
        }
        for count in 1..=3 {
            for point in lattice_coordinates::<3>(count) {
                assert!((point.iter().sum::<f64>() - 1.0).abs() < 1e-15 && point.iter().all(|c| *c > 0.0));
            }
        }
    }
}
