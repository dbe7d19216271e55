//! μ(I) rheology of dense granular flow (sheet: constitutive §2.9, §3.7.9; Jop, Forterre & Pouliquen 2006;
//! Bui & Nguyen 2021, eqs. 63–67; Dunatunga & Kamrin 2015).
//!
//! `√J2 = μ(I) p`, `μ(I) = μ_s + (μ_2 - μ_s)/(I_0/I + 1)`, `I = γ̇ d/√(p/ρ_s)`, with `γ̇ = √(2 D':D')`, the
//! density `ρ_s` of the grains and pressure from density, `p = c₀² (ρ - ρ₀)`, `c₀² = K/ρ₀`.
//!
//! By default elastic up to the static yield stress `μ_s p` and viscoplastic above it, so that deposits come
//! to rest; or viscous, `s = 2η dev D`, with one of three regularisations of `η` at rest, which all creep.
//! Cohesionless: where the density falls below `ρ₀` the stress is zero until the density is recovered. Limits: pressure
//! has no memory of dilatancy; ill-posed at very low and high `I`.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::equation_of_state::{Barotropic, EquationOfState};
use super::granular_flow::inertial_number;
use crate::Warning;
use crate::contract::parameter_checks::{check, positive};
use crate::laws::model::with_defaults;
use crate::laws::model::{Model, ModelFamily, ModelInfo};
use crate::laws::viscous_flow::{
    EffectiveViscosity, FlowCurve, FlowOutputs, Viscoplastic, ViscousFluid, shear_modulus,
    without_shear_modulus,
};
use crate::{Corotational, Material, MaterialError};

/// Value of the key `model` in case files.
const NAME: &str = "mu-i";

/// Parameters of `mu-i`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MuISpec {
    /// Zero-pressure density with voids (kg/m³), positive.
    pub density: f64,
    /// Bulk modulus `ρ₀ c₀²` of the packing (Pa), positive.
    pub bulk_modulus: f64,
    /// Shear modulus below yield (Pa), positive, for `elasto-viscoplastic`; by default from bulk modulus and Poisson's ratio 0.3.
    #[serde(default)]
    pub shear_modulus: Option<f64>,
    /// Grain density (kg/m³), positive.
    pub grain_density: f64,
    /// Grain diameter (m), positive.
    pub grain_diameter: f64,
    /// Static friction coefficient `μ_s`, between 0 and 2.
    pub static_friction: f64,
    /// Friction coefficient `μ_2` in fast flow: at least `static_friction`, below 2.
    pub limit_friction: f64,
    /// Inertial number `I_0` at halfway friction, positive.
    pub reference_inertial_number: f64,
    /// Flow integration.
    #[serde(default)]
    pub form: MuIForm,
}

/// Flow integration of `mu-i`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum MuIForm {
    /// Elastic below static yield: can rest on a slope, and viscosity does not limit the step. Default.
    // With braces, so that unknown keys are refused here as well.
    ElastoViscoplastic {},
    /// Capped viscosity `η = min(μ(I) p/γ̇, η_max)`, floored `γ̇` (Bui & Nguyen 2021).
    Capped {
        /// Largest viscosity `η_max` (Pa s), positive.
        max_viscosity: f64,
        /// Floor of shear rate (1/s), positive.
        #[serde(default = "rate_floor")]
        min_shear_rate: f64,
    },
    /// Smoothed viscosity `η = μ(I) p/√(γ̇² + δ²)`.
    Smoothed {
        /// Smoothing shear rate `δ` (1/s), positive.
        shear_rate: f64,
    },
    /// Papanastasiou's viscosity `η = μ_s p (1 - e^(-mγ̇))/γ̇ + (μ(I) - μ_s) p/γ̇`.
    Papanastasiou {
        /// Time constant `m` (s), positive.
        time: f64,
    },
}

impl Default for MuIForm {
    fn default() -> Self {
        Self::ElastoViscoplastic {}
    }
}

