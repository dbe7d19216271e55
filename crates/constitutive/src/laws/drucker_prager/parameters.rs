//! Parameters of `drucker-prager` in a case file.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Cone, DruckerPrager, NAME, Softening};
use crate::Warning;
use crate::contract::parameter_checks::check;
use crate::laws::linear_elastic::incompressibility_warnings;
use crate::laws::model::with_defaults;
use crate::laws::model::{Model, ModelFamily, ModelInfo, StrainMeasure};
use crate::laws::strength_reduced::StrengthReduction;
use crate::laws::{Elasticity, angle_warnings, check_angles};
use crate::{Material, MaterialError};

/// Cone matching to Mohr–Coulomb.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Matching {
    /// Triaxial compression edges: far too strong in plane strain.
    #[default]
    Compression,
    /// Triaxial extension edges.
    Extension,
    /// Inscribed cone: plane-strain strength for associated flow only.
    PlaneStrainAssociated,
    /// Mohr–Coulomb strength and dilatancy in plane strain, any dilatancy.
    PlaneStrain,
}

/// Parameters of `drucker-prager`, angles in degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DruckerPragerSpec {
    /// Density (kg/m³), positive.
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
    /// Dilatancy angle (degrees), within ±`friction_angle`.
    #[serde(default)]
    pub dilatancy_angle: f64,
    /// Cone matching to Mohr–Coulomb.
    #[serde(default)]
    pub matching: Matching,
    /// Exponential softening.
    #[serde(default)]
    pub softening: Option<Softening>,
    /// Dilatancy decay rate over plastic strain.
    #[serde(default)]
    pub dilatancy_decay: f64,
    /// Integration of plastic steps.
    #[serde(default)]
    pub integration: PlasticIntegration,
    /// Strain measure.
    #[serde(default)]
    pub strain_measure: StrainMeasure,
    /// Return of initial stress outside yield; otherwise refused.
    #[serde(default)]
    pub return_initial_stress_to_yield: bool,
}

/// Integration of a plastic step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PlasticIntegration {
    /// Implicit return to cone or apex.
    #[default]
    ClosestPoint,
    /// Algorithm 2 of Bui & Nguyen: one corrector with trial slopes; drift is scaled back. The implicit return replaces it if softening
    /// takes at least half the elastic resistance `G + 9Kαα_ψ`, or work would be gained.
    SemiImplicit,
    /// Algorithm 1 of Bui & Nguyen: forward step from the cone; drift is corrected by tension cracking and stress scaling. Steps above half
    /// of the yield strain at zero pressure, `k/2G`, are divided. The implicit return replaces parts that start by unloading or
    /// might reverse the deviator, and steep softening.
    Explicit,
}

impl DruckerPragerSpec {
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
    pub fn law(&self) -> Result<DruckerPrager, MaterialError> {
        let elasticity = Elasticity::new(self.youngs_modulus, self.poissons_ratio)?;
        check_angles(self.friction_angle, self.dilatancy_angle)?;
        let (cohesion, decay) = (self.cohesion, self.dilatancy_decay);
        Softening::check(self.softening, self.friction_angle, cohesion, decay)?;
        if self.integration != PlasticIntegration::ClosestPoint
            && self.strain_measure == StrainMeasure::Hencky
        {
            let rule = "only closest-point is available with strain_measure hencky";
            return Err(MaterialError::incompatible_options("integration", rule));
        }
        let constant = self.softening.is_none() && decay == 0.0;
        let law = DruckerPrager {
            name: NAME,
            elasticity,
            spec: self.clone(),
            has_constant_cone: constant,
            peak: Cone::default(),
            inverse_plastic_modulus: 0.0,
        };
        let peak = law.softened_cone(0.0);
        let modulus =
            elasticity.shear_modulus + 9.0 * elasticity.bulk_modulus * peak.friction * peak.dilatancy;
        let rule = "gives a contraction too large for this stiffness (G + 9 K α α_ψ must be positive)";
        check("dilatancy_angle", self.dilatancy_angle, modulus > 0.0, rule)?;
        Ok(DruckerPrager { peak, inverse_plastic_modulus: 1.0 / modulus, ..law })
    }

