//! B-splines along one axis, with open knots at both ends (sheet: mpm §2.5).

use crate::Basis;
use crate::shape_functions::basis::{cell_index, cell_indices};
use crate::shape_functions::stencil::batch::{AxisBatch, BatchArray, STENCIL_BATCH};

/// Non-zero B-splines of degree `S - 1` in a cell, with open knots at both ends (Cox–de Boor).
#[inline(never)]
fn open_spline<const S: usize>(x: f64, cell: usize, cells: usize) -> ([f64; S], [f64; S]) {
    let knot = |k: isize| (cell as isize + k).clamp(0, cells as isize) as f64;
    let mut w = [0.0; S];
    let mut lower_degree = [0.0; S];
    w[0] = 1.0;
    for degree in 1..S {
        if degree == S - 1 {
            lower_degree = w;
        }
        let mut saved = 0.0;
        for r in 0..degree {
            let right = knot(r as isize + 1);
            let left = knot(r as isize + 1 - degree as isize);
            let term = w[r] / (right - left);
            w[r] = saved + (right - x) * term;
            saved = (x - left) * term;
        }
        w[degree] = saved;
    }
    // The slope of a spline is a difference of two of one degree less.
    let degree = S - 1;
    let mut g = [0.0; S];
    for r in 0..degree {
        let span = knot(r as isize + 1) - knot(r as isize + 1 - degree as isize);
        let slope = degree as f64 * lower_degree[r] / span;
        g[r] -= slope;
        g[r + 1] += slope;
    }
    (w, g)
}

/// `N` numbers that increase by one from `start`.
#[inline(always)]
fn consecutive<const N: usize>(start: f64) -> [f64; N] {
    let mut numbers = [start; N];
    for k in 0..N {
        numbers[k] += k as f64;
    }
    numbers
}

/// Sets the shape functions of the points of a batch in one of the `margin` cells at either end.
#[inline(never)]
fn set_near_ends<const S: usize, B: Basis<S>>(
    x: &BatchArray,
    count: usize,
    width: f64,
    cells: usize,
    margin: usize,
    out: &mut AxisBatch<S>,
) {
    for (point, x) in x.iter().enumerate().take(count) {
        let cell = cell_index(*x, cells);
        if cell < margin || cell + margin + 1 > cells {
            out.set(point, B::evaluate(*x, width, cells));
        }
    }
}

/// Coordinates of the `S` nodes from each of many first ones on, which are consecutive from `first - shift` where `first` is at least
/// `lowest` and the last one at most `cells`.
#[inline(always)]
fn consecutive_batch<const S: usize, B: Basis<S>>(
    first: &[u32; STENCIL_BATCH],
    cells: usize,
    lowest: u32,
    shift: f64,
    out: &mut [BatchArray; S],
) {
    let highest = (cells + 1).saturating_sub(S) as u32;
    let mut is_inside = true;
    for (point, first) in first.iter().enumerate() {
        is_inside &= (*first >= lowest) & (*first <= highest);
        for k in 0..S {
            out[k][point] = (f64::from(*first) - shift) + k as f64;
        }
    }
    if !is_inside {
        for (point, first) in
            first.iter().enumerate().filter(|(_, first)| **first < lowest || **first > highest)
        {
            let nodes = coordinates_near_ends::<S, B>(*first as usize, cells);
            (0..S).for_each(|k| out[k][point] = nodes[k]);
        }
    }
}

/// Coordinates of consecutive nodes, some of which are close to an end.
#[inline(never)]
fn coordinates_near_ends<const S: usize, B: Basis<S>>(first: usize, cells: usize) -> [f64; S] {
    std::array::from_fn(|k| B::coordinate(first + k, cells))
}

/// Greville abscissa of a B-spline: mean of its interior knots, in cell widths.
fn greville(index: usize, cells: usize, degree: usize) -> f64 {
    let knots = (index + 1..=index + degree).map(|k| k.saturating_sub(degree).min(cells) as f64);
    knots.sum::<f64>() / degree as f64
}

/// Quadratic B-splines with open knots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct QuadraticSpline;

impl Basis<3> for QuadraticSpline {
    const NAME: &'static str = "quadratic B-spline";
    const ALLOWS_INTERIOR_WALLS: bool = false;
    const GHOSTS: usize = 0;
    const NODES_BELOW: usize = 0;
    const NODES_ABOVE: usize = 2;

    fn nodes(cells: usize) -> usize {
        cells + 2
    }

