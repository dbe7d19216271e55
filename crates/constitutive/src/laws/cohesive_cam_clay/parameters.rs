//! Parameters of `cohesive-cam-clay` and construction of the law.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::super::Elasticity;
use super::super::linear_elastic::{snow_ratio_warnings, text_above};
use super::CohesiveCamClay;
use crate::Warning;
use crate::adapters::hencky::StressInvariants;
use crate::contract::parameter_checks::{check, not_negative, positive};
use crate::laws::model::with_defaults;
use crate::laws::model::{Model, ModelFamily, ModelInfo};
use crate::{Material, MaterialError};

/// Parameters of `cohesive-cam-clay`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CohesiveCamClaySpec {
    /// Density (kg/m³), positive.
    pub density: f64,
    /// Young's modulus (Pa), positive.
    pub youngs_modulus: f64,
    /// Poisson's ratio, between -1 and 0.5.
    pub poissons_ratio: f64,
    /// Cohesionless critical-state slope `M = q/p`, positive.
    pub critical_state_slope: f64,
    /// Isotropic tensile strength over `p0`, β, non-negative.
    #[serde(default)]
    pub cohesion_ratio: f64,
    /// Initial isotropic compressive strength `p0` (Pa), positive, below the bulk modulus.
    pub compressive_strength: f64,
    /// Growth factor ξ of `p0` with plastic volume, positive.
    pub hardening_factor: f64,
    /// Hardening of `p0`.
    #[serde(default)]
    pub hardening: CamClayHardening,
    /// Tensor of invariants.
    #[serde(default)]
    pub invariants: StressInvariants,
    /// Time of the `p0` of the return.
    #[serde(default)]
    pub integration: CamClayIntegration,
    /// Return of initial stress outside yield; otherwise refused.
    #[serde(default)]
    pub return_initial_stress_to_yield: bool,
}

/// Time of the `p0` to which `cohesive-cam-clay` returns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CamClayIntegration {
    /// End of step: stress on its yield surface.
    #[default]
    Implicit,
    /// Start of step, as in Gaume et al.: stress one step behind. Both agree as steps shrink, but differ at explicit steps in
    /// fast-softening weak layers.
    Explicit,
}

/// Change of strength of `cohesive-cam-clay`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum CamClayHardening {
    /// Plastic compaction hardens, plastic dilation softens.
    #[default]
    Slab,
    /// Either plastic volume change softens until collapse; then as slab, without cohesion.
    WeakLayer {
        /// Anticrack strain α per plastic volumetric strain before collapse, positive.
        softening_factor: f64,
    },
}

impl CohesiveCamClaySpec {
    /// Parameters from density (kg/m³), Young's modulus (Pa), Poisson's ratio (-), critical state slope (-), compressive strength (Pa)
    /// and hardening factor (-); all others have the defaults of a case file.
    #[must_use]
    pub fn new(
        density: f64,
        youngs_modulus: f64,
        poissons_ratio: f64,
        critical_state_slope: f64,
        compressive_strength: f64,
        hardening_factor: f64,
    ) -> Self {
        with_defaults(&[
            ("density", density),
            ("youngs_modulus", youngs_modulus),
            ("poissons_ratio", poissons_ratio),
            ("critical_state_slope", critical_state_slope),
            ("compressive_strength", compressive_strength),
            ("hardening_factor", hardening_factor),
        ])
    }

    /// Checks the ranges and builds the law.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn law(&self) -> Result<CohesiveCamClay, MaterialError> {
        let elasticity = Elasticity::new(self.youngs_modulus, self.poissons_ratio)?;
        positive("critical_state_slope", self.critical_state_slope, "")?;
        not_negative("cohesion_ratio", self.cohesion_ratio, "")?;
        positive("compressive_strength", self.compressive_strength, "Pa")?;
        positive("hardening_factor", self.hardening_factor, "")?;
        if let CamClayHardening::WeakLayer { softening_factor } = self.hardening {
            positive("hardening.softening_factor", softening_factor, "")?;
        }
        let elasticity = self.invariants.elasticity(elasticity);
        // Sheet: snow-mpm §7.
        let (strength, bulk) = (self.compressive_strength, elasticity.bulk_modulus);
        let rule = format!("must be below the bulk modulus, which is {bulk:.4e} Pa");
        check("compressive_strength", strength, strength < bulk, &rule)?;
        Ok(CohesiveCamClay { elasticity, spec: self.clone() })
    }
}

