//! Shape functions of the reference configuration (total-Lagrangian; sheet: mpm §2.5g).

use crate::{Basis, Grid, InterpolatedMotion, NodalState, NodeSupport, Stencil, Vector4};

/// Nodes of a point at its initial position, with gradients in the current configuration, `∇N = F⁻ᵀ ∇₀N`. Thus `Σ V σ ∇N` equals `Σ V₀ P
/// ∇₀N` with the first Piola–Kirchhoff stress, and `Σ v ⊗ ∇N` equals `Ḟ F⁻¹`.
///
/// So `Σ V σ ∇N` is `Σ V₀ P ∇₀N` with the first Piola–Kirchhoff stress, and `Σ v ⊗ ∇N` is `Ḟ F⁻¹`.
#[derive(Clone, Copy, Debug)]
pub struct ReferenceStencil<const D: usize, const S: usize> {
    /// Nodes and gradients of the initial configuration.
    pub reference: Stencil<D, S>,
    /// Inverse `F⁻¹` of the deformation gradient, as an array of rows.
    pub inverse: [[f64; D]; D],
}

impl<const D: usize, const S: usize> ReferenceStencil<D, S> {
    /// Stress columns in the reference configuration: product with the inverse deformation gradient.
    #[inline(always)]
    fn pull_back(&self, columns: &[Vector4; D]) -> [Vector4; D] {
        std::array::from_fn(|k| {
            let mut sum = Vector4::ZERO;
            for (column, inverse) in columns.iter().zip(&self.inverse[k]) {
                sum += *column * *inverse;
            }
            sum
        })
    }

    /// Velocity gradient in the current configuration, from that in the reference one.
    #[inline(always)]
    fn push_forward(&self, mut out: InterpolatedMotion<D>) -> InterpolatedMotion<D> {
        let reference = out.gradient;
        for (j, column) in out.gradient.iter_mut().enumerate() {
            *column = Vector4::ZERO;
            for (k, slope) in reference.iter().enumerate() {
                *column += *slope * self.inverse[k][j];
            }
        }
        out
    }
}

impl<const D: usize, const S: usize> NodeSupport<D> for ReferenceStencil<D, S> {
    fn for_each(&self, strides: &[usize; D], mut visit: impl FnMut(usize, f64, &[f64; D])) {
        self.reference.for_each(strides, |number, w, g| {
            let slopes = std::array::from_fn(|j| (0..D).map(|k| self.inverse[k][j] * g[k]).sum());
            visit(number, w, &slopes);
        });
    }

    /// Returns the moments of the initial configuration: `position` is the initial position of the point.
    fn affine_moments<const T: usize, B: Basis<T>>(
        &self,
        grid: &Grid<D>,
        position: &[f64; D],
    ) -> (Self, [f64; D]) {
        let (reference, squares) = self.reference.affine_moments::<T, B>(grid, position);
        (Self { reference, ..*self }.with_matching_gradients(), squares)
    }

    #[inline(always)]
    fn with_matching_gradients(&self) -> Self {
        let inverse = std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }));
        Self { reference: self.reference, inverse }
    }

    #[inline(always)]
    fn p2g(
        &self,
        nodes: &mut [NodalState],
        offset: usize,
        strides: &[usize; D],
        motion: Vector4,
        columns: &[Vector4; D],
        body: Option<Vector4>,
    ) {
        self.reference.p2g(nodes, offset, strides, motion, &self.pull_back(columns), body);
    }

    #[inline(always)]
    fn p2g_value<T>(
        &self,
        nodes: &mut [T],
        offset: usize,
        strides: &[usize; D],
        value: Vector4,
        at: impl Fn(&mut T) -> &mut Vector4,
    ) {
        self.reference.p2g_value(nodes, offset, strides, value, at);
    }

    #[inline(always)]
    fn g2p(&self, nodes: &[NodalState], strides: &[usize; D]) -> InterpolatedMotion<D> {
        self.push_forward(self.reference.g2p(nodes, strides))
    }

    #[inline(always)]
    fn g2p_motion(&self, nodes: &[NodalState], strides: &[usize; D]) -> [Vector4; 2] {
        self.reference.g2p_motion(nodes, strides)
    }

    #[inline(always)]
    fn g2p_velocity(&self, nodes: &[Vector4], strides: &[usize; D]) -> InterpolatedMotion<D> {
        self.push_forward(self.reference.g2p_velocity(nodes, strides))
    }
}
