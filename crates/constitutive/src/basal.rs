//! Basal shear stress of depth-averaged flow (constitutive sheet §2.11; Pastor et al. 2020, §4).
//!
//! With flow depth `h`, depth-averaged speed `v̄`, effective normal stress at the base
//! `σ'_b = (σ_b - p_wb)₊`:
//!
//! - Bingham: `v̄ = τ_b h/(6μ) (1 - ξ)² (2 + ξ)`, `ξ = τ_y/τ_b`, that is `ξ³ - (3 + a) ξ + 2 = 0` with
//!   `a = 6μv̄/(hτ_y)`;
//! - viscous-frictional of power `m`: `τ_b = σ'_b tan φ + μ ((1 + 2m)/m · v̄/h)^m`;
//! - Voellmy: `τ_b = σ'_b tan φ + ρ g v̄²/ς`;
//! - Coulomb: `τ_b = σ'_b tan φ`.
//!
//! All are positive numbers (Pa), to be applied against the velocity. Flow at rest is held by as much as
//! drives it, up to its strength. Limits: profiles of steady uniform flow.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::MaterialError;
use crate::model::{check, not_negative, positive};

/// What a column of flow tells the law at its base.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BasalFlow {
    /// Depth `h` (m), normal to the base.
    pub depth: f64,
    /// Depth-averaged speed `v̄` (m/s), not negative.
    pub speed: f64,
    /// Total normal stress on the base (Pa), compression-positive: `ρgh cos θ`, where the bed is plane.
    pub normal_stress: f64,
    /// Pore pressure at the base (Pa), compression-positive.
    pub pore_pressure: f64,
    /// Tangent of the slope that drives the flow (that of the bed, or of the energy line), for flow at rest.
    pub slope: f64,
    /// Unit weight `ρg` of the flowing mass (N/m³).
    pub unit_weight: f64,
}

impl BasalFlow {
    /// Effective normal stress on the base (Pa), compression-positive, never tension.
    #[inline]
    pub fn effective_stress(&self) -> f64 {
        (self.normal_stress - self.pore_pressure).max(0.0)
    }
}

/// Basal shear stress from depth-averaged flow.
pub trait BasalRheology: Send + Sync {
    /// Name of the model as it stands in a case file.
    fn name(&self) -> &'static str;

    /// Basal shear stress (Pa) of flow at a speed above zero; depth positive.
    fn moving(&self, flow: &BasalFlow) -> f64;

    /// Largest basal shear stress (Pa) that flow at rest bears without moving.
    fn max_static(&self, flow: &BasalFlow) -> f64;

    /// Basal shear stress (Pa), not negative: zero where the bed is dry; at rest as much as drives the flow,
    /// up to the strength.
    ///
    /// # Errors
    /// [`MaterialError::Motion`] where the flow is not finite or its speed negative.
    fn shear_stress(&self, flow: &BasalFlow) -> Result<f64, MaterialError> {
        let invalid = |reason| MaterialError::Motion { model: self.name(), reason };
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
            return Ok(self.moving(flow));
        }
        let driving = normal_stress.max(0.0) * slope.abs();
        Ok(driving.min(self.max_static(flow)))
    }
}

/// A basal law of a case file: the model's name and its parameters, angles in degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "model")]
pub enum BasalSpec {
    /// Bingham fluid.
    #[serde(rename = "bingham")]
    Bingham(BinghamBaseSpec),
    /// Friction and a viscous power law.
    #[serde(rename = "viscous-frictional")]
    ViscousFrictional(ViscousFrictionalSpec),
    /// Friction and turbulence.
    #[serde(rename = "voellmy")]
    Voellmy(VoellmySpec),
    /// Friction alone.
    #[serde(rename = "coulomb")]
    Coulomb(CoulombSpec),
}

