//! Domains of points, which determine the nodes of a point and their weights (sheet: mpm §2.5).

mod contiguous_gimp_domains;
mod convected_domains;
mod domain_columns;
mod element_domain;
mod reference_domain;

#[cfg(test)]
mod tests;

pub use crate::point_domain::contiguous_gimp_domains::{RightStretchDomain, StretchingDomain};
pub use crate::point_domain::convected_domains::{ConvectedDomain, ConvectedQuadrilateral};
pub use crate::point_domain::domain_columns::{DomainSlice, Domains, DomainsMut};
pub use crate::point_domain::element_domain::ElementDomain;
pub use crate::point_domain::reference_domain::ReferenceDomain;

use crate::shape_functions::stencil::batch::{STENCIL_BATCH, StencilBatch};
use crate::{Basis, Grid, Layout, Mesh, NodeSupport, Stencil};

/// Square matrix of the space dimension, row by row.
pub type SquareMatrix<const D: usize> = [[f64; D]; D];

/// Diagonal of the right stretch tensor of a deformation gradient. This crate has no tensors; users of domains with the right
/// stretch provide the function.
pub type RightStretchDiagonal<const D: usize> = fn(&SquareMatrix<D>) -> [f64; D];

/// View of the grid or mesh in which points find their nodes.
#[derive(Clone, Copy)]
pub struct GridView<'a, const D: usize> {
    /// Structured grid; with a mesh the box of cells around it.
    pub grid: &'a Grid<D>,
    /// Mesh; empty on a structured grid.
    pub mesh: &'a Mesh<D>,
    /// Distance in memory between neighbouring nodes along each axis.
    pub strides: [usize; D],
    /// Layers of nodes outside the domain.
    pub ghosts: usize,
}

impl<'a, const D: usize> GridView<'a, D> {
    /// Returns the view of the nodes of `layout` on a grid, or on a mesh that is not empty.
    pub fn new(grid: &'a Grid<D>, mesh: &'a Mesh<D>, layout: &Layout<D>) -> Self {
        Self { grid, mesh, strides: layout.strides(), ghosts: layout.ghosts() }
    }

    /// Number of the lowest node of the cell that contains `position` (m).
    #[inline(always)]
    pub fn lowest_node(&self, position: &[f64; D]) -> usize {
        let cell = self.grid.cell_of(position);
        (0..D).map(|axis| (cell[axis] + self.ghosts) * self.strides[axis]).sum()
    }
}

