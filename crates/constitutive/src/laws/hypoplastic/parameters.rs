//! Parameters of `hypoplastic`: their ranges, the calibration of the constants, and the construction of the law.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::super::acceleration_viscous::{AccelerationViscosity, AccelerationViscous, ViscousMode};
use super::{CriticalState, Hypoplastic, HypoplasticConstants};
use crate::Warning;
use crate::contract::parameter_checks::{check, positive};
use crate::laws::model::{Model, ModelFamily, ModelInfo};
use crate::{Corotational, Material, MaterialError};

/// Parameters of `hypoplastic`, angles in degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HypoplasticSpec {
    /// Density (kg/m³), positive.
    pub density: f64,
    /// Initial void ratio, positive.
    pub void_ratio: f64,
    /// Four constants, or two states to calibrate them.
    pub parameters: HypoplasticParameters,
    /// Critical-state line; when absent no influence of density (`f_d = 1`).
    #[serde(default)]
    pub critical_state: Option<CriticalState>,
    /// Mean pressure (Pa) below which stress is zero, positive.
    #[serde(default = "minimum_pressure")]
    pub minimum_pressure: f64,
    /// Viscous stress from the acceleration of strain.
    #[serde(default)]
    pub viscous: Option<AccelerationViscosity>,
}

/// Default minimum mean pressure of the law (Pa).
fn minimum_pressure() -> f64 {
    10.0
}

/// Source of the four constants.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum HypoplasticParameters {
    /// Given constants; spurious stationary states raise a warning.
    Constants(HypoplasticConstants),
    /// Calibrated constants; spurious stationary states are refused.
    Calibration(Calibration),
}

/// Triaxial compression from isotropic stress: start and failure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Calibration {
    /// Initial Young's modulus (Pa), positive.
    pub youngs_modulus: f64,
    /// Isotropic pressure (Pa), positive.
    pub pressure: f64,
    /// Initial Poisson's ratio, 0 to 0.5 (excluded).
    #[serde(default)]
    pub poissons_ratio: f64,
    /// Critical friction angle (degrees), between 0 and 90.
    pub friction_angle: f64,
    /// Dilatancy angle at failure (degrees), between -45 and 45: `tan ψ = 2ν - 1`, ν lateral expansion over axial compression.
    #[serde(default)]
    pub dilatancy_angle: f64,
}

impl HypoplasticConstants {
    /// Calibrates the constants to an isotropic state and to a stationary state in triaxial compression (eqs. 16–18). The isotropic state
    /// has the given initial stiffness and Poisson's ratio.
    ///
    /// # Errors
    /// A parameter out of range, or a friction angle for which a loading path stalls before failure.
    pub fn calibrate(calibration: &Calibration) -> Result<Self, MaterialError> {
        let Calibration { youngs_modulus, pressure, poissons_ratio, friction_angle, dilatancy_angle } =
            *calibration;
        positive("parameters.calibration.youngs_modulus", youngs_modulus, "Pa")?;
        positive("parameters.calibration.pressure", pressure, "Pa")?;
        let holds = (0.0..0.5).contains(&poissons_ratio);
        check(
            "parameters.calibration.poissons_ratio",
            poissons_ratio,
            holds,
            "is not in 0..0.5 (0.5 excluded)",
        )?;
        let holds = friction_angle > 0.0 && friction_angle < 90.0;
        check(
            "parameters.calibration.friction_angle",
            friction_angle,
            holds,
            "is not between 0 and 90 degrees",
        )?;
        let holds = dilatancy_angle > -45.0 && dilatancy_angle < 45.0;
        check(
            "parameters.calibration.dilatancy_angle",
            dilatancy_angle,
            holds,
            "is not between -45 and 45 degrees",
        )?;

        let sin = friction_angle.to_radians().sin();
        let r = (1.0 + sin) / (1.0 - sin);
        let nu = 0.5 * (1.0 + dilatancy_angle.to_radians().tan());
        let norm = |nu: f64| (1.0 + 2.0 * nu * nu).sqrt();
        let (ni, n) = (norm(poissons_ratio), norm(nu));
        let c1 = -youngs_modulus / (3.0 * pressure * (1.0 + poissons_ratio));
        // C3 = slope C2 + shift, from no lateral stress rate in the isotropic state.
        let slope = (1.0 - 2.0 * poissons_ratio) / ni;
        let shift = -9.0 * poissons_ratio * c1 / ni;
        let (outer, inner) = ((r + 2.0).powi(2), r * r - 4.0);
        let c2 = (inner * n * shift - outer * (1.0 + 4.0 * nu) * c1)
            / ((r - 4.0) * (r - 2.0 * nu) - inner * n * slope);
        let c3 = slope * c2 + shift;
        let c4 = 9.0 * ((r - 2.0 * nu) * c2 - nu * outer * c1 - n * c3) / ((r - 1.0).powi(2) * n);
        let constants = Self { c1, c2, c3, c4 };
        let field = "parameters.calibration.friction_angle";
        let finite = [c1, c2, c3, c4].iter().all(|c| c.is_finite());
        check(field, friction_angle, finite, "has no calibration at this Poisson's ratio and dilatancy")?;
        let states = constants.stationary_states();
        let wanted = states.iter().any(|state| (state.stress_ratio - r).abs() < 1e-6 * r);
        let early = states.iter().find(|state| state.stress_ratio < r * (1.0 - 1e-6));
        if let Some(state) = early {
            let rule = format!(
                "stops at the spurious stationary state R = {:.4}, ψ = {:.1}° before failure at R = {r:.4}",
                state.stress_ratio,
                state.dilatancy_angle.to_degrees()
            );
            return Err(MaterialError::parameter(field, friction_angle, rule));
        }
        check(field, friction_angle, wanted, "is not reached by a compression path with these constants")?;
        Ok(constants)
    }
}

