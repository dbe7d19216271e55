//! Viscoplastic fluids: Bingham and frictional (sheet: constitutive §2.10, §3.7.9; Anura3D manual 2021,
//! eqs. 7.29–7.38).
//!
//! `√J2 = τ_y + μ γ̇`, `γ̇ = √(2 D':D')`, with `τ_y` constant (`bingham`) or
//! `τ_y = max(0, c cos φ + p sin φ)` (`frictional-fluid`); pressure from density, not below minus the
//! cavitation strength, where shear is gone.
//!
//! By default elastic in shear up to `τ_y` and by backward Euler above it,
//! `τ = (τᵗʳ + ζ τ_y)/(1 + ζ)`, `ζ = GΔt/μ`: a true static yield and no limit to the viscous step. Alternatively a
//! viscosity `η = min(μ + τ_y/γ̇, η_max)`, which creeps at rest.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::equation_of_state::{Barotropic, EquationOfState};
use crate::Warning;
use crate::contract::parameter_checks::{check, not_negative, positive};
use crate::laws::model::with_defaults;
use crate::laws::model::{Model, ModelFamily, ModelInfo};
use crate::laws::viscous_flow::{
    EffectiveViscosity, FlowCurve, FlowOutputs, Viscoplastic, ViscousFluid, shear_modulus,
    without_shear_modulus,
};
use crate::{Corotational, Material, MaterialError};

/// Flow integration of `bingham` and `frictional-fluid`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum YieldForm {
    /// Elastic below yield, backward Euler above. Default.
    // With braces, so that unknown keys are refused here as well.
    Viscoplastic {},
    /// Effective viscosity, capped.
    Capped {
        /// Largest viscosity (Pa s), at least `viscosity`.
        max_viscosity: f64,
    },
}

impl Default for YieldForm {
    fn default() -> Self {
        Self::Viscoplastic {}
    }
}

/// Parameters of `bingham`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BinghamSpec {
    /// Zero-pressure density (kg/m³), positive.
    pub density: f64,
    /// Zero-pressure bulk modulus (Pa), positive.
    pub bulk_modulus: f64,
    /// Shear modulus below yield (Pa), positive, for `viscoplastic`; by default from bulk modulus and Poisson's ratio 0.3.
    #[serde(default)]
    pub shear_modulus: Option<f64>,
    /// Yield stress `τ_y` (Pa), non-negative.
    pub yield_stress: f64,
    /// Plastic viscosity `μ` (Pa s), non-negative.
    pub viscosity: f64,
    /// Cavitation tension (Pa), non-negative. At zero unconfined fluid opens as it moves: without a free surface give this or initial
    /// pressure.
    #[serde(default)]
    pub cavitation_strength: f64,
    /// Equation of state.
    #[serde(default)]
    pub equation_of_state: EquationOfState,
    /// Flow integration.
    #[serde(default)]
    pub form: YieldForm,
}

/// Parameters of `frictional-fluid`, angles in degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FrictionalFluidSpec {
    /// Zero-pressure density (kg/m³), positive.
    pub density: f64,
    /// Zero-pressure bulk modulus (Pa), positive.
    pub bulk_modulus: f64,
    /// Shear modulus below yield (Pa), positive, for `viscoplastic`; by default from bulk modulus and Poisson's ratio 0.3.
    #[serde(default)]
    pub shear_modulus: Option<f64>,
    /// Friction angle (degrees), non-negative, below 90.
    pub friction_angle: f64,
    /// Cohesion (Pa), non-negative.
    #[serde(default)]
    pub cohesion: f64,
    /// Viscosity above yield (Pa s), non-negative.
    #[serde(default)]
    pub viscosity: f64,
    /// Cavitation tension (Pa), non-negative. At zero unconfined fluid opens as it moves: without a free surface give this or initial
    /// pressure.
    #[serde(default)]
    pub cavitation_strength: f64,
    /// Equation of state.
    #[serde(default)]
    pub equation_of_state: EquationOfState,
    /// Flow integration.
    #[serde(default)]
    pub form: YieldForm,
}

