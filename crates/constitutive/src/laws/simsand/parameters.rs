//! Parameters of `simsand` in a case file.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{Simsand, VOID_RANGE};
use crate::Warning;
use crate::contract::parameter_checks::{check, not_negative, positive};
use crate::laws::linear_elastic::incompressibility_warnings;
use crate::laws::model::with_defaults;
use crate::laws::model::{Model, ModelFamily, ModelInfo};
use crate::laws::pressure_elastic::{check_poissons_ratio, shear_ratio};
use crate::{Corotational, Material, MaterialError};

/// Parameters of `simsand`, angles in degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SimsandSpec {
    /// Density (kg/m³), positive.
    pub density: f64,
    /// Initial void ratio `e`, above 0, below 2.9.
    pub void_ratio: f64,
    /// Elastic stiffness constant `K₀`, positive.
    pub stiffness_constant: f64,
    /// Exponent `ζ` of pressure in the stiffness, 0 to 1.
    pub stiffness_exponent: f64,
    /// Poisson's ratio, between -1 and 0.5.
    pub poissons_ratio: f64,
    /// Critical-state friction angle `φ_c` (degrees), above 0, below 90.
    pub critical_friction_angle: f64,
    /// Critical void ratio at zero pressure `e_ref`, positive.
    pub reference_void_ratio: f64,
    /// Critical-state factor `λ`, positive.
    pub critical_state_factor: f64,
    /// Critical-state exponent `ξ` of pressure, positive.
    pub critical_state_exponent: f64,
    /// Dilatancy constant `A_d`, non-negative.
    pub dilatancy_constant: f64,
    /// Phase-transformation exponent `n_d` of density, non-negative.
    pub dilatancy_exponent: f64,
    /// Peak-angle exponent `n_p` of density, non-negative.
    pub peak_exponent: f64,
    /// Plastic shear strain `k_p` at half strength, positive.
    pub hardening_constant: f64,
    /// Atmospheric pressure `p_at` (Pa), positive.
    #[serde(default = "atmospheric_pressure")]
    pub atmospheric_pressure: f64,
    /// Whether strength decreases from compression to extension.
    #[serde(default)]
    pub lode_dependence: bool,
    /// Reduction of initial deviators above the strength to that at plastic shear 1; otherwise refused.
    #[serde(default)]
    pub return_initial_stress_to_yield: bool,
}

/// Default atmospheric pressure (Pa).
fn atmospheric_pressure() -> f64 {
    100e3
}

impl SimsandSpec {
    /// Parameters from density (kg/m³), void ratio (-), stiffness constant (-), stiffness exponent (-), Poisson's ratio (-), critical
    /// friction angle (degrees), reference void ratio (-), critical state factor (-), critical state exponent (-), dilatancy constant
    /// (-), dilatancy exponent (-), peak exponent (-) and hardening constant (-); all others have the defaults of a case file.
    #[must_use]
    #[expect(clippy::too_many_arguments, reason = "the constants of the published law, in its order")]
    pub fn new(
        density: f64,
        void_ratio: f64,
        stiffness_constant: f64,
        stiffness_exponent: f64,
        poissons_ratio: f64,
        critical_friction_angle: f64,
        reference_void_ratio: f64,
        critical_state_factor: f64,
        critical_state_exponent: f64,
        dilatancy_constant: f64,
        dilatancy_exponent: f64,
        peak_exponent: f64,
        hardening_constant: f64,
    ) -> Self {
        with_defaults(&[
            ("density", density),
            ("void_ratio", void_ratio),
            ("stiffness_constant", stiffness_constant),
            ("stiffness_exponent", stiffness_exponent),
            ("poissons_ratio", poissons_ratio),
            ("critical_friction_angle", critical_friction_angle),
            ("reference_void_ratio", reference_void_ratio),
            ("critical_state_factor", critical_state_factor),
            ("critical_state_exponent", critical_state_exponent),
            ("dilatancy_constant", dilatancy_constant),
            ("dilatancy_exponent", dilatancy_exponent),
            ("peak_exponent", peak_exponent),
            ("hardening_constant", hardening_constant),
        ])
    }

