//! Parameters of the Cam-clays in a case file.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::CamClay;
use crate::Warning;
use crate::contract::parameter_checks::{check, positive};
use crate::laws::cam_clay::common::{CamClayConstants, InitialSurfaceSize, ShearStiffness};
use crate::laws::linear_elastic::incompressibility_warnings;
use crate::laws::model::with_defaults;
use crate::laws::model::{Model, ModelFamily, ModelInfo};
use crate::laws::pressure_elastic::{check_poissons_ratio, shear_ratio};
use crate::{Corotational, Material, MaterialError};

/// Parameters of `modified-cam-clay` and `original-cam-clay`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CamClaySpec {
    /// Density (kg/m³), positive.
    pub density: f64,
    /// Critical-state slope `M = q/p`, positive.
    pub critical_state_slope: f64,
    /// Slope `λ` of normal compression (specific volume over ln p), above `κ`.
    pub compression_slope: f64,
    /// Slope `κ` of unloading–reloading, positive.
    pub swelling_slope: f64,
    /// Poisson's ratio, between -1 and 0.5, or give `shear_modulus`.
    #[serde(default)]
    pub poissons_ratio: Option<f64>,
    /// Constant shear modulus (Pa), positive, or give `poissons_ratio`.
    #[serde(default)]
    pub shear_modulus: Option<f64>,
    /// Initial void ratio, positive.
    pub void_ratio: f64,
    /// Initial tip pressure `p_c` of yield (Pa), positive, or give `overconsolidation_ratio`.
    #[serde(default)]
    pub preconsolidation_pressure: Option<f64>,
    /// Overconsolidation ratio, at least 1: `p_c` over that through the initial stress.
    #[serde(default)]
    pub overconsolidation_ratio: Option<f64>,
    /// Return of initial stress outside yield (pressure to `p_c`, then deviator); otherwise refused.
    #[serde(default)]
    pub return_initial_stress_to_yield: bool,
}

impl CamClaySpec {
    /// Parameters from density (kg/m³), critical state slope (-), compression slope (-), swelling slope (-) and void ratio (-); all
    /// others have their defaults.
    #[must_use]
    pub fn new(
        density: f64,
        critical_state_slope: f64,
        compression_slope: f64,
        swelling_slope: f64,
        void_ratio: f64,
    ) -> Self {
        with_defaults(&[
            ("density", density),
            ("critical_state_slope", critical_state_slope),
            ("compression_slope", compression_slope),
            ("swelling_slope", swelling_slope),
            ("void_ratio", void_ratio),
        ])
    }

    /// Checks the ranges and builds the law.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn law(&self) -> Result<CamClay, MaterialError> {
        Ok(CamClay { constants: self.constants()? })
    }

    /// Checks the ranges and returns the constants.
    pub(in crate::laws) fn constants(&self) -> Result<CamClayConstants, MaterialError> {
        positive("critical_state_slope", self.critical_state_slope, "")?;
        positive("swelling_slope", self.swelling_slope, "")?;
        let (lambda, kappa) = (self.compression_slope, self.swelling_slope);
        let rule = format!("must be above swelling_slope, {kappa}");
        check("compression_slope", lambda, lambda.is_finite() && lambda > kappa, &rule)?;
        let shear = match (self.poissons_ratio, self.shear_modulus) {
            (Some(ratio), None) => {
                check_poissons_ratio(ratio)?;
                ShearStiffness::Ratio(shear_ratio(ratio))
            }
            (None, Some(modulus)) => {
                positive("shear_modulus", modulus, "Pa")?;
                ShearStiffness::Modulus(modulus)
            }
            (ratio, _) => return Err(exclusive_options_error("poissons_ratio", ratio, "shear_modulus")),
        };
        positive("void_ratio", self.void_ratio, "")?;
        let size = match (self.preconsolidation_pressure, self.overconsolidation_ratio) {
            (Some(pressure), None) => {
                positive("preconsolidation_pressure", pressure, "Pa")?;
                InitialSurfaceSize::Pressure(pressure)
            }
            (None, Some(ratio)) => {
                let rule = "must be at least 1";
                check("overconsolidation_ratio", ratio, ratio.is_finite() && ratio >= 1.0, rule)?;
                InitialSurfaceSize::Ratio(ratio)
            }
            (pressure, _) => {
                return Err(exclusive_options_error(
                    "preconsolidation_pressure",
                    pressure,
                    "overconsolidation_ratio",
                ));
            }
        };
        Ok(CamClayConstants {
            critical: self.critical_state_slope,
            compression: lambda,
            swelling: kappa,
            shear,
            void_ratio: self.void_ratio,
            size,
            return_initial_stress_to_yield: self.return_initial_stress_to_yield,
        })
    }

    /// Warnings on the shear stiffness.
    pub(in crate::laws) fn stiffness_warnings(&self) -> Vec<Warning> {
        self.poissons_ratio.map(incompressibility_warnings).unwrap_or_default()
    }

    /// Samples: over-consolidated, normally consolidated, and with constant shear modulus.
    pub(in crate::laws) fn samples() -> Vec<Self> {
        let soft = Self {
            density: 1800.0,
            critical_state_slope: 1.0,
            compression_slope: 0.2,
            swelling_slope: 0.05,
            poissons_ratio: Some(0.3),
            shear_modulus: None,
            void_ratio: 1.0,
            preconsolidation_pressure: None,
            overconsolidation_ratio: Some(1.5),
            return_initial_stress_to_yield: false,
        };
        let normal = Self { overconsolidation_ratio: Some(1.0), critical_state_slope: 1.2, ..soft.clone() };
        let stiff = Self {
            poissons_ratio: None,
            shear_modulus: Some(2e6),
            preconsolidation_pressure: Some(200e3),
            overconsolidation_ratio: None,
            ..soft.clone()
        };
        vec![soft, normal, stiff]
    }
}

/// Error of two options of which exactly one must be given.
fn exclusive_options_error(field: &'static str, given: Option<f64>, other: &str) -> MaterialError {
    let rule = match given {
        Some(_) => format!("and {other} exclude each other: give one"),
        None => format!("or {other} must be given"),
    };
    match given {
        Some(value) => MaterialError::parameter(field, value, rule),
        None => MaterialError::incompatible_options(field, rule),
    }
}

impl Model for CamClaySpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Roscoe & Burland 1968; implicit return",
        kind: ModelFamily::Solid,
        strain: "rate",
        tangent: "analytic",
    };

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        Ok(Arc::new(Corotational(self.law()?)))
    }

    fn warnings(&self) -> Vec<Warning> {
        self.stiffness_warnings()
    }

    fn examples() -> Vec<Self> {
        Self::samples()
    }
}
