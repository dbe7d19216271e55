//! Data that are constant during a run: case, options, kernel and gravity.

use std::sync::Arc;

use colluvium_case::Case;

use crate::SphOptions;
use crate::clock::Clock;
use crate::kernel::Smoothing;

/// Leading components of a vector of the case.
pub fn leading_components<const D: usize>(values: &[f64]) -> [f64; D] {
    std::array::from_fn(|axis| values[axis])
}

/// Case, options, kernel and gravity, constant during a run.
#[derive(Clone)]
pub struct SolverContext<const D: usize> {
    /// Case of the run.
    pub case: Arc<Case>,
    /// Options of this method.
    pub options: SphOptions,
    /// Kernel at the initial smoothing length.
    pub smoothing: Smoothing<D>,
    /// Full gravity (m/s²).
    pub gravity: [f64; D],
}

impl<const D: usize> SolverContext<D> {
    /// Gravity at the end of a step of `dt` (m/s²).
    pub fn gravity_at(&self, clock: &Clock, dt: f64) -> [f64; D] {
        let factor = self.case.stages[clock.stage].gravity_factor(clock.time + dt - clock.stage_start);
        self.gravity.map(|g| g * factor)
    }

    /// Smoothing length `h₀ (ρ₀/ρ)^(1/d)`, bounded (m), of the `initial` and the present density (kg/m³).
    pub fn length_at(&self, initial: f64, density: f64) -> f64 {
        let ratio = (initial / density).powf(1.0 / D as f64);
        self.smoothing.length() * ratio.min(self.options.smoothing_growth)
    }

    /// Factor of viscous damping on a velocity after `dt` (s), at the speed of sound `sound` (m/s) and the smoothing
    /// length `h` (m).
    pub fn damping_factor(&self, sound: f64, h: f64, dt: f64) -> f64 {
        let damping = self.options.damping;
        if damping > 0.0 { (-damping / h * sound * dt).exp() } else { 1.0 }
    }

    /// Radius of the kernel support at the smoothing length `length` (m).
    pub fn support(&self, length: f64) -> f64 {
        self.smoothing.kernel().support() * length
    }

    /// Whether the stage has an equilibrium criterion.
    pub fn needs_equilibrium(&self, clock: &Clock) -> bool {
        self.case.stages[clock.stage].equilibrium.is_some()
    }
}
