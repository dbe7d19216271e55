//! Original Cam-clay (sheet: constitutive §2.6; Anura3D manual eqs. 7.14–7.17; Schofield & Wroth 1968).
//!
//! `F = η - M ln(p_c/p) ≤ 0` with `η = q/p`, associated: plastic dilatancy `dε_v/dε_q = M - η` from Taylor's
//! work equation, so that the step dissipates `M p dε_q`. Hardening and elasticity are those of
//! [`super::cam_clay`]. With `L = ln(p_c/p)` the yield condition at the end of a step of plastic shear `Δ`
//! reads `L = (L_tr + a)/(1 + a)`, `a = (θ + χ) M Δ`, which leaves one falling function of `Δ`.
//! The tip `(p_c, 0)` of the bullet is a corner: trials between its two limiting normals return to it.
//! Limits: as modified Cam-clay; the surface extends into tension where `η > 3`.

use std::borrow::Cow;
use std::sync::Arc;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize};

use super::cam_clay::{CamClayConstants, CamClaySpec, CamClayState, CamClayTrial, OUTPUTS};
use crate::Warning;
use crate::laws::model::{Model, ModelFamily, ModelInfo};
use crate::return_maps::scalar_roots::{drop_round_off, falling_root};
use crate::return_maps::substepping::SubstepResult;
use crate::{
    Corotational, InitialCondition, Law, Material, MaterialError, Motion, Point, PointLaw, SmallStrain,
    SymTensor, Tangent,
};

/// Value of the key `model` in case files.
const NAME: &str = "original-cam-clay";

/// Round-off tolerance of a stress on the yield surface, relative to the terms of the yield function.
const ON_SURFACE: f64 = 64.0 * f64::EPSILON;

/// Parameters of `original-cam-clay`, which are those of `modified-cam-clay`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct OriginalCamClaySpec(pub CamClaySpec);

impl OriginalCamClaySpec {
    /// Parameters from density (kg/m³), critical state slope (-), compression slope (-), swelling slope (-) and void ratio (-); all
    /// others have the defaults of a case file.
    #[must_use]
    pub fn new(
        density: f64,
        critical_state_slope: f64,
        compression_slope: f64,
        swelling_slope: f64,
        void_ratio: f64,
    ) -> Self {
        Self(CamClaySpec::new(density, critical_state_slope, compression_slope, swelling_slope, void_ratio))
    }
}

/// Schema with the keys themselves in place of a reference to those of the other model.
impl JsonSchema for OriginalCamClaySpec {
    fn schema_name() -> Cow<'static, str> {
        "OriginalCamClaySpec".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        CamClaySpec::json_schema(generator)
    }
}

impl OriginalCamClaySpec {
    /// Checks the ranges and builds the law.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn law(&self) -> Result<OriginalCamClay, MaterialError> {
        Ok(OriginalCamClay { constants: self.0.constants()? })
    }
}

impl Model for OriginalCamClaySpec {
    const INFO: ModelInfo = ModelInfo {
        source: "Schofield & Wroth 1968; Anura3D manual 2021, eqs. 7.14–7.17",
        kind: ModelFamily::Solid,
        strain: "rate",
        tangent: "analytic",
    };

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        Ok(Arc::new(Corotational(self.law()?)))
    }

    fn warnings(&self) -> Vec<Warning> {
        self.0.stiffness_warnings()
    }

    fn examples() -> Vec<Self> {
        CamClaySpec::samples().into_iter().map(Self).collect()
    }
}

/// Original Cam-clay law. See the module's head for source and limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OriginalCamClay {
    constants: CamClayConstants,
}

/// Result of the return of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
enum OriginalCamClayReturn {
    Elastic,
    /// Return to the smooth surface: pressure (Pa), `ln(p_c/p)` and plastic shear `Δε_q`.
    Surface {
        pressure: f64,
        size_ratio: f64,
        shear: f64,
    },
    /// Return to the tip: pressure `p = p_c` (Pa) and plastic shear, all of the trial's.
    Tip {
        pressure: f64,
        shear: f64,
    },
}

