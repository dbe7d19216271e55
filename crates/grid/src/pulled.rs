//! Shape functions of the reference configuration (total-Lagrangian; sheet: mpm §2.5g).

use crate::{Basis, Gathered, Grid, Lanes, Node, Stencil, Support};

/// The nodes of a point where it was at the start, with gradients by where it is now: `∇N = F⁻ᵀ ∇₀N`.
///
/// So `Σ V σ ∇N` is `Σ V₀ P ∇₀N` with the first Piola–Kirchhoff stress, and `Σ v ⊗ ∇N` is `Ḟ F⁻¹`.
#[derive(Clone, Copy, Debug)]
pub struct Pulled<const D: usize, const S: usize> {
    /// The nodes and gradients of the start.
    pub reference: Stencil<D, S>,
    /// `F⁻¹`, row by row.
    pub inverse: [[f64; D]; D],
}

impl<const D: usize, const S: usize> Pulled<D, S> {
    #[inline(always)]
    fn pull(&self, columns: &[Lanes; D]) -> [Lanes; D] {
        std::array::from_fn(|k| {
            let mut sum = Lanes::ZERO;
            for (column, inverse) in columns.iter().zip(&self.inverse[k]) {
                sum += *column * *inverse;
            }
            sum
        })
    }

    #[inline(always)]
    fn push(&self, mut out: Gathered<D>) -> Gathered<D> {
        let reference = out.gradient;
        for (j, column) in out.gradient.iter_mut().enumerate() {
            *column = Lanes::ZERO;
            for (k, slope) in reference.iter().enumerate() {
                *column += *slope * self.inverse[k][j];
            }
        }
        out
    }
}

impl<const D: usize, const S: usize> Support<D> for Pulled<D, S> {
    fn for_each(&self, strides: &[usize; D], mut visit: impl FnMut(usize, f64, &[f64; D])) {
        self.reference.for_each(strides, |number, w, g| {
            let slopes = std::array::from_fn(|j| (0..D).map(|k| self.inverse[k][j] * g[k]).sum());
            visit(number, w, &slopes);
        });
    }

    /// Those of the start: `position` is where the point was then.
    fn moments<const T: usize, B: Basis<T>>(&self, grid: &Grid<D>, position: &[f64; D]) -> (Self, [f64; D]) {
        let (reference, squares) = self.reference.moments::<T, B>(grid, position);
        (Self { reference, ..*self }.of_moments(), squares)
    }

    #[inline(always)]
    fn of_moments(&self) -> Self {
        let inverse = std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }));
        Self { reference: self.reference, inverse }
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
        self.reference.deposit(nodes, offset, strides, motion, &self.pull(columns), body);
    }

    #[inline(always)]
    fn deposit_motion(&self, nodes: &mut [Lanes], offset: usize, strides: &[usize; D], value: Lanes) {
        self.reference.deposit_motion(nodes, offset, strides, value);
    }

    #[inline(always)]
    fn gather(&self, nodes: &[Node], strides: &[usize; D]) -> Gathered<D> {
        self.push(self.reference.gather(nodes, strides))
    }

    #[inline(always)]
    fn gather_motion(&self, nodes: &[Node], strides: &[usize; D]) -> [Lanes; 2] {
        self.reference.gather_motion(nodes, strides)
    }

    #[inline(always)]
    fn gather_velocity(&self, nodes: &[Lanes], strides: &[usize; D]) -> Gathered<D> {
        self.push(self.reference.gather_velocity(nodes, strides))
    }
}