    /// Returns the sand of Bui & Nguyen (2021), Table 1, at a void ratio: they list 0.77 (dense), 0.81 (medium) and
    /// 0.91 (loose).
    pub fn bui_nguyen(void_ratio: f64) -> Self {
        Self {
            density: 1500.0,
            void_ratio,
            stiffness_constant: 130.0,
            stiffness_exponent: 0.67,
            poissons_ratio: 0.2,
            critical_friction_angle: 31.4,
            reference_void_ratio: 0.964,
            critical_state_factor: 0.118,
            critical_state_exponent: 0.205,
            dilatancy_constant: 0.5,
            dilatancy_exponent: 3.5,
            peak_exponent: 1.9,
            hardening_constant: 0.0017,
            atmospheric_pressure: atmospheric_pressure(),
            lode_dependence: false,
            return_initial_stress_to_yield: false,
        }
    }

    /// Checks the ranges and builds the law.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn law(&self) -> Result<Simsand, MaterialError> {
        let e = self.void_ratio;
        check("void_ratio", e, e > 0.0 && e < VOID_RANGE.1, "is not between 0 and 2.9 (exclusive)")?;
        positive("stiffness_constant", self.stiffness_constant, "")?;
        let zeta = self.stiffness_exponent;
        check("stiffness_exponent", zeta, (0.0..=1.0).contains(&zeta), "is not between 0 and 1")?;
        check_poissons_ratio(self.poissons_ratio)?;
        let phi = self.critical_friction_angle;
        let rule = "is not between 0 and 90 degrees (exclusive)";
        check("critical_friction_angle", phi, phi > 0.0 && phi < 90.0, rule)?;
        positive("reference_void_ratio", self.reference_void_ratio, "")?;
        positive("critical_state_factor", self.critical_state_factor, "")?;
        positive("critical_state_exponent", self.critical_state_exponent, "")?;
        not_negative("dilatancy_constant", self.dilatancy_constant, "")?;
        not_negative("dilatancy_exponent", self.dilatancy_exponent, "")?;
        not_negative("peak_exponent", self.peak_exponent, "")?;
        positive("hardening_constant", self.hardening_constant, "")?;
        positive("atmospheric_pressure", self.atmospheric_pressure, "Pa")?;
        let shear_ratio = shear_ratio(self.poissons_ratio);
        Ok(Simsand { spec: self.clone(), shear_ratio, tangent_critical: phi.to_radians().tan() })
    }
}

impl Model for SimsandSpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Bui & Nguyen 2021, section 3.2.4; Jin et al. 2017",
        kind: ModelFamily::Solid,
        strain: "rate",
        tangent: "analytic",
    };

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        Ok(Arc::new(Corotational(self.law()?)))
    }

    fn warnings(&self) -> Vec<Warning> {
        let mut warnings = incompressibility_warnings(self.poissons_ratio);
        let (e, reference) = (self.void_ratio, self.reference_void_ratio);
        if e >= reference {
            warnings.push(Warning::new(
                "void-ratio-out-of-range",
                format!(
                    "void_ratio: {e} is looser than any critical state (below {reference}). \
                               Correct void_ratio or reference_void_ratio"
                ),
            ));
        }
        if self.dilatancy_constant > 1.0 {
            warnings.push(Warning::new(
                "work-releasing-dilatancy",
                format!(
                    "dilatancy_constant: {} is above 1, plastic flow may release work. Give 1 or less",
                    self.dilatancy_constant
                ),
            ));
        }
        warnings
    }

    fn examples() -> Vec<Self> {
        let dense = Self::bui_nguyen(0.77);
        let lode = Self { lode_dependence: true, ..Self::bui_nguyen(0.81) };
        vec![dense, lode, Self::bui_nguyen(0.91)]
    }
}
