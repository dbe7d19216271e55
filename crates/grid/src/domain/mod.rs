//! Domains of points: what a point knows of the space around it, and so on which nodes it stands (sheet: mpm §2.5).

mod contiguous_gimp_domains;
mod convected_domains;
mod domain_columns;
mod element_domain;
mod reference_domain;

#[cfg(test)]
mod tests;

pub use crate::domain::contiguous_gimp_domains::{RightStretchDomain, StretchingDomain};
pub use crate::domain::convected_domains::{ConvectedDomain, ConvectedQuadrilateral};
pub use crate::domain::domain_columns::{DomainSlice, Domains, DomainsMut};
pub use crate::domain::element_domain::ElementDomain;
pub use crate::domain::reference_domain::ReferenceDomain;

use crate::{Basis, Grid, Layout, Mesh, NodeSupport, Stencil};

/// A matrix of the space, row by row.
pub type SquareMatrix<const D: usize> = [[f64; D]; D];

/// Diagonal of the right stretch tensor of a deformation gradient. The grid has no tensors; who uses domains that turn brings
/// theirs.
pub type RightStretchDiagonal<const D: usize> = fn(&SquareMatrix<D>) -> [f64; D];

/// Where points find their nodes.
#[derive(Clone, Copy)]
pub struct GridView<'a, const D: usize> {
    /// The structured grid; with a mesh the box of cells around it.
    pub grid: &'a Grid<D>,
    /// The mesh; empty on a structured grid.
    pub mesh: &'a Mesh<D>,
    /// Distance in memory between neighbouring nodes along each axis.
    pub strides: [usize; D],
    /// Layers of nodes outside the domain.
    pub ghosts: usize,
}

impl<'a, const D: usize> GridView<'a, D> {
    /// The nodes of `layout` on a grid, or on a mesh that is not empty.
    pub fn new(grid: &'a Grid<D>, mesh: &'a Mesh<D>, layout: &Layout<D>) -> Self {
        Self { grid, mesh, strides: layout.strides(), ghosts: layout.ghosts() }
    }

    /// Number of the lowest node of the cell that holds `position` (m).
    #[inline(always)]
    pub fn lowest_node(&self, position: &[f64; D]) -> usize {
        let cell = self.grid.cell_of(position);
        (0..D).map(|axis| (cell[axis] + self.ghosts) * self.strides[axis]).sum()
    }
}