impl CohesiveCamClaySpec {
    /// Warns of strengths that do not match the elasticity or the softening (sheet: snow-mpm §7, P9).
    fn warn_of_strength(&self, warnings: &mut Vec<Warning>) {
        let Ok(law) = self.law() else { return };
        let (strength, bulk) = (self.compressive_strength, law.elasticity.bulk_modulus);
        if strength > 0.1 * bulk {
            warnings.push(Warning::new("large-elastic-strain", format!(
                "compressive_strength: {strength} Pa is more than a tenth of the bulk modulus ({bulk:.4e} \
                 Pa): elastic strains become large before it yields. Lower the strength, or raise the \
                 stiffness"
            )));
        }
        let slope = self.cohesion_ratio * law.strength(law.initial_strain()).1.abs() / bulk;
        if slope >= 1.0 {
            warnings.push(Warning::new("brittle-softening", format!(
                "hardening_factor: {} makes the failure in tension unstable (β ξ cosh(ξ x0) = {slope:.3}, \
                 stable below 1). Lower hardening_factor or cohesion_ratio",
                self.hardening_factor
            )));
        }
    }
}

impl Model for CohesiveCamClaySpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Gaume et al. 2020, eqs. 54–58",
        kind: ModelFamily::Solid,
        strain: "Hencky",
        tangent: "analytic",
    };

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        Ok(self.invariants.wrap(self.law()?))
    }

    fn warnings(&self) -> Vec<Warning> {
        let mut warnings = snow_ratio_warnings(self.poissons_ratio);
        let slope = ("critical_state_slope", self.critical_state_slope, 3.0);
        let text = text_above(slope, "no snow or soil has a friction so large. Give 6 sin φ / (3 - sin φ)");
        warnings.extend(text.map(|text| Warning::new("large-critical-slope", text)));
        let text = text_above(
            ("cohesion_ratio", self.cohesion_ratio, 1.0),
            "the strength in tension is then above that in compression, and return mappings take longer. Give 1 or less",
        );
        warnings.extend(text.map(|text| Warning::new("tension-above-compression", text)));
        self.warn_of_strength(&mut warnings);
        if let (CamClayHardening::WeakLayer { softening_factor }, Ok(law)) = (self.hardening, self.law()) {
            let slope =
                softening_factor * law.strength(law.initial_strain()).1.abs() / law.elasticity.bulk_modulus;
            if slope >= 1.0 {
                warnings.push(Warning::new(
                    "brittle-softening",
                    format!(
                        "hardening.softening_factor: {softening_factor} makes the failure of the weak layer \
                     unstable (α ξ cosh(ξ x0) = {slope:.3}, stable below 1). Lower softening_factor"
                    ),
                ));
            }
        }
        warnings
    }

    fn examples() -> Vec<Self> {
        let with = |hardening_factor, hardening| Self {
            density: 250.0,
            youngs_modulus: 20e6,
            poissons_ratio: 0.3,
            critical_state_slope: 0.8,
            cohesion_ratio: 0.1,
            compressive_strength: 200e3,
            hardening_factor,
            hardening,
            invariants: StressInvariants::Space,
            integration: CamClayIntegration::Implicit,
            return_initial_stress_to_yield: false,
        };
        vec![
            with(10.0, CamClayHardening::Slab),
            with(0.5, CamClayHardening::WeakLayer { softening_factor: 1.0 }),
            with(1.0, CamClayHardening::WeakLayer { softening_factor: 3.0 }),
        ]
    }
}
