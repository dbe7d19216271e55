//! Work of the stresses, and what of it is dissipated (MPM sheet A-30: energy balance of a run-out).
//!
//! A point does the work `∫ σ : D Ω dt`, in each step with the mean of `Ω σ` before and after. What of it is not stored, by what
//! the law says of its stress, is dissipated.

use colluvium_constitutive::{BLOCK, Motion, SymTensor};
use colluvium_grid::Basis;

use crate::points::PointDomain;
use crate::report::stored_energies;
use crate::solver::MpmSolver;

/// Stresses (Pa) of a block before its update.
pub struct Before([SymTensor; BLOCK]);

impl Before {
    /// Takes those of a block.
    pub fn of(stresses: &[SymTensor]) -> Self {
        let mut before = [SymTensor::ZERO; BLOCK];
        before[..stresses.len()].copy_from_slice(stresses);
        Self(before)
    }

    /// Adds the work (J) of a step that ends with stresses `after` (Pa) and `volumes`.
    pub fn add_work(&self, motions: &[Motion], after: &[SymTensor], volumes: &[f64], work: &mut [f64]) {
        for (p, motion) in motions.iter().enumerate() {
            let volume = volumes[p];
            let started = volume / motion.deformation.determinant();
            let mean = self.0[p] * (0.5 * started) + after[p] * (0.5 * volume);
            work[p] += mean.dot(&motion.strain_increment());
        }
    }
}

impl<const D: usize, const S: usize, B: Basis<S>, P: PointDomain<D>> MpmSolver<D, S, B, P> {
    /// Begins to count work, from what is stored.
    pub(crate) fn count_work(&mut self) {
        for set in self.sets.iter_mut().filter(|set| set.rigid.is_none()) {
            set.work = stored_energies(set);
        }
    }

    /// Energy dissipated since the start (J), of the points that are there.
    pub(crate) fn dissipated_energy(&self) -> f64 {
        let counted = self.sets.iter().filter(|set| !set.work.is_empty());
        let lost = counted.map(|set| {
            let stored = stored_energies(set);
            set.work.iter().zip(stored).map(|(work, stored)| work - stored).sum::<f64>()
        });
        lost.sum()
    }
}
