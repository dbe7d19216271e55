//! Kernel sum `Σ m W` in lanes of four nodes.

use wide::f64x4;

use crate::kernel::Kernel;
use crate::neighbours::cell_sorted::sum_lanes;

/// Kernel sum `Σ m W` under construction.
pub struct KernelSum<const D: usize> {
    inverse: f64,
    support_radius: f64x4,
    factor: f64,
    total: f64x4,
}

impl<const D: usize> KernelSum<D> {
    /// Empty sum with this smoothing length (m).
    #[inline(always)]
    pub fn new(kernel: Kernel, length: f64) -> Self {
        let (inverse, reach) = (1.0 / length, kernel.support() * length);
        let factor = kernel.factor::<D>() * inverse.powi(D as i32);
        Self { inverse, support_radius: f64x4::splat(reach), factor, total: f64x4::ZERO }
    }

    /// Adds four nodes: their distances (m) and volumes.
    #[inline(always)]
    pub fn add(&mut self, kernel: Kernel, distance: f64x4, volume: f64x4) {
        let shape = kernel.profile_of_four::<D>(distance * self.inverse);
        self.total += (distance.simd_lt(self.support_radius) & shape) * volume;
    }

    /// The sum of all lanes.
    #[inline(always)]
    pub fn total(self) -> f64 {
        sum_lanes(self.total) * self.factor
    }
}