impl OriginalCamClay {
    /// Deviatoric stress (Pa) on the yield surface at a pressure (Pa): `M p ln(p_c/p)`.
    #[inline]
    pub fn strength(&self, pressure: f64, preconsolidation_pressure: f64) -> f64 {
        self.constants.critical * pressure * (preconsolidation_pressure / pressure).ln()
    }

    /// Return of an elastic trial to the yield surface with preconsolidation pressure `size` (Pa).
    fn return_map(&self, trial: &CamClayTrial, size: f64) -> Result<OriginalCamClayReturn, MaterialError> {
        let m = self.constants.critical;
        let (p_tr, q_tr) = (trial.pressure, trial.q);
        let ratio = (size / p_tr).ln();
        let excess = q_tr - m * p_tr * ratio;
        if excess <= ON_SURFACE * (q_tr + m * p_tr * ratio.abs().max(1.0)) {
            return Ok(OriginalCamClayReturn::Elastic);
        }
        if !excess.is_finite() {
            return Err(MaterialError::Motion { model: NAME, reason: "the trial stress is not finite" });
        }
        let stiffness = trial.theta + trial.chi;
        let largest = q_tr / (3.0 * trial.shear);
        // All of the trial's deviator becomes plastic inside the cone of the two limiting normals.
        if ratio + stiffness * m * largest <= 0.0 {
            let pressure = p_tr * (trial.theta / stiffness * ratio).exp();
            return Ok(OriginalCamClayReturn::Tip { pressure, shear: largest });
        }
        let at = |shear: f64| {
            let a = stiffness * m * shear;
            let gained = a * (1.0 - ratio) / (1.0 + a);
            let pressure = p_tr * (-trial.theta / stiffness * gained).exp();
            (pressure, ratio + gained, a)
        };
        let root = falling_root(0.0, largest, 0.0, |shear| {
            let (p, l, a) = at(shear);
            let l_slope = stiffness * m * (1.0 - ratio) / (1.0 + a).powi(2);
            let strength = m * l * p;
            let slope = m * p * l_slope * (1.0 - l * trial.theta / stiffness);
            let value = drop_round_off(q_tr - 3.0 * trial.shear * shear - strength, q_tr + strength.abs());
            (value, -3.0 * trial.shear - slope)
        });
        let shear = root.ok_or(MaterialError::NotConverged { model: NAME, reason: "yield condition" })?;
        let (pressure, size_ratio, _) = at(shear);
        Ok(OriginalCamClayReturn::Surface { pressure, size_ratio, shear })
    }

    /// Stress, state and dissipated work after a sub-step.
    fn step(
        &self,
        strain: &SymTensor,
        old: &Point<CamClayState>,
    ) -> Result<SubstepResult<CamClayState>, MaterialError> {
        let trial = self.constants.trial(strain, old);
        let mut advance = self.constants.elastic(&trial, strain, old);
        let (pressure, q, shear, p_c) = match self.return_map(&trial, old.state.preconsolidation_pressure)? {
            OriginalCamClayReturn::Elastic => return Ok(advance),
            OriginalCamClayReturn::Tip { pressure, shear } => (pressure, 0.0, shear, pressure),
            OriginalCamClayReturn::Surface { pressure, size_ratio, shear } => {
                let q = (self.constants.critical * pressure * size_ratio).max(0.0);
                (pressure, q, shear, pressure * size_ratio.exp())
            }
        };
        let state = &mut advance.point.state;
        // Plastic volume compression, from the hardening.
        let volume = (p_c / state.preconsolidation_pressure).ln() / trial.chi;
        state.preconsolidation_pressure = p_c;
        state.plastic_strain += shear;
        advance.dissipated_work = pressure * volume + q * shear;
        advance.point.stress = trial.radial.stress(pressure, if q > 0.0 { q / trial.q } else { 0.0 });
        Ok(advance)
    }

