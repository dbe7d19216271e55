//! Von Mises plasticity (sheet: constitutive §2.4; Bui & Nguyen 2021, section 4.3).
//!
//! `f = √J2 - k ≤ 0`, associated: Drucker–Prager without friction. The relation of `k` to the cohesion depends on
//! the matching: `k = c` is exact in plane strain and simple shear (default), `k = 2c/√3` in
//! triaxial compression (the source's, 15.47 % too strong in plane strain). Cohesion may soften
//! exponentially with the accumulated deviatoric plastic strain.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::linear_elastic::incompressibility_warnings;
use super::{
    DruckerPrager, DruckerPragerSpec, Matching, PlasticIntegration, ReductionScope, Softening,
    StrengthReduction,
};
use crate::Warning;
use crate::contract::parameter_checks::positive;
use crate::laws::model::with_defaults;
use crate::laws::model::{Model, ModelFamily, ModelInfo, StrainMeasure};
use crate::{Material, MaterialError};

/// Parameters of `von-mises`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct VonMisesSpec {
    /// Density (kg/m³), positive.
    pub density: f64,
    /// Young's modulus (Pa), positive.
    pub youngs_modulus: f64,
    /// Poisson's ratio, between -1 and 0.5.
    pub poissons_ratio: f64,
    /// Cohesion (Pa), positive.
    pub cohesion: f64,
    /// Stress state of strength exactly `cohesion`.
    #[serde(default)]
    pub exact_in: ExactIn,
    /// Residual cohesion (Pa), 0 to the peak; no softening when absent.
    #[serde(default)]
    pub residual_cohesion: Option<f64>,
    /// Cohesion decay rate over plastic strain, positive with `residual_cohesion`, else 0.
    #[serde(default)]
    pub softening_rate: f64,
    /// Strain measure.
    #[serde(default)]
    pub strain_measure: StrainMeasure,
    /// Return of initial stress outside yield; otherwise refused.
    #[serde(default)]
    pub return_initial_stress_to_yield: bool,
}

/// Stress state where von Mises and Tresca agree.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ExactIn {
    /// Pure shear, plane strain: `k = c`.
    #[default]
    PlaneStrain,
    /// Triaxial compression and extension: `k = 2c/√3`.
    Triaxial,
}

impl VonMisesSpec {
    /// Parameters from density (kg/m³), Young's modulus (Pa), Poisson's ratio (-) and cohesion (Pa); all others have the defaults of a case file.
    #[must_use]
    pub fn new(density: f64, youngs_modulus: f64, poissons_ratio: f64, cohesion: f64) -> Self {
        with_defaults(&[
            ("density", density),
            ("youngs_modulus", youngs_modulus),
            ("poissons_ratio", poissons_ratio),
            ("cohesion", cohesion),
        ])
    }

    /// Checks the ranges and builds the law.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn law(&self) -> Result<DruckerPrager, MaterialError> {
        positive("cohesion", self.cohesion, "Pa")?;
        let softening =
            self.residual_cohesion.map(|residual| Softening::of_cohesion(residual, self.softening_rate));
        let law = DruckerPragerSpec {
            density: self.density,
            youngs_modulus: self.youngs_modulus,
            poissons_ratio: self.poissons_ratio,
            friction_angle: 0.0,
            cohesion: self.cohesion,
            dilatancy_angle: 0.0,
            matching: match self.exact_in {
                ExactIn::PlaneStrain => Matching::PlaneStrain,
                ExactIn::Triaxial => Matching::Compression,
            },
            softening,
            dilatancy_decay: 0.0,
            integration: PlasticIntegration::default(),
            strain_measure: self.strain_measure,
            return_initial_stress_to_yield: self.return_initial_stress_to_yield,
        };
        let own = |error: MaterialError| error.with_key("softening.residual_cohesion", "residual_cohesion");
        let law =
            law.law().map_err(|error| own(error.with_key("softening.cohesion_rate", "softening_rate")))?;
        self.check_softening_pair()?;
        Ok(law.with_name("von-mises"))
    }

    /// Checks that both parameters of softening are given or neither.
    fn check_softening_pair(&self) -> Result<(), MaterialError> {
        let refuse = |field, rule| Err(MaterialError::incompatible_options(field, rule));
        match self.residual_cohesion {
            Some(_) if self.softening_rate == 0.0 => {
                refuse("residual_cohesion", "is never reached without a softening_rate")
            }
            None if self.softening_rate != 0.0 => {
                refuse("softening_rate", "needs a residual_cohesion as the end of softening")
            }
            _ => Ok(()),
        }
    }
}

impl Model for VonMisesSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Bui & Nguyen 2021, section 4.3",
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
        let residual = match reduction.scope {
            ReductionScope::Peak => self.residual_cohesion,
            ReductionScope::Both => self.residual_cohesion.map(|c| c / reduction.factor),
        };
        let reduced =
            Self { cohesion: self.cohesion / reduction.factor, residual_cohesion: residual, ..self.clone() };
        Some(reduced.law().map(|_| reduced))
    }

    fn examples() -> Vec<Self> {
        let with = |exact_in, residual_cohesion| Self {
            density: 2000.0,
            youngs_modulus: 20e6,
            poissons_ratio: 0.3,
            cohesion: 20e3,
            exact_in,
            residual_cohesion,
            softening_rate: if residual_cohesion.is_some() { 5.0 } else { 0.0 },
            strain_measure: StrainMeasure::Rate,
            return_initial_stress_to_yield: false,
        };
        let hencky = Self { strain_measure: StrainMeasure::Hencky, ..with(ExactIn::PlaneStrain, None) };
        vec![with(ExactIn::PlaneStrain, None), with(ExactIn::Triaxial, Some(5e3)), hencky]
    }
}
