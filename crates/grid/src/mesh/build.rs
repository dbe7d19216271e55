//! Construction of a [`Mesh`] from nodes and elements, or from the cells of a grid.

use std::collections::{BTreeMap, HashMap};

use thiserror::Error;

use super::{CORNERS, Element, ElementBins, Mesh, NO_ELEMENT, NodeElements, norm};
use crate::Grid;

/// Reason why a mesh cannot be used.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum MeshError {
    /// No nodes or elements.
    #[error("has no {0}")]
    Empty(&'static str),
    /// An element refers to an unknown node.
    #[error("element {element} has the node {node}, but the mesh has only {nodes} nodes")]
    UnknownNode {
        /// Number of the element.
        element: usize,
        /// Unknown node number.
        node: usize,
        /// Number of nodes.
        nodes: usize,
    },
    /// A node with a coordinate that is not finite.
    #[error("node {node} lies at {position:?} m")]
    NotFinite {
        /// Number of the node.
        node: usize,
        /// Coordinates of the node (m).
        position: Vec<f64>,
    },
    /// An element without volume, or inverted.
    #[error(
        "element {element} around {centre:?} m has the volume {volume:.3e}: it must be positive (corners in the wrong order, or flat)"
    )]
    Volume {
        /// Number of the element.
        element: usize,
        /// Centre of the element (m).
        centre: Vec<f64>,
        /// Volume of the element (m³; m² in the plane).
        volume: f64,
    },
    /// Two nodes at the same position.
    #[error("nodes {first} and {second} lie at the same place {position:?} m")]
    Duplicate {
        /// Number of the first node.
        first: usize,
        /// Number of the second node.
        second: usize,
        /// Position of both (m).
        position: Vec<f64>,
    },
    /// A facet of three elements or more.
    #[error("elements around {first:?} m and {second:?} m share a facet with a third element")]
    SharedFacet {
        /// Centre of one element (m).
        first: Vec<f64>,
        /// Centre of another (m).
        second: Vec<f64>,
    },
}

impl MeshError {
    /// Stable code of the error, which `docs/messages.md` of the repository explains.
    #[must_use]
    pub fn code(&self) -> &'static str {
        "mesh"
    }
}

impl<const D: usize> Mesh<D> {
    /// Returns the mesh of `elements` with `D + 1` node numbers each, and of named groups of nodes. Nodes without
    /// an element are removed.
    ///
    /// # Errors
    /// When elements are flat or inverted, nodes coincide, or facets belong to more than two elements.
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
        let (order, number_of) = renumber_nodes(nodes, elements);
        let nodes: Vec<[f64; D]> = order.iter().map(|&old| nodes[old]).collect();
        check_nodes(&nodes, &order)?;
        let mut built = Vec::with_capacity(elements.len());
        for number in along_first_axis(elements, &number_of) {
            built.push(element(&nodes, elements[number].iter().map(|old| number_of[old]), number)?);
        }
        link_neighbours(&mut built, &nodes)?;
        let around = NodeElements::from_elements(&built, nodes.len());
        let groups = groups.iter().map(|(name, members)| {
            let mut members: Vec<u32> =
                members.iter().filter_map(|old| number_of.get(old).copied()).collect();
            members.sort_unstable();
            members.dedup();
            (name.clone(), members)
        });
        let mut mesh =
            Self { groups: groups.collect(), nodes, elements: built, node_elements: around, bins: None };
        mesh.bins = Some(mesh.make_bins());
        Ok(mesh)
    }

    /// Mesh of the cells of a grid, each divided into two triangles or six tetrahedra: one for each order of the axes on a path from the
    /// lowest to the highest corner (Kuhn's triangulation).
    ///
    /// # Errors
    /// As [`Mesh::new`]; the elements of a grid fulfil its conditions.
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
            for (axes, even) in axis_permutations::<D>() {
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

    /// Sorts the elements into cells as wide as the largest element, for the search of the element at a position.
    fn make_bins(&self) -> ElementBins<D> {
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
            // A little wider, so that round-off excludes no point of the element.
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
        let mut bin_offsets = vec![0];
        for list in &members {
            bin_offsets.push(bin_offsets[bin_offsets.len() - 1] + list.len() as u32);
        }
        ElementBins { grid, bin_offsets, elements: members.concat() }
    }
}

/// Permutations of `D` axes, and whether each is even.
fn axis_permutations<const D: usize>() -> Vec<([usize; D], bool)> {
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

/// Nodes of the elements in the order of their coordinates, with the new number of each.
fn renumber_nodes<const D: usize>(
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

/// Elements in the order of their lowest node, so that slabs of the mesh are ranges of elements.
fn along_first_axis(elements: &[Vec<usize>], number_of: &HashMap<usize, u32>) -> Vec<usize> {
    let mut order: Vec<usize> = (0..elements.len()).collect();
    order.sort_by_key(|&element| elements[element].iter().map(|old| number_of[old]).min());
    order
}

impl NodeElements {
    /// Returns the elements around each of `nodes` nodes.
    fn from_elements<const D: usize>(elements: &[Element<D>], nodes: usize) -> Self {
        let corners =
            || (0..).zip(elements).flat_map(|(e, element)| element.nodes[..=D].iter().map(move |&n| (e, n)));
        let mut row_offsets = vec![0; nodes + 1];
        corners().for_each(|(_, node)| row_offsets[node as usize + 1] += 1);
        for node in 0..nodes {
            row_offsets[node + 1] += row_offsets[node];
        }
        let mut place = row_offsets.clone();
        let mut members = vec![0; row_offsets[nodes] as usize];
        for (element, node) in corners() {
            members[place[node as usize] as usize] = element;
            place[node as usize] += 1;
        }
        Self { row_offsets, elements: members }
    }
}

/// Requires finite positions, sorted so that equal ones are adjacent, without duplicates.
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

/// Element of its corner nodes with volume and gradients of the shape functions; an error if it is degenerate.
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
        return Err(MeshError::Volume { element: number, centre: centre(at), volume });
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
    Ok(Element { nodes, values, gradients, neighbours: [NO_ELEMENT; CORNERS], volume, height })
}

/// Centre of an element with its corners at `at` (m).
fn centre<const D: usize>(at: impl Fn(usize) -> [f64; D]) -> Vec<f64> {
    (0..D).map(|c| (0..=D).map(|k| at(k)[c]).sum::<f64>() / (D + 1) as f64).collect()
}

/// Determinant of the matrix whose row `k` is edge `k`, and rows of its adjugate: `adjugate[k] · edge_j = det δ_kj`.
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

/// Links elements across their common facets.
fn link_neighbours<const D: usize>(
    elements: &mut [Element<D>],
    places: &[[f64; D]],
) -> Result<(), MeshError> {
    let mut open: HashMap<[u32; CORNERS], (usize, usize, bool)> = HashMap::new();
    for number in 0..elements.len() {
        for opposite in 0..=D {
            let mut key = [NO_ELEMENT; CORNERS];
            let nodes = elements[number].nodes;
            (0..=D).filter(|&k| k != opposite).zip(&mut key).for_each(|(k, node)| *node = nodes[k]);
            key.sort_unstable();
            let Some((other, facet, joined)) = open.insert(key, (number, opposite, false)) else { continue };
            if joined {
                let [first, second] =
                    [other, number].map(|e| centre(|k| places[elements[e].nodes[k] as usize]));
                return Err(MeshError::SharedFacet { first, second });
            }
            elements[number].neighbours[opposite] = other as u32;
            elements[other].neighbours[facet] = number as u32;
            open.insert(key, (number, opposite, true));
        }
    }
    Ok(())
}
