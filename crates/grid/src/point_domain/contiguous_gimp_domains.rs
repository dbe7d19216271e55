//! Point domains of contiguous-particle GIMP (sheet: mpm §2.5c).

use crate::point_domain::{
    GridView, PointDomain, RightStretchDiagonal, SquareMatrix, from_numbers, identity, update_deformation,
};
use crate::{Basis, Stencil};

/// Bounds of the width of a domain, in cells.
const MIN_WIDTH: f64 = 1e-3;
/// Upper bound of the width of a domain, in cells.
const MAX_WIDTH: f64 = 2.0;

/// Widths of a stretched domain along the axes (m), within [`MIN_WIDTH`] and [`MAX_WIDTH`].
#[inline(always)]
fn widths<const D: usize>(initial: &[f64; D], stretch: impl Fn(usize) -> f64, cell: f64) -> [f64; D] {
    std::array::from_fn(|a| (initial[a] * stretch(a)).clamp(MIN_WIDTH * cell, MAX_WIDTH * cell))
}

/// Domain that stretches with the diagonal of the deformation gradient (Wallstedt & Guilkey 2008).
/// It shrinks in rotation and in shear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StretchingDomain<const D: usize> {
    deformation: SquareMatrix<D>,
}

impl<const D: usize> Default for StretchingDomain<D> {
    fn default() -> Self {
        Self { deformation: identity() }
    }
}

impl<const D: usize> PointDomain<D> for StretchingDomain<D> {
    type Support<const S: usize> = Stencil<D, S>;

    const CHECKPOINT_NUMBERS: usize = D * D;

    crate::point_domain::domain_columns::domain_column!(Stretching);

    #[inline(always)]
    fn support<const S: usize, B: Basis<S>>(
        &self,
        ground: &GridView<'_, D>,
        position: &[f64; D],
        initial: &[f64; D],
    ) -> Stencil<D, S> {
        Stencil::new::<B>(ground.grid, position, &self.extent(initial, ground.grid.cell))
    }

    #[inline(always)]
    fn extent(&self, initial: &[f64; D], cell: f64) -> [f64; D] {
        widths(initial, |a| self.deformation[a][a], cell)
    }

    #[inline(always)]
    fn update_deformation(&mut self, gradient: &SquareMatrix<D>, _right_stretch: RightStretchDiagonal<D>) {
        update_deformation(&mut self.deformation, gradient);
    }

    fn append_numbers(self, numbers: &mut Vec<f64>) {
        numbers.extend(self.deformation.as_flattened());
    }

    fn from_numbers(numbers: &[f64], _right_stretch: RightStretchDiagonal<D>) -> Self {
        Self { deformation: from_numbers(numbers) }
    }
}

/// Domain that stretches with the diagonal of the right stretch tensor `U = √(FᵀF)`, which a
/// rotation does not change (Coombs et al. 2020).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RightStretchDomain<const D: usize> {
    deformation: SquareMatrix<D>,
    /// Diagonal of `U`.
    stretch: [f64; D],
}

impl<const D: usize> Default for RightStretchDomain<D> {
    fn default() -> Self {
        Self { deformation: identity(), stretch: [1.0; D] }
    }
}

impl<const D: usize> PointDomain<D> for RightStretchDomain<D> {
    type Support<const S: usize> = Stencil<D, S>;

    const CHECKPOINT_NUMBERS: usize = D * D;

    crate::point_domain::domain_columns::domain_column!(Turning);

    #[inline(always)]
    fn support<const S: usize, B: Basis<S>>(
        &self,
        ground: &GridView<'_, D>,
        position: &[f64; D],
        initial: &[f64; D],
    ) -> Stencil<D, S> {
        Stencil::new::<B>(ground.grid, position, &self.extent(initial, ground.grid.cell))
    }

    #[inline(always)]
    fn extent(&self, initial: &[f64; D], cell: f64) -> [f64; D] {
        widths(initial, |a| self.stretch[a], cell)
    }

    #[inline]
    fn update_deformation(&mut self, gradient: &SquareMatrix<D>, right_stretch: RightStretchDiagonal<D>) {
        update_deformation(&mut self.deformation, gradient);
        self.stretch = right_stretch(&self.deformation);
    }

    fn append_numbers(self, numbers: &mut Vec<f64>) {
        numbers.extend(self.deformation.as_flattened());
    }

    fn from_numbers(numbers: &[f64], right_stretch: RightStretchDiagonal<D>) -> Self {
        let deformation = from_numbers(numbers);
        Self { deformation, stretch: right_stretch(&deformation) }
    }
}