/// Least shear rate of Bui & Nguyen (1/s).
fn rate_floor() -> f64 {
    1e-7
}

/// Checks the ranges of the friction coefficients at rest and in fast flow.
pub(crate) fn check_friction(low: f64, high: f64) -> Result<(), MaterialError> {
    check("static_friction", low, low > 0.0 && low < 2.0, "is not between 0 and 2 (exclusive)")?;
    let rule = format!("is not between the static friction, {low}, and 2 (excluded)");
    check("limit_friction", high, high >= low && high < 2.0, &rule)
}

impl MuISpec {
    /// Parameters from density (kg/m³), bulk modulus (Pa), grain density (kg/m³), grain diameter (m), static friction (-), limit friction
    /// (-) and reference inertial number (-); all others have the defaults of a case file.
    #[must_use]
    pub fn new(
        density: f64,
        bulk_modulus: f64,
        grain_density: f64,
        grain_diameter: f64,
        static_friction: f64,
        limit_friction: f64,
        reference_inertial_number: f64,
    ) -> Self {
        with_defaults(&[
            ("density", density),
            ("bulk_modulus", bulk_modulus),
            ("grain_density", grain_density),
            ("grain_diameter", grain_diameter),
            ("static_friction", static_friction),
            ("limit_friction", limit_friction),
            ("reference_inertial_number", reference_inertial_number),
        ])
    }

    /// Checks the ranges and returns the friction law.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn rheology(&self) -> Result<MuI, MaterialError> {
        positive("density", self.density, "kg/m³")?;
        positive("bulk_modulus", self.bulk_modulus, "Pa")?;
        positive("grain_density", self.grain_density, "kg/m³")?;
        positive("grain_diameter", self.grain_diameter, "m")?;
        let (low, high) = (self.static_friction, self.limit_friction);
        check_friction(low, high)?;
        positive("reference_inertial_number", self.reference_inertial_number, "")?;
        match self.form {
            MuIForm::ElastoViscoplastic {} => {}
            MuIForm::Capped { max_viscosity, min_shear_rate } => {
                positive("form.max_viscosity", max_viscosity, "Pa s")?;
                positive("form.min_shear_rate", min_shear_rate, "1/s")?;
            }
            MuIForm::Smoothed { shear_rate } => positive("form.shear_rate", shear_rate, "1/s")?,
            MuIForm::Papanastasiou { time } => positive("form.time", time, "s")?,
        }
        Ok(MuI {
            static_friction: low,
            limit_friction: high,
            reference: self.reference_inertial_number,
            diameter: self.grain_diameter,
            grain_density: self.grain_density,
        })
    }

    /// Linear equation of state without tensile strength.
    fn pressure(&self) -> Barotropic {
        Barotropic { bulk_modulus: self.bulk_modulus, tension: 0.0, equation: EquationOfState::Linear }
    }

    /// Elasto-viscoplastic law of the parameters, for any form.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn viscoplastic(&self) -> Result<Viscoplastic<MuI>, MaterialError> {
        let rheology = self.rheology()?;
        let shear_modulus = shear_modulus(self.shear_modulus, self.bulk_modulus)?;
        Ok(Viscoplastic { rheology, pressure: self.pressure(), shear_modulus })
    }
}

