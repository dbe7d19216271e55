//! Background grid: the grid around the domain, the order of the nodes, the shape functions. A step only reads it.
//!
//! The grid is some cells wider than the domain on every side. All shape functions of points in the domain are therefore those of an
//! unbounded grid: their second moment, on which APIC depends, is constant, and they are a partition of unity at walls too (sheet:
//! snow-mpm §3.3, P16). Nodes are at multiples of the cell size from the corner of the domain.

use colluvium_grid::{
    Basis1d, Grid, GridError, GridView, Layout, Mesh, NodalState, ShapeFunctionKind, Transfers,
};

use crate::config::SplineShape;

/// Number of grid cells outside the domain at each end.
const MARGIN_CELLS: f64 = 4.0;

/// Background grid of all points.
pub struct BackgroundGrid<const D: usize> {
    /// Grid, wider than the domain.
    pub grid: Grid<D>,
    /// Layout of the nodes, with the active nodes since the last sort.
    pub layout: Layout<D>,
    /// Transfers between points and grid.
    pub transfers: &'static dyn Transfers<D>,
    /// Shape functions along an axis.
    pub basis_1d: Basis1d,
    /// Lower corner of the domain (m).
    pub low: [f64; D],
    /// Upper corner of the domain (m).
    pub upper_corner: [f64; D],
    /// Whether the domain is periodic along each axis.
    pub periodic: [bool; D],
    /// Empty mesh: the grid is structured.
    mesh: Mesh<D>,
}

/// Kind of the shape functions in the grid crate.
pub fn shape_function_kind(chosen: SplineShape) -> ShapeFunctionKind {
    match chosen {
        SplineShape::Cubic => ShapeFunctionKind::Cubic,
        SplineShape::Quadratic => ShapeFunctionKind::Quadratic,
        SplineShape::Linear => ShapeFunctionKind::Linear,
    }
}

impl<const D: usize> BackgroundGrid<D> {
    /// Background grid of a domain with given corners and cell size (m).
    ///
    /// # Errors
    /// When the domain is not a whole number of cells wide, or the grid too large.
    pub fn new(
        [low, upper_corner]: [[f64; D]; 2],
        cell: f64,
        sweeps: &'static dyn Transfers<D>,
    ) -> Result<Self, GridError> {
        Grid::new(low, upper_corner, cell)?;
        let axis = sweeps.basis_1d();
        // Nodes of an odd number of functions a cell lie at the centres of its grid's cells.
        let margin = MARGIN_CELLS - (axis.coordinate(5, 12) - axis.coordinate(5, 12).floor());
        let wide = margin * cell;
        let grid = Grid::new(low.map(|x| x - wide), upper_corner.map(|x| x + wide), cell)?;
        let layout = Layout::with_basis(&grid, &axis);
        Ok(Self {
            grid,
            layout,
            transfers: sweeps,
            basis_1d: axis,
            low,
            upper_corner,
            periodic: [false; D],
            mesh: Mesh::default(),
        })
    }

    /// Background grid with periodic axes, along which nodes one domain width apart are identical.
    ///
    /// # Errors
    /// The number of cells that the domain needs along a periodic axis, where it has fewer.
    pub fn with_periodic_axes(mut self, periodic: [bool; D]) -> Result<Self, usize> {
        let period =
            |axis: usize| ((self.upper_corner[axis] - self.low[axis]) / self.grid.cell).round() as usize;
        // The grid is wider than the domain by the same length along all axes.
        let smallest = self.layout.nodes()[0] - period(0);
        let periods = std::array::from_fn(|axis| if periodic[axis] { period(axis) } else { 0 });
        self.layout = self.layout.with_period(periods).ok_or(smallest)?;
        self.periodic = periodic;
        Ok(self)
    }

    /// Sums the values of nodes that are identical in a periodic domain, and copies the sum to all of them.
    pub fn sum_periodic_images(&self, nodes: &mut [NodalState]) {
        if self.periodic != [false; D] {
            self.layout.sum_periodic_images(nodes, |sum, node| {
                sum.momentum_and_mass += node.momentum_and_mass;
                sum.force += node.force;
            });
        }
    }

