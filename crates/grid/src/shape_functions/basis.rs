//! Shape functions of one axis (sheet: mpm §2.5).

use crate::shape_functions::stencil::batch::{AxisBatch, BatchArray, STENCIL_BATCH};

/// Shape functions along one axis, of which `S` are non-zero at a point. Coordinates are in cells from the domain's lower end; gradients
/// are per cell.
///
/// Every basis is a partition of unity and, away from the ends of spline grids, reproduces linear
/// fields.
pub trait Basis<const S: usize>: Copy + Send + Sync + 'static {
    /// Name of the family.
    const NAME: &'static str;
    /// Number of node layers outside the domain at each end.
    const GHOSTS: usize;
    /// Number of nodes in the support of a point below the lower node of its cell.
    const NODES_BELOW: usize;
    /// Number of nodes in the support of a point above the lower node of its cell.
    const NODES_ABOVE: usize;
    /// Whether fixed nodes on a grid line inside the domain also fix the material there.
    const ALLOWS_INTERIOR_WALLS: bool = true;

    /// Number of nodes of an axis with `cells` cells, ghosts included.
    fn nodes(cells: usize) -> usize;

    /// Coordinate of a node in cells from the lower end; for splines the Greville abscissa.
    fn coordinate(index: usize, cells: usize) -> f64;

    /// Coordinates of consecutive nodes from `first` on, see [`Basis::coordinate`].
    #[inline(always)]
    fn coordinates(first: usize, cells: usize) -> [f64; S] {
        std::array::from_fn(|k| Self::coordinate(first + k, cells))
    }

    /// Second moment of the shape functions from node `first` on (cells²), if it does not depend on the position; else `None`.
    #[inline(always)]
    fn second_moment(_first: usize, _cells: usize) -> Option<f64> {
        None
    }

    /// First node, weights and gradients at `x`, for a point of full width `width` (both in cells).
    fn evaluate(x: f64, width: f64, cells: usize) -> (usize, [f64; S], [f64; S]);

    /// [`Basis::evaluate`] at the first `count` of many positions, with the same results.
    #[inline(always)]
    fn evaluate_batch(x: &BatchArray, count: usize, width: f64, cells: usize, out: &mut AxisBatch<S>) {
        for (point, x) in x.iter().enumerate().take(count) {
            out.set(point, Self::evaluate(*x, width, cells));
        }
    }

    /// [`Basis::coordinates`] of the nodes from each of many first ones on, with the same results.
    #[inline(always)]
    fn coordinates_batch(first: &[u32; STENCIL_BATCH], cells: usize, out: &mut [BatchArray; S]) {
        for (point, first) in first.iter().enumerate() {
            let nodes = Self::coordinates(*first as usize, cells);
            (0..S).for_each(|k| out[k][point] = nodes[k]);
        }
    }
}

/// Computes the indices of the cells at many positions, like [`cell_index`]. Returns whether none is one of the `margin` cells at either
/// end.
#[inline(always)]
pub(super) fn cell_indices(
    x: &BatchArray,
    cells: usize,
    margin: usize,
    out: &mut [u32; STENCIL_BATCH],
) -> bool {
    let last = cells as i32 - 1;
    let (low, high) = (margin as i32, last - margin as i32);
    let mut is_inside = true;
    for (cell, x) in out.iter_mut().zip(x) {
        let index = (x.max(0.0) as i32).min(last);
        is_inside &= (index >= low) & (index <= high);
        *cell = index as u32;
    }
    is_inside
}

/// Index of the cell at a position in cell widths; the first or last cell for positions outside the grid.
#[inline]
pub(super) fn cell_index(x: f64, cells: usize) -> usize {
    (x.max(0.0) as usize).min(cells - 1)
}

/// Linear shape functions (hat functions, GT eq. 3.25).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LinearBasis;