impl Model for MuISpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Jop et al. 2006; Bui & Nguyen 2021, eqs. 63–67; Dunatunga & Kamrin 2015",
        kind: ModelFamily::Fluid,
        strain: "rate",
        tangent: "analytic (viscous forms: numerical)",
    };

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        let law = self.viscoplastic()?;
        Ok(match self.form {
            MuIForm::ElastoViscoplastic {} => Arc::new(Corotational(law)),
            form => {
                without_shear_modulus(self.shear_modulus, "elasto-viscoplastic")?;
                let rheology = RegularisedMuI { law: law.rheology, form };
                Arc::new(ViscousFluid { rheology, pressure: law.pressure })
            }
        })
    }

    fn warnings(&self) -> Vec<Warning> {
        let mut warnings = Vec::new();
        if self.density >= self.grain_density {
            warnings.push(Warning::new(
                "no-voids",
                format!(
                    "density: {} kg/m³ leaves no voids between grains of {} kg/m³. Give the density of the \
                 grains with their voids, or correct grain_density",
                    self.density, self.grain_density
                ),
            ));
        }
        if self.form != MuIForm::default() {
            warnings.push(Warning::new(
                "creep-at-rest",
                "form: with a viscous form the material always creeps and does not come to rest on a \
                 slope. For deposits use the form elasto-viscoplastic",
            ));
        }
        warnings
    }

    fn examples() -> Vec<Self> {
        let with = |grain_diameter, form| Self {
            density: 1500.0,
            bulk_modulus: 26e6 / 3.0,
            shear_modulus: (form == MuIForm::default()).then_some(4e6),
            grain_density: 2450.0,
            grain_diameter,
            static_friction: 0.38,
            limit_friction: 0.64,
            reference_inertial_number: 0.279,
            form,
        };
        // Boulders, which relax in a millisecond: the contract's order test resolves that. Sand, with
        // viscosities bounded at a shear rate that the contract's motions lie about.
        vec![
            with(0.4, MuIForm::ElastoViscoplastic {}),
            with(0.53e-3, MuIForm::Capped { max_viscosity: 100.0, min_shear_rate: rate_floor() }),
            with(0.53e-3, MuIForm::Smoothed { shear_rate: 300.0 }),
            with(0.53e-3, MuIForm::Papanastasiou { time: 0.003 }),
        ]
    }
}

/// Friction law μ(I).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MuI {
    /// Static friction coefficient `μ_s`.
    pub static_friction: f64,
    /// Limit friction coefficient `μ_2`.
    pub limit_friction: f64,
    /// Reference inertial number `I_0`.
    pub reference: f64,
    /// Grain diameter `d` (m).
    pub diameter: f64,
    /// Density of the grains `ρ_s` (kg/m³).
    pub grain_density: f64,
}

/// Coefficients of the quadratic `τ² - Bτ + H = 0` of the return, with `α` and `√(B² - 4H)`.
struct ReturnQuadratic {
    b: f64,
    h: f64,
    alpha: f64,
    root: f64,
}

impl MuI {
    /// Inertial number at shear rate `rate` (1/s) and `pressure` (Pa).
    #[inline]
    pub fn inertial_number(&self, rate: f64, pressure: f64) -> f64 {
        inertial_number(rate, self.diameter, pressure, self.grain_density)
    }

    /// Friction coefficient `μ(I)`.
    #[inline]
    pub fn friction(&self, inertial_number: f64) -> f64 {
        // Also valid where the inertial number is infinite.
        let share = if inertial_number > 0.0 { 1.0 / (self.reference / inertial_number + 1.0) } else { 0.0 };
        self.static_friction + (self.limit_friction - self.static_friction) * share
    }

    /// Quadratic equation of the shear stress at the end of the step, from the trial shear stress and pressure (Pa).
    #[inline]
    fn quadratic(&self, trial: f64, pressure: f64, stiffness: f64) -> ReturnQuadratic {
        let (s0, s2) = (self.static_friction * pressure, self.limit_friction * pressure);
        let alpha = self.reference / (self.diameter * self.grain_density.sqrt())
            * stiffness
            * pressure.max(0.0).sqrt();
        let (b, h) = (s2 + trial + alpha, s2 * trial + s0 * alpha);
        ReturnQuadratic { b, h, alpha, root: b * (1.0 - 4.0 * (h / b) / b).max(0.0).sqrt() }
    }

