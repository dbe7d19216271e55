//! Conformity of a mesh: elements share whole facets with all their nodes, and do not overlap.

use std::collections::{BTreeSet, HashMap};

use crate::mesh::{Mesh, NO_ELEMENT, lowest_entry};

/// Tolerance of a position on an element, over its heights. Nodes of elements that are less flat than that are farther
/// apart, and round-off of coordinates in a text file is smaller.
const INSIDE_TOLERANCE: f64 = 1e-5;

/// Node or element centre at which the mesh is not conforming, because it is inside an element or on one of its facets.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Nonconformity<const D: usize> {
    /// Kind of the nonconformity.
    pub kind: NonconformityKind,
    /// Position (m).
    pub position: [f64; D],
    /// Element that contains the node or centre.
    pub element: u32,
    /// Whether the node is inside the element, and not on a facet.
    pub is_inside: bool,
}

/// Kind of a nonconformity: node, centre of an element, or centre of a facet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum NonconformityKind {
    /// A node that is no corner of the element.
    Node(u32),
    /// A node that lies on a corner of the element, and that corner.
    CoincidentNode(u32, u32),
    /// Centre of another element.
    Centre(u32),
    /// Centre of a boundary facet of another element.
    FacetCentre(u32),
}

/// Elements by the cells that they overlap. Cells are as large as the elements in them, to a factor of two, in as many levels as
/// there are such sizes.
struct ElementCells<const D: usize> {
    levels: BTreeSet<i32>,
    members: HashMap<(i32, [i64; D]), Vec<u32>>,
}

impl<const D: usize> ElementCells<D> {
    /// Sorts the elements of a mesh into cells of a size that is the power of two above their width.
    fn new(mesh: &Mesh<D>) -> Self {
        let mut cells = Self { levels: BTreeSet::new(), members: HashMap::new() };
        for (number, element) in (0..).zip(mesh.elements()) {
            let corners = || element.nodes[..=D].iter().map(|node| mesh.nodes()[*node as usize]);
            let low: [f64; D] =
                std::array::from_fn(|c| corners().map(|x| x[c]).fold(f64::INFINITY, f64::min));
            let high: [f64; D] =
                std::array::from_fn(|c| corners().map(|x| x[c]).fold(f64::NEG_INFINITY, f64::max));
            let width = (0..D).map(|c| high[c] - low[c]).fold(0.0, f64::max);
            let level = width.log2().ceil() as i32;
            let margin = 2.0 * INSIDE_TOLERANCE * width;
            let first = Self::cell(level, &low.map(|c| c - margin));
            let last = Self::cell(level, &high.map(|c| c + margin));
            cells.levels.insert(level);
            cells.insert(level, first, last, number);
        }
        cells
    }

    /// Indices of the cell of a level at a position; cells of a level are `2^level` wide (m).
    fn cell(level: i32, place: &[f64; D]) -> [i64; D] {
        place.map(|c| (c / 2f64.powi(level)).floor() as i64)
    }

    /// Adds an element to all cells of a level between the first and the last index.
    fn insert(&mut self, level: i32, first: [i64; D], last: [i64; D], number: u32) {
        let mut index = first;
        'cells: loop {
            self.members.entry((level, index)).or_default().push(number);
            for c in 0..D {
                if index[c] < last[c] {
                    index[c] += 1;
                    continue 'cells;
                }
                index[c] = first[c];
            }
            break;
        }
    }

    /// Elements that may contain a position.
    fn candidates(&self, place: &[f64; D]) -> impl Iterator<Item = u32> {
        let list = |level: &i32| self.members.get(&(*level, Self::cell(*level, place)));
        self.levels.iter().filter_map(list).flatten().copied()
    }
}