/// Parameters common to both models.
struct ViscoplasticParameters {
    bulk_modulus: f64,
    shear_modulus: Option<f64>,
    tension: f64,
    equation: EquationOfState,
    form: YieldForm,
}

impl ViscoplasticParameters {
    /// Checks the parameters with the density (kg/m³) and viscosity (Pa s) of the material.
    fn validate(&self, density: f64, viscosity: f64) -> Result<(), MaterialError> {
        positive("density", density, "kg/m³")?;
        positive("bulk_modulus", self.bulk_modulus, "Pa")?;
        not_negative("viscosity", viscosity, "Pa s")?;
        not_negative("cavitation_strength", self.tension, "Pa")?;
        if let YieldForm::Capped { max_viscosity } = self.form {
            let rule = format!("must be positive and at least the viscosity, {viscosity} Pa s");
            let holds = max_viscosity.is_finite() && max_viscosity > 0.0 && max_viscosity >= viscosity;
            check("form.max_viscosity", max_viscosity, holds, &rule)?;
        }
        Ok(())
    }

    /// Law of a flow curve with the equation of state and shear modulus of the parameters.
    fn law<Y>(&self, rheology: Y) -> Result<Viscoplastic<Y>, MaterialError> {
        let pressure =
            Barotropic { bulk_modulus: self.bulk_modulus, tension: self.tension, equation: self.equation };
        let shear_modulus = shear_modulus(self.shear_modulus, self.bulk_modulus)?;
        Ok(Viscoplastic { rheology, pressure, shear_modulus })
    }

    /// Material of a flow curve: elastic–viscoplastic, or a viscous fluid with a capped viscosity.
    fn build<Y: YieldStress>(&self, rheology: Y) -> Result<Arc<dyn Material>, MaterialError> {
        let law = self.law(rheology)?;
        Ok(match self.form {
            YieldForm::Viscoplastic {} => Arc::new(Corotational(law)),
            YieldForm::Capped { max_viscosity } => {
                without_shear_modulus(self.shear_modulus, "viscoplastic")?;
                let rheology = Capped { law: law.rheology, max_viscosity };
                Arc::new(ViscousFluid { rheology, pressure: law.pressure })
            }
        })
    }

    /// Warnings for the user: a material with a capped viscosity creeps on every slope.
    fn warnings(&self) -> Vec<Warning> {
        match self.form {
            YieldForm::Viscoplastic {} => Vec::new(),
            YieldForm::Capped { .. } => {
                vec![Warning::new(
                    "creep-at-rest",
                    "form: with a capped viscosity the material always creeps and does not come to rest \
                      on a slope. For deposits use the form viscoplastic",
                )]
            }
        }
    }
}

impl BinghamSpec {
    /// Parameters from density (kg/m³), bulk modulus (Pa), yield stress (Pa) and viscosity (Pa s); all others have the defaults of a case file.
    #[must_use]
    pub fn new(density: f64, bulk_modulus: f64, yield_stress: f64, viscosity: f64) -> Self {
        with_defaults(&[
            ("density", density),
            ("bulk_modulus", bulk_modulus),
            ("yield_stress", yield_stress),
            ("viscosity", viscosity),
        ])
    }

    /// Parameters that the law has in common with other viscoplastic fluids.
    fn viscoplastic_parameters(&self) -> ViscoplasticParameters {
        ViscoplasticParameters {
            bulk_modulus: self.bulk_modulus,
            shear_modulus: self.shear_modulus,
            tension: self.cavitation_strength,
            equation: self.equation_of_state,
            form: self.form,
        }
    }

    /// Checks the ranges and returns the flow curve.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn rheology(&self) -> Result<Bingham, MaterialError> {
        self.viscoplastic_parameters().validate(self.density, self.viscosity)?;
        not_negative("yield_stress", self.yield_stress, "Pa")?;
        Ok(Bingham { yield_stress: self.yield_stress, viscosity: self.viscosity })
    }

    /// Viscoplastic law of the parameters, for any form of the yield stress.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn viscoplastic(&self) -> Result<Viscoplastic<Bingham>, MaterialError> {
        self.viscoplastic_parameters().law(self.rheology()?)
    }
}

