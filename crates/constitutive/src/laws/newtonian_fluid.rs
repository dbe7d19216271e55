//! Weakly compressible Newtonian fluid (sheet: constitutive §2.10; Anura3D manual eqs. 7.29–7.36).
//!
//! `σ = -p 1 + 2 μ dev D`, pressure from density: linear `p = c² (ρ - ρ₀)` with `c² = K/ρ₀`, or
//! Tait's `p = ρ₀ c²/7 [(ρ/ρ₀)⁷ - 1]`. Where pressure would fall below minus the cavitation
//! strength it is limited to it, and the shear stress vanishes. Limit: explicit viscosity bounds the step.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::equation_of_state::{Barotropic, EquationOfState};
use crate::contract::parameter_checks::{not_negative, positive};
use crate::laws::model::with_defaults;
use crate::laws::model::{Model, ModelFamily, ModelInfo};
use crate::laws::viscous_flow::{EffectiveViscosity, FlowOutputs, ViscousFluid};
use crate::{Material, MaterialError};

/// Value of the key `model` in case files.
const NAME: &str = "newtonian-fluid";

/// Parameters of `newtonian-fluid`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NewtonianFluidSpec {
    /// Zero-pressure density (kg/m³), positive.
    pub density: f64,
    /// Zero-pressure bulk modulus (Pa), positive.
    pub bulk_modulus: f64,
    /// Dynamic viscosity (Pa s), non-negative.
    #[serde(default)]
    pub viscosity: f64,
    /// Cavitation tension (Pa), non-negative. At zero unconfined fluid opens as it moves: without a free surface give this or initial
    /// pressure.
    #[serde(default)]
    pub cavitation_strength: f64,
    /// Equation of state.
    #[serde(default)]
    pub equation_of_state: EquationOfState,
}

impl NewtonianFluidSpec {
    /// Parameters from density (kg/m³) and bulk modulus (Pa); all others have the defaults of a case file.
    #[must_use]
    pub fn new(density: f64, bulk_modulus: f64) -> Self {
        with_defaults(&[("density", density), ("bulk_modulus", bulk_modulus)])
    }

    /// Checks the ranges and builds the law.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn law(&self) -> Result<NewtonianFluid, MaterialError> {
        positive("density", self.density, "kg/m³")?;
        positive("bulk_modulus", self.bulk_modulus, "Pa")?;
        not_negative("viscosity", self.viscosity, "Pa s")?;
        not_negative("cavitation_strength", self.cavitation_strength, "Pa")?;
        let pressure = Barotropic {
            bulk_modulus: self.bulk_modulus,
            tension: self.cavitation_strength,
            equation: self.equation_of_state,
        };
        Ok(ViscousFluid { rheology: ConstantViscosity { viscosity: self.viscosity }, pressure })
    }
}

impl Model for NewtonianFluidSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Anura3D manual 2021, eqs. 7.29–7.36; Cole 1948 (Tait)",
        kind: ModelFamily::Fluid,
        strain: "rate",
        tangent: "numerical",
    };

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        Ok(Arc::new(self.law()?))
    }

    fn examples() -> Vec<Self> {
        let with = |equation_of_state| Self {
            density: 2000.0,
            bulk_modulus: 2e7,
            viscosity: 100.0,
            cavitation_strength: 1e4,
            equation_of_state,
        };
        [EquationOfState::Linear, EquationOfState::Tait].map(with).into()
    }
}

/// Newtonian fluid law. See the module's head for source and limits.
pub type NewtonianFluid = ViscousFluid<ConstantViscosity>;

/// Constant viscosity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstantViscosity {
    /// Dynamic viscosity `μ` (Pa s).
    pub viscosity: f64,
}

impl FlowOutputs for ConstantViscosity {
    const NAME: &'static str = NAME;
    const OUTPUTS: &'static [&'static str] = &[];

    fn outputs(&self, _: f64, _: f64, _: f64, _: &mut [f64]) {}
}

impl EffectiveViscosity for ConstantViscosity {
    #[inline]
    fn viscosity(&self, _rate: f64, _pressure: f64) -> f64 {
        self.viscosity
    }
}