    /// Common parameters of the samples.
    fn example(matching: Matching) -> Self {
        Self {
            density: 2000.0,
            youngs_modulus: 20e6,
            poissons_ratio: 0.3,
            friction_angle: 30.0,
            cohesion: 10e3,
            dilatancy_angle: 10.0,
            matching,
            softening: None,
            dilatancy_decay: 0.0,
            integration: PlasticIntegration::default(),
            strain_measure: StrainMeasure::Rate,
            return_initial_stress_to_yield: false,
        }
    }
}

impl Model for DruckerPragerSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Bui & Nguyen 2021, eqs. 74–80",
        kind: ModelFamily::Solid,
        strain: "rate or Hencky",
        tangent: "analytic",
    };

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        Ok(self.strain_measure.wrap(self.law()?))
    }

    fn warnings(&self) -> Vec<Warning> {
        let mut warnings = incompressibility_warnings(self.poissons_ratio);
        warnings.extend(angle_warnings(self.friction_angle, self.dilatancy_angle));
        if self.matching == Matching::Compression && self.friction_angle >= 36.87 {
            warnings.push(Warning::new(
                "tension-in-cone",
                format!(
                    "matching: at {} degrees, above 36.87, the compression cone admits tension in extension. \
                     Use plane-strain, or the model mohr-coulomb",
                    self.friction_angle
                ),
            ));
        }
        if self.matching == Matching::PlaneStrainAssociated && self.dilatancy_angle != self.friction_angle {
            warnings.push(Warning::new(
                "inexact-matching",
                format!(
                    "matching: plane-strain-associated is exact only for associated flow, but the friction \
                     angle is {} and the dilatancy angle {} degrees. Use plane-strain",
                    self.friction_angle, self.dilatancy_angle
                ),
            ));
        }
        if let Ok(law) = self.law() {
            // Sheet: snow-mpm §7, κ c0 ≥ 3 μ of the cone in q.
            let softens = -law.cone_rate(0.0).strength / (3f64.sqrt() * law.elasticity.shear_modulus);
            if softens >= 1.0 {
                warnings.push(Warning::new("brittle-softening", format!(
                    "softening.cohesion_rate: strength decreases {softens:.2} times as fast as the stress \
                     by elastic unloading: a point loses its strength at once, and results depend on the \
                     steps. Divide the rate by more than {softens:.2}"
                )));
            }
        }
        warnings
    }

    fn strength_reduced(&self, reduction: &StrengthReduction) -> Option<Result<Self, MaterialError>> {
        let friction_angle = reduction.angle(self.friction_angle);
        let reduced = Self {
            friction_angle,
            cohesion: self.cohesion / reduction.factor,
            dilatancy_angle: reduction.dilatancy(self.dilatancy_angle, friction_angle),
            softening: reduction.softening(self.softening),
            ..self.clone()
        };
        Some(reduced.law().map(|_| reduced))
    }

    fn examples() -> Vec<Self> {
        let mut all = Vec::new();
        for strain_measure in [StrainMeasure::Rate, StrainMeasure::Hencky] {
            for softening in [None, Some(Softening::EXAMPLE)] {
                if strain_measure == StrainMeasure::Rate {
                    let sources = [PlasticIntegration::SemiImplicit, PlasticIntegration::Explicit];
                    all.extend(sources.map(|integration| Self {
                        integration,
                        softening,
                        ..Self::example(Matching::Compression)
                    }));
                }
                let matchings = [
                    Matching::Compression,
                    Matching::Extension,
                    Matching::PlaneStrain,
                    Matching::PlaneStrainAssociated,
                ];
                all.extend(matchings.map(|matching| Self {
                    softening,
                    dilatancy_decay: if softening.is_some() { 2.0 } else { 0.0 },
                    strain_measure,
                    ..Self::example(matching)
                }));
            }
        }
        all
    }
}