impl FrictionalFluidSpec {
    /// Parameters from density (kg/m³), bulk modulus (Pa) and friction angle (degrees); all others have the defaults of a case file.
    #[must_use]
    pub fn new(density: f64, bulk_modulus: f64, friction_angle: f64) -> Self {
        with_defaults(&[
            ("density", density),
            ("bulk_modulus", bulk_modulus),
            ("friction_angle", friction_angle),
        ])
    }

    /// Parameters that the law has in common with other viscoplastic fluids.
    fn viscoplastic_parameters(&self) -> ViscoplasticParameters {
        ViscoplasticParameters {
            bulk_modulus: self.bulk_modulus,
            shear_modulus: self.shear_modulus,
            tension: self.cavitation_strength,
            equation: self.equation_of_state,
            form: self.form,
        }
    }

    /// Checks the ranges and returns the flow curve.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn rheology(&self) -> Result<FrictionalFluid, MaterialError> {
        self.viscoplastic_parameters().validate(self.density, self.viscosity)?;
        super::check_angles(self.friction_angle, 0.0)?;
        not_negative("cohesion", self.cohesion, "Pa")?;
        let (sin, cos) = self.friction_angle.to_radians().sin_cos();
        Ok(FrictionalFluid { friction: sin, cohesion: self.cohesion * cos, viscosity: self.viscosity })
    }

    /// Viscoplastic law of the parameters, for any form of the yield stress.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn viscoplastic(&self) -> Result<Viscoplastic<FrictionalFluid>, MaterialError> {
        self.viscoplastic_parameters().law(self.rheology()?)
    }
}

/// Kind of tangent that the list of materials shows.
const TANGENT: &str = "analytic (capped form: numerical)";

impl Model for BinghamSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Bingham 1922; Anura3D manual 2021, eq. 7.37 (corrected)",
        kind: ModelFamily::Fluid,
        strain: "rate",
        tangent: TANGENT,
    };

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        self.viscoplastic_parameters().build(self.rheology()?)
    }

    fn warnings(&self) -> Vec<Warning> {
        self.viscoplastic_parameters().warnings()
    }

    fn examples() -> Vec<Self> {
        let with = |yield_stress, viscosity, equation_of_state, form| Self {
            density: 1800.0,
            bulk_modulus: 2e7,
            shear_modulus: (form == YieldForm::default()).then_some(1e6),
            yield_stress,
            viscosity,
            cavitation_strength: 1e4,
            equation_of_state,
            form,
        };
        vec![
            with(2e3, 500.0, EquationOfState::Linear, YieldForm::Viscoplastic {}),
            with(2e4, 500.0, EquationOfState::Tait, YieldForm::Viscoplastic {}),
            with(2e3, 0.0, EquationOfState::Linear, YieldForm::Viscoplastic {}),
            with(2e3, 50.0, EquationOfState::Linear, YieldForm::Capped { max_viscosity: 500.0 }),
        ]
    }
}

impl Model for FrictionalFluidSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Anura3D manual 2021, eqs. 7.37 (corrected), 7.38",
        kind: ModelFamily::Fluid,
        strain: "rate",
        tangent: TANGENT,
    };

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        self.viscoplastic_parameters().build(self.rheology()?)
    }

    fn warnings(&self) -> Vec<Warning> {
        let mut warnings = super::angle_warnings(self.friction_angle, 0.0);
        warnings.extend(self.viscoplastic_parameters().warnings());
        warnings
    }

    fn examples() -> Vec<Self> {
        let with = |cohesion, viscosity, form| Self {
            density: 1800.0,
            bulk_modulus: 26e6 / 3.0,
            shear_modulus: (form == YieldForm::default()).then_some(4e6),
            friction_angle: 20.0,
            cohesion,
            viscosity,
            cavitation_strength: 0.0,
            equation_of_state: EquationOfState::Linear,
            form,
        };
        vec![
            with(0.0, 2000.0, YieldForm::Viscoplastic {}),
            with(1e3, 0.0, YieldForm::Viscoplastic {}),
            with(0.0, 20.0, YieldForm::Capped { max_viscosity: 100.0 }),
        ]
    }
}