    /// Whether a node is the periodic image of a node of lower index, which sums over nodes omit.
    #[inline(always)]
    pub fn is_periodic_image(&self, index: &[usize; 3]) -> bool {
        self.periodic != [false; D] && self.layout.is_periodic_image(index)
    }

    /// Whether a position (m) is in the domain; false for not-a-number.
    pub fn contains(&self, place: &[f64; D]) -> bool {
        (0..D).all(|axis| place[axis] >= self.low[axis] && place[axis] <= self.upper_corner[axis])
    }

    /// View of the grid for the transfers of points.
    #[inline(always)]
    pub fn grid_view(&self) -> GridView<'_, D> {
        GridView::new(&self.grid, &self.mesh, &self.layout)
    }

    /// Position of a node (m).
    pub fn node_position(&self, index: &[usize; 3]) -> [f64; 3] {
        let mut place = [0.0; 3];
        for axis in 0..D {
            let along = self.basis_1d.coordinate(index[axis], self.grid.cells[axis]);
            place[axis] = self.grid.origin[axis] + self.grid.cell * along;
        }
        place
    }

    /// Largest distance of a position outside the domain along an axis (cells); not positive inside. Periodic axes do not count.
    #[inline]
    pub fn distance_outside(&self, place: &[f64; D]) -> f64 {
        let beyond = |axis: usize| (self.low[axis] - place[axis]).max(place[axis] - self.upper_corner[axis]);
        (0..D).filter(|axis| !self.periodic[*axis]).map(beyond).fold(f64::NEG_INFINITY, f64::max)
            / self.grid.cell
    }

    /// Number of the last node along `axis` at or below the coordinate `place` (m).
    pub fn node_below(&self, axis: usize, place: f64) -> usize {
        let local = (place - self.grid.origin[axis]) / self.grid.cell + 1e-6;
        let cells = self.grid.cells[axis];
        let lies_below = |node: &usize| self.basis_1d.coordinate(*node, cells) <= local;
        (0..self.basis_1d.nodes(cells)).take_while(lies_below).last().unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn background(shape: ShapeFunctionKind) -> BackgroundGrid<2> {
        BackgroundGrid::new([[1.0, -2.0], [3.0, 1.0]], 0.25, shape.in_plane().unwrap()).unwrap()
    }

    #[test]
    fn nodes_lie_on_multiples_of_the_cell_from_the_corner() {
        for shape in [ShapeFunctionKind::Cubic, ShapeFunctionKind::Quadratic, ShapeFunctionKind::Linear] {
            let ground = background(shape);
            let node = ground.node_below(1, -2.0);
            let place = |node: usize| {
                ground.grid.origin[1] + 0.25 * ground.basis_1d.coordinate(node, ground.grid.cells[1])
            };
            assert!((place(node) + 2.0).abs() < 1e-12, "{shape:?}: {}", place(node));
            assert_eq!(ground.node_below(1, -1.9), node);
            assert_eq!(ground.node_below(1, -1.74), node + 1);
        }
    }

    #[test]
    fn second_moments_are_the_same_at_sides_and_a_cell_beyond_them() {
        for (shape, moment) in [(ShapeFunctionKind::Cubic, 1.0 / 3.0), (ShapeFunctionKind::Quadratic, 0.25)] {
            let ground = background(shape);
            let place = [[1.0, -2.0], [2.99, 0.999], [0.76, 1.24], [2.1, -0.3], [3.24, -2.24]];
            let domain = ground.transfers.domains(place.len());
            let points =
                colluvium_grid::PointSlice { position: &place, domain: domain.as_slice(), extent: &[0.1; 2] };
            let mut squares = [[0.0; 2]; 5];
            ground.transfers.second_moments(&ground.grid_view(), &points, &mut squares);
            for square in squares.as_flattened() {
                assert!((square / 0.0625 - moment).abs() < 1e-12, "{shape:?} {squares:?}");
            }
        }
    }
}
