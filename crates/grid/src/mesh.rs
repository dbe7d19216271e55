//! Unstructured meshes of 3-node triangles and 4-node tetrahedra (MPM sheet §2.5b, §3.2).

use std::collections::{BTreeMap, HashMap};

use thiserror::Error;

use crate::{Basis, Grid, NodeList};

/// No element: what lies across a facet on the boundary.
const NONE: u32 = u32::MAX;
/// How far below zero a barycentric coordinate of a point of an element may lie.
const TOLERANCE: f64 = 1e-10;
/// Elements a search walks through before it starts again from the bins.
const HOPS: usize = 50;
/// Corners of an element, at most.
const CORNERS: usize = 4;

/// Why a mesh cannot be used.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum MeshError {
    /// Nothing to compute on.
    #[error("has no {0}")]
    Empty(&'static str),
    /// An element names a node that is not there.
    #[error("element {element} names node {node}, and there are {nodes}")]
    UnknownNode {
        /// Number of the element.
        element: usize,
        /// What it names.
        node: usize,
        /// Number of nodes.
        nodes: usize,
    },
    /// A node with a coordinate that is no number.
    #[error("node {node} lies at {position:?} m")]
    NotFinite {
        /// Number of the node.
        node: usize,
        /// Its coordinates.
        position: Vec<f64>,
    },
    /// An element without volume, or turned inside out.
    #[error(
        "element {element} around {centre:?} m has the volume {volume:.3e}: it must be positive (corners in the wrong order, or flat)"
    )]
    Volume {
        /// Number of the element.
        element: usize,
        /// Its centre (m).
        centre: Vec<f64>,
        /// Its volume (m³; m² in the plane).
        volume: f64,
    },
    /// Two nodes at one place.
    #[error("nodes {first} and {second} lie at the same place {position:?} m")]
    Duplicate {
        /// Number of one.
        first: usize,
        /// Number of the other.
        second: usize,
        /// Where they lie (m).
        position: Vec<f64>,
    },
    /// A facet between three elements or more.
    #[error("elements {first} and {second} share a facet that a third one has too")]
    SharedFacet {
        /// Number of one element.
        first: usize,
        /// Number of another.
        second: usize,
    },
}

/// Marks the shape functions of a mesh, which has no axes: `S` nodes a point, `D + 1` of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Simplex;

impl<const S: usize> Basis<S> for Simplex {
    const NAME: &'static str = "mesh";
    const GHOSTS: usize = 0;
    const BELOW: usize = 1;
    const ABOVE: usize = 1;

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

/// A triangle or tetrahedron, with its shape functions `N_i(x) = values[i] + gradients[i] · x`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Element<const D: usize> {
    /// Its `D + 1` nodes.
    pub nodes: [u32; CORNERS],
    values: [f64; CORNERS],
    gradients: [[f64; D]; CORNERS],
    /// The element across the facet opposite to each node.
    neighbours: [u32; CORNERS],
    /// Volume (m³; m² in the plane).
    pub volume: f64,
    /// Least height (m): the `L_min` of the critical time step, `3 V / A_max` or `2 A / l_max`.
    pub height: f64,
}

/// A mesh of triangles (`D = 2`) or tetrahedra (`D = 3`). Its nodes are numbered along the first axis, so that slabs
/// of the mesh are ranges of nodes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh<const D: usize> {
    nodes: Vec<[f64; D]>,
    elements: Vec<Element<D>>,
    groups: BTreeMap<String, Vec<u32>>,
    /// Cells of the size of the largest element, and the elements that reach into each.
    bins: Option<Bins<D>>,
}

#[derive(Clone, Debug, PartialEq)]
struct Bins<const D: usize> {
    grid: Grid<D>,
    starts: Vec<u32>,
    elements: Vec<u32>,
}

