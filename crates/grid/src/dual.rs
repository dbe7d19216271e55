//! Dual-domain shape functions (Zhang et al. 2011; MPM sheet §2.5f): linear weights, and gradients that are continuous
//! across cells.

use crate::{Basis, Gathered, Grid, Lanes, Node, Stencil, Support};

/// The linear functions among four nodes an axis, for [`DualNodes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DualDomain;

impl Basis<4> for DualDomain {
    const NAME: &'static str = "dual domain";
    const GHOSTS: usize = 1;
    const BELOW: usize = 1;
    const ABOVE: usize = 2;

    fn nodes(cells: usize) -> usize {
        cells + 3
    }

    fn coordinate(index: usize, _cells: usize) -> f64 {
        index as f64 - 1.0
    }

    #[inline]
    fn evaluate(x: f64, _width: f64, cells: usize) -> (usize, [f64; 4], [f64; 4]) {
        let cell = (x.max(0.0) as usize).min(cells - 1);
        let s = x - cell as f64;
        (cell, [0.0, 1.0 - s, s, 0.0], [0.0, -1.0, 1.0, 0.0])
    }
}

/// Node `j`'s averages `1/V_j ∫ N_j N_i` and `1/V_j ∫ N_j N_i'` (per cell) over the nodes `i = j - 1, j, j + 1` of an
/// axis; what a node at the end of the grid would take from outside is zero.
fn averages(node: usize, cells: usize) -> ([f64; 3], [f64; 3]) {
    if node == 0 {
        ([0.0, 2.0 / 3.0, 1.0 / 3.0], [0.0, -1.0, 1.0])
    } else if node == cells {
        ([1.0 / 3.0, 2.0 / 3.0, 0.0], [-1.0, 1.0, 0.0])
    } else {
        ([1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0], [-0.5, 0.0, 0.5])
    }
}

/// Nodes of a point with linear weights and the gradients `α ∇N_i + (1 - α) Σ_j N_j 1/V_j ∫ N_j ∇N_i`.
///
/// `α` is the product of the element's shape functions over its value in the middle, `(4 s (1 - s))` per axis to the
/// power of half the number of nodes of an element: it vanishes on the faces of cells.
#[derive(Clone, Copy, Debug)]
pub struct DualNodes<const D: usize, const S: usize> {
    linear: Stencil<D, S>,
    /// Weights and slopes of the nodal averages along each axis.
    averaged: Stencil<D, S>,
    share: f64,
}

impl<const D: usize, const S: usize> DualNodes<D, S> {
    /// The nodes of a point at `position` (m).
    #[inline(always)]
    pub fn new<B: Basis<S>>(grid: &Grid<D>, position: &[f64; D]) -> Self {
        let linear = Stencil::new::<B>(grid, position, &[0.0; D]);
        let mut averaged = linear;
        let mut bubble = 1.0;
        for axis in 0..D {
            let (cell, s) = (linear.first[axis], linear.weights[axis][2]);
            bubble *= 4.0 * s * (1.0 - s);
            (averaged.weights[axis], averaged.gradients[axis]) = ([0.0; S], [0.0; S]);
            for (k, weight) in [(0, 1.0 - s), (1, s)] {
                let (values, slopes) = averages(cell + k, grid.cells[axis]);
                for i in 0..3 {
                    averaged.weights[axis][k + i] += weight * values[i];
                    averaged.gradients[axis][k + i] += weight * slopes[i] / grid.cell;
                }
            }
        }
        Self { linear, averaged, share: bubble.max(0.0).powi(1 << (D - 1)) }
    }

    #[inline(always)]
    fn split(&self, columns: &[Lanes; D]) -> [[Lanes; D]; 2] {
        [columns.map(|c| c * self.share), columns.map(|c| c * (1.0 - self.share))]
    }

    #[inline(always)]
    fn join(&self, out: &mut Gathered<D>, averaged: &Gathered<D>) {
        for (column, other) in out.gradient.iter_mut().zip(&averaged.gradient) {
            *column = *column * self.share + *other * (1.0 - self.share);
        }
    }
}

impl<const D: usize, const S: usize> Support<D> for DualNodes<D, S> {
    fn for_each(&self, strides: &[usize; D], mut visit: impl FnMut(usize, f64, &[f64; D])) {
        self.linear.for_each(strides, |number, w, g| visit(number, w, &g.map(|c| self.share * c)));
        self.averaged
            .for_each(strides, |number, _, g| visit(number, 0.0, &g.map(|c| (1.0 - self.share) * c)));
    }