impl<const D: usize> Mesh<D> {
    /// First position where the mesh does not conform.
    pub(crate) fn first_nonconformity(&self) -> Option<Nonconformity<D>> {
        let cells = ElementCells::new(self);
        let within = |position: &[f64; D], but: &dyn Fn(u32) -> bool| {
            let holds = |e: &u32| {
                !but(*e) && lowest_entry::<D>(&self.barycentric(*e, position)).1 >= -INSIDE_TOLERANCE
            };
            cells.candidates(position).find(holds)
        };
        let clash = |what: NonconformityKind, position: [f64; D], within: u32| {
            let is_inside = lowest_entry::<D>(&self.barycentric(within, &position)).1 > INSIDE_TOLERANCE;
            Nonconformity { kind: what, position, element: within, is_inside }
        };
        let of_node = |node: u32| {
            let position = self.nodes()[node as usize];
            let corners = |e: u32| &self.elements()[e as usize].nodes[..=D];
            let found = within(&position, &|e| corners(e).contains(&node))?;
            let shares = self.barycentric(found, &position);
            let twin = corners(found).iter().zip(shares).find(|(_, share)| *share > 1.0 - INSIDE_TOLERANCE);
            let what = twin.map_or(NonconformityKind::Node(node), |(corner, _)| {
                NonconformityKind::CoincidentNode(node, *corner)
            });
            Some(clash(what, position, found))
        };
        let of_centre = |element: u32| {
            let position = self.element_point(element, &[1.0 / (D as f64 + 1.0); 4][..=D]);
            Some(clash(NonconformityKind::Centre(element), position, within(&position, &|e| e == element)?))
        };
        let of_facets = |element: u32| {
            (0..=D).filter(|k| self.elements()[element as usize].neighbours[*k] == NO_ELEMENT).find_map(|k| {
                let mut shares = [1.0 / D as f64; 4];
                shares[k] = 0.0;
                let position = self.element_point(element, &shares[..=D]);
                Some(clash(
                    NonconformityKind::FacetCentre(element),
                    position,
                    within(&position, &|e| e == element)?,
                ))
            })
        };
        let all = || 0..self.elements().len() as u32;
        let found = (0..self.nodes().len() as u32).find_map(of_node);
        found.or_else(|| all().find_map(of_centre)).or_else(|| all().find_map(of_facets))
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::Grid;

    fn nonconformity<const D: usize>(
        nodes: &[[f64; D]],
        elements: &[Vec<usize>],
    ) -> Option<Nonconformity<D>> {
        Mesh::new(nodes, elements, &BTreeMap::new()).unwrap().first_nonconformity()
    }

    #[test]
    fn meshes_of_grids_and_graded_meshes_conform() {
        let flat = Mesh::of_grid(&Grid { origin: [1e5, -3.0], cell: 0.3, cells: [30, 20] }).unwrap();
        assert_eq!(flat.first_nonconformity(), None);
        let solid = Mesh::of_grid(&Grid { origin: [0.1; 3], cell: 0.7, cells: [6, 5, 4] }).unwrap();
        assert_eq!(solid.first_nonconformity(), None);
        // A fan whose triangles become half as large in each step.
        let mut nodes = vec![[0.0, 0.0]];
        nodes.extend((0..20).map(|k| [0.5f64.powi(k), 0.0]));
        nodes.extend((0..20).map(|k| [0.5f64.powi(k), 0.5f64.powi(k)]));
        let mut elements = vec![vec![0, 20, 40]];
        (1..20).for_each(|k| elements.extend([vec![k + 1, k, k + 20], vec![k + 1, k + 20, k + 21]]));
        assert_eq!(nonconformity(&nodes, &elements), None);
    }

    #[test]
    fn hanging_nodes_are_reported_as_nonconforming() {
        // A square of two triangles with half a square at its right side, whose node 4 is a hanging node.
        let nodes = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [1.0, 0.5], [2.0, 0.0]];
        let found = nonconformity(&nodes, &[vec![0, 1, 2], vec![0, 2, 3], vec![1, 5, 4]]).unwrap();
        assert!(matches!(found.kind, NonconformityKind::Node(_)) && !found.is_inside, "{found:?}");
        assert_eq!(found.position, [1.0, 0.5]);
    }

    #[test]
    fn coincident_nodes_and_overlapping_elements_are_reported_as_nonconforming() {
        let twin = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0 + 1e-9, 0.0], [1.0, 1.0]];
        let found = nonconformity(&twin, &[vec![0, 1, 2], vec![3, 4, 2]]).unwrap();
        assert!(matches!(found.kind, NonconformityKind::CoincidentNode(..)), "{found:?}");
        let over = [[0.0, 0.0], [4.0, 0.0], [0.0, 4.0], [1.0, 1.0], [1.5, 1.0], [1.0, 1.5]];
        let found = nonconformity(&over, &[vec![0, 1, 2], vec![3, 4, 5]]).unwrap();
        assert!(matches!(found.kind, NonconformityKind::Node(_)) && found.is_inside, "{found:?}");
        // A star of two triangles, with no corner of either in the other.
        let star = [[0.0, 0.0], [6.0, 0.0], [3.0, 5.0], [3.0, -2.0], [6.0, 3.5], [0.0, 3.5]];
        let found = nonconformity(&star, &[vec![0, 1, 2], vec![3, 4, 5]]).unwrap();
        assert!(matches!(found.kind, NonconformityKind::Centre(_)), "{found:?}");
    }

    #[test]
    fn facets_split_along_different_diagonals_are_reported_as_nonconforming() {
        // Half cubes with common nodes at x = 1 and crossing diagonals there.
        let nodes = [
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [1.0, 1.0, 1.0],
            [1.0, 0.0, 1.0],
            [0.0, 0.5, 0.5],
            [2.0, 0.5, 0.5],
        ];
        let left = [vec![0, 1, 2, 4], vec![0, 2, 3, 4]];
        let right = |a: [usize; 3], b: [usize; 3]| [a, b].map(|[a, b, c]| vec![a, c, b, 5]);
        let turned = |tets: Vec<Vec<usize>>| -> Vec<Vec<usize>> {
            let volume = |t: &[usize]| {
                let edge =
                    |k: usize| -> [f64; 3] { std::array::from_fn(|c| nodes[t[k]][c] - nodes[t[0]][c]) };
                let [a, b, c] = [edge(1), edge(2), edge(3)];
                a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
                    + a[2] * (b[0] * c[1] - b[1] * c[0])
            };
            tets.into_iter()
                .map(|mut t| {
                    if volume(&t) < 0.0 {
                        t.swap(0, 1);
                    }
                    t
                })
                .collect()
        };
        let same = turned([left.clone(), right([0, 1, 2], [0, 2, 3])].concat());
        assert_eq!(nonconformity(&nodes, &same), None);
        let other = turned([left, right([1, 2, 3], [1, 3, 0])].concat());
        assert!(matches!(nonconformity(&nodes, &other).unwrap().kind, NonconformityKind::FacetCentre(_)));
    }
}
