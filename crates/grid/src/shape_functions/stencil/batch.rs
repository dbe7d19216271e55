//! Stencils of many points at once: each weight of all points in an array of its own, so that SIMD instructions compute several points
//! together. The arithmetic is that of single points.

use super::Stencil;
use crate::{Basis, Grid};

/// Largest number of points whose stencils are computed together.
pub const STENCIL_BATCH: usize = 64;

/// Values of one weight at the points of a batch.
pub type BatchArray = [f64; STENCIL_BATCH];

/// Shape functions along one axis at the points of a batch.
pub struct AxisBatch<const S: usize> {
    /// First node of each point.
    pub first: [u32; STENCIL_BATCH],
    /// Weights of the `S` nodes.
    pub weights: [BatchArray; S],
    /// Gradients of the `S` nodes, per cell.
    pub gradients: [BatchArray; S],
}

impl<const S: usize> AxisBatch<S> {
    /// Batch before it is computed.
    const EMPTY: Self = Self {
        first: [0; STENCIL_BATCH],
        weights: [[0.0; STENCIL_BATCH]; S],
        gradients: [[0.0; STENCIL_BATCH]; S],
    };

    /// Sets the shape functions of a point.
    #[inline(always)]
    pub fn set(&mut self, point: usize, (first, weights, gradients): (usize, [f64; S], [f64; S])) {
        self.first[point] = first as u32;
        for k in 0..S {
            self.weights[k][point] = weights[k];
            self.gradients[k][point] = gradients[k];
        }
    }
}

/// Stencils of up to [`STENCIL_BATCH`] points of equal width.
pub struct StencilBatch<const D: usize, const S: usize> {
    axes: [AxisBatch<S>; D],
    /// Positions along each axis, in cells from the lower end.
    places: [BatchArray; D],
}

impl<const D: usize, const S: usize> StencilBatch<D, S> {
    /// Stencils before they are computed.
    pub const EMPTY: Self = Self { axes: [AxisBatch::EMPTY; D], places: [[0.0; STENCIL_BATCH]; D] };

    /// Computes the stencils of `basis` at `positions` (m) for points of full widths `extent` (m).
    #[inline(always)]
    pub fn compute<B: Basis<S>>(&mut self, grid: &Grid<D>, positions: &[[f64; D]], extent: &[f64; D]) {
        let inverse = 1.0 / grid.cell;
        for axis in 0..D {
            let (axes, places) = (&mut self.axes[axis], &mut self.places[axis]);
            for (place, position) in places.iter_mut().zip(positions) {
                *place = (position[axis] - grid.origin[axis]) * inverse;
            }
            B::evaluate_batch(places, positions.len(), extent[axis] * inverse, grid.cells[axis], axes);
            for gradients in &mut axes.gradients {
                gradients.iter_mut().for_each(|gradient| *gradient *= inverse);
            }
        }
    }

    /// Stencil of a point.
    #[inline(always)]
    pub fn stencil(&self, point: usize) -> Stencil<D, S> {
        Stencil {
            first: std::array::from_fn(|axis| self.axes[axis].first[point] as usize),
            weights: std::array::from_fn(|axis| std::array::from_fn(|k| self.axes[axis].weights[k][point])),
            gradients: std::array::from_fn(|axis| {
                std::array::from_fn(|k| self.axes[axis].gradients[k][point])
            }),
        }
    }

    /// Computes the weights times arms `N (x_i - x_p)` (m) of all points, along each axis.
    #[inline(always)]
    pub fn moments<B: Basis<S>>(&self, grid: &Grid<D>, moments: &mut [[BatchArray; S]; D]) {
        for axis in 0..D {
            let (own, moments) = (&self.axes[axis], &mut moments[axis]);
            B::coordinates_batch(&own.first, grid.cells[axis], moments);
            for k in 0..S {
                for p in 0..STENCIL_BATCH {
                    let arm = (moments[k][p] - self.places[axis][p]) * grid.cell;
                    moments[k][p] = own.weights[k][p] * arm;
                }
            }
        }
    }

    /// Stencil of a point with its moments in place of the gradients, and the second moments (m²), see
    /// [`NodeSupport::affine_moments`](crate::NodeSupport::affine_moments).
    #[inline(always)]
    pub fn affine_moments<B: Basis<S>>(
        &self,
        grid: &Grid<D>,
        moments: &[[BatchArray; S]; D],
        point: usize,
    ) -> (Stencil<D, S>, [f64; D]) {
        let mut stencil = self.stencil(point);
        let mut squares = [0.0; D];
        for axis in 0..D {
            for k in 0..S {
                stencil.gradients[axis][k] = moments[axis][k][point];
            }
            let (first, cells) = (stencil.first[axis], grid.cells[axis]);
            squares[axis] = if let Some(same) = B::second_moment(first, cells) {
                same * (grid.cell * grid.cell)
            } else {
                let nodes: [f64; S] = B::coordinates(first, cells);
                let place = self.places[axis][point];
                (0..S).fold(0.0, |sum, k| sum + stencil.gradients[axis][k] * ((nodes[k] - place) * grid.cell))
            };
        }
        (stencil, squares)
    }
}
