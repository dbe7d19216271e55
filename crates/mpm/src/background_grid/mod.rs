//! Background grid: grid or mesh, layout of the nodes, shape functions, cells that average.
//!
//! It is constant during a step, apart from the active nodes, which a sort finds. The module knows the options and the case; all other
//! modules of the method may know it.

pub(crate) mod averaging_cells;
pub(crate) mod dimension_dispatch;
pub(crate) mod structured_grid;
pub(crate) mod unstructured_mesh;

use std::sync::Arc;

use colluvium_case::Case;
use colluvium_case::description::Space;
use colluvium_grid::{Basis1d, DomainSlice, Grid, GridView, InterpolatedMotion, Layout, Mesh, Transfers};

use crate::background_grid::averaging_cells::{GridCells, MeshCells};
use crate::background_grid::dimension_dispatch::SelectedTransfers;

/// Background grid of all points.
pub struct BackgroundGrid<const D: usize> {
    /// Structured grid; for an unstructured mesh the grid of its bounding box.
    pub grid: Grid<D>,
    /// The mesh; empty on a structured grid.
    pub mesh: Arc<Mesh<D>>,
    /// Arrangement of the nodes in memory, and the nodes that have been active since the last sort.
    pub layout: Layout<D>,
    /// The elements of the mesh; `None` on a structured grid, whose cells are named by their lowest nodes.
    pub elements: Option<Layout<D>>,
    /// Transfers between points and grid.
    pub transfers: &'static dyn Transfers<D>,
    /// Transfers with linear functions, for any shape; on a grid.
    pub linear_transfers: &'static dyn Transfers<D>,
    /// The shape functions along an axis.
    pub basis_1d: Basis1d,
    /// Upper corner of the grid (m).
    pub upper_corner: [f64; D],
    /// Axes along which the domain is periodic.
    pub periodic: [bool; D],
    /// Whether the first axis is a radius.
    pub axisymmetric: bool,
}

impl<const D: usize> BackgroundGrid<D> {
    /// Returns the background grid of a case.
    pub fn new(
        case: &Case,
        SelectedTransfers { transfers, linear }: SelectedTransfers<D>,
        (grid, mesh, layout): (Grid<D>, Arc<Mesh<D>>, Layout<D>),
    ) -> Self {
        Self {
            elements: (!mesh.is_empty()).then(|| Layout::of_elements(&mesh, &grid)),
            basis_1d: transfers.basis_1d(),
            upper_corner: grid.upper(),
            periodic: std::array::from_fn(|axis| case.domain.is_periodic(axis)),
            axisymmetric: case.space == Space::Axisymmetric,
            transfers,
            linear_transfers: linear,
            grid,
            mesh,
            layout,
        }
    }

    /// View of the grid for point domains and transfers.
    #[inline(always)]
    pub fn grid_view(&self) -> GridView<'_, D> {
        GridView::new(&self.grid, &self.mesh, &self.layout)
    }

    /// Whether the background is a mesh.
    #[inline(always)]
    pub fn is_meshed(&self) -> bool {
        self.elements.is_some()
    }

    /// Layout of arrays with an entry a cell.
    #[inline(always)]
    pub fn cell_layout(&self) -> &Layout<D> {
        self.elements.as_ref().unwrap_or(&self.layout)
    }

    /// The cells of the grid.
    pub fn grid_cells(&self) -> GridCells<'_, D> {
        let (strides, ghosts) = (self.layout.strides(), self.basis_1d.ghosts);
        GridCells { grid: &self.grid, strides, ghosts, axisymmetric: self.axisymmetric }
    }

    /// The elements of the mesh.
    pub fn mesh_cells(&self) -> MeshCells<'_, D> {
        MeshCells { mesh: &self.mesh, axisymmetric: self.axisymmetric }
    }

    /// Cell size at a point (m), which is its effective size for laws with an internal length (sheet: constitutive §2.16). For an element
    /// it is that of the square or cube which elements of its volume fill.
    #[inline(always)]
    pub fn edge(&self, domains: &DomainSlice<'_, D>, p: usize, position: &[f64; D]) -> f64 {
        if !self.is_meshed() {
            return self.grid.cell;
        }
        let volume = self.mesh.elements()[domains.cell(p, &self.grid_view(), position)].volume;
        if D == 2 { (2.0 * volume).sqrt() } else { (6.0 * volume).cbrt() }
    }

    /// Number of normal strains.
    #[inline(always)]
    pub fn normal_strains(&self) -> usize {
        if self.axisymmetric { 3 } else { D }
    }

    /// Rate of volumetric strain (1/s) from the interpolated values of a point at a radius (m; used in axisymmetry).
    #[inline(always)]
    pub fn dilation(&self, read: &InterpolatedMotion<D>, radius: f64) -> f64 {
        let trace: f64 = (0..D).map(|j| read.gradient[j].as_array()[j]).sum();
        trace + if self.axisymmetric { read.velocity.as_array()[0] / radius } else { 0.0 }
    }

    /// Position of a node (m), by its number in memory and its index along the axes.
    pub fn node_at(&self, number: usize, index: &[usize; 3]) -> [f64; 3] {
        let mut place = [0.0; 3];
        if self.is_meshed() {
            if let Some(x) = self.mesh.nodes().get(number) {
                place[..D].copy_from_slice(x);
            }
            return place;
        }
        for a in 0..D {
            place[a] =
                self.grid.origin[a] + self.grid.cell * self.basis_1d.coordinate(index[a], self.grid.cells[a]);
        }
        place
    }

    /// Least distance between nodes (m).
    pub fn spacing(&self) -> f64 {
        if self.is_meshed() { self.mesh.height() } else { self.grid.cell }
    }
}
