//! Simple elastic–perfectly plastic soil with pressure from density (sheet: constitutive §2.8; Bui & Nguyen
//! 2021, eqs. 58–62).
//!
//! `p = K (ρ/ρ₀ - 1)`; the deviator follows Hooke's law in the co-rotating frame and is scaled back where its
//! norm exceeds `τ_f = max(0, c + p tan φ)`. The norm is `√J2`, which corresponds to Coulomb; or `q`, as the
//! source prints it, which makes the strength smaller by `√3`. Tension beyond the apex `c cot φ` opens the
//! material (for `φ = 0` never): no stress without cohesion. Limits: no dilatancy, no plastic strain in the state.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Elasticity;
use super::equation_of_state::{Barotropic, EquationOfState};
use super::linear_elastic::incompressibility_warnings;
use crate::Warning;
use crate::contract::parameter_checks::{check, not_negative, positive};
use crate::laws::model::with_defaults;
use crate::laws::model::{Model, ModelFamily, ModelInfo};
use crate::laws::viscous_flow::{FlowCurve, FlowOutputs, Viscoplastic};
use crate::{Corotational, Material, MaterialError};

/// Shear measure compared with strength.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ShearNorm {
    /// `√J2`, simple-shear stress.
    #[default]
    SqrtJ2,
    /// `q = √(3 J2)`, as printed in the source.
    VonMisesQ,
}

/// Parameters of `cfd-soil`, angles in degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CfdSoilSpec {
    /// Zero-pressure density (kg/m³), positive.
    pub density: f64,
    /// Young's modulus (Pa), positive.
    pub youngs_modulus: f64,
    /// Poisson's ratio, between -1 and 0.5.
    pub poissons_ratio: f64,
    /// Friction angle (degrees), non-negative, below 90.
    pub friction_angle: f64,
    /// Cohesion (Pa), non-negative.
    #[serde(default)]
    pub cohesion: f64,
    /// Shear measure compared with strength.
    #[serde(default)]
    pub norm: ShearNorm,
}

impl CfdSoilSpec {
    /// Parameters from density (kg/m³), Young's modulus (Pa), Poisson's ratio (-) and friction angle (degrees); all others have their
    /// defaults.
    #[must_use]
    pub fn new(density: f64, youngs_modulus: f64, poissons_ratio: f64, friction_angle: f64) -> Self {
        with_defaults(&[
            ("density", density),
            ("youngs_modulus", youngs_modulus),
            ("poissons_ratio", poissons_ratio),
            ("friction_angle", friction_angle),
        ])
    }

    /// Checks the ranges and builds the law.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn law(&self) -> Result<Viscoplastic<CfdSoil>, MaterialError> {
        positive("density", self.density, "kg/m³")?;
        let elasticity = Elasticity::new(self.youngs_modulus, self.poissons_ratio)?;
        super::check_angles(self.friction_angle, 0.0)?;
        not_negative("cohesion", self.cohesion, "Pa")?;
        let strong = self.friction_angle > 0.0 || self.cohesion > 0.0;
        check("cohesion", self.cohesion, strong, "must be positive without a friction angle (Pa)")?;
        let slope = self.friction_angle.to_radians().tan();
        let tension = if slope > 0.0 { self.cohesion / slope } else { f64::INFINITY };
        let scale = match self.norm {
            ShearNorm::SqrtJ2 => 1.0,
            ShearNorm::VonMisesQ => 3f64.sqrt().recip(),
        };
        Ok(Viscoplastic {
            rheology: CfdSoil { friction: scale * slope, cohesion: scale * self.cohesion },
            pressure: Barotropic {
                bulk_modulus: elasticity.bulk_modulus,
                tension,
                equation: EquationOfState::Linear,
            },
            shear_modulus: elasticity.shear_modulus,
        })
    }
}

impl Model for CfdSoilSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Bui & Nguyen 2021, eqs. 58–62",
        kind: ModelFamily::Solid,
        strain: "rate",
        tangent: "analytic",
    };

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        Ok(Arc::new(Corotational(self.law()?)))
    }

    fn warnings(&self) -> Vec<Warning> {
        let mut warnings = super::angle_warnings(self.friction_angle, 0.0);
        warnings.extend(incompressibility_warnings(self.poissons_ratio));
        if self.norm == ShearNorm::VonMisesQ {
            warnings.push(Warning::new(
                "weak-matching",
                "norm: von-mises-q makes the soil weaker than that of Coulomb by a factor of the root of \
                 3. Use sqrt-j2, or calibrate the strength for this norm",
            ));
        }
        warnings
    }

    fn examples() -> Vec<Self> {
        let with = |friction_angle, cohesion, norm| Self {
            density: 2000.0,
            youngs_modulus: 20e6,
            poissons_ratio: 0.3,
            friction_angle,
            cohesion,
            norm,
        };
        vec![
            with(30.0, 10e3, ShearNorm::SqrtJ2),
            with(30.0, 10e3, ShearNorm::VonMisesQ),
            with(30.0, 0.0, ShearNorm::SqrtJ2),
            with(0.0, 10e3, ShearNorm::SqrtJ2),
        ]
    }
}

/// Strength `max(0, c + p tan φ)`, as a limit to `√J2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CfdSoil {
    /// Friction coefficient `tan φ`, over `√3` for the norm `q`.
    pub friction: f64,
    /// Cohesion `c` (Pa), over `√3` for the norm `q`.
    pub cohesion: f64,
}

impl FlowOutputs for CfdSoil {
    const NAME: &'static str = "cfd-soil";
    const OUTPUTS: &'static [&'static str] = &["shear_rate"];

    fn outputs(&self, rate: f64, _shear: f64, _pressure: f64, out: &mut [f64]) {
        out[0] = rate;
    }
}

impl FlowCurve for CfdSoil {
    #[inline]
    fn strength(&self, _rate: f64, pressure: f64) -> f64 {
        (self.cohesion + self.friction * pressure).max(0.0)
    }

    #[inline]
    fn return_shear_stress(&self, _trial: f64, pressure: f64, _stiffness: f64) -> f64 {
        self.strength(0.0, pressure)
    }

    fn return_derivatives(&self, _trial: f64, pressure: f64, _stiffness: f64) -> (f64, f64) {
        (0.0, if self.cohesion + self.friction * pressure > 0.0 { self.friction } else { 0.0 })
    }
}
