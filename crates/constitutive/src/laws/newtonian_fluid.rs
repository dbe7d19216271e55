//! Weakly compressible Newtonian fluid (constitutive sheet §2.10; Anura3D manual eqs. 7.29–7.36).
//!
//! `σ = -p 1 + 2 μ dev D`, pressure from density: linear `p = c² (ρ - ρ₀)` with `c² = K/ρ₀`, or
//! Tait's `p = ρ₀ c²/7 [(ρ/ρ₀)⁷ - 1]`. Where pressure would fall below minus the cavitation
//! strength it stays there, and the fluid carries no shear. Limit: explicit viscosity bounds the step.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::model::{Facts, Kind, Model, not_negative, positive};
use crate::{InitialCondition, Material, MaterialError, Motion, Point, StressUpdate, SymTensor};

const NAME: &str = "newtonian-fluid";

/// Exponent of Tait's equation for water.
const TAIT: f64 = 7.0;

/// Pressure as a function of density.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum EquationOfState {
    /// `p = c² (ρ - ρ₀)`.
    #[default]
    Linear,
    /// `p = ρ₀ c²/7 [(ρ/ρ₀)⁷ - 1]`.
    Tait,
}

/// Parameters of `newtonian-fluid`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NewtonianFluidSpec {
    /// Density at zero pressure (kg/m³), > 0.
    pub density: f64,
    /// Bulk modulus at zero pressure (Pa), > 0.
    pub bulk_modulus: f64,
    /// Dynamic viscosity (Pa s), not negative.
    #[serde(default)]
    pub viscosity: f64,
    /// Largest tension before the fluid cavitates (Pa), not negative.
    #[serde(default)]
    pub cavitation_strength: f64,
    /// Equation of state.
    #[serde(default)]
    pub equation_of_state: EquationOfState,
}

impl NewtonianFluidSpec {
    /// Checks the ranges and builds the law.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn law(&self) -> Result<NewtonianFluid, MaterialError> {
        positive("density", self.density, "kg/m³")?;
        positive("bulk_modulus", self.bulk_modulus, "Pa")?;
        not_negative("viscosity", self.viscosity, "Pa s")?;
        not_negative("cavitation_strength", self.cavitation_strength, "Pa")?;
        Ok(NewtonianFluid { spec: self.clone() })
    }
}

impl Model for NewtonianFluidSpec {
    const FACTS: Facts = Facts {
        source: "Anura3D manual 2021, eqs. 7.29–7.36; Cole 1948 (Tait)",
        kind: Kind::Fluid,
        strain: "rate",
        tangent: "numerical",
    };

    fn density(&self) -> f64 {
        self.density
    }

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        Ok(Arc::new(self.law()?))
    }

    fn examples() -> Vec<Self> {
        let with = |equation_of_state| Self {
            density: 2000.0,
            bulk_modulus: 2e7,
            viscosity: 100.0,
            cavitation_strength: 1e4,
            equation_of_state,
        };
        [EquationOfState::Linear, EquationOfState::Tait].map(with).into()
    }
}

/// The law. See the module's head for source and limits.
#[derive(Clone, Debug, PartialEq)]
pub struct NewtonianFluid {
    spec: NewtonianFluidSpec,
}

/// Density at which a point has no pressure (kg/m³): points that start under pressure are denser.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FluidState {
    /// Density at zero pressure.
    pub rest_density: f64,
    /// Density now.
    pub density: f64,
}

impl NewtonianFluid {
    /// Pressure (Pa, compression-positive) of the density ratio `ρ/ρ₀`, without cavitation.
    #[inline]
    pub fn pressure(&self, ratio: f64) -> f64 {
        let modulus = self.spec.bulk_modulus;
        match self.spec.equation_of_state {
            EquationOfState::Linear => modulus * (ratio - 1.0),
            EquationOfState::Tait => modulus / TAIT * (ratio.powi(TAIT as i32) - 1.0),
        }
    }

    fn ratio_of(&self, pressure: f64) -> f64 {
        let share = pressure / self.spec.bulk_modulus;
        match self.spec.equation_of_state {
            EquationOfState::Linear => 1.0 + share,
            EquationOfState::Tait => (1.0 + TAIT * share).powf(1.0 / TAIT),
        }
    }
}

impl StressUpdate for NewtonianFluid {
    type State = FluidState;

    fn name(&self) -> &'static str {
        NAME
    }

    fn initial(&self, initial: &InitialCondition) -> Result<Point<FluidState>, MaterialError> {
        let pressure = initial.stress.pressure();
        let shear = initial.stress.deviator().norm();
        let fail = |reason: &str| MaterialError::Initial { model: NAME, reason: reason.to_owned() };
        if shear > 1e-9 * pressure.abs() {
            return Err(fail("a fluid at rest carries no shear stress"));
        }
        let ratio = self.ratio_of(pressure);
        if pressure < -self.spec.cavitation_strength || !(ratio > 0.0) {
            return Err(fail("the initial tension is above the cavitation strength"));
        }
        let state = FluidState { rest_density: initial.density / ratio, density: initial.density };
        Ok(Point { stress: SymTensor::isotropic(-pressure), state })
    }

    #[inline]
    fn update(&self, motion: &Motion, old: &Point<FluidState>) -> Result<Point<FluidState>, MaterialError> {
        let invalid = |reason| MaterialError::Motion { model: NAME, reason };
        if !(motion.density > 0.0 && motion.dt > 0.0) {
            return Err(invalid("density and time step must be positive"));
        }
        let state = FluidState { density: motion.density, ..old.state };
        let pressure = self.pressure(motion.density / state.rest_density);
        if pressure < -self.spec.cavitation_strength {
            return Ok(Point { stress: SymTensor::isotropic(self.spec.cavitation_strength), state });
        }
        let rate = motion.strain_increment().deviator() * (1.0 / motion.dt);
        let stress = rate * (2.0 * self.spec.viscosity) + SymTensor::isotropic(-pressure);
        if !stress.is_finite() {
            return Err(invalid("the stress is not finite"));
        }
        Ok(Point { stress, state })
    }

    fn wave_modulus(&self, point: &Point<FluidState>) -> f64 {
        // ρ dp/dρ
        let ratio = point.state.density / point.state.rest_density;
        match self.spec.equation_of_state {
            EquationOfState::Linear => self.spec.bulk_modulus * ratio,
            EquationOfState::Tait => self.spec.bulk_modulus * ratio.powi(TAIT as i32),
        }
    }

    fn viscosity(&self, _point: &Point<FluidState>) -> f64 {
        self.spec.viscosity
    }

    fn stored_energy(&self, point: &Point<FluidState>) -> Option<f64> {
        // ρ ∫ p dρ/ρ² from the rest density.
        let ratio = point.state.density / point.state.rest_density;
        let modulus = self.spec.bulk_modulus;
        Some(match self.spec.equation_of_state {
            EquationOfState::Linear => modulus * (ratio * ratio.ln() - ratio + 1.0),
            EquationOfState::Tait => {
                modulus / TAIT * ((ratio.powi(TAIT as i32) - ratio) / (TAIT - 1.0) + 1.0 - ratio)
            }
        })
    }
}