impl<const D: usize> Mesh<D> {
    /// The mesh of `elements` with `D + 1` corners each, by number of node, and of groups of nodes by name. Nodes that
    /// no element has are dropped.
    ///
    /// # Errors
    /// When elements are flat or inside out, nodes lie at the same place, or facets join more than two elements.
    pub fn new(
        nodes: &[[f64; D]],
        elements: &[Vec<usize>],
        groups: &BTreeMap<String, Vec<usize>>,
    ) -> Result<Self, MeshError> {
        if elements.is_empty() {
            return Err(MeshError::Empty(if D == 2 { "triangle" } else { "tetrahedron" }));
        }
        for (number, corners) in elements.iter().enumerate() {
            if let Some(&node) = corners.iter().find(|&&node| node >= nodes.len()) {
                return Err(MeshError::UnknownNode { element: number, node, nodes: nodes.len() });
            }
        }
        let (order, number_of) = numbering(nodes, elements);
        let nodes: Vec<[f64; D]> = order.iter().map(|&old| nodes[old]).collect();
        check_nodes(&nodes, &order)?;
        let mut built = Vec::with_capacity(elements.len());
        for (number, corners) in elements.iter().enumerate() {
            built.push(element(&nodes, corners.iter().map(|old| number_of[old]), number)?);
        }
        join(&mut built)?;
        let groups = groups.iter().map(|(name, members)| {
            let mut members: Vec<u32> =
                members.iter().filter_map(|old| number_of.get(old).copied()).collect();
            members.sort_unstable();
            members.dedup();
            (name.clone(), members)
        });
        let mut mesh = Self { groups: groups.collect(), nodes, elements: built, bins: None };
        mesh.bins = Some(mesh.make_bins());
        Ok(mesh)
    }

    /// The cells of `grid` cut into triangles (two a cell) or tetrahedra (six a cell): one for each order in which a
    /// way from the lowest to the highest corner takes the axes (Kuhn's triangulation).
    ///
    /// # Errors
    /// As [`Mesh::new`]; a grid has no flaw that would make it fail.
    pub fn of_grid(grid: &Grid<D>) -> Result<Self, MeshError> {
        let counts: [usize; D] = std::array::from_fn(|a| grid.cells[a] + 1);
        let number = |index: &[usize; D]| (0..D).fold(0, |number, a| number * counts[a] + index[a]);
        let every = |counts: [usize; D]| {
            (0..counts.iter().product::<usize>()).map(move |mut rest| {
                let mut index = [0; D];
                for a in (0..D).rev() {
                    index[a] = rest % counts[a];
                    rest /= counts[a];
                }
                index
            })
        };
        let place = |index: [usize; D]| std::array::from_fn(|a| grid.origin[a] + index[a] as f64 * grid.cell);
        let nodes: Vec<[f64; D]> = every(counts).map(place).collect();
        let mut elements = Vec::new();
        for cell in every(grid.cells) {
            for (axes, even) in orders::<D>() {
                let mut corner = cell;
                let mut corners = vec![number(&corner)];
                for axis in axes {
                    corner[axis] += 1;
                    corners.push(number(&corner));
                }
                if !even {
                    corners.swap(D - 1, D);
                }
                elements.push(corners);
            }
        }
        Self::new(&nodes, &elements, &BTreeMap::new())
    }

    /// Positions of the nodes (m).
    pub fn nodes(&self) -> &[[f64; D]] {
        &self.nodes
    }

    /// The elements.
    pub fn elements(&self) -> &[Element<D>] {
        &self.elements
    }

    /// The nodes of a group.
    pub fn group(&self, name: &str) -> Option<&[u32]> {
        self.groups.get(name).map(Vec::as_slice)
    }

    /// Names of the groups.
    pub fn groups(&self) -> impl Iterator<Item = &str> {
        self.groups.keys().map(String::as_str)
    }

    /// True on a structured grid, which has no mesh.
    pub fn is_empty(&self) -> bool {
        self.elements.is_empty()
    }

    /// Box of cells around the mesh, as large as its largest element.
    pub fn cells(&self) -> Option<Grid<D>> {
        self.bins.as_ref().map(|bins| bins.grid)
    }

    /// Least height of all elements (m).
    pub fn height(&self) -> f64 {
        self.elements.iter().map(|e| e.height).fold(f64::INFINITY, f64::min)
    }

