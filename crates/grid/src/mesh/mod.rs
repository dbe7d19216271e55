//! Unstructured meshes of 3-node triangles and 4-node tetrahedra (sheet: mpm §2.5b, §3.2).

mod build;
mod conformity;
pub(crate) mod msh;

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use crate::{Basis, Grid, NodeList};

pub(crate) use crate::mesh::conformity::{Nonconformity, NonconformityKind};
pub use build::MeshError;

/// Marker of no element, across a facet on the boundary.
const NO_ELEMENT: u32 = u32::MAX;
/// Tolerance below zero of the barycentric coordinates of a point in an element.
const BARYCENTRIC_TOLERANCE: f64 = 1e-10;
/// Largest number of elements in a walk search before it restarts from the bins.
const MAX_WALK_STEPS: usize = 50;
/// Largest number of corners of an element.
const CORNERS: usize = 4;

/// Marker of the shape functions of a mesh, which has no axes: `S` nodes a point, `D + 1` of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SimplexBasis;

impl<const S: usize> Basis<S> for SimplexBasis {
    const NAME: &'static str = "mesh";
    const GHOSTS: usize = 0;
    const NODES_BELOW: usize = 1;
    const NODES_ABOVE: usize = 1;

    fn nodes(cells: usize) -> usize {
        cells + 1
    }

    fn coordinate(index: usize, _cells: usize) -> f64 {
        index as f64
    }

    fn evaluate(x: f64, _width: f64, _cells: usize) -> (usize, [f64; S], [f64; S]) {
        (x.max(0.0) as usize, [0.0; S], [0.0; S])
    }
}

/// Triangle or tetrahedron, with its shape functions `N_i(x) = values[i] + gradients[i] · x`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Element<const D: usize> {
    /// Node numbers, `D + 1` of them.
    pub nodes: [u32; CORNERS],
    values: [f64; CORNERS],
    /// Gradients of the shape functions (1/m).
    pub gradients: [[f64; D]; CORNERS],
    /// Element across the facet opposite to each node.
    neighbours: [u32; CORNERS],
    /// Volume (m³; m² in the plane).
    pub volume: f64,
    /// Least height (m): the `L_min` of the critical time step, `3 V / A_max` or `2 A / l_max`.
    pub height: f64,
}

/// Mesh of triangles (`D = 2`) or tetrahedra (`D = 3`). Its nodes are numbered along the first axis, and its elements
/// in the order of their lowest nodes, so that slabs of the mesh are ranges of both.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh<const D: usize> {
    nodes: Vec<[f64; D]>,
    elements: Vec<Element<D>>,
    groups: BTreeMap<String, Vec<u32>>,
    node_elements: NodeElements,
    /// Cells of the size of the largest element, with the elements that overlap each.
    bins: Option<ElementBins<D>>,
}

/// Elements around the nodes: those of node `n` are the members from `starts[n]` to `starts[n + 1]`.
#[derive(Clone, Debug, Default, PartialEq)]
struct NodeElements {
    row_offsets: Vec<u32>,
    elements: Vec<u32>,
}

#[derive(Clone, Debug, PartialEq)]
struct ElementBins<const D: usize> {
    grid: Grid<D>,
    bin_offsets: Vec<u32>,
    elements: Vec<u32>,
}

impl<const D: usize> Mesh<D> {
    /// Positions of the nodes (m).
    pub fn nodes(&self) -> &[[f64; D]] {
        &self.nodes
    }

    /// Elements of the mesh.
    pub fn elements(&self) -> &[Element<D>] {
        &self.elements
    }

    /// Memory of a mesh (bytes) with these numbers of nodes and elements, without named groups.
    pub fn bytes(nodes: f64, elements: f64) -> f64 {
        let number = size_of::<u32>() as f64;
        // Each node lists its elements, and each element is in a few bins.
        let of_element = size_of::<Element<D>>() as f64 + (D + 1 + (1 << D)) as f64 * number;
        nodes * (size_of::<[f64; D]>() as f64 + number) + elements * of_element
    }

    /// Elements around a node.
    #[inline]
    pub fn elements_around(&self, node: u32) -> &[u32] {
        let NodeElements { row_offsets, elements } = &self.node_elements;
        &elements[row_offsets[node as usize] as usize..row_offsets[node as usize + 1] as usize]
    }

    /// Elements across the facets of an element; none across a facet on the boundary of the mesh.
    pub fn neighbours(&self, element: u32) -> impl Iterator<Item = u32> {
        let across = self.elements[element as usize].neighbours;
        across.into_iter().take(D + 1).filter(|&other| other != NO_ELEMENT)
    }

    /// Nodes of a group.
    pub fn group(&self, name: &str) -> Option<&[u32]> {
        self.groups.get(name).map(Vec::as_slice)
    }

    /// Names of the groups.
    pub fn groups(&self) -> impl Iterator<Item = &str> {
        self.groups.keys().map(String::as_str)
    }

