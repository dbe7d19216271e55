//! Dimensionless numbers and regimes of granular flow (sheet: constitutive §2.9; Wu, Wang & Alipour 2020,
//! §2; Bagnold 1954; Krieger & Dougherty 1959). Diagnostics: no law depends on them but for the inertial
//! number.

/// Inertial number `I = γ̇ d / √(p/ρ_s)` of shear rate `shear_rate` (1/s), grain diameter `diameter` (m),
/// `pressure` (Pa, compression-positive) and density of the grains `grain_density` (kg/m³). Infinite without
/// pressure where there is flow, zero without flow.
#[inline]
pub fn inertial_number(shear_rate: f64, diameter: f64, pressure: f64, grain_density: f64) -> f64 {
    if shear_rate == 0.0 { 0.0 } else { shear_rate * diameter / (pressure.max(0.0) / grain_density).sqrt() }
}

/// Savage number `ρ_s d² γ̇² / p`, collisional over frictional stress: the square of the inertial number.
pub fn savage_number(shear_rate: f64, diameter: f64, pressure: f64, grain_density: f64) -> f64 {
    inertial_number(shear_rate, diameter, pressure, grain_density).powi(2)
}

/// Linear concentration `λ_B = 1 / ((φ_max/φ)^⅓ - 1)`: grain diameter over mean gap, at solid fraction
/// `fraction` (0 to `densest`). Infinite at the densest packing.
pub fn linear_concentration(fraction: f64, densest: f64) -> f64 {
    1.0 / ((densest / fraction).cbrt() - 1.0)
}

/// Bagnold number `ρ d² √λ_B γ̇ / μ_f`, the ratio of grain inertia to viscous stress of the pore fluid. `concentration` is the linear
/// concentration `λ_B`, `fluid_viscosity` the viscosity `μ_f` (Pa s).
pub fn bagnold_number(
    shear_rate: f64,
    diameter: f64,
    grain_density: f64,
    concentration: f64,
    fluid_viscosity: f64,
) -> f64 {
    grain_density * diameter * diameter * concentration.sqrt() * shear_rate / fluid_viscosity
}

/// Relative viscosity `α (1 - φ/φ_m)^-β` of a suspension of solid fraction `fraction`; infinite from the
/// densest packing `densest` on. Rigid spheres: `α = 1`, `β = 2.5 φ_m`.
pub fn krieger_dougherty(fraction: f64, densest: f64, prefactor: f64, exponent: f64) -> f64 {
    prefactor * (1.0 - fraction / densest).max(0.0).powf(-exponent)
}

/// Solid fraction `φ(I) = φ_max - (φ_max - φ_min) I` of steady flow, not below `loosest`.
pub fn solid_fraction(inertial_number: f64, densest: f64, loosest: f64) -> f64 {
    (densest - (densest - loosest) * inertial_number).max(loosest)
}

/// Regimes of dry granular flow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlowRegime {
    /// Quasi-static flow, independent of the rate, `I < 10⁻³`.
    QuasiStatic,
    /// Dense flow, in between.
    Dense,
    /// Collisional flow, `I > 10⁻¹`.
    Collisional,
}

impl FlowRegime {
    /// Regime at the given inertial number.
    pub fn at_inertial_number(inertial_number: f64) -> Self {
        match inertial_number {
            i if i < 1e-3 => Self::QuasiStatic,
            i if i <= 1e-1 => Self::Dense,
            _ => Self::Collisional,
        }
    }
}

/// Regimes of grains in a fluid after Bagnold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BagnoldRegime {
    /// Macro-viscous regime, stress grows with the rate, `N_B < 40`.
    MacroViscous,
    /// Transitional regime, in between.
    Transitional,
    /// Grain-inertia regime, stress grows with about the square of the rate, `N_B > 450`.
    GrainInertia,
}

impl BagnoldRegime {
    /// Regime at the given Bagnold number.
    pub fn at_bagnold_number(bagnold_number: f64) -> Self {
        match bagnold_number {
            n if n < 40.0 => Self::MacroViscous,
            n if n <= 450.0 => Self::Transitional,
            _ => Self::GrainInertia,
        }
    }
}
