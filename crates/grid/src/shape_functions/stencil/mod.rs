//! Shape functions of a point in `D` dimensions, and its transfers.

pub(crate) mod batch;
mod transfers;

use wide::f64x8;

use crate::nodes::nodal_state::join_halves;
use crate::{Basis, Grid, Vector4};

/// Weights and gradients of the `S^D` nodes at a point, as products over the axes.
#[derive(Clone, Copy, Debug)]
pub struct Stencil<const D: usize, const S: usize> {
    /// First node along each axis.
    pub first: [usize; D],
    /// Weights along each axis.
    pub weights: [[f64; S]; D],
    /// Gradients along each axis (1/m).
    pub gradients: [[f64; S]; D],
}

impl<const D: usize, const S: usize> Stencil<D, S> {
    /// Returns the stencil of `basis` at `position` (m) for a point of full widths `extent` (m).
    #[inline(always)]
    pub fn new<B: Basis<S>>(grid: &Grid<D>, position: &[f64; D], extent: &[f64; D]) -> Self {
        let inverse = 1.0 / grid.cell;
        let at = |axis: usize| {
            let x = (position[axis] - grid.origin[axis]) * inverse;
            B::evaluate(x, extent[axis] * inverse, grid.cells[axis])
        };
        // Not initialised with zeros, which would cost a tenth of a transfer.
        let (first, w, g) = at(0);
        let mut stencil = Self { first: [first; D], weights: [w; D], gradients: [g; D] };
        for axis in 0..D {
            let (first, w, g) = if axis == 0 { (first, w, g) } else { at(axis) };
            stencil.first[axis] = first;
            stencil.weights[axis] = w;
            for k in 0..S {
                stencil.gradients[axis][k] = g[k] * inverse;
            }
        }
        stencil
    }

    /// Number of lines of nodes along the last axis that the stencil has in the direction of the first axis, and of the second in three
    /// dimensions.
    const LINE_COUNTS: [usize; 2] = [if D > 1 { S } else { 1 }, if D > 2 { S } else { 1 }];

    /// Line of `S` consecutive nodes along the last axis: index of its first node, weight, and gradients of this stencil and of `other`.
    /// Weight and gradients are those of the other axes.
    #[inline(always)]
    fn node_line(
        &self,
        other: &Self,
        strides: &[usize; D],
        i: usize,
        j: usize,
    ) -> (usize, f64, [f64; 2], [f64; 2]) {
        let start = self.first[D - 1];
        if D == 1 {
            return (start, 1.0, [0.0; 2], [0.0; 2]);
        }
        let start = start + (self.first[0] + i) * strides[0];
        let (wx, gx, hx) = (self.weights[0][i], self.gradients[0][i], other.gradients[0][i]);
        if D == 2 {
            return (start, wx, [gx, 0.0], [hx, 0.0]);
        }
        let start = start + (self.first[1] + j) * strides[1];
        let (wy, gy, hy) = (self.weights[1][j], self.gradients[1][j], other.gradients[1][j]);
        (start, wx * wy, [gx * wy, wx * gy], [hx * wy, wx * hy])
    }

    /// Calls `visit` for each line of `S` consecutive nodes along the last axis, with the index of its first node, weight and gradient. The
    /// latter are those of the other axes.
    #[inline(always)]
    pub(crate) fn for_each_line(&self, strides: &[usize; D], mut visit: impl FnMut(usize, f64, [f64; 2])) {
        for i in 0..Self::LINE_COUNTS[0] {
            for j in 0..Self::LINE_COUNTS[1] {
                let (start, w, g, _) = self.node_line(self, strides, i, j);
                visit(start, w, g);
            }
        }
    }

    /// Sum of the values `of` over a line of nodes along the last axis, multiplied by the weight `w` of the other axes.
    #[inline(always)]
    fn sum_along_line(&self, w: f64, of: impl Fn(usize) -> f64x8) -> f64x8 {
        let mut value = f64x8::ZERO;
        for k in 0..S {
            value += of(k) * self.weights[D - 1][k];
        }
        value * w
    }

    /// Gradients along the last axis: of this stencil in the first four numbers of a vector, of `other` in the last four.
    #[inline(always)]
    fn paired_gradients(&self, other: &Self) -> [f64x8; S] {
        let mut ends = [f64x8::ZERO; S];
        for k in 0..S {
            ends[k] = splat_pair(self.gradients[D - 1][k], other.gradients[D - 1][k]);
        }
        ends
    }
}

/// Vector of eight numbers: four times `first`, then four times `second`.
#[inline(always)]
fn splat_pair(first: f64, second: f64) -> f64x8 {
    join_halves(Vector4::splat(first), Vector4::splat(second))
}

#[cfg(test)]
mod tests;
