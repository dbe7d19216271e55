//! Point domains of contiguous-particle GIMP (sheet: mpm §2.5c).

use super::{Ground, PointDomain, RightStretch, Square, follow, from_numbers, identity};
use crate::{Basis, Stencil};

/// Widths of a domain, in cells.
const NARROWEST: f64 = 1e-3;
const WIDEST: f64 = 2.0;

#[inline(always)]
fn widths<const D: usize>(initial: &[f64; D], stretch: impl Fn(usize) -> f64, cell: f64) -> [f64; D] {
    std::array::from_fn(|a| (initial[a] * stretch(a)).clamp(NARROWEST * cell, WIDEST * cell))
}

/// A domain that stretches with the diagonal of the deformation gradient (Wallstedt & Guilkey 2008).
/// It shrinks when its point turns, and in shear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StretchingDomain<const D: usize> {
    deformation: Square<D>,
}

impl<const D: usize> Default for StretchingDomain<D> {
    fn default() -> Self {
        Self { deformation: identity() }
    }
}

impl<const D: usize> PointDomain<D> for StretchingDomain<D> {
    type Support<const S: usize> = Stencil<D, S>;

    const NUMBERS: usize = D * D;

    super::columns::column!(Stretching);

    #[inline(always)]
    fn support<const S: usize, B: Basis<S>>(
        &self,
        ground: &Ground<'_, D>,
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
    fn follow(&mut self, gradient: &Square<D>, _right_stretch: RightStretch<D>) {
        follow(&mut self.deformation, gradient);
    }

    fn put(self, numbers: &mut Vec<f64>) {
        numbers.extend(self.deformation.as_flattened());
    }

    fn from_numbers(numbers: &[f64], _right_stretch: RightStretch<D>) -> Self {
        Self { deformation: from_numbers(numbers) }
    }
}

/// A domain that stretches with the diagonal of the right stretch tensor `U = √(FᵀF)`, which a
/// rotation leaves as it is (Coombs et al. 2020).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurningDomain<const D: usize> {
    deformation: Square<D>,
    /// Diagonal of `U`.
    stretch: [f64; D],
}

impl<const D: usize> Default for TurningDomain<D> {
    fn default() -> Self {
        Self { deformation: identity(), stretch: [1.0; D] }
    }
}

impl<const D: usize> PointDomain<D> for TurningDomain<D> {
    type Support<const S: usize> = Stencil<D, S>;

    const NUMBERS: usize = D * D;

    super::columns::column!(Turning);

    #[inline(always)]
    fn support<const S: usize, B: Basis<S>>(
        &self,
        ground: &Ground<'_, D>,
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
    fn follow(&mut self, gradient: &Square<D>, right_stretch: RightStretch<D>) {
        follow(&mut self.deformation, gradient);
        self.stretch = right_stretch(&self.deformation);
    }

    fn put(self, numbers: &mut Vec<f64>) {
        numbers.extend(self.deformation.as_flattened());
    }

    fn from_numbers(numbers: &[f64], right_stretch: RightStretch<D>) -> Self {
        let deformation = from_numbers(numbers);
        Self { deformation, stretch: right_stretch(&deformation) }
    }
}
