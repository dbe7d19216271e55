//! Loads on the facets of a mesh (sheet: mpm §2.11).

use std::collections::BTreeMap;

use colluvium_case::description::Space;
use colluvium_case::{Case, CaseError};
use colluvium_grid::Mesh;

use crate::points::point_set::PointSet;

/// Loaded area of each point of a set (m²; m in the plane, per radian in axisymmetry): the loaded facets of elements with points, divided
/// among these points (sheet: mpm §2.11). For a load that varies, the area is multiplied by the relative load.
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

/// Numbers of the nodes on the loaded surface, with their loaded areas (sheet: mpm §2.11).
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

/// Element of each point of a set.
fn elements_of<const D: usize>(mesh: &Mesh<D>, set: &PointSet<D>) -> Vec<u32> {
    set.points.position.iter().filter_map(|x| mesh.locate(x)).collect()
}

/// Number of points in each element.
fn counts<const D: usize>(mesh: &Mesh<D>, element_of: &[u32]) -> Vec<u32> {
    let mut count = vec![0u32; mesh.elements().len()];
    element_of.iter().for_each(|&e| count[e as usize] += 1);
    count
}

/// Facets on the loaded surface of the elements that contain points.
fn loaded_facets<const D: usize>(
    case: &Case,
    number: usize,
    mesh: &Mesh<D>,
    count: &[u32],
) -> Result<Vec<LoadedFacet<D>>, CaseError> {
    let load = &case.loads[number];
    let Some(side) = load.loaded_side() else { return Ok(Vec::new()) };
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

/// Means over a facet of the linear shape function of each corner times `share`, by Gauss integration with as many positions as corners.
/// Exact where `share` is linear.
fn facet_means<const D: usize>(corners: &[[f64; D]; D], share: impl Fn(&[f64; D]) -> f64) -> [f64; D] {
    let position_weight = if D == 2 { 1.0 / 3f64.sqrt() } else { 0.5 };
    let mut means = [0.0; D];
    for near in 0..D {
        let weights: [f64; D] = std::array::from_fn(|k| {
            let own = if k == near { position_weight } else { 0.0 };
            own + (1.0 - position_weight) / D as f64
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
}