impl Basis<2> for LinearBasis {
    const NAME: &'static str = "linear";
    const GHOSTS: usize = 0;
    const NODES_BELOW: usize = 0;
    const NODES_ABOVE: usize = 1;

    fn nodes(cells: usize) -> usize {
        cells + 1
    }

    fn coordinate(index: usize, _cells: usize) -> f64 {
        index as f64
    }

    #[inline]
    fn evaluate(x: f64, _width: f64, cells: usize) -> (usize, [f64; 2], [f64; 2]) {
        let cell = cell_index(x, cells);
        let s = x - cell as f64;
        (cell, [1.0 - s, s], [-1.0, 1.0])
    }

    #[inline(always)]
    fn evaluate_batch(x: &BatchArray, _count: usize, _width: f64, cells: usize, out: &mut AxisBatch<2>) {
        cell_indices(x, cells, 0, &mut out.first);
        for point in 0..STENCIL_BATCH {
            let s = x[point] - f64::from(out.first[point]);
            (out.weights[0][point], out.weights[1][point]) = (1.0 - s, s);
            (out.gradients[0][point], out.gradients[1][point]) = (-1.0, 1.0);
        }
    }
}

/// Generalised interpolation (GIMP) for point widths up to one cell: linear functions averaged over the point domain (GT eq. 3.27, in the
/// general form of the sheet).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GimpBasis;

impl Basis<3> for GimpBasis {
    const NAME: &'static str = "gimp";
    const GHOSTS: usize = 1;
    const NODES_BELOW: usize = 1;
    const NODES_ABOVE: usize = 2;

    fn nodes(cells: usize) -> usize {
        cells + 3
    }

    fn coordinate(index: usize, _cells: usize) -> f64 {
        index as f64 - 1.0
    }

    #[inline]
    fn evaluate(x: f64, width: f64, cells: usize) -> (usize, [f64; 3], [f64; 3]) {
        // Ends of the point's domain, counted from the ghost node.
        let lower = (x - 0.5 * width + 1.0).max(0.0);
        let first = (lower as usize).min(cells);
        let a = lower - first as f64;
        let b = a + width;
        // Averages over [a, b] of the hats at 0, 1 and 2 and of their slopes.
        let inside = b.min(1.0);
        let beyond = (b - 1.0).max(0.0);
        let inverse = 1.0 / width;
        let w0 = ((1.0 - a) * (1.0 - a) - (1.0 - inside) * (1.0 - inside)) * (0.5 * inverse);
        let w2 = beyond * beyond * (0.5 * inverse);
        let g0 = (a - inside) * inverse;
        let g2 = beyond * inverse;
        (first, [w0, 1.0 - w0 - w2, w2], [g0, -g0 - g2, g2])
    }
}

/// Generalised interpolation for point widths up to two cells, for contiguous-particle GIMP with domains that deform.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ContiguousGimpBasis;

impl Basis<4> for ContiguousGimpBasis {
    const NAME: &'static str = "contiguous-particle gimp";
    const GHOSTS: usize = 2;
    const NODES_BELOW: usize = 1;
    const NODES_ABOVE: usize = 3;

    fn nodes(cells: usize) -> usize {
        cells + 5
    }

    fn coordinate(index: usize, _cells: usize) -> f64 {
        index as f64 - 2.0
    }