impl BasalSpec {
    /// The law, parameters checked and angles converted.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn build(&self) -> Result<Arc<dyn BasalRheology>, MaterialError> {
        Ok(match self {
            Self::Bingham(spec) => Arc::new(spec.law()?),
            Self::ViscousFrictional(spec) => Arc::new(spec.law()?),
            Self::Voellmy(spec) => Arc::new(spec.law()?),
            Self::Coulomb(spec) => Arc::new(spec.law()?),
        })
    }

    /// A sample of every law and every way to run it.
    pub fn examples() -> Vec<Self> {
        let bingham = |solution| BinghamBaseSpec { yield_stress: 200.0, viscosity: 50.0, solution };
        vec![
            Self::Bingham(bingham(BinghamSolution::Exact)),
            Self::Bingham(bingham(BinghamSolution::Quadratic)),
            Self::ViscousFrictional(ViscousFrictionalSpec {
                friction_angle: 15.0,
                consistency: 0.8,
                exponent: 2.0,
            }),
            Self::Voellmy(VoellmySpec { friction_angle: 15.0, turbulence: 600.0 }),
            Self::Coulomb(CoulombSpec { friction_angle: 15.0 }),
        ]
    }
}

/// `tan φ` of an angle in degrees.
fn friction(angle: f64) -> Result<f64, MaterialError> {
    let rule = "is not in 0..90 degrees (90 excluded)";
    check("friction_angle", angle, (0.0..90.0).contains(&angle), rule)?;
    Ok(angle.to_radians().tan())
}

/// Parameters of `bingham`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BinghamBaseSpec {
    /// Yield stress `τ_y` (Pa), not negative.
    pub yield_stress: f64,
    /// Plastic viscosity `μ` (Pa s), > 0.
    pub viscosity: f64,
    /// How the cubic equation is solved.
    #[serde(default)]
    pub solution: BinghamSolution,
}

/// How the cubic equation of the Bingham profile is solved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum BinghamSolution {
    /// To round-off.
    #[default]
    Exact,
    /// By the economised quadratic of Pastor et al. (2004): within -2.8 % to +5.2 %.
    Quadratic,
}

impl BinghamBaseSpec {
    /// Checks the ranges and builds the law.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn law(&self) -> Result<BinghamBase, MaterialError> {
        not_negative("yield_stress", self.yield_stress, "Pa")?;
        positive("viscosity", self.viscosity, "Pa s")?;
        Ok(BinghamBase {
            yield_stress: self.yield_stress,
            viscosity: self.viscosity,
            solution: self.solution,
        })
    }
}

/// Bingham fluid in steady flow over a base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BinghamBase {
    yield_stress: f64,
    viscosity: f64,
    solution: BinghamSolution,
}

/// Root `ξ = τ_y/τ_b` in (0, 1] of `ξ³ - (3 + a) ξ + 2 = 0`, `a >= 0`: in closed form, then two Newton
/// steps.
pub fn plug_ratio(a: f64) -> f64 {
    // From here on the cube is below round-off.
    if a > 1e6 {
        return 2.0 / (3.0 + a);
    }
    let r = ((3.0 + a) / 3.0).sqrt();
    let angle = (-r.powi(-3)).max(-1.0).acos();
    let mut xi = 2.0 * r * ((angle + 4.0 * std::f64::consts::PI) / 3.0).cos();
    for _ in 0..2 {
        let slope = 3.0 * xi * xi - (3.0 + a);
        // At rest the root is double.
        if slope < 0.0 {
            xi -= (xi * xi * xi - (3.0 + a) * xi + 2.0) / slope;
        }
    }
    xi.clamp(f64::MIN_POSITIVE, 1.0)
}

/// The same root from the economised quadratic `3/2 ξ² - (57/16 + a) ξ + 65/32 = 0`.
pub fn plug_ratio_quadratic(a: f64) -> f64 {
    let (b, c) = (57.0 / 16.0 + a, 65.0 / 32.0);
    2.0 * c / (b * (1.0 + (1.0 - 6.0 * c / b / b).sqrt()))
}

impl BasalRheology for BinghamBase {
    fn name(&self) -> &'static str {
        "bingham"
    }

    fn moving(&self, flow: &BasalFlow) -> f64 {
        let rate = flow.speed / flow.depth;
        let a = 6.0 * self.viscosity * rate / self.yield_stress;
        if !a.is_finite() {
            return 3.0 * self.viscosity * rate;
        }
        match self.solution {
            BinghamSolution::Exact => self.yield_stress / plug_ratio(a),
            BinghamSolution::Quadratic => self.yield_stress / plug_ratio_quadratic(a),
        }
    }

    fn max_static(&self, _flow: &BasalFlow) -> f64 {
        self.yield_stress
    }
}