    /// Barycentric coordinates, which are the shape functions, of `position` in an element.
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

    /// The nodes of a point in an element.
    #[inline(always)]
    pub fn support<const N: usize>(&self, element: u32, position: &[f64; D]) -> NodeList<D, N> {
        let e = &self.elements[element as usize];
        let weights = self.barycentric(element, position);
        let mut list = NodeList::EMPTY;
        for k in 0..N {
            list.nodes[k] = e.nodes[k];
            list.places[k] = self.nodes[e.nodes[k] as usize];
            list.weights[k] = weights[k];
            list.gradients[k] = e.gradients[k];
        }
        list
    }

    /// Position with barycentric coordinates `local` in an element.
    pub fn place(&self, element: u32, local: &[f64]) -> [f64; D] {
        let nodes = self.elements[element as usize].nodes;
        std::array::from_fn(|c| {
            local.iter().zip(nodes).map(|(share, node)| share * self.nodes[node as usize][c]).sum()
        })
    }

    /// The element that holds `position`; of several that touch it, the one with the lowest number.
    pub fn locate(&self, position: &[f64; D]) -> Option<u32> {
        let bins = self.bins.as_ref()?;
        let local = bins.grid.local(position);
        let margin = 1e-6;
        if (0..D).any(|a| !(local[a] > -margin && local[a] < bins.grid.cells[a] as f64 + margin)) {
            return None;
        }
        let cell = bins.grid.cell_of(position);
        let bin = (0..D).fold(0, |number, a| number * bins.grid.cells[a] + cell[a]);
        let range = bins.starts[bin] as usize..bins.starts[bin + 1] as usize;
        bins.elements[range]
            .iter()
            .copied()
            .find(|&e| lowest::<D>(&self.barycentric(e, position)).1 >= -TOLERANCE)
    }

    /// The element that holds `position`, searched from `start`: through the facet that the position lies farthest
    /// beyond, until there is none.
    #[inline]
    pub fn walk(&self, start: u32, position: &[f64; D]) -> Option<u32> {
        let mut element = start;
        for _ in 0..HOPS {
            let (facet, least) = lowest::<D>(&self.barycentric(element, position));
            if least >= -TOLERANCE {
                return Some(element);
            }
            element = self.elements[element as usize].neighbours[facet];
            if element == NONE {
                break;
            }
        }
        self.locate(position)
    }

    /// Facets of the union of the elements that `inside` picks: element, and the node opposite to the facet.
    pub fn boundary<'a>(
        &'a self,
        inside: impl Fn(u32) -> bool + 'a,
    ) -> impl Iterator<Item = (u32, usize)> + 'a {
        let all = (0..self.elements.len() as u32).flat_map(|e| (0..=D).map(move |k| (e, k)));
        all.filter(move |&(e, k)| {
            let across = self.elements[e as usize].neighbours[k];
            inside(e) && (across == NONE || !inside(across))
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

    fn make_bins(&self) -> Bins<D> {
        let ends = |nodes: &mut dyn Iterator<Item = [f64; D]>| {
            let start = ([f64::INFINITY; D], [f64::NEG_INFINITY; D]);
            nodes.fold(start, |(low, high), x| {
                (std::array::from_fn(|a| low[a].min(x[a])), std::array::from_fn(|a| high[a].max(x[a])))
            })
        };
        let of_element = |e: &Element<D>| ends(&mut e.nodes[..=D].iter().map(|&n| self.nodes[n as usize]));
        let widest = |(low, high): ([f64; D], [f64; D])| (0..D).map(|a| high[a] - low[a]).fold(0.0, f64::max);
        let cell = self.elements.iter().map(|e| widest(of_element(e))).fold(0.0, f64::max);
        let (low, high) = ends(&mut self.nodes.iter().copied());
        let cells = std::array::from_fn(|a| ((high[a] - low[a]) / cell).ceil().max(1.0) as usize);
        let grid = Grid { origin: low, cell, cells };
        let mut members: Vec<Vec<u32>> = vec![Vec::new(); cells.iter().product()];
        for (number, e) in self.elements.iter().enumerate() {
            let (low, high) = of_element(e);
            // A little wider, so that round-off loses no point of the element.
            let [first, last] = [(low, -1e-6), (high, 1e-6)]
                .map(|(x, more)| grid.cell_of(&std::array::from_fn(|a| x[a] + more * cell)));
            let mut index = first;
            'cells: loop {
                members[(0..D).fold(0, |n, a| n * cells[a] + index[a])].push(number as u32);
                for a in 0..D {
                    if index[a] < last[a] {
                        index[a] += 1;
                        continue 'cells;
                    }
                    index[a] = first[a];
                }
                break;
            }
        }
        let mut starts = vec![0];
        for list in &members {
            starts.push(starts[starts.len() - 1] + list.len() as u32);
        }
        Bins { grid, starts, elements: members.concat() }
    }
}