/// Flow curves `τ_y(p) + μ γ̇`.
pub trait YieldStress: FlowOutputs + Send + Sync + 'static {
    /// Yield stress (Pa) at `pressure` (Pa).
    fn yield_stress(&self, pressure: f64) -> f64;

    /// Derivative of the yield stress with respect to pressure.
    fn yield_slope(&self, pressure: f64) -> f64;

    /// Viscosity `μ` above yield (Pa s).
    fn viscosity(&self) -> f64;
}

/// Flow curve with a constant yield stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bingham {
    /// Yield stress `τ_y` (Pa).
    pub yield_stress: f64,
    /// Plastic viscosity `μ` (Pa s).
    pub viscosity: f64,
}

impl FlowOutputs for Bingham {
    const NAME: &'static str = "bingham";
}

impl YieldStress for Bingham {
    #[inline]
    fn yield_stress(&self, _pressure: f64) -> f64 {
        self.yield_stress
    }

    fn yield_slope(&self, _pressure: f64) -> f64 {
        0.0
    }

    #[inline]
    fn viscosity(&self) -> f64 {
        self.viscosity
    }
}

/// Flow curve with a yield stress that grows with pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionalFluid {
    /// Friction coefficient `sin φ`.
    pub friction: f64,
    /// Cohesive strength `c cos φ` (Pa).
    pub cohesion: f64,
    /// Viscosity `μ` (Pa s).
    pub viscosity: f64,
}

impl FlowOutputs for FrictionalFluid {
    const NAME: &'static str = "frictional-fluid";
}

impl YieldStress for FrictionalFluid {
    #[inline]
    fn yield_stress(&self, pressure: f64) -> f64 {
        (self.cohesion + self.friction * pressure).max(0.0)
    }

    fn yield_slope(&self, pressure: f64) -> f64 {
        if self.cohesion + self.friction * pressure > 0.0 { self.friction } else { 0.0 }
    }

    #[inline]
    fn viscosity(&self) -> f64 {
        self.viscosity
    }
}

impl<Y: YieldStress> FlowCurve for Y {
    #[inline]
    fn strength(&self, rate: f64, pressure: f64) -> f64 {
        self.yield_stress(pressure) + self.viscosity() * rate
    }

    #[inline]
    fn return_shear_stress(&self, trial: f64, pressure: f64, stiffness: f64) -> f64 {
        let viscosity = self.viscosity();
        (viscosity * trial + stiffness * self.yield_stress(pressure)) / (viscosity + stiffness)
    }

    fn return_derivatives(&self, _trial: f64, pressure: f64, stiffness: f64) -> (f64, f64) {
        let viscosity = self.viscosity();
        let whole = viscosity + stiffness;
        (viscosity / whole, stiffness * self.yield_slope(pressure) / whole)
    }
}

/// Regularised yield stress: a viscosity with a cap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Capped<Y> {
    /// Flow curve.
    pub law: Y,
    /// Largest viscosity (Pa s).
    pub max_viscosity: f64,
}

impl<Y: YieldStress> FlowOutputs for Capped<Y> {
    const NAME: &'static str = Y::NAME;
}

impl<Y: YieldStress> EffectiveViscosity for Capped<Y> {
    #[inline]
    fn viscosity(&self, rate: f64, pressure: f64) -> f64 {
        let (viscosity, strength) = (self.law.viscosity(), self.law.yield_stress(pressure));
        // Without strength and rate the quotient is NaN.
        if strength > 0.0 { (viscosity + strength / rate).min(self.max_viscosity) } else { viscosity }
    }
}
