//! Parameters of `mohr-coulomb` in a case file.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{MohrCoulomb, NAME, Pyramid};
use crate::Warning;
use crate::contract::parameter_checks::check;
use crate::laws::drucker_prager::Softening;
use crate::laws::linear_elastic::incompressibility_warnings;
use crate::laws::model::with_defaults;
use crate::laws::model::{Model, ModelFamily, ModelInfo, StrainMeasure};
use crate::laws::strength_reduced::StrengthReduction;
use crate::laws::{Elasticity, angle_warnings, check_angles};
use crate::{Material, MaterialError};

/// Parameters of `mohr-coulomb`, angles in degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MohrCoulombSpec {
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
    /// Exponential softening.
    #[serde(default)]
    pub softening: Option<Softening>,
    /// Dilatancy decay rate over plastic strain.
    #[serde(default)]
    pub dilatancy_decay: f64,
    /// Tension cut-off (Pa, Rankine, associated), 0 to `c / tan φ`; none when absent.
    #[serde(default)]
    pub tensile_strength: Option<f64>,
    /// Strain measure.
    #[serde(default)]
    pub strain_measure: StrainMeasure,
    /// Return of initial stress outside yield; otherwise refused.
    #[serde(default)]
    pub return_initial_stress_to_yield: bool,
}

impl MohrCoulombSpec {
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

    /// Sets the dilatancy angle, and the friction angle by Bolton's rule `φ = φ_cs + 0.8 ψ` from the critical-state angle (Anura3D manual
    /// eq. 7.28); angles in degrees.
    #[must_use]
    pub fn from_bolton(self, critical_state_angle: f64, dilatancy_angle: f64) -> Self {
        Self { friction_angle: critical_state_angle + 0.8 * dilatancy_angle, dilatancy_angle, ..self }
    }

    /// Checks the ranges and builds the law.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn law(&self) -> Result<MohrCoulomb, MaterialError> {
        let elasticity = Elasticity::new(self.youngs_modulus, self.poissons_ratio)?;
        check_angles(self.friction_angle, self.dilatancy_angle)?;
        let (cohesion, decay) = (self.cohesion, self.dilatancy_decay);
        Softening::check(self.softening, self.friction_angle, cohesion, decay)?;
        let friction_angle = self.friction_angle.to_radians();
        if let Some(strength) = self.tensile_strength {
            let apex = cohesion / friction_angle.tan();
            let rule = format!("is not between 0 and the apex c / tan φ, {apex:.6} Pa");
            check("tensile_strength", strength, strength >= 0.0 && strength <= apex, &rule)?;
        }
        let constant = self.softening.is_none() && decay == 0.0;
        let peak = Pyramid::new(friction_angle, cohesion, self.dilatancy_angle.to_radians())
            .with_cut_off(self.tensile_strength);
        let (k, m) = (peak.friction, peak.dilatancy);
        let modulus =
            elasticity.lame() * (k - 1.0) * (m - 1.0) + 2.0 * elasticity.shear_modulus * (k * m + 1.0);
        let rule = "gives a contraction too large for this stiffness (aᵀ D b must be positive)";
        check("dilatancy_angle", self.dilatancy_angle, modulus > 0.0, rule)?;
        let peak = peak.pyramid_return(&elasticity);
        Ok(MohrCoulomb {
            name: NAME,
            elasticity,
            spec: self.clone(),
            has_constant_pyramid: constant,
            peak_return: peak,
        })
    }
}

impl Model for MohrCoulombSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Anura3D manual 2021, eqs. 7.25–7.28; Clausen et al. 2006 (return)",
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
        warnings
    }

    fn strength_reduced(&self, reduction: &StrengthReduction) -> Option<Result<Self, MaterialError>> {
        let friction_angle = reduction.angle(self.friction_angle);
        let cohesion = self.cohesion / reduction.factor;
        let reduced = Self {
            friction_angle,
            cohesion,
            dilatancy_angle: reduction.dilatancy(self.dilatancy_angle, friction_angle),
            softening: reduction.softening(self.softening),
            // Both the cut-off and the apex c / tan φ are unchanged.
            ..self.clone()
        };
        Some(reduced.law().map(|_| reduced))
    }

    fn examples() -> Vec<Self> {
        let mut all = Vec::new();
        for strain_measure in [StrainMeasure::Rate, StrainMeasure::Hencky] {
            let variants = [
                (None, None),
                (Some(Softening::EXAMPLE), None),
                (None, Some(2e3)),
                (Some(Softening::EXAMPLE), Some(2e3)),
            ];
            all.extend(variants.map(|(softening, tensile_strength)| Self {
                density: 2000.0,
                youngs_modulus: 20e6,
                poissons_ratio: 0.3,
                friction_angle: 30.0,
                cohesion: 10e3,
                dilatancy_angle: 10.0,
                softening,
                dilatancy_decay: if softening.is_some() { 2.0 } else { 0.0 },
                tensile_strength,
                strain_measure,
                return_initial_stress_to_yield: false,
            }));
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boltons_rule_adds_four_fifths_of_the_dilatancy() {
        let sand = MohrCoulombSpec::examples()[0].clone().from_bolton(32.0, 10.0);
        assert_eq!((sand.friction_angle, sand.dilatancy_angle), (40.0, 10.0));
    }
}
