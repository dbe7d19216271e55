//! Dependence of stiffness and friction on pressure and density.

use super::{Simsand, VOID_RANGE};
use crate::SymTensor;
use crate::laws::pressure_elastic::MIN_PRESSURE;

/// Void ratio at which the stiffness of the formula vanishes.
const ZERO_STIFFNESS_VOID_RATIO: f64 = 2.97;

/// Stress ratio `M_x` with its derivatives by pressure (1/Pa), void ratio and Lode's cosine.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StressRatio {
    /// Value of the stress ratio `M_x`.
    pub value: f64,
    /// Derivative with respect to the mean pressure (1/Pa).
    pub(super) by_pressure: f64,
    /// Derivative with respect to the void ratio.
    pub(super) by_void_ratio: f64,
    /// Derivative with respect to the cosine of the Lode angle.
    pub(super) by_lode: f64,
}

/// Lode's cosine `cos 3θ` of a deviator.
pub(super) fn lode_cosine(deviator: &SymTensor) -> f64 {
    let j2 = 0.5 * deviator.dot(deviator);
    if j2 <= f64::MIN_POSITIVE {
        return 0.0;
    }
    (1.5 * 3f64.sqrt() * deviator.determinant() / (j2 * j2.sqrt())).clamp(-1.0, 1.0)
}

/// Derivative of `cos 3θ = (3√3/2) J3/J2^(3/2)` by the deviator: a deviator.
pub(super) fn lode_gradient(s: &SymTensor) -> SymTensor {
    let j2 = 0.5 * s.dot(s);
    let m = s.to_matrix();
    let squared = (m * m).sym().deviator();
    let c = 1.5 * 3f64.sqrt() / (j2 * j2.sqrt());
    squared * c + *s * (-1.5 * c * s.determinant() / j2)
}

impl Simsand {
    /// Bulk modulus (Pa) at a pressure (Pa) and void ratio.
    pub fn bulk_modulus(&self, pressure: f64, void_ratio: f64) -> f64 {
        let spec = &self.spec;
        let p = pressure.max(MIN_PRESSURE) / spec.atmospheric_pressure;
        let e = void_ratio.clamp(VOID_RANGE.0, VOID_RANGE.1);
        let density = (ZERO_STIFFNESS_VOID_RATIO - e).powi(2) / (1.0 + e);
        spec.stiffness_constant * spec.atmospheric_pressure * density * p.powf(spec.stiffness_exponent)
    }

    /// Void ratio of the critical state at a pressure (Pa).
    pub fn critical_void_ratio(&self, pressure: f64) -> f64 {
        let spec = &self.spec;
        let power = (pressure / spec.atmospheric_pressure).powf(spec.critical_state_exponent);
        spec.reference_void_ratio - spec.critical_state_factor * power
    }

    /// Pressure of the critical state at a void ratio (Pa); `None` if it is not below the reference void ratio.
    pub fn critical_pressure(&self, void_ratio: f64) -> Option<f64> {
        let spec = &self.spec;
        let ratio = (spec.reference_void_ratio - void_ratio) / spec.critical_state_factor;
        (ratio > 0.0).then(|| spec.atmospheric_pressure * ratio.powf(1.0 / spec.critical_state_exponent))
    }

    /// Stress ratio `M_c` of the critical state in triaxial compression.
    pub fn critical_slope(&self) -> f64 {
        let sin = self.tangent_critical / self.tangent_critical.hypot(1.0);
        6.0 * sin / (3.0 - sin)
    }

    /// Stress ratios `M_p` and `M_pt` at a pressure (Pa), void ratio and Lode cosine (1 extension, -1 compression).
    pub fn slopes(&self, pressure: f64, void_ratio: f64, lode: f64) -> [StressRatio; 2] {
        let spec = &self.spec;
        let power = (pressure / spec.atmospheric_pressure).powf(spec.critical_state_exponent);
        let free = spec.reference_void_ratio - spec.critical_state_factor * power;
        let critical = free.max(VOID_RANGE.0);
        let e = void_ratio.clamp(VOID_RANGE.0, VOID_RANGE.1);
        // Logarithmic derivatives of e_c/e; zero where a bound is active.
        let log_by_pressure = if free < critical {
            0.0
        } else {
            -spec.critical_state_exponent * spec.critical_state_factor * power / (pressure * critical)
        };
        let log_by_void = if e == void_ratio { -1.0 / e } else { 0.0 };
        [spec.peak_exponent, -spec.dilatancy_exponent].map(|exponent| {
            let tan = (critical / e).powf(exponent) * self.tangent_critical;
            let root = tan.hypot(1.0);
            let sin = tan / root;
            // Derivative by ln tan φ.
            let sin_slope = tan / root.powi(3);
            let (mut value, mut by_sin) = (6.0 * sin / (3.0 - sin), 18.0 / (3.0 - sin).powi(2));
            let mut by_lode = 0.0;
            if spec.lode_dependence {
                let c = (3.0 - sin) / (3.0 + sin);
                let u = c.powi(4);
                let below = (1.0 + lode) + u * (1.0 - lode);
                let factor = (2.0 * u / below).powf(0.25);
                // d ln factor = d(2u/below) / (4 · 2u/below)
                let by_u = 0.25 * (1.0 + lode) / (u * below);
                let u_by_sin = 4.0 * c.powi(3) * (-6.0 / (3.0 + sin).powi(2));
                by_sin = factor * (by_sin + value * by_u * u_by_sin);
                by_lode = -0.25 * value * factor * (1.0 - u) / below;
                value *= factor;
            }
            let by_log = by_sin * sin_slope * exponent;
            StressRatio {
                value,
                by_pressure: by_log * log_by_pressure,
                by_void_ratio: by_log * log_by_void,
                by_lode,
            }
        })
    }

    /// Mobilised fraction of the strength, `ε_q/(k_p + ε_q)`, and its derivative.
    pub(super) fn mobilised_share(&self, plastic_strain: f64) -> (f64, f64) {
        let sum = self.spec.hardening_constant + plastic_strain;
        (plastic_strain / sum, self.spec.hardening_constant / (sum * sum))
    }
}