    /// Whether there is no mesh, as on a structured grid.
    pub fn is_empty(&self) -> bool {
        self.elements.is_empty()
    }

    /// Grid of cells around the mesh, as large as its largest element.
    pub fn cells(&self) -> Option<Grid<D>> {
        self.bins.as_ref().map(|bins| bins.grid)
    }

    /// Least height of all elements (m).
    pub fn height(&self) -> f64 {
        self.elements.iter().map(|e| e.height).fold(f64::INFINITY, f64::min)
    }

    /// Barycentric coordinates of `position` in an element, equal to its shape functions.
    #[inline(always)]
    pub fn barycentric(&self, element: u32, position: &[f64; D]) -> [f64; CORNERS] {
        let e = &self.elements[element as usize];
        let mut out = [0.0; CORNERS];
        for k in 0..=D {
            out[k] = e.values[k];
            for c in 0..D {
                out[k] += e.gradients[k][c] * position[c];
            }
        }
        out
    }

    /// Nodes of a point in an element.
    #[inline(always)]
    pub fn support<const N: usize>(&self, element: u32, position: &[f64; D]) -> NodeList<D, N> {
        let e = &self.elements[element as usize];
        let weights = self.barycentric(element, position);
        let mut list = NodeList::EMPTY;
        for k in 0..N {
            list.nodes[k] = e.nodes[k];
            list.positions[k] = self.nodes[e.nodes[k] as usize];
            list.weights[k] = weights[k];
            list.gradients[k] = e.gradients[k];
        }
        list
    }

    /// Position with barycentric coordinates `local` in an element.
    pub fn element_point(&self, element: u32, local: &[f64]) -> [f64; D] {
        let nodes = self.elements[element as usize].nodes;
        std::array::from_fn(|c| {
            local.iter().zip(nodes).map(|(share, node)| share * self.nodes[node as usize][c]).sum()
        })
    }

    /// Element that contains `position`; on a common facet, the one with the lowest number.
    pub fn locate(&self, position: &[f64; D]) -> Option<u32> {
        let bins = self.bins.as_ref()?;
        let local = bins.grid.local(position);
        let margin = 1e-6;
        if (0..D).any(|a| !(local[a] > -margin && local[a] < bins.grid.cells[a] as f64 + margin)) {
            return None;
        }
        let cell = bins.grid.cell_of(position);
        let bin = (0..D).fold(0, |number, a| number * bins.grid.cells[a] + cell[a]);
        let range = bins.bin_offsets[bin] as usize..bins.bin_offsets[bin + 1] as usize;
        bins.elements[range]
            .iter()
            .copied()
            .find(|&e| lowest_entry::<D>(&self.barycentric(e, position)).1 >= -BARYCENTRIC_TOLERANCE)
    }

    /// Element that contains `position`, by a walk from `start` through the facet that the position lies farthest
    /// beyond, until there is none.
    #[inline]
    pub fn locate_from(&self, start: u32, position: &[f64; D]) -> Option<u32> {
        let mut element = start;
        for _ in 0..MAX_WALK_STEPS {
            let (facet, smallest) = lowest_entry::<D>(&self.barycentric(element, position));
            if smallest >= -BARYCENTRIC_TOLERANCE {
                return Some(element);
            }
            element = self.elements[element as usize].neighbours[facet];
            if element == NO_ELEMENT {
                break;
            }
        }
        self.locate(position)
    }

    /// Boundary facets of the union of the elements that `inside` selects: element, and the node opposite to the facet.
    pub fn boundary<'a>(
        &'a self,
        inside: impl Fn(u32) -> bool + 'a,
    ) -> impl Iterator<Item = (u32, usize)> + 'a {
        let all = (0..self.elements.len() as u32).flat_map(|e| (0..=D).map(move |k| (e, k)));
        all.filter(move |&(e, k)| {
            let across = self.elements[e as usize].neighbours[k];
            inside(e) && (across == NO_ELEMENT || !inside(across))
        })
    }

    /// Area of a facet (m²; m in the plane): `D V / height`.
    pub fn facet_area(&self, element: u32, opposite: usize) -> f64 {
        let e = &self.elements[element as usize];
        D as f64 * e.volume * norm(&e.gradients[opposite])
    }

    /// Nodes of a facet.
    pub fn facet_nodes(&self, element: u32, opposite: usize) -> impl Iterator<Item = u32> {
        let nodes = self.elements[element as usize].nodes;
        (0..=D).filter(move |&k| k != opposite).map(move |k| nodes[k])
    }
}

fn norm<const D: usize>(vector: &[f64; D]) -> f64 {
    vector.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// Index and value of the lowest of the first `D + 1` numbers.
#[inline(always)]
fn lowest_entry<const D: usize>(values: &[f64; CORNERS]) -> (usize, f64) {
    let mut smallest = (0, values[0]);
    for k in 1..=D {
        if values[k] < smallest.1 {
            smallest = (k, values[k]);
        }
    }
    smallest
}