    fn moments<const T: usize, B: Basis<T>>(&self, grid: &Grid<D>, position: &[f64; D]) -> (Self, [f64; D]) {
        let (linear, squares) = self.linear.moments_at(grid, position, B::coordinate);
        (Self { linear, share: 1.0, ..*self }, squares)
    }

    #[inline(always)]
    fn deposit(
        &self,
        nodes: &mut [Node],
        offset: usize,
        strides: &[usize; D],
        motion: Lanes,
        columns: &[Lanes; D],
        body: Option<Lanes>,
    ) {
        let [linear, averaged] = self.split(columns);
        self.linear.deposit(nodes, offset, strides, motion, &linear, body);
        self.averaged.deposit_slopes(nodes, offset, strides, Lanes::ZERO, &averaged, |node| &mut node.force);
    }

    #[inline(always)]
    fn gather(&self, nodes: &[Node], strides: &[usize; D]) -> Gathered<D> {
        let mut out = self.linear.gather(nodes, strides);
        self.join(&mut out, &self.averaged.gather(nodes, strides));
        out
    }

    #[inline(always)]
    fn gather_velocity(&self, nodes: &[Lanes], strides: &[usize; D]) -> Gathered<D> {
        let mut out = self.linear.gather_velocity(nodes, strides);
        self.join(&mut out, &self.averaged.gather_velocity(nodes, strides));
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Layout;
    use proptest::prelude::*;

    /// Sum over the nodes of value and gradient times `field` of the node's place (cells of 1 m).
    fn sums<const D: usize>(x: [f64; D], field: impl Fn(&[f64; D]) -> f64) -> (f64, [f64; D]) {
        let grid = Grid::new([0.0; D], [6.0; D], 1.0).unwrap();
        let strides = Layout::<D>::new::<4, DualDomain>(&grid).strides();
        let (mut value, mut slope) = (0.0, [0.0; D]);
        DualNodes::<D, 4>::new::<DualDomain>(&grid, &x).for_each(&strides, |number, w, g| {
            let mut rest = number;
            let place = std::array::from_fn(|axis| {
                let index = rest / strides[axis];
                rest %= strides[axis];
                DualDomain::coordinate(index, 6)
            });
            value += w * field(&place);
            (0..D).for_each(|c| slope[c] += g[c] * field(&place));
        });
        (value, slope)
    }

    fn linear_is_exact<const D: usize>(x: [f64; D]) {
        let (one, zero) = sums(x, |_| 1.0);
        assert!((one - 1.0).abs() < 1e-13 && zero.iter().all(|c| c.abs() < 1e-12));
        for axis in 0..D {
            let (value, slope) = sums(x, |place| place[axis]);
            assert!((value - x[axis]).abs() < 1e-12);
            for c in 0..D {
                // Away from the ends: there the averages of a node see one side only, and are still exact along it.
                let exact = if c == axis { 1.0 } else { 0.0 };
                assert!((slope[c] - exact).abs() < 1e-12, "{slope:?} at {x:?}");
            }
        }
    }

    proptest! {
        #[test]
        fn linear_fields_are_reproduced(x in proptest::array::uniform3(1.0..5.0f64)) {
            linear_is_exact([x[0]]);
            linear_is_exact([x[0], x[1]]);
            linear_is_exact(x);
        }

        #[test]
        fn gradients_are_continuous_across_cells(y in 0.1..5.9f64, node in 1..5i32) {
            let field = |place: &[f64; 2]| (1.3 * place[0]).sin() * (0.7 * place[1]).cos();
            let face = f64::from(node);
            let (_, below) = sums([face - 1e-9, y], field);
            let (_, above) = sums([face + 1e-9, y], field);
            prop_assert!((0..2).all(|c| (below[c] - above[c]).abs() < 1e-6), "{below:?} {above:?}");
        }
    }

    #[test]
    fn in_the_middle_of_a_cell_the_gradient_is_the_linear_one() {
        let (_, slope) = sums([2.5, 3.5], |place| place[0] * place[0]);
        assert!((slope[0] - 5.0).abs() < 1e-12, "(9 - 4) / 1");
    }
}