    /// Writes shear rate (1/s), effective viscosity (Pa s) and inertial number to `out`.
    fn fill_outputs(&self, rate: f64, shear: f64, pressure: f64, out: &mut [f64]) {
        out[0] = rate;
        out[1] = if rate > 0.0 { shear / rate } else { 0.0 };
        // Finite also where the pressure vanishes.
        out[2] = if pressure > 0.0 { self.inertial_number(rate, pressure) } else { 0.0 };
    }
}

/// Names of the output values: shear rate (1/s), effective viscosity (Pa s), inertial number (-).
const OUTPUTS: &[&str] = &["shear_rate", "effective_viscosity", "inertial_number"];

impl FlowOutputs for MuI {
    const NAME: &'static str = NAME;
    const OUTPUTS: &'static [&'static str] = OUTPUTS;

    fn outputs(&self, rate: f64, shear: f64, pressure: f64, out: &mut [f64]) {
        self.fill_outputs(rate, shear, pressure, out);
    }
}

impl FlowCurve for MuI {
    #[inline]
    fn strength(&self, rate: f64, pressure: f64) -> f64 {
        self.friction(self.inertial_number(rate, pressure)) * pressure.max(0.0)
    }

    #[inline]
    fn return_shear_stress(&self, trial: f64, pressure: f64, stiffness: f64) -> f64 {
        let ReturnQuadratic { b, h, root, .. } = self.quadratic(trial, pressure, stiffness);
        2.0 * h / (b + root)
    }

    fn return_derivatives(&self, trial: f64, pressure: f64, stiffness: f64) -> (f64, f64) {
        let shear = self.return_shear_stress(trial, pressure, stiffness);
        let ReturnQuadratic { alpha, root, .. } = self.quadratic(trial, pressure, stiffness);
        if !(root > 0.0 && pressure > 0.0) {
            return (0.0, self.static_friction);
        }
        let alpha_rate = 0.5 * alpha / pressure;
        let b_rate = self.limit_friction + alpha_rate;
        let h_rate = self.limit_friction * trial + self.static_friction * (alpha + pressure * alpha_rate);
        ((self.limit_friction * pressure - shear) / root, (h_rate - shear * b_rate) / root)
    }
}

/// Friction law `μ(I)` as a viscous fluid whose viscosity at rest is finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RegularisedMuI {
    /// Friction law.
    pub law: MuI,
    /// Form of the regularisation.
    pub form: MuIForm,
}

impl FlowOutputs for RegularisedMuI {
    const NAME: &'static str = NAME;
    const OUTPUTS: &'static [&'static str] = OUTPUTS;

    fn outputs(&self, rate: f64, shear: f64, pressure: f64, out: &mut [f64]) {
        self.law.fill_outputs(rate, shear, pressure, out);
    }
}

impl EffectiveViscosity for RegularisedMuI {
    #[inline]
    fn viscosity(&self, rate: f64, pressure: f64) -> f64 {
        if pressure <= 0.0 {
            return 0.0;
        }
        let law = &self.law;
        match self.form {
            MuIForm::ElastoViscoplastic {} => law.strength(rate, pressure) / rate.max(rate_floor()),
            MuIForm::Capped { max_viscosity, min_shear_rate } => {
                let rate = rate.max(min_shear_rate);
                (law.strength(rate, pressure) / rate).min(max_viscosity)
            }
            MuIForm::Smoothed { shear_rate } => law.strength(rate, pressure) / rate.hypot(shear_rate),
            MuIForm::Papanastasiou { time } => {
                let yielding = if rate > 0.0 { -(-time * rate).exp_m1() / rate } else { time };
                // (μ(I) - μ_s)/γ̇ with I = kγ̇, finite at rest.
                let k = law.inertial_number(1.0, pressure);
                let flowing = (law.limit_friction - law.static_friction) * k / (law.reference + k * rate);
                pressure * (law.static_friction * yielding + flowing)
            }
        }
    }
}
