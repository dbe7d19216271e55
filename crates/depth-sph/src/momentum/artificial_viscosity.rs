//! Artificial viscosity between approaching nodes (sheet: depth-sph §2.10).

use wide::f64x4;

use crate::config::settings::Numerics;
use crate::points::phase_nodes::PhaseNodes;

/// Softening term of the viscosity for coincident nodes, in squares of the smoothing length.
const SOFTENING: f64 = 0.01;

/// Artificial viscosity of a node against four neighbours.
pub(super) struct ArtificialViscosity {
    linear: f64x4,
    quadratic: f64x4,
    half_effective_gravity: f64x4,
    depth: f64x4,
    height: f64x4,
}

impl ArtificialViscosity {
    /// Artificial viscosity with the data of node `i`.
    pub(super) fn for_node<const D: usize>(numerics: &Numerics, nodes: &PhaseNodes<D>, i: usize) -> Self {
        let (linear, quadratic) = numerics.viscosity;
        Self {
            linear: f64x4::splat(linear),
            quadratic: f64x4::splat(quadratic),
            half_effective_gravity: f64x4::splat(0.5 * nodes.effective_gravity[i]),
            depth: f64x4::splat(nodes.depth[i]),
            height: f64x4::splat(nodes.partial_thickness[i]),
        }
    }

    /// `Π` (m/s² over `m ∇W`) of approaching neighbours: `closing` is the scalar product of relative velocity and relative position.
    #[inline(always)]
    pub(super) fn over_kernel(
        &self,
        closing: f64x4,
        square: f64x4,
        mean: f64x4,
        depths: f64x4,
        heights: f64x4,
    ) -> f64x4 {
        let soft = square + mean * mean * SOFTENING;
        let both = self.height + heights;
        let inverse = f64x4::ONE / (soft * both);
        let rate = mean * closing * both * inverse;
        let celerity = (self.half_effective_gravity * (self.depth + depths)).sqrt();
        (self.quadratic * rate - self.linear * celerity) * rate * soft * inverse * 2.0
    }
}
