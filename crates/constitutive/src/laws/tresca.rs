//! Tresca plasticity (sheet: constitutive §2.5, §3.7.4; Anura3D manual eq. 7.24).
//!
//! `f = σ1 - σ3 - 2 s_u ≤ 0`, associated, perfectly plastic: Mohr–Coulomb without friction and with the
//! undrained shear strength as cohesion. For the short-term strength of clays in total stresses.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::linear_elastic::incompressibility_warnings;
use super::{MohrCoulomb, MohrCoulombSpec, StrengthReduction};
use crate::Warning;
use crate::contract::parameter_checks::positive;
use crate::laws::model::with_defaults;
use crate::laws::model::{Model, ModelFamily, ModelInfo, StrainMeasure};
use crate::{Material, MaterialError};

/// Parameters of `tresca`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrescaSpec {
    /// Density (kg/m³), positive.
    pub density: f64,
    /// Young's modulus (Pa), positive.
    pub youngs_modulus: f64,
    /// Poisson's ratio, between -1 and 0.5.
    pub poissons_ratio: f64,
    /// Undrained shear strength `s_u` (Pa), positive.
    pub undrained_strength: f64,
    /// Strain measure.
    #[serde(default)]
    pub strain_measure: StrainMeasure,
    /// Return of initial stress outside yield; otherwise refused.
    #[serde(default)]
    pub return_initial_stress_to_yield: bool,
}

impl TrescaSpec {
    /// Parameters from density (kg/m³), Young's modulus (Pa), Poisson's ratio (-) and undrained strength (Pa); all others have their
    /// defaults.
    #[must_use]
    pub fn new(density: f64, youngs_modulus: f64, poissons_ratio: f64, undrained_strength: f64) -> Self {
        with_defaults(&[
            ("density", density),
            ("youngs_modulus", youngs_modulus),
            ("poissons_ratio", poissons_ratio),
            ("undrained_strength", undrained_strength),
        ])
    }

    /// Checks the ranges and builds the law.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn law(&self) -> Result<MohrCoulomb, MaterialError> {
        positive("undrained_strength", self.undrained_strength, "Pa")?;
        let law = MohrCoulombSpec {
            density: self.density,
            youngs_modulus: self.youngs_modulus,
            poissons_ratio: self.poissons_ratio,
            friction_angle: 0.0,
            cohesion: self.undrained_strength,
            dilatancy_angle: 0.0,
            softening: None,
            dilatancy_decay: 0.0,
            tensile_strength: None,
            strain_measure: self.strain_measure,
            return_initial_stress_to_yield: self.return_initial_stress_to_yield,
        };
        Ok(law.law()?.with_name("tresca"))
    }
}

impl Model for TrescaSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Anura3D manual 2021, eq. 7.24",
        kind: ModelFamily::Solid,
        strain: "rate or Hencky",
        tangent: "analytic",
    };

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        Ok(self.strain_measure.wrap(self.law()?))
    }

    fn warnings(&self) -> Vec<Warning> {
        incompressibility_warnings(self.poissons_ratio)
    }

    fn strength_reduced(&self, reduction: &StrengthReduction) -> Option<Result<Self, MaterialError>> {
        let reduced = Self { undrained_strength: self.undrained_strength / reduction.factor, ..self.clone() };
        Some(reduced.law().map(|_| reduced))
    }

    fn examples() -> Vec<Self> {
        let with = |strain_measure| Self {
            density: 2000.0,
            youngs_modulus: 20e6,
            poissons_ratio: 0.3,
            undrained_strength: 20e3,
            strain_measure,
            return_initial_stress_to_yield: false,
        };
        [StrainMeasure::Rate, StrainMeasure::Hencky].map(with).into()
    }
}