    #[inline]
    fn coordinate(index: usize, cells: usize) -> f64 {
        // Away from the ends, the middle of two knots.
        if (1..=cells).contains(&index) { index as f64 - 0.5 } else { greville(index, cells, 2) }
    }

    #[inline(always)]
    fn coordinates(first: usize, cells: usize) -> [f64; 3] {
        if first >= 1 && first + 2 <= cells {
            consecutive(first as f64 - 0.5)
        } else {
            coordinates_near_ends::<3, Self>(first, cells)
        }
    }

    #[inline(always)]
    fn second_moment(first: usize, cells: usize) -> Option<f64> {
        (first >= 2 && first + 3 <= cells).then_some(0.25)
    }

    #[inline]
    fn evaluate(x: f64, _width: f64, cells: usize) -> (usize, [f64; 3], [f64; 3]) {
        let cell = cell_index(x, cells);
        if cell < 2 || cell + 3 > cells {
            let (w, g) = open_spline::<3>(x, cell, cells);
            return (cell, w, g);
        }
        let s = x - cell as f64;
        let t = 1.0 - s;
        (cell, [0.5 * t * t, 0.5 + s * t, 0.5 * s * s], [-t, t - s, s])
    }

    #[inline(always)]
    fn evaluate_batch(x: &BatchArray, count: usize, width: f64, cells: usize, out: &mut AxisBatch<3>) {
        let is_inside = cell_indices(x, cells, 2, &mut out.first);
        let (first, [w0, w1, w2], [g0, g1, g2]) = (&out.first, &mut out.weights, &mut out.gradients);
        for point in 0..STENCIL_BATCH {
            let s = x[point] - f64::from(first[point]);
            let t = 1.0 - s;
            (w0[point], w1[point], w2[point]) = (0.5 * t * t, 0.5 + s * t, 0.5 * s * s);
            (g0[point], g1[point], g2[point]) = (-t, t - s, s);
        }
        if !is_inside {
            set_near_ends::<3, Self>(x, count, width, cells, 2, out);
        }
    }

    #[inline(always)]
    fn coordinates_batch(first: &[u32; STENCIL_BATCH], cells: usize, out: &mut [BatchArray; 3]) {
        consecutive_batch::<3, Self>(first, cells, 1, 0.5, out);
    }
}

/// Cubic B-splines with open knots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CubicSpline;

impl Basis<4> for CubicSpline {
    const NAME: &'static str = "cubic B-spline";
    const ALLOWS_INTERIOR_WALLS: bool = false;
    const GHOSTS: usize = 0;
    const NODES_BELOW: usize = 0;
    const NODES_ABOVE: usize = 3;

    fn nodes(cells: usize) -> usize {
        cells + 3
    }

    #[inline]
    fn coordinate(index: usize, cells: usize) -> f64 {
        // Away from the ends, the middle one of three knots.
        if (2..=cells).contains(&index) { (index - 1) as f64 } else { greville(index, cells, 3) }
    }

    #[inline(always)]
    fn coordinates(first: usize, cells: usize) -> [f64; 4] {
        if first >= 2 && first + 3 <= cells {
            consecutive((first - 1) as f64)
        } else {
            coordinates_near_ends::<4, Self>(first, cells)
        }
    }

    #[inline(always)]
    fn second_moment(first: usize, cells: usize) -> Option<f64> {
        (first >= 3 && first + 4 <= cells).then_some(1.0 / 3.0)
    }

    #[inline]
    fn evaluate(x: f64, _width: f64, cells: usize) -> (usize, [f64; 4], [f64; 4]) {
        let cell = cell_index(x, cells);
        if cell < 3 || cell + 4 > cells {
            let (w, g) = open_spline::<4>(x, cell, cells);
            return (cell, w, g);
        }
        let s = x - cell as f64;
        let t = 1.0 - s;
        let sixth = 1.0 / 6.0;
        let w0 = t * t * t * sixth;
        let w3 = s * s * s * sixth;
        let w1 = (4.0 - 3.0 * s * s * (1.0 + t)) * sixth;
        let g0 = -0.5 * t * t;
        let g3 = 0.5 * s * s;
        let g1 = 0.5 * s * (3.0 * s - 4.0);
        (cell, [w0, w1, 1.0 - w0 - w1 - w3, w3], [g0, g1, -g0 - g1 - g3, g3])
    }

    #[inline(always)]
    fn coordinates_batch(first: &[u32; STENCIL_BATCH], cells: usize, out: &mut [BatchArray; 4]) {
        consecutive_batch::<4, Self>(first, cells, 2, 1.0, out);
    }
}
