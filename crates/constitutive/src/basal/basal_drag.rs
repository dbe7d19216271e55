//! Speed-dependent part of the basal shear stress, and the speed after an implicit step.

use crate::basal::{BasalFlow, BinghamSolution};

/// Part of the basal shear stress that depends on the speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BasalDrag {
    /// No drag.
    None,
    /// Power law of the shear rate: `μ ((1 + 2m)/m · v̄/h)^m`.
    Viscous {
        /// Consistency `μ` (Pa sᵐ).
        consistency: f64,
        /// Power `m`.
        exponent: f64,
    },
    /// Turbulence, `ρ g v̄²/ξ`.
    Turbulent {
        /// Turbulence coefficient `ξ` (m/s²); infinite for none.
        coefficient: f64,
    },
    /// Turbulence by Manning's roughness, `ρ g n² v̄²/h^⅓`.
    Manning {
        /// Roughness `n` (s/m^⅓).
        roughness: f64,
    },
    /// Dense granular flow beyond its friction at rest: `σ' (μ_2 - μ_s)/(I_0/I + 1)` with `I = 5 v̄ d/(2h √(σ'/ρ_s))`,
    /// that of Bagnold's profile at its base.
    Granular {
        /// Friction range `μ_2 - μ_s`.
        friction_range: f64,
        /// Inertial number `I_0` at which friction is halfway between the two.
        reference: f64,
        /// Diameter `d` of the grains (m).
        diameter: f64,
        /// Density `ρ_s` of the grains (kg/m³).
        grain_density: f64,
    },
    /// Bingham profile, whose yield stress is the strength.
    Bingham {
        /// Plastic viscosity `μ` (Pa s).
        viscosity: f64,
        /// Solution of the cubic equation.
        solution: BinghamSolution,
    },
}

/// Speed `w` at which the inertial number of a column is `reference`.
#[inline]
fn reference_speed(reference: f64, diameter: f64, grain_density: f64, effective: f64, depth: f64) -> f64 {
    0.4 * reference * depth * (effective / grain_density).sqrt() / diameter
}

impl BasalDrag {
    /// Factor `b` of `b v̄²` for drag that grows with the square of speed.
    #[inline]
    fn quadratic(&self, flow: &BasalFlow) -> Option<f64> {
        match *self {
            Self::Turbulent { coefficient } => Some(flow.unit_weight / coefficient),
            Self::Manning { roughness } => Some(flow.unit_weight * roughness * roughness / flow.depth.cbrt()),
            Self::Viscous { consistency, exponent: 2.0 } => {
                Some(6.25 * consistency / (flow.depth * flow.depth))
            }
            _ => None,
        }
    }

    /// Shear stress (Pa) in addition to the strength; `effective` is the effective normal stress (Pa). Zero for
    /// [`BasalDrag::Bingham`], which is no sum.
    #[inline]
    pub(super) fn shear_stress(&self, effective: f64, flow: &BasalFlow) -> f64 {
        match *self {
            Self::None | Self::Bingham { .. } => 0.0,
            Self::Viscous { consistency, exponent: m } => {
                consistency * ((1.0 + 2.0 * m) / m * flow.speed / flow.depth).powf(m)
            }
            Self::Turbulent { coefficient } => flow.unit_weight * flow.speed * flow.speed / coefficient,
            Self::Manning { .. } => self.quadratic(flow).unwrap_or(0.0) * flow.speed * flow.speed,
            Self::Granular { friction_range: rise, reference, diameter, grain_density } => {
                let half = reference_speed(reference, diameter, grain_density, effective, flow.depth);
                if flow.speed > 0.0 { effective * rise * flow.speed / (flow.speed + half) } else { 0.0 }
            }
        }
    }

    /// Root `v₁` of `v₁ - v₀ + k D(v₁) = 0`.
    #[inline]
    pub(super) fn speed_after_step(&self, effective: f64, flow: &BasalFlow, impulse: f64) -> f64 {
        let speed = flow.speed;
        if let Some(factor) = self.quadratic(flow) {
            return 2.0 * speed / (1.0 + (1.0 + 4.0 * impulse * factor * speed).sqrt());
        }
        match *self {
            Self::Viscous { consistency, exponent: 1.0 } => {
                speed / (1.0 + 3.0 * consistency * impulse / flow.depth)
            }
            Self::Viscous { consistency, exponent: m } => {
                let factor = impulse * consistency * ((1.0 + 2.0 * m) / m / flow.depth).powf(m);
                power_root(speed, factor, m)
            }
            Self::Granular { friction_range: rise, reference, diameter, grain_density } => {
                let half = reference_speed(reference, diameter, grain_density, effective, flow.depth);
                // v₁² + b v₁ - v₀ w = 0.
                let b = half + impulse * effective * rise - speed;
                let root = b.hypot(2.0 * (speed * half).sqrt());
                if b > 0.0 { 2.0 * speed * half / (b + root) } else { 0.5 * (root - b) }
            }
            _ => speed,
        }
    }
}

/// Root `v` in `[0, speed]` of `v + factor vᵐ = speed`, by Newton's method within a bracket.
fn power_root(speed: f64, factor: f64, m: f64) -> f64 {
    let (mut low, mut high) = (0.0, speed);
    let mut v = (speed / factor).powf(1.0 / m).min(speed);
    for _ in 0..100 {
        let drag = factor * v.powf(m);
        let excess = v + drag - speed;
        if excess.abs() <= 1e-14 * speed {
            break;
        }
        if excess > 0.0 {
            high = v;
        } else {
            low = v;
        }
        let next = v - excess * v / (v + m * drag);
        v = if next > low && next < high { next } else { 0.5 * (low + high) };
    }
    v
}
