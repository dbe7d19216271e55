//! Equation of state: pressure from density (sheet: constitutive §2.10, eq. 2.13; Cole 1948 for Tait's form).
//!
//! `p = K (r - 1)` or `p = K/7 (r⁷ - 1)`, with `r = ρ/ρ₀` the density over that at zero pressure and
//! `K = ρ₀ c₀²`. Where pressure would fall below minus the tensile strength, the material opens: pressure
//! remains there, shear vanishes, and it closes again only when the density is recovered.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{InitialCondition, MaterialError, Motion};

/// Exponent of Tait's equation for water.
const TAIT: f64 = 7.0;

/// Pressure–density relation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum EquationOfState {
    /// Linear equation `p = c² (ρ - ρ₀)`.
    #[default]
    Linear,
    /// Tait's equation `p = ρ₀ c²/7 [(ρ/ρ₀)⁷ - 1]`.
    Tait,
}

/// State of a material whose pressure follows from density. Points under initial pressure are denser
/// than at rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FluidState {
    /// Density at zero pressure (kg/m³).
    pub rest_density: f64,
    /// Current density (kg/m³).
    pub density: f64,
    /// Shear rate `√(2 D':D')` of the last step (1/s); only its plastic part for a law with elastic shear.
    pub shear_rate: f64,
}

impl FluidState {
    /// Ratio of density to density at zero pressure.
    #[inline]
    pub fn ratio(&self) -> f64 {
        self.density / self.rest_density
    }
}

/// Equation of state with its constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Barotropic {
    /// Bulk modulus at zero pressure, `ρ₀ c₀²` (Pa).
    pub bulk_modulus: f64,
    /// Largest tension before the material opens (Pa), not negative.
    pub tension: f64,
    /// Form of the equation.
    pub equation: EquationOfState,
}

impl Barotropic {
    /// Pressure (Pa, compression-positive) at density ratio `ratio` without a limit to tension.
    #[inline]
    pub fn unlimited_pressure(&self, ratio: f64) -> f64 {
        match self.equation {
            EquationOfState::Linear => self.bulk_modulus * (ratio - 1.0),
            EquationOfState::Tait => self.bulk_modulus / TAIT * (ratio.powi(TAIT as i32) - 1.0),
        }
    }

    /// Pressure (Pa, compression-positive) at density ratio `ratio`; `None` where the material has opened.
    #[inline]
    pub fn pressure(&self, ratio: f64) -> Option<f64> {
        let pressure = self.unlimited_pressure(ratio);
        (pressure >= -self.tension).then_some(pressure)
    }

    /// Density ratio at `pressure` (Pa); NaN if no density has this pressure.
    pub fn ratio_of(&self, pressure: f64) -> f64 {
        let share = pressure / self.bulk_modulus;
        match self.equation {
            EquationOfState::Linear => 1.0 + share,
            EquationOfState::Tait => (1.0 + TAIT * share).powf(1.0 / TAIT),
        }
    }

    /// Bulk modulus `ρ dp/dρ` (Pa) at density ratio `ratio`.
    #[inline]
    pub fn modulus(&self, ratio: f64) -> f64 {
        match self.equation {
            EquationOfState::Linear => self.bulk_modulus * ratio,
            EquationOfState::Tait => self.bulk_modulus * ratio.powi(TAIT as i32),
        }
    }

    /// Energy `ρ ∫ p dρ/ρ²` from zero pressure, per unit current volume (J/m³).
    pub fn energy(&self, ratio: f64) -> f64 {
        let open = self.ratio_of(-self.tension);
        if ratio < open {
            return ratio / open * self.energy(open) + self.tension * (1.0 - ratio / open);
        }
        match self.equation {
            EquationOfState::Linear => self.bulk_modulus * (ratio * ratio.ln() - ratio + 1.0),
            EquationOfState::Tait => {
                self.bulk_modulus / TAIT * ((ratio.powi(TAIT as i32) - ratio) / (TAIT - 1.0) + 1.0 - ratio)
            }
        }
    }

    /// State of a point that starts from `initial`.
    pub(super) fn initial(
        &self,
        model: &'static str,
        initial: &InitialCondition,
    ) -> Result<FluidState, MaterialError> {
        let fail = |reason: &str| MaterialError::Initial { model, reason: reason.to_owned() };
        let pressure = initial.stress.pressure();
        let ratio = self.ratio_of(pressure);
        // The tolerance is round-off of a mean stress of three components.
        if !(ratio > 0.0 && pressure >= -self.tension - 1e-12 * initial.stress.norm()) {
            return Err(fail("the initial tension is above the tensile strength of the material"));
        }
        if !(initial.density > 0.0 && initial.density.is_finite()) {
            return Err(fail("the density must be positive"));
        }
        let density = initial.density;
        Ok(FluidState { rest_density: density / ratio, density, shear_rate: 0.0 })
    }

    /// State at the end of a step, without the shear rate. The density changes by less than a factor of two (sheet: constitutive §7).
    #[inline]
    pub(super) fn step(
        &self,
        model: &'static str,
        motion: &Motion,
        old: &FluidState,
    ) -> Result<FluidState, MaterialError> {
        if !(motion.density > 0.0 && motion.dt > 0.0) {
            return Err(MaterialError::Motion { model, reason: "density and time step must be positive" });
        }
        if !(0.5..=2.0).contains(&(motion.density / old.density)) {
            return Err(MaterialError::Motion {
                model,
                reason: "the step changes density by more than half",
            });
        }
        Ok(FluidState { density: motion.density, shear_rate: 0.0, ..*old })
    }
}
