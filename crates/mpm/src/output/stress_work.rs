//! Work of the stresses, and its dissipated part (sheet: mpm A-30: energy balance of a run-out).
//!
//! A point does the work `∫ σ : D Ω dt`, in each step with the mean of `Ω σ` before and after. The part that the law does not store as
//! recoverable energy is dissipated.

use colluvium_constitutive::{BLOCK_SIZE, MotionBlock, SymTensor};

/// Stresses (Pa) of a block before its update.
pub struct PreviousStress([SymTensor; BLOCK_SIZE]);

impl PreviousStress {
    /// Copies the stresses (Pa) of a block.
    pub fn of_block(stresses: &[SymTensor]) -> Self {
        let mut before = [SymTensor::ZERO; BLOCK_SIZE];
        before[..stresses.len()].copy_from_slice(stresses);
        Self(before)
    }

    /// Adds the work (J) of a step that ends with stresses `after` (Pa) and `volumes`.
    pub fn add_work(&self, motions: &MotionBlock, after: &[SymTensor], volumes: &[f64], work: &mut [f64]) {
        for (p, (work, volume)) in work.iter_mut().zip(volumes).enumerate() {
            let started = volume / motions.volume_ratio(p);
            let mean = self.0[p] * (0.5 * started) + after[p] * (0.5 * volume);
            *work += mean.dot(&motions.motion(p).strain_increment());
        }
    }
}
