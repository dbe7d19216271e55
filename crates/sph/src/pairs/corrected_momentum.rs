//! Corrected momentum equation, adjoint to the corrected velocity gradient (sheet: sph §2.3; Bonet & Lok 1999).
//!
//! With `L^v_i = Σ V_j (v_j - v_i) ⊗ L_i ∇W` the stress power `-Σ V_i σ_i : L^v_i` is the power of the pair forces
//! `V_i V_j (σ_i L_i + σ_j L_j) ∇W`: they conserve energy with it, and linear momentum too, for they are antisymmetric.

use crate::pairs::operators::product;
use crate::pairs::{PairContext, PairSums};
use crate::points::particles::SquareMatrix;
use crate::points::vector_algebra::separation;

impl<const D: usize> PairContext<'_, D> {
    /// Correction matrix `L_i = M_i⁻¹` of the corrected gradient; the unit matrix where a particle has too few neighbours.
    pub fn correction(&self, i: usize, row: &[u32]) -> SquareMatrix<D> {
        let unit = std::array::from_fn(|a| std::array::from_fn(|b| f64::from(u8::from(a == b))));
        self.moment(i, row).correction().unwrap_or(unit)
    }
}

impl<const D: usize> PairSums<'_, D> {
    /// Corrected traction `σ_i L_i x`.
    fn corrected_traction(&self, i: usize, x: &[f64; D]) -> [f64; D] {
        let turned = product(&self.pair_data.correction[i], x);
        let stress = &self.particles.stress[i];
        std::array::from_fn(|a| (0..D).map(|b| stress.component(a, b) * turned[b]).sum())
    }

    /// Adds `Σ m_j (σ_i L_i + σ_j L_j) / (ρ_i ρ_j) ∇W` to the acceleration of particle `i` (m/s²).
    pub(crate) fn add_corrected(&self, i: usize, row: &[u32], weights: &[f64], sum: &mut [f64; D]) {
        let p = self.particles;
        for (&j, &weight) in row.iter().zip(weights) {
            let j = j as usize;
            if weight == 0.0 || self.walls.smooth_bodies.contain(j) {
                continue;
            }
            let (apart, _) = separation(&p.position[i], &p.position[j]);
            let (own, other) = (self.corrected_traction(i, &apart), self.corrected_traction(j, &apart));
            let scale = p.mass[j] * weight / (p.density[i] * p.density[j]);
            (0..D).for_each(|c| sum[c] += scale * (own[c] + other[c]));
        }
    }
}