/// What a point knows of its own domain, beyond the initial width all points of a body share, and the nodes it
/// stands on by that.
pub trait PointDomain<const D: usize>: Copy + Default + Send + Sync + 'static {
    /// The nodes of a point: `S` per axis, or `S` in all where they are no product over the axes.
    type Support<const S: usize>: NodeSupport<D>;

    /// Whether it changes in the course of a run.
    const DEFORMS: bool = true;

    /// Whether points look at the grid from where they were at the start (total-Lagrangian).
    const REFERENCE_CONFIGURATION: bool = false;

    /// Whether corners move with the grid where they are ([`PointDomain::convect`]).
    const CONVECTS_CORNERS: bool = false;

    /// Numbers to keep of each in a checkpoint.
    const CHECKPOINT_NUMBERS: usize;

    /// The column of this type.
    fn typed_column<'a>(column: &DomainSlice<'a, D>) -> &'a [Self];

    /// Such a column, of points that have not moved yet.
    fn new_column(count: usize) -> Domains<D>;

    /// The nodes of a point at `position` (m) with initial full widths `initial` (m).
    fn support<const S: usize, B: Basis<S>>(
        &self,
        ground: &GridView<'_, D>,
        position: &[f64; D],
        initial: &[f64; D],
    ) -> Self::Support<S>;

    /// Entry, in arrays with one a cell, of the cell that a point at `position` (m) is in: the number of the cell's lowest
    /// node, or of the element.
    #[inline(always)]
    fn cell(&self, ground: &GridView<'_, D>, position: &[f64; D]) -> usize {
        ground.lowest_node(&self.evaluation_position(position))
    }

    /// Full widths (m) from the initial ones, on cells of edge `cell`.
    fn extent(&self, initial: &[f64; D], cell: f64) -> [f64; D];

    /// Takes its place in the initial state.
    ///
    /// # Errors
    /// When there is none, as a reason.
    fn initialise(&mut self, _ground: &GridView<'_, D>, _position: &[f64; D]) -> Result<(), String> {
        Ok(())
    }

    /// Where a point at `position` looks at the grid from (m).
    #[inline(always)]
    fn evaluation_position(&self, position: &[f64; D]) -> [f64; D] {
        *position
    }

    /// Least distance between nodes around the point (m), on which the time step depends.
    #[inline(always)]
    fn spacing(&self, ground: &GridView<'_, D>) -> f64 {
        ground.grid.cell
    }

    /// Takes its place after a move; of use on a mesh only.
    ///
    /// # Errors
    /// When there is none, as a reason.
    #[inline(always)]
    fn relocate(&mut self, _ground: &GridView<'_, D>, _position: &[f64; D]) -> Result<(), String> {
        Ok(())
    }

    /// Follows the step `f = 1 + gradient` (row `i`, column `j`: `∂u_i/∂x_j`).
    #[inline(always)]
    fn update_deformation(&mut self, _gradient: &SquareMatrix<D>, _right_stretch: RightStretchDiagonal<D>) {}

    /// Moves the corners with the velocity that `read` finds at a place (m), in a step of `dt` (s) in which the point moves
    /// with `velocity` (m/s).
    #[inline(always)]
    fn convect(
        &mut self,
        _position: &[f64; D],
        _initial: &[f64; D],
        _velocity: &[f64; D],
        _dt: f64,
        _read: impl Fn(&[f64; D]) -> [f64; D],
    ) {
    }

    /// Why the domain can no longer be honoured, if so.
    #[inline(always)]
    fn validity_error(&self, _initial: &[f64; D], _cell: f64) -> Option<String> {
        None
    }

    /// Appends the [`PointDomain::CHECKPOINT_NUMBERS`] numbers to keep in a checkpoint.
    fn append_numbers(self, numbers: &mut Vec<f64>);

    /// From the numbers of [`PointDomain::append_numbers`].
    fn from_numbers(numbers: &[f64], right_stretch: RightStretchDiagonal<D>) -> Self;
}

/// A domain that keeps its size (and shape functions that do not look at it).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FixedDomain;

impl<const D: usize> PointDomain<D> for FixedDomain {
    type Support<const S: usize> = Stencil<D, S>;

    const DEFORMS: bool = false;
    const CHECKPOINT_NUMBERS: usize = 0;

    domain_columns::domain_column!(Fixed);

    #[inline(always)]
    fn support<const S: usize, B: Basis<S>>(
        &self,
        ground: &GridView<'_, D>,
        position: &[f64; D],
        initial: &[f64; D],
    ) -> Stencil<D, S> {
        Stencil::new::<B>(ground.grid, position, initial)
    }

    #[inline(always)]
    fn extent(&self, initial: &[f64; D], _cell: f64) -> [f64; D] {
        *initial
    }

    fn append_numbers(self, _numbers: &mut Vec<f64>) {}

    fn from_numbers(_numbers: &[f64], _right_stretch: RightStretchDiagonal<D>) -> Self {
        Self
    }
}

fn identity<const D: usize>() -> SquareMatrix<D> {
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }))
}

/// `F ← (1 + gradient) F`.
#[inline(always)]
fn update_deformation<const D: usize>(deformation: &mut SquareMatrix<D>, gradient: &SquareMatrix<D>) {
    let old = *deformation;
    for i in 0..D {
        for j in 0..D {
            deformation[i][j] += (0..D).map(|k| gradient[i][k] * old[k][j]).sum::<f64>();
        }
    }
}

fn from_numbers<const D: usize>(numbers: &[f64]) -> SquareMatrix<D> {
    let mut square = [[0.0; D]; D];
    square.as_flattened_mut().copy_from_slice(numbers);
    square
}