/// Parameters of `viscous-frictional`, angles in degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ViscousFrictionalSpec {
    /// Friction angle at the base (degrees), 0 to 90 (excluded).
    pub friction_angle: f64,
    /// Consistency `μ` (Pa sᵐ), > 0.
    pub consistency: f64,
    /// Power `m` of the shear rate, > 0: 1 for a viscous fluid, 2 for grain inertia.
    pub exponent: f64,
}

impl ViscousFrictionalSpec {
    /// Checks the ranges and builds the law.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn law(&self) -> Result<ViscousFrictional, MaterialError> {
        let friction = friction(self.friction_angle)?;
        positive("consistency", self.consistency, "Pa sᵐ")?;
        positive("exponent", self.exponent, "")?;
        Ok(ViscousFrictional { friction, consistency: self.consistency, exponent: self.exponent })
    }
}

/// Friction, and a power law of the shear rate above it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViscousFrictional {
    friction: f64,
    consistency: f64,
    exponent: f64,
}

impl BasalRheology for ViscousFrictional {
    fn name(&self) -> &'static str {
        "viscous-frictional"
    }

    fn moving(&self, flow: &BasalFlow) -> f64 {
        let m = self.exponent;
        let viscous = self.consistency * ((1.0 + 2.0 * m) / m * flow.speed / flow.depth).powf(m);
        self.max_static(flow) + viscous
    }

    fn max_static(&self, flow: &BasalFlow) -> f64 {
        flow.effective_stress() * self.friction
    }
}

/// Parameters of `voellmy`, angles in degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VoellmySpec {
    /// Friction angle at the base (degrees), 0 to 90 (excluded).
    pub friction_angle: f64,
    /// Turbulence coefficient `ς` (m/s²), > 0.
    pub turbulence: f64,
}

impl VoellmySpec {
    /// Checks the ranges and builds the law.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn law(&self) -> Result<Voellmy, MaterialError> {
        let friction = friction(self.friction_angle)?;
        positive("turbulence", self.turbulence, "m/s²")?;
        Ok(Voellmy { friction, turbulence: self.turbulence })
    }
}

/// Friction and turbulent drag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Voellmy {
    friction: f64,
    turbulence: f64,
}

impl BasalRheology for Voellmy {
    fn name(&self) -> &'static str {
        "voellmy"
    }

    fn moving(&self, flow: &BasalFlow) -> f64 {
        self.max_static(flow) + flow.unit_weight * flow.speed * flow.speed / self.turbulence
    }

    fn max_static(&self, flow: &BasalFlow) -> f64 {
        flow.effective_stress() * self.friction
    }
}

/// Parameters of `coulomb`, angles in degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CoulombSpec {
    /// Friction angle at the base (degrees), 0 to 90 (excluded).
    pub friction_angle: f64,
}

impl CoulombSpec {
    /// Checks the ranges and builds the law.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn law(&self) -> Result<Coulomb, MaterialError> {
        Ok(Coulomb { friction: friction(self.friction_angle)? })
    }
}

/// Friction alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coulomb {
    friction: f64,
}

impl BasalRheology for Coulomb {
    fn name(&self) -> &'static str {
        "coulomb"
    }

    fn moving(&self, flow: &BasalFlow) -> f64 {
        self.max_static(flow)
    }

    fn max_static(&self, flow: &BasalFlow) -> f64 {
        flow.effective_stress() * self.friction
    }
}

/// Stiffness of the skeleton for the equation of pore pressure (Pastor et al. 2020, eq. 58).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SkeletonSpec {
    /// Young's modulus (Pa), > 0.
    pub youngs_modulus: f64,
    /// Poisson's ratio, between -1 and 0.5.
    pub poissons_ratio: f64,
    /// Confinement `α`: 1 for isotropic compression, the coefficient of lateral stress `k_0` where the
    /// sides are held; > 0.
    #[serde(default = "isotropic")]
    pub alpha: f64,
}

fn isotropic() -> f64 {
    1.0
}

impl SkeletonSpec {
    /// Volumetric stiffness `K_v / α` (Pa), `K_v = E/(3(1 - 2ν))`.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn stiffness(&self) -> Result<f64, MaterialError> {
        let elasticity = crate::laws::Elasticity::new(self.youngs_modulus, self.poissons_ratio)?;
        positive("alpha", self.alpha, "")?;
        Ok(elasticity.bulk_modulus / self.alpha)
    }
}