impl HypoplasticSpec {
    /// Parameters from density (kg/m³), void ratio (-) and parameters; all others have the defaults of a case file.
    #[must_use]
    pub fn new(density: f64, void_ratio: f64, parameters: HypoplasticParameters) -> Self {
        Self {
            density,
            void_ratio,
            parameters,
            critical_state: None,
            minimum_pressure: minimum_pressure(),
            viscous: None,
        }
    }

    /// Checks the ranges and builds the frictional law, without its viscous part.
    ///
    /// # Errors
    /// The first parameter out of range; a calibration with spurious stationary states.
    pub fn law(&self) -> Result<Hypoplastic, MaterialError> {
        positive("void_ratio", self.void_ratio, "")?;
        positive("minimum_pressure", self.minimum_pressure, "Pa")?;
        let constants = match &self.parameters {
            HypoplasticParameters::Calibration(calibration) => HypoplasticConstants::calibrate(calibration)?,
            HypoplasticParameters::Constants(constants) => {
                let c1 = constants.c1;
                check("parameters.constants.c1", c1, c1.is_finite() && c1 < 0.0, "must be negative")?;
                for (name, value) in [
                    ("parameters.constants.c2", constants.c2),
                    ("parameters.constants.c3", constants.c3),
                    ("parameters.constants.c4", constants.c4),
                ] {
                    check(name, value, value.is_finite(), "must be finite")?;
                }
                *constants
            }
        };
        if let Some(critical) = &self.critical_state {
            critical.validate()?;
        }
        Ok(Hypoplastic {
            constants,
            critical_state: self.critical_state,
            void_ratio: self.void_ratio,
            minimum_pressure: self.minimum_pressure,
        })
    }
}

impl Model for HypoplasticSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Wu, Wang & Alipour 2020, eqs. 8–32",
        kind: ModelFamily::Solid,
        strain: "rate",
        tangent: "analytic (viscous mode rate-material: numerical)",
    };

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        let frictional = Corotational(self.law()?);
        Ok(match self.viscous {
            None => Arc::new(frictional),
            Some(viscosity) => Arc::new(AccelerationViscous::new(frictional, viscosity)?),
        })
    }

    fn warnings(&self) -> Vec<Warning> {
        let mut warnings = Vec::new();
        if let HypoplasticParameters::Constants(constants) = &self.parameters {
            let states = constants.stationary_states();
            if states.len() != 1 {
                let ratios: Vec<String> = states.iter().map(|s| format!("{:.4}", s.stress_ratio)).collect();
                warnings.push(Warning::new(
                    "several-stationary-states",
                    format!(
                        "parameters.constants: triaxial compression has {} stationary states (stress ratios \
                     {}) instead of one. Give `calibration` in place of the constants, or other constants",
                        states.len(),
                        ratios.join(", ")
                    ),
                ));
            }
        }
        if let Some(critical) = &self.critical_state
            && self.void_ratio <= critical.minimum_void_ratio
        {
            warnings.push(Warning::new(
                "void-ratio-out-of-range",
                format!(
                    "void_ratio: {} is not above the smallest void ratio, {}. Correct void_ratio or \
                 critical_state.minimum_void_ratio",
                    self.void_ratio, critical.minimum_void_ratio
                ),
            ));
        }
        if self.viscous.is_some_and(|viscous| viscous.mode == ViscousMode::RateMaterial) {
            warnings.push(Warning::new(
                "not-objective",
                "viscous.mode: rate-material is not objective; use it in element tests only",
            ));
        }
        warnings
    }

    fn examples() -> Vec<Self> {
        let plain = Self {
            density: 1700.0,
            void_ratio: 0.7,
            parameters: HypoplasticParameters::Calibration(Calibration {
                youngs_modulus: 20e6,
                pressure: 100e3,
                poissons_ratio: 0.0,
                friction_angle: 30.0,
                dilatancy_angle: 0.0,
            }),
            critical_state: None,
            minimum_pressure: minimum_pressure(),
            viscous: None,
        };
        let critical_state = CriticalState {
            minimum_void_ratio: 0.5,
            p1: 0.5,
            p2: 0.5,
            p3: -5e-7,
            q1: 1.0,
            q2: -0.2,
            q3: -1e-7,
        };
        let dense = Self { critical_state: Some(critical_state), ..plain.clone() };
        let viscous = AccelerationViscosity {
            a: -8e-4,
            m1: 0.5,
            m2: 1e-3,
            eta1: 5.0,
            eta3: 0.0,
            mode: ViscousMode::Integrated,
        };
        let viscous = Self { viscous: Some(viscous), ..dense.clone() };
        vec![plain, dense, viscous]
    }
}
