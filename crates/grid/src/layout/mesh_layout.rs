//! Layout of the nodes and elements of a mesh, which are numbered along its first axis.

use crate::layout::{Layout, SORT_MARGIN};
use crate::{Grid, Mesh};

impl<const D: usize> Layout<D> {
    /// Returns the layout of the nodes of a mesh in the box `grid` of cells as large as its largest element. Rows are ranges of
    /// node numbers, and all are active; slabs are those of the box, as the element of a point extends over at most a cell.
    pub fn of_mesh(mesh: &Mesh<D>, grid: &Grid<D>) -> Self {
        Self::from_lowest_coordinates(grid, &mesh.nodes().iter().map(|x| x[0]).collect::<Vec<f64>>())
    }

    /// Layout of the elements of a mesh, with the slabs of [`Layout::of_mesh`]; its entries are element numbers.
    pub fn of_elements(mesh: &Mesh<D>, grid: &Grid<D>) -> Self {
        let lowest =
            |nodes: &[u32]| nodes.iter().map(|&n| mesh.nodes()[n as usize][0]).fold(f64::INFINITY, f64::min);
        let elements = mesh.elements().iter();
        Self::from_lowest_coordinates(
            grid,
            &elements.map(|element| lowest(&element.nodes[..=D])).collect::<Vec<f64>>(),
        )
    }

    /// Layout of items that extend over at most one cell along the first axis, from their ascending lowest coordinates (m).
    fn from_lowest_coordinates(grid: &Grid<D>, lowest: &[f64]) -> Self {
        let line = if D == 2 { [64, 1] } else { [8, 8] };
        let count = lowest.len();
        let row = line[0] * line[1];
        let nodes = std::array::from_fn(|axis| if axis == 0 { count.div_ceil(row) } else { line[axis - 1] });
        let strides = std::array::from_fn(|axis| {
            if axis == 0 {
                row
            } else if axis == 1 {
                line[1]
            } else {
                1
            }
        });
        let slab_cells = 2 * (1 + SORT_MARGIN);
        let start = |slab: usize| {
            let cells = (slab * slab_cells) as f64 - (1 + SORT_MARGIN) as f64;
            let bound = grid.origin[0] + cells * grid.cell;
            lowest.partition_point(|x| *x < bound)
        };
        let slabs = grid.cells[0].div_ceil(slab_cells);
        let rows = 0..nodes[0];
        Self {
            grid: *grid,
            nodes,
            strides,
            ghosts: 0,
            nodes_below: 1,
            nodes_above: 1,
            slab_cells,
            active_nodes: rows.map(|k| 0..row.min(count - k * row)).collect(),
            window_starts: (0..slabs).map(start).collect(),
            period: [0; D],
        }
    }
}