fn norm<const D: usize>(vector: &[f64; D]) -> f64 {
    vector.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// Index and value of the lowest of the first `D + 1` numbers.
#[inline(always)]
fn lowest<const D: usize>(values: &[f64; CORNERS]) -> (usize, f64) {
    let mut least = (0, values[0]);
    for k in 1..=D {
        if values[k] < least.1 {
            least = (k, values[k]);
        }
    }
    least
}

/// The orders of `D` axes, and whether each is even.
fn orders<const D: usize>() -> Vec<([usize; D], bool)> {
    let mut all = vec![(std::array::from_fn(|a| a), true)];
    for place in 0..D {
        for (order, even) in all.clone() {
            for other in place + 1..D {
                let mut swapped: [usize; D] = order;
                swapped.swap(place, other);
                all.push((swapped, !even));
            }
        }
    }
    all
}

/// The nodes that elements have, in order of their coordinates, and the new number of each.
fn numbering<const D: usize>(
    nodes: &[[f64; D]],
    elements: &[Vec<usize>],
) -> (Vec<usize>, HashMap<usize, u32>) {
    let mut order: Vec<usize> = elements.iter().flatten().copied().collect();
    order.sort_unstable();
    order.dedup();
    let compare = |a: &usize, b: &usize| {
        let by_axis = (0..D).map(|c| nodes[*a][c].total_cmp(&nodes[*b][c]));
        by_axis.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
    };
    order.sort_by(compare);
    let number_of = order.iter().enumerate().map(|(new, &old)| (old, new as u32)).collect();
    (order, number_of)
}

fn check_nodes<const D: usize>(nodes: &[[f64; D]], order: &[usize]) -> Result<(), MeshError> {
    if let Some(k) = nodes.iter().position(|x| !x.iter().all(|c| c.is_finite())) {
        return Err(MeshError::NotFinite { node: order[k], position: nodes[k].to_vec() });
    }
    match nodes.windows(2).position(|pair| pair[0] == pair[1]) {
        None => Ok(()),
        Some(k) => Err(MeshError::Duplicate {
            first: order[k].min(order[k + 1]),
            second: order[k].max(order[k + 1]),
            position: nodes[k].to_vec(),
        }),
    }
}

fn element<const D: usize>(
    places: &[[f64; D]],
    corners: impl Iterator<Item = u32>,
    number: usize,
) -> Result<Element<D>, MeshError> {
    let mut nodes = [0; CORNERS];
    corners.zip(&mut nodes).for_each(|(corner, node)| *node = corner);
    let at = |k: usize| places[nodes[k] as usize];
    // J with the columns x_k - x_0, and its inverse by cofactors: row k is the gradient of N_{k+1}.
    let edge = |k: usize, c: usize| at(k + 1)[c] - at(0)[c];
    let (determinant, inverse) = invert::<D>(edge);
    let volume = determinant / if D == 2 { 2.0 } else { 6.0 };
    let longest = (0..D).map(|k| norm(&std::array::from_fn::<f64, D, _>(|c| edge(k, c)))).fold(0.0, f64::max);
    if !(volume > 1e-14 * longest.powi(D as i32)) {
        let centre = (0..D).map(|c| (0..=D).map(|k| at(k)[c]).sum::<f64>() / (D + 1) as f64).collect();
        return Err(MeshError::Volume { element: number, centre, volume });
    }
    let mut gradients = [[0.0; D]; CORNERS];
    for c in 0..D {
        for k in 0..D {
            gradients[k + 1][c] = inverse[k][c] / determinant;
            gradients[0][c] -= gradients[k + 1][c];
        }
    }
    let mut values = [0.0; CORNERS];
    for k in 0..=D {
        let origin = if k == 0 { 1.0 } else { 0.0 };
        values[k] = origin - (0..D).map(|c| gradients[k][c] * at(0)[c]).sum::<f64>();
    }
    let height = gradients[..=D].iter().map(|g| 1.0 / norm(g)).fold(f64::INFINITY, f64::min);
    Ok(Element { nodes, values, gradients, neighbours: [NONE; CORNERS], volume, height })
}

/// Determinant and adjugate rows of the matrix whose row `k` is edge `k`: `adjugate[k] · edge_j = det δ_kj`.
fn invert<const D: usize>(edge: impl Fn(usize, usize) -> f64) -> (f64, [[f64; D]; D]) {
    let mut rows = [[0.0; D]; D];
    for k in 0..D {
        for c in 0..D {
            let (k1, k2, c1, c2) = ((k + 1) % D, (k + 2) % D, (c + 1) % D, (c + 2) % D);
            rows[k][c] = match D {
                2 if k == c => edge(k1, c1),
                2 => -edge(k1, c1),
                _ => edge(k1, c1) * edge(k2, c2) - edge(k1, c2) * edge(k2, c1),
            };
        }
    }
    ((0..D).map(|c| edge(0, c) * rows[0][c]).sum(), rows)
}

/// Finds the elements across all facets.
fn join<const D: usize>(elements: &mut [Element<D>]) -> Result<(), MeshError> {
    let mut open: HashMap<[u32; CORNERS], (usize, usize, bool)> = HashMap::new();
    for number in 0..elements.len() {
        for opposite in 0..=D {
            let mut key = [NONE; CORNERS];
            let nodes = elements[number].nodes;
            (0..=D).filter(|&k| k != opposite).zip(&mut key).for_each(|(k, node)| *node = nodes[k]);
            key.sort_unstable();
            let Some((other, facet, joined)) = open.insert(key, (number, opposite, false)) else { continue };
            if joined {
                return Err(MeshError::SharedFacet { first: other, second: number });
            }
            elements[number].neighbours[opposite] = other as u32;
            elements[other].neighbours[facet] = number as u32;
            open.insert(key, (number, opposite, true));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn cut<const D: usize>(cells: [usize; D]) -> Mesh<D> {
        Mesh::of_grid(&Grid { origin: [-1.0; D], cell: 0.5, cells }).unwrap()
    }

    #[test]
    fn the_reference_tetrahedron_has_the_height_of_the_sheet() {
        let nodes = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]];
        let mesh = Mesh::new(&nodes, &[vec![0, 1, 2, 3]], &BTreeMap::new()).unwrap();
        assert!((mesh.elements[0].volume - 1.0).abs() < 1e-15);
        assert!((mesh.height() - 0.857_143).abs() < 5e-7, "3 V / A_max, A_max = 3.5");
        let areas: Vec<f64> = (0..4).map(|k| mesh.facet_area(0, k)).collect();
        assert!(areas.iter().any(|a| (a - 3.5).abs() < 1e-14), "{areas:?}");
        // A right triangle: 2 A / l_max.
        let flat =
            Mesh::new(&[[0.0, 0.0], [3.0, 0.0], [0.0, 4.0]], &[vec![0, 1, 2]], &BTreeMap::new()).unwrap();
        assert!((flat.height() - 12.0 / 5.0).abs() < 1e-15);
    }

    #[test]
    fn what_is_cut_from_a_box_fills_it() {
        let flat = cut([4, 3]);
        let volume: f64 = flat.elements.iter().map(|e| e.volume).sum();
        assert!(flat.elements.len() == 24 && (volume - 3.0).abs() < 1e-14);
        assert_eq!(flat.boundary(|_| true).count(), 14);
        let solid = cut([2, 3, 2]);
        let volume: f64 = solid.elements.iter().map(|e| e.volume).sum();
        assert!(solid.elements.len() == 72 && (volume - 12.0 * 0.125).abs() < 1e-14);
        assert_eq!(solid.boundary(|_| true).count(), 2 * 2 * (6 + 4 + 6), "two triangles a face of a cell");
    }

    fn shape_functions<const D: usize>(mesh: &Mesh<D>, x: &[f64; D]) {
        let element = mesh.locate(x).unwrap();
        let n = mesh.barycentric(element, x);
        let e = &mesh.elements[element as usize];
        assert!((n.iter().sum::<f64>() - 1.0).abs() < 1e-13);
        for i in 0..D {
            let place: f64 = (0..=D).map(|k| n[k] * mesh.nodes[e.nodes[k] as usize][i]).sum();
            assert!((place - x[i]).abs() < 1e-13);
            for j in 0..D {
                let unit: f64 = (0..=D).map(|k| mesh.nodes[e.nodes[k] as usize][i] * e.gradients[k][j]).sum();
                assert!((unit - if i == j { 1.0 } else { 0.0 }).abs() < 1e-12);
            }
        }
    }

    proptest! {
        #[test]
        fn linear_fields_are_reproduced(x in proptest::array::uniform3(-1.0..0.5f64)) {
            shape_functions(&cut([3, 3]), &[x[0], x[1]]);
            shape_functions(&cut([3, 3, 3]), &x);
        }

        #[test]
        fn a_walk_ends_where_the_bins_say(start in 0u32..162, x in proptest::array::uniform3(-1.0..0.5f64)) {
            let mesh = cut([3, 3, 3]);
            let found = mesh.walk(start, &x).unwrap();
            prop_assert!(lowest::<3>(&mesh.barycentric(found, &x)).1 >= -TOLERANCE);
            prop_assert_eq!(mesh.walk(start, &[x[0] + 2.0, x[1], x[2]]), None);
        }
    }

    #[test]
    fn bad_meshes_are_refused() {
        let none = BTreeMap::new();
        let nodes = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
        let refuse =
            |nodes: &[[f64; 2]], elements: &[Vec<usize>]| Mesh::new(nodes, elements, &none).unwrap_err();
        assert_eq!(refuse(&nodes, &[]), MeshError::Empty("triangle"));
        assert!(matches!(refuse(&nodes, &[vec![0, 1, 7]]), MeshError::UnknownNode { node: 7, .. }));
        assert!(matches!(refuse(&nodes, &[vec![0, 2, 1]]), MeshError::Volume { .. }), "clockwise");
        let line = [[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]];
        assert!(matches!(refuse(&line, &[vec![0, 1, 2]]), MeshError::Volume { .. }));
        let twice = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 0.0]];
        assert!(matches!(
            refuse(&twice, &[vec![0, 1, 2], vec![0, 3, 2]]),
            MeshError::Duplicate { first: 1, second: 3, .. }
        ));
        let infinite = [[0.0, 0.0], [f64::NAN, 0.0], [0.0, 1.0]];
        assert!(matches!(refuse(&infinite, &[vec![0, 1, 2]]), MeshError::NotFinite { node: 1, .. }));
        let thrice = [vec![0, 1, 2], vec![0, 1, 3], vec![0, 1, 2]];
        assert!(matches!(refuse(&nodes, &thrice), MeshError::SharedFacet { .. }));
    }

    #[test]
    fn nodes_are_numbered_along_the_first_axis_and_groups_follow() {
        let nodes = [[1.0, 0.0], [9.0, 9.0], [0.0, 0.0], [0.0, 1.0]];
        let groups = BTreeMap::from([("left".to_owned(), vec![3, 2, 1])]);
        let mesh = Mesh::new(&nodes, &[vec![2, 0, 3]], &groups).unwrap();
        assert_eq!(mesh.nodes(), [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]]);
        assert_eq!(mesh.group("left"), Some(&[0, 1][..]), "and the node of no element is gone");
    }
}
