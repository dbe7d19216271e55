//! Basal shear stress of depth-averaged flow (sheet: depth-sph §2.6, §3.5; sheet: constitutive §2.11; Pastor et
//! al. 2020, §4).
//!
//! A law is the sum of a strength and a speed-dependent part. With flow depth `h`, depth-averaged speed `v̄`, the share `r_u`
//! of the normal stress carried by water, and `σ' = ((1 - r_u) σ_b - p_b)₊`:
//!
//! - strength ([`BasalStrength`]): `s = σ' tan φ + c`, or cohesion that vanishes with the normal stress;
//! - [`BasalDrag::Viscous`]: `τ_b = s + μ ((1 + 2m)/m · v̄/h)^m`;
//! - [`BasalDrag::Turbulent`]: `τ_b = s + ρ g v̄²/ξ` (Voellmy; Chézy with `ξ = C²`);
//! - [`BasalDrag::Manning`]: `τ_b = s + ρ g n² v̄²/h^⅓`;
//! - [`BasalDrag::Granular`]: `τ_b = s + σ' (μ_2 - μ_s)/(I_0/I + 1)`, `I = 5 v̄ d/(2h √(σ'/ρ_s))`;
//! - [`BasalDrag::Bingham`]: `v̄ = τ_b h/(6μ) (1 - ζ)² (2 + ζ)`, `ζ = s/τ_b`.
//!
//! All are positive numbers (Pa), to be applied against the velocity. Flow at rest mobilises as much as its driving stress,
//! up to its strength. Limits: profiles of steady uniform flow; the strength is taken constant over the depth in
//! [`BasalDrag::Bingham`], linear in the others.

mod basal_drag;
mod basal_strength;
mod bingham;
mod from_material;
mod skeleton_stiffness;
mod spec;

pub use crate::basal::basal_drag::BasalDrag;
pub use crate::basal::basal_strength::{BasalStrength, CohesionForm};
pub use crate::basal::skeleton_stiffness::{LateralConfinement, SkeletonSpec};
pub use bingham::{BinghamSolution, plug_ratio, plug_ratio_quadratic};
pub use spec::{
    BasalSpec, BinghamBaseSpec, ChezySpec, CoulombSpec, GranularBaseSpec, ManningSpec, ViscousFrictionalSpec,
    VoellmySpec,
};

use crate::MaterialError;

/// State of a flow column at its base.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BasalFlow {
    /// Depth `h` (m), normal to the base.
    pub depth: f64,
    /// Depth-averaged speed `v̄` (m/s), not negative.
    pub speed: f64,
    /// Total normal stress on the base (Pa), compression-positive: `ρgh cos θ`, where the bed is plane.
    pub normal_stress: f64,
    /// Pore pressure at the base (Pa), compression-positive, without the part of a law's constant `pore_pressure_ratio`.
    pub pore_pressure: f64,
    /// Tangent of the slope of the bed or energy line that drives the flow, used for flow at rest.
    pub slope: f64,
    /// Unit weight `ρg` of the flowing mass (N/m³).
    pub unit_weight: f64,
}

/// Basal shear stress of depth-averaged flow: a strength and a speed-dependent part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BasalRheology {
    /// Name of the model in a case file.
    pub name: &'static str,
    /// Static strength of the base.
    pub strength: BasalStrength,
    /// Part of the basal stress that depends on the speed.
    pub drag: BasalDrag,
}

impl BasalRheology {
    /// Base without shear stress.
    pub const FRICTIONLESS: Self =
        Self { name: "none", strength: BasalStrength::ZERO, drag: BasalDrag::None };

    /// Largest basal shear stress of flow at rest (Pa). For moving flow it is the limit of [`BasalRheology::moving_shear_stress`] at zero
    /// speed.
    #[inline]
    pub fn static_shear_strength(&self, flow: &BasalFlow) -> f64 {
        let strength = self.strength.shear_strength(flow);
        match self.drag {
            BasalDrag::Bingham { solution, .. } => strength * solution.static_factor(),
            _ => strength,
        }
    }

    /// Basal shear stress (Pa) of a flow with positive speed and depth.
    #[inline]
    pub fn moving_shear_stress(&self, flow: &BasalFlow) -> f64 {
        let strength = self.strength.shear_strength(flow);
        match self.drag {
            BasalDrag::Bingham { viscosity, solution } => {
                solution.shear_stress(strength, viscosity, flow.speed / flow.depth)
            }
            drag => strength + drag.shear_stress(self.strength.effective_stress(flow), flow),
        }
    }

    /// Basal shear stress (Pa), not negative. It is zero on a dry bed; at rest it equals the driving stress, up to the strength.
    ///
    /// # Errors
    /// [`MaterialError::Motion`] where the flow is not finite or its speed negative.
    pub fn shear_stress(&self, flow: &BasalFlow) -> Result<f64, MaterialError> {
        let invalid = |reason| MaterialError::Motion { model: self.name, reason };
        let BasalFlow { depth, speed, normal_stress, pore_pressure, slope, unit_weight } = *flow;
        // NaN and infinity make the sum NaN.
        if (depth + speed + normal_stress + pore_pressure + slope + unit_weight) * 0.0 != 0.0 {
            return Err(invalid("the flow is not finite"));
        }
        if speed < 0.0 {
            return Err(invalid("the speed must not be negative"));
        }
        if depth <= 0.0 {
            return Ok(0.0);
        }
        if speed > 0.0 {
            return Ok(self.moving_shear_stress(flow));
        }
        let driving = normal_stress.max(0.0) * slope.abs();
        Ok(driving.min(self.static_shear_strength(flow)))
    }

    /// Whether the basal stress is the sum of strength and drag, `τ_b = s + D(v̄)`. For a Bingham profile it is not.
    pub fn is_additive(&self) -> bool {
        !matches!(self.drag, BasalDrag::Bingham { .. })
    }

    /// Speed (m/s) after an implicit step with the basal stress as the only force (sheet: depth-sph §3.5). It is the root `v₁` of `v₁ - v₀
    /// + k τ_b(v₁) = 0` with the speed `v₀` of `flow` and the `impulse` `k = Δt/(ρh)` (m²s/kg), and zero if the strength stops the flow.
    /// The root has a closed form, except for powers `m` other than 1 and 2, for which an iteration solves it to 1e-14 of `v₀`.
    #[inline]
    pub fn speed_after_step(&self, flow: &BasalFlow, impulse: f64) -> f64 {
        let left = flow.speed - impulse * self.static_shear_strength(flow);
        if left <= 0.0 {
            return 0.0;
        }
        match self.drag {
            BasalDrag::Bingham { viscosity, solution } => {
                solution.speed_after_step(self.strength.shear_strength(flow), viscosity, flow, impulse, left)
            }
            _ => self.speed_after_drag(&BasalFlow { speed: left, ..*flow }, impulse),
        }
    }

    /// Speed (m/s) after a step like [`BasalRheology::speed_after_step`] with the drag alone, without the strength. A Bingham profile has
    /// no such part: the speed is unchanged.
    #[inline]
    pub fn speed_after_drag(&self, flow: &BasalFlow, impulse: f64) -> f64 {
        self.drag.speed_after_step(self.strength.effective_stress(flow), flow, impulse)
    }

    /// Returns the law with a friction coefficient of at most `friction`, for a bed that is smoother than the material.
    #[must_use]
    pub fn with_max_friction(mut self, friction: f64) -> Self {
        self.strength.friction = self.strength.friction.min(friction);
        self
    }
}