    /// Consistent tangent, by the implicit-function theorem on
    /// `q_tr - 3 G Δ - M L p` with `L` and `p` as functions of `Δ` and the trial.
    fn step_tangent(&self, strain: &SymTensor, old: &Point<CamClayState>) -> Option<Tangent> {
        let trial = self.constants.trial(strain, old);
        let m = self.constants.critical;
        let unit = SymTensor::IDENTITY;
        let stiffness = trial.theta + trial.chi;
        // d ln p_tr/dΔ, and L_tr falls by as much.
        let log_slope = trial.pressure_slope / trial.pressure;
        match self.return_map(&trial, old.state.preconsolidation_pressure).ok()? {
            OriginalCamClayReturn::Elastic => {
                Some(trial.radial.tangent(1.0, &(unit * -trial.pressure_slope), &SymTensor::ZERO))
            }
            OriginalCamClayReturn::Tip { pressure, .. } => {
                let slope = pressure * log_slope * trial.chi / stiffness;
                Some(trial.radial.tangent(0.0, &(unit * -slope), &SymTensor::ZERO))
            }
            OriginalCamClayReturn::Surface { pressure: p, size_ratio: l, shear } => {
                let ratio = (old.state.preconsolidation_pressure / trial.pressure).ln();
                let a = stiffness * m * shear;
                let share = trial.theta / stiffness;
                // Slopes of L and ln p with the plastic shear and with the volume compression.
                let l_by_shear = stiffness * m * (1.0 - ratio) / (1.0 + a).powi(2);
                let p_by_shear = -share * l_by_shear;
                let l_by_volume = -log_slope / (1.0 + a);
                let p_by_volume = log_slope - share * (l_by_volume + log_slope);
                let strength = |l_slope: f64, p_slope: f64| m * p * (l_slope + l * p_slope);
                let stiff = 3.0 * trial.shear + strength(l_by_shear, p_by_shear);
                let by_volume =
                    (-3.0 * trial.shear_slope * shear - strength(l_by_volume, p_by_volume)) / stiff;
                let q_tr_slope = trial.radial.slope(&(trial.radial.deviator * (1.5 / trial.q)));
                let shear_slope = unit * -by_volume + q_tr_slope * (1.0 / stiff);
                let p_slope = (shear_slope * p_by_shear + unit * -p_by_volume) * p;
                let q = m * l * p;
                let q_slope = shear_slope * strength(l_by_shear, p_by_shear)
                    + unit * -strength(l_by_volume, p_by_volume);
                let keep_slope = q_slope * (1.0 / trial.q) + q_tr_slope * (-q / (trial.q * trial.q));
                Some(trial.radial.tangent(q / trial.q, &p_slope, &keep_slope))
            }
        }
    }
}

impl Law for OriginalCamClay {
    fn name(&self) -> &'static str {
        NAME
    }

    fn output_names(&self) -> &[&'static str] {
        OUTPUTS
    }
}

impl PointLaw for OriginalCamClay {
    type State = CamClayState;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<CamClayState>, MaterialError> {
        let m = self.constants.critical;
        self.constants.initial(NAME, &initial.stress, |p, q| p * (q / (m * p)).exp())
    }

    fn wave_modulus(&self, point: &Point<CamClayState>) -> f64 {
        self.constants.wave_modulus(point)
    }

    /// Yield function `F p` (Pa), scaled to a stress.
    fn yield_value(&self, point: &Point<CamClayState>) -> Option<f64> {
        let size = point.state.preconsolidation_pressure;
        Some(point.stress.q() - self.strength(point.stress.pressure(), size))
    }

    fn outputs(&self, point: &Point<CamClayState>, out: &mut [f64]) {
        point.state.outputs(out);
    }
}

impl SmallStrain for OriginalCamClay {
    fn update(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<CamClayState>,
    ) -> Result<Point<CamClayState>, MaterialError> {
        self.step(strain, old).map(|advance| advance.point)
    }

    fn tangent(&self, strain: &SymTensor, _motion: &Motion, old: &Point<CamClayState>) -> Option<Tangent> {
        self.step_tangent(strain, old)
    }

    fn dissipation(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<CamClayState>,
        _new: &Point<CamClayState>,
    ) -> Option<f64> {
        self.step(strain, old).ok().map(|advance| advance.dissipated_work)
    }
}