    #[inline]
    fn evaluate(x: f64, width: f64, cells: usize) -> (usize, [f64; 4], [f64; 4]) {
        let lower = (x - 0.5 * width + 2.0).max(0.0);
        let first = (lower as usize).min(cells + 1);
        let a = lower - first as f64;
        let b = a + width;
        let inverse = 1.0 / width;
        // Lengths of [a, b] within the first, second and third cell.
        let first_part = b.min(1.0) - a;
        let second_end = b.clamp(1.0, 2.0);
        let second_part = second_end - 1.0;
        let third_part = (b - 2.0).max(0.0);
        let square = |t: f64| t * t;
        let w0 = 0.5 * (square(1.0 - a) - square(1.0 - b.min(1.0))) * inverse;
        let rising = 0.5 * (square(b.min(1.0)) - square(a));
        let falling = 0.5 * (1.0 - square(2.0 - second_end));
        let w1 = (rising + falling) * inverse;
        let w3 = 0.5 * square(third_part) * inverse;
        let g0 = -first_part * inverse;
        let g1 = (first_part - second_part) * inverse;
        let g3 = third_part * inverse;
        (first, [w0, w1, 1.0 - w0 - w1 - w3, w3], [g0, g1, -g0 - g1 - g3, g3])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{CubicSpline, QuadraticSpline};
    use proptest::prelude::*;

    fn value_at<const S: usize, B: Basis<S>>(node: usize, x: f64, width: f64, cells: usize) -> (f64, f64) {
        let (first, w, g) = B::evaluate(x, width, cells);
        if node < first || node >= first + S { (0.0, 0.0) } else { (w[node - first], g[node - first]) }
    }

    #[test]
    fn gimp_has_the_values_of_the_sheet() {
        // (width, offset from the node, value, gradient), sheet: mpm §2.5.
        let table = [
            (0.5, 0.0, 0.875, 0.0),
            (0.5, 0.1, 0.855, -0.4),
            (0.5, 0.25, 0.75, -1.0),
            (0.5, 0.5, 0.5, -1.0),
            (0.5, 0.75, 0.25, -1.0),
            (0.5, 1.0, 0.0625, -0.5),
            (0.5, 1.2, 0.0025, -0.1),
            (0.5, 1.25, 0.0, 0.0),
            (0.25, 0.0, 0.9375, 0.0),
            (0.25, 0.1, 0.8975, -0.8),
            (0.25, 0.125, 0.875, -1.0),
            (0.25, 0.875, 0.125, -1.0),
            (0.25, 1.0, 0.03125, -0.5),
            (0.25, 1.1, 0.00125, -0.1),
        ];
        for (width, offset, value, gradient) in table {
            for sign in [1.0, -1.0] {
                let (w, g) = value_at::<3, GimpBasis>(6, 5.0 + sign * offset, width, 10);
                assert!((w - value).abs() < 1e-14 && (g - sign * gradient).abs() < 1e-13, "{width} {offset}");
                let (w, g) = value_at::<4, ContiguousGimpBasis>(7, 5.0 + sign * offset, width, 10);
                assert!((w - value).abs() < 1e-14 && (g - sign * gradient).abs() < 1e-13, "{width} {offset}");
            }
        }
    }

    #[test]
    fn splines_have_the_values_of_the_sheet() {
        let quadratic = [
            (0.0, 0.75, 0.0),
            (0.25, 0.6875, -0.5),
            (0.5, 0.5, -1.0),
            (0.75, 0.28125, -0.75),
            (1.0, 0.125, -0.5),
            (1.25, 0.03125, -0.25),
        ];
        for (offset, value, gradient) in quadratic {
            // Control point 6 lies at 5.5.
            let (w, g) = value_at::<3, QuadraticSpline>(6, 5.5 + offset, 0.0, 12);
            assert!((w - value).abs() < 1e-14 && (g - gradient).abs() < 1e-14, "{offset}: {w} {g}");
        }
        let cubic = [
            (0.0, 2.0 / 3.0, 0.0),
            (0.25, 0.611979, -0.40625),
            (0.5, 0.479167, -0.625),
            (1.0, 0.166667, -0.5),
            (1.5, 0.0208333, -0.125),
        ];
        for (offset, value, gradient) in cubic {
            let (w, g) = value_at::<4, CubicSpline>(7, 6.0 + offset, 0.0, 12);
            assert!((w - value).abs() < 1e-6 && (g - gradient).abs() < 1e-14, "{offset}: {w} {g}");
        }
        let close = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
        let (_, w, g) = QuadraticSpline::evaluate(0.25, 0.0, 12);
        assert!(close(&w, &[0.5625, 0.40625, 0.03125]) && close(&g, &[-1.5, 1.25, 0.25]));
        let (first, w, g) = QuadraticSpline::evaluate(1.5, 0.0, 12);
        assert!(first == 1 && close(&w, &[0.125, 0.75, 0.125]) && close(&g, &[-0.5, 0.0, 0.5]));
        let (_, w, g) = CubicSpline::evaluate(0.25, 0.0, 12);
        assert!(close(&w, &[0.421875, 0.496094, 0.079427, 0.002604]));
        assert!(close(&g, &[-1.6875, 1.078125, 0.578125, 0.03125]));
        let (first, w, g) = CubicSpline::evaluate(1.5, 0.0, 12);
        assert!(first == 1 && close(&w, &[0.03125, 0.46875, 0.479167, 0.020833]));
        assert!(close(&g, &[-0.1875, -0.5625, 0.625, 0.125]));
    }

    fn reproduces<const S: usize, B: Basis<S>>(x: f64, width: f64, cells: usize) {
        let (first, w, g) = B::evaluate(x, width, cells);
        assert!(first + S <= B::nodes(cells), "{} nodes in range", B::NAME);
        let at = |k: usize| B::coordinate(first + k, cells);
        let sums: [f64; 4] = std::array::from_fn(|q| {
            let term = |k| match q {
                0 => w[k],
                1 => g[k],
                2 => w[k] * at(k),
                _ => g[k] * at(k),
            };
            (0..S).map(term).sum()
        });
        assert_eq!(B::coordinates(first, cells), std::array::from_fn(at), "{}", B::NAME);
        if let Some(moment) = B::second_moment(first, cells) {
            let sum: f64 = (0..S).map(|k| w[k] * (at(k) - x) * (at(k) - x)).sum();
            assert!((sum - moment).abs() < 1e-13, "{} at {x}: {sum}", B::NAME);
        }
        for (sum, exact) in sums.into_iter().zip([1.0, 0.0, x, 1.0]) {
            assert!((sum - exact).abs() < 1e-12, "{} at {x}, width {width}: {sum} for {exact}", B::NAME);
        }
    }

    proptest! {
        #[test]
        fn every_basis_reproduces_linear_fields(x in 0.0..9.0f64, width in 1e-3..1.0f64, wide in 1e-3..2.0f64) {
            reproduces::<2, LinearBasis>(x, width, 9);
            reproduces::<3, GimpBasis>(x, width, 9);
            reproduces::<4, ContiguousGimpBasis>(x, wide, 9);
            reproduces::<3, QuadraticSpline>(x, width, 9);
            reproduces::<4, CubicSpline>(x, width, 9);
            reproduces::<3, QuadraticSpline>(x / 9.0, width, 1);
            reproduces::<4, CubicSpline>(x / 4.5, width, 2);
        }

        #[test]
        fn gradients_are_the_slopes_of_the_weights(x in 1.0..8.0f64, width in 0.05..1.0f64) {
            let step = 1e-6;
            fn slope<const S: usize, B: Basis<S>>(node: usize, x: f64, width: f64, step: f64) -> (f64, f64) {
                let (up, down) = (value_at::<S, B>(node, x + step, width, 9).0, value_at::<S, B>(node, x - step, width, 9).0);
                ((up - down) / (2.0 * step), value_at::<S, B>(node, x, width, 9).1)
            }
            for node in 0..12 {
                for (difference, g) in [
                    slope::<3, GimpBasis>(node, x, width, step),
                    slope::<4, ContiguousGimpBasis>(node, x, 2.0 * width, step),
                    slope::<3, QuadraticSpline>(node, x, width, step),
                    slope::<4, CubicSpline>(node, x, width, step),
                ] {
                    prop_assert!((difference - g).abs() < 1e-4);
                }
            }
        }
    }
}