/// Domain of a point, beyond the initial width that all points of a body share, and the nodes that
/// follow from it.
pub trait PointDomain<const D: usize>: Copy + Default + Send + Sync + 'static {
    /// Nodes of a point: `S` per axis, or `S` in total where they are no product over the axes.
    type Support<const S: usize>: NodeSupport<D>;

    /// Whether the domain changes in the course of a run.
    const DEFORMS: bool = true;

    /// Whether shape functions are evaluated at the initial position (total-Lagrangian).
    const REFERENCE_CONFIGURATION: bool = false;

    /// Whether corners move with the grid velocity ([`PointDomain::advect_corners`]).
    const CONVECTS_CORNERS: bool = false;

    /// Number of values of a domain in a checkpoint.
    const CHECKPOINT_NUMBERS: usize;

    /// Column of this type.
    fn typed_column<'a>(column: &DomainSlice<'a, D>) -> &'a [Self];

    /// New column of points that have not moved yet.
    fn new_column(count: usize) -> Domains<D>;

    /// Returns the nodes of a point at `position` (m) with initial full widths `initial` (m).
    fn support<const S: usize, B: Basis<S>>(
        &self,
        ground: &GridView<'_, D>,
        position: &[f64; D],
        initial: &[f64; D],
    ) -> Self::Support<S>;

    /// Calls `visit` with the number and the nodes of every point; `domains` are those of the points.
    #[inline(always)]
    fn for_each_support<const S: usize, B: Basis<S>>(
        domains: &[Self],
        ground: &GridView<'_, D>,
        positions: &[[f64; D]],
        initial: &[f64; D],
        mut visit: impl FnMut(usize, &Self::Support<S>),
    ) {
        for (p, (position, domain)) in positions.iter().zip(domains).enumerate() {
            visit(p, &domain.support::<S, B>(ground, position, initial));
        }
    }

    /// Calls `visit` with the number, the nodes and the [affine moments](NodeSupport::affine_moments) of every point.
    #[inline(always)]
    fn for_each_affine_support<const S: usize, B: Basis<S>>(
        domains: &[Self],
        ground: &GridView<'_, D>,
        positions: &[[f64; D]],
        initial: &[f64; D],
        mut visit: impl FnMut(usize, &Self::Support<S>, &(Self::Support<S>, [f64; D])),
    ) {
        for (p, (position, domain)) in positions.iter().zip(domains).enumerate() {
            let support = domain.support::<S, B>(ground, position, initial);
            let anchor = domain.evaluation_position(position);
            visit(p, &support, &support.affine_moments::<S, B>(ground.grid, &anchor));
        }
    }

    /// Index, in arrays with one entry a cell, of the cell of a point at `position` (m): the number of the cell's lowest
    /// node, or of the element.
    #[inline(always)]
    fn cell(&self, ground: &GridView<'_, D>, position: &[f64; D]) -> usize {
        ground.lowest_node(&self.evaluation_position(position))
    }

    /// Full widths of the domain (m) from the initial ones, on cells of edge `cell`.
    fn extent(&self, initial: &[f64; D], cell: f64) -> [f64; D];

    /// Determines the domain in the initial state.
    ///
    /// # Errors
    /// When the point is in no element, as a reason.
    fn initialise(&mut self, _ground: &GridView<'_, D>, _position: &[f64; D]) -> Result<(), String> {
        Ok(())
    }

    /// Position at which shape functions of a point at `position` are evaluated (m).
    #[inline(always)]
    fn evaluation_position(&self, position: &[f64; D]) -> [f64; D] {
        *position
    }

    /// Least node spacing around the point (m), on which the time step depends.
    #[inline(always)]
    fn spacing(&self, ground: &GridView<'_, D>) -> f64 {
        ground.grid.cell
    }

    /// Updates the element of the point after a move; has an effect on a mesh only.
    ///
    /// # Errors
    /// When the point is in no element, as a reason.
    #[inline(always)]
    fn relocate(&mut self, _ground: &GridView<'_, D>, _position: &[f64; D]) -> Result<(), String> {
        Ok(())
    }

    /// Updates the domain by the incremental deformation `f = 1 + gradient` (row `i`, column `j`: `∂u_i/∂x_j`).
    #[inline(always)]
    fn update_deformation(&mut self, _gradient: &SquareMatrix<D>, _right_stretch: RightStretchDiagonal<D>) {}

    /// Moves the corners with the velocity that `read` returns at a position (m), in a step of `dt` (s) in which the point moves
    /// with `velocity` (m/s).
    #[inline(always)]
    fn advect_corners(
        &mut self,
        _position: &[f64; D],
        _initial: &[f64; D],
        _velocity: &[f64; D],
        _dt: f64,
        _read: impl Fn(&[f64; D]) -> [f64; D],
    ) {
    }

    /// Reason why the domain is invalid, if it is.
    #[inline(always)]
    fn validity_error(&self, _initial: &[f64; D], _cell: f64) -> Option<String> {
        None
    }

    /// Appends the [`PointDomain::CHECKPOINT_NUMBERS`] values of the domain for a checkpoint.
    fn append_numbers(self, numbers: &mut Vec<f64>);

    /// Returns the domain from the values of [`PointDomain::append_numbers`].
    fn from_numbers(numbers: &[f64], right_stretch: RightStretchDiagonal<D>) -> Self;
}

/// Domain of constant size (or for shape functions that do not depend on it).
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
    fn for_each_support<const S: usize, B: Basis<S>>(
        _domains: &[Self],
        ground: &GridView<'_, D>,
        positions: &[[f64; D]],
        initial: &[f64; D],
        mut visit: impl FnMut(usize, &Stencil<D, S>),
    ) {
        // The only call of `visit`, so that it is inlined: through memory, a stencil stored number by number and loaded in vectors stalls.
        let mut batch = StencilBatch::<D, S>::EMPTY;
        for (group, positions) in positions.chunks(STENCIL_BATCH).enumerate() {
            batch.compute::<B>(ground.grid, positions, initial);
            for p in 0..positions.len() {
                visit(group * STENCIL_BATCH + p, &batch.stencil(p));
            }
        }
    }

    #[inline(always)]
    fn for_each_affine_support<const S: usize, B: Basis<S>>(
        _domains: &[Self],
        ground: &GridView<'_, D>,
        positions: &[[f64; D]],
        initial: &[f64; D],
        mut visit: impl FnMut(usize, &Stencil<D, S>, &(Stencil<D, S>, [f64; D])),
    ) {
        let (mut batch, mut moments) = (StencilBatch::<D, S>::EMPTY, [[[0.0; STENCIL_BATCH]; S]; D]);
        for (group, positions) in positions.chunks(STENCIL_BATCH).enumerate() {
            batch.compute::<B>(ground.grid, positions, initial);
            batch.moments::<B>(ground.grid, &mut moments);
            for p in 0..positions.len() {
                let affine = batch.affine_moments::<B>(ground.grid, &moments, p);
                visit(group * STENCIL_BATCH + p, &batch.stencil(p), &affine);
            }
        }
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
