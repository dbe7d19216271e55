//! Modified Cam-clay (constitutive sheet §2.6, §3.7.5; Roscoe & Burland 1968).
//!
//! `f = q²/M² + p (p - p_c) ≤ 0`, associated; `ṗ_c = v/(λ-κ) p_c ε̇ᵖ_v`, `K = v p/κ`, with `p` and the
//! plastic volume compression compression-positive and `v = 1 + e`. The shear modulus follows `K` at
//! constant Poisson's ratio, or is given. The return is implicit in `p`, `p_c` and the multiplier with
//! `v` frozen over the step: for a multiplier the volume part has one root, so that one falling
//! function of the multiplier remains. Steps above 1 % strain are divided. Limits: no tension, pressure does
//! not fall below 1 Pa; no elastic energy exists at constant Poisson's ratio.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::linear_elastic::stiff_warnings;
use super::pressure_elastic::{
    LEAST_PRESSURE, VolumeStep, check_poissons_ratio, shear_ratio, void_ratio_after,
};
use super::radial::RadialTrial;
use super::root::{falling_root, less_round_off};
use super::substep::Advance;
use crate::model::{Facts, Kind, Model, check, positive};
use crate::{
    Corotational, InitialCondition, Mat3, Material, MaterialError, Motion, Point, SmallStrain, SymTensor,
    Tangent,
};

const NAME: &str = "modified-cam-clay";

/// Round-off of a stress that lies on the yield surface, relative to the terms of the yield function.
const ON_SURFACE: f64 = 64.0 * f64::EPSILON;

/// Parameters of `modified-cam-clay` and `original-cam-clay`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CamClaySpec {
    /// Density (kg/m³), > 0.
    pub density: f64,
    /// Slope `M` of the critical state line, `q/p`, > 0.
    pub critical_state_slope: f64,
    /// Slope `λ` of the normal compression line in the plane of specific volume and ln p, above `κ`.
    pub compression_slope: f64,
    /// Slope `κ` of unloading and reloading in the same plane, > 0.
    pub swelling_slope: f64,
    /// Poisson's ratio, between -1 and 0.5; this or `shear_modulus`.
    #[serde(default)]
    pub poissons_ratio: Option<f64>,
    /// Constant shear modulus (Pa), > 0; this or `poissons_ratio`.
    #[serde(default)]
    pub shear_modulus: Option<f64>,
    /// Initial void ratio, > 0.
    pub void_ratio: f64,
    /// Pressure `p_c` at the tip of the initial yield surface (Pa), > 0; this or `overconsolidation_ratio`.
    #[serde(default)]
    pub preconsolidation_pressure: Option<f64>,
    /// `p_c` over that of the surface through the initial stress, at least 1; this or
    /// `preconsolidation_pressure`.
    #[serde(default)]
    pub overconsolidation_ratio: Option<f64>,
    /// Start on the yield surface where the initial stress lies outside it: pressure at most `p_c`, and then as
    /// much of the deviator as there is room for; refused when false.
    #[serde(default)]
    pub project: bool,
}

/// Parameters that both Cam-clays share, checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CamClayConstants {
    /// Slope `M` of the critical state line.
    pub critical: f64,
    /// Slope `λ` of normal compression.
    pub compression: f64,
    /// Slope `κ` of unloading.
    pub swelling: f64,
    /// Shear stiffness.
    shear: Shear,
    /// Initial void ratio.
    void_ratio: f64,
    /// Size of the initial surface.
    size: Size,
    /// Whether an initial stress outside is moved to the surface.
    project: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Shear {
    /// `G/K`.
    Ratio(f64),
    /// `G` (Pa).
    Modulus(f64),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Size {
    /// `p_c` (Pa).
    Pressure(f64),
    /// `p_c` over that of the surface through the initial stress.
    Ratio(f64),
}

impl CamClaySpec {
    /// Checks the ranges and builds the law.
    ///
    /// # Errors
    /// The first parameter out of range.
    pub fn law(&self) -> Result<CamClay, MaterialError> {
        Ok(CamClay { constants: self.constants()? })
    }

    /// Checks the ranges.
    pub(super) fn constants(&self) -> Result<CamClayConstants, MaterialError> {
        positive("critical_state_slope", self.critical_state_slope, "")?;
        positive("swelling_slope", self.swelling_slope, "")?;
        let (lambda, kappa) = (self.compression_slope, self.swelling_slope);
        let rule = format!("must be above swelling_slope, {kappa}");
        check("compression_slope", lambda, lambda.is_finite() && lambda > kappa, &rule)?;
        let shear = match (self.poissons_ratio, self.shear_modulus) {
            (Some(ratio), None) => {
                check_poissons_ratio(ratio)?;
                Shear::Ratio(shear_ratio(ratio))
            }
            (None, Some(modulus)) => {
                positive("shear_modulus", modulus, "Pa")?;
                Shear::Modulus(modulus)
            }
            (ratio, _) => return Err(one_of("poissons_ratio", ratio, "shear_modulus")),
        };
        positive("void_ratio", self.void_ratio, "")?;
        let size = match (self.preconsolidation_pressure, self.overconsolidation_ratio) {
            (Some(pressure), None) => {
                positive("preconsolidation_pressure", pressure, "Pa")?;
                Size::Pressure(pressure)
            }
            (None, Some(ratio)) => {
                let rule = "must be at least 1";
                check("overconsolidation_ratio", ratio, ratio.is_finite() && ratio >= 1.0, rule)?;
                Size::Ratio(ratio)
            }
            (pressure, _) => {
                return Err(one_of("preconsolidation_pressure", pressure, "overconsolidation_ratio"));
            }
        };
        Ok(CamClayConstants {
            critical: self.critical_state_slope,
            compression: lambda,
            swelling: kappa,
            shear,
            void_ratio: self.void_ratio,
            size,
            project: self.project,
        })
    }

    /// Warnings on the shear stiffness.
    pub(super) fn stiffness_warnings(&self) -> Vec<String> {
        self.poissons_ratio.map(stiff_warnings).unwrap_or_default()
    }

    /// Samples: over-consolidated, normally consolidated, and with constant shear modulus.
    pub(super) fn samples() -> Vec<Self> {
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
            project: false,
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

fn one_of(field: &'static str, given: Option<f64>, other: &str) -> MaterialError {
    let rule = match given {
        Some(_) => format!("and {other} exclude each other: give one"),
        None => format!("or {other} must be given"),
    };
    match given {
        Some(value) => MaterialError::parameter(field, value, rule),
        None => MaterialError::choice(field, rule),
    }
}

impl Model for CamClaySpec {
    const FACTS: Facts = Facts {
        source: "Roscoe & Burland 1968; implicit return",
        kind: Kind::Solid,
        strain: "rate",
        tangent: "analytic",
    };

    fn density(&self) -> f64 {
        self.density
    }

    fn build(&self) -> Result<Arc<dyn Material>, MaterialError> {
        Ok(Arc::new(Corotational(self.law()?)))
    }

    fn warnings(&self) -> Vec<String> {
        self.stiffness_warnings()
    }

    fn examples() -> Vec<Self> {
        Self::samples()
    }
}

/// State of the Cam-clays.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CamClayState {
    /// Pressure `p_c` at the tip of the yield surface (Pa).
    pub preconsolidation_pressure: f64,
    /// Volume of voids over volume of grains.
    pub void_ratio: f64,
    /// Accumulated deviatoric plastic strain.
    pub plastic_strain: f64,
}

/// Elastic trial of a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct CamClayTrial {
    /// `θ = v/κ`.
    pub theta: f64,
    /// `χ = v/(λ-κ)`.
    pub chi: f64,
    /// Trial pressure (Pa).
    pub pressure: f64,
    /// `dp_tr/dΔ` (Pa).
    pub pressure_slope: f64,
    /// Shear modulus of the step (Pa).
    pub shear: f64,
    /// `dG/dΔ` (Pa).
    pub shear_slope: f64,
    /// Trial deviator.
    pub radial: RadialTrial,
    /// `q` of the trial (Pa).
    pub q: f64,
}

impl CamClayConstants {
    /// State at the start; `size` gives `p_c` of the surface through a stress.
    pub(super) fn initial(
        &self,
        model: &'static str,
        stress: &SymTensor,
        size: impl Fn(f64, f64) -> f64,
    ) -> Result<Point<CamClayState>, MaterialError> {
        super::check_compressive(model, stress)?;
        let through = size(stress.pressure(), stress.q());
        let preconsolidation_pressure = match self.size {
            Size::Pressure(pressure) => pressure,
            Size::Ratio(ratio) => ratio * through,
        };
        let state =
            CamClayState { preconsolidation_pressure, void_ratio: self.void_ratio, plastic_strain: 0.0 };
        let excess = through - preconsolidation_pressure;
        if self.project && excess > 0.0 {
            let pressure = stress.pressure().min(preconsolidation_pressure);
            let (q, deviator) = (stress.q(), stress.deviator());
            let (mut inside, mut outside) = (0.0, 1.0);
            while outside - inside > f64::EPSILON {
                let share = 0.5 * (inside + outside);
                let fits = size(pressure, share * q) <= preconsolidation_pressure;
                if fits { inside = share } else { outside = share }
            }
            return Ok(Point { stress: deviator * inside - SymTensor::isotropic(pressure), state });
        }
        super::check_initial(model, stress, excess, preconsolidation_pressure)?;
        Ok(Point { stress: *stress, state })
    }

    /// Elastic trial: `p_tr = p exp(θ Δ)` and the deviator with the secant shear modulus.
    pub(super) fn trial(&self, strain: &SymTensor, old: &Point<CamClayState>) -> CamClayTrial {
        let v = 1.0 + old.state.void_ratio;
        let (theta, chi) = (v / self.swelling, v / (self.compression - self.swelling));
        let p = old.stress.pressure();
        let compression = -strain.trace();
        let modulus = theta * p;
        let growth = (theta * compression).exp_m1();
        let floor = p.min(LEAST_PRESSURE);
        let mut volume =
            VolumeStep::new(p, compression, growth, modulus, modulus * (1.0 + growth), theta * modulus);
        if volume.pressure < floor {
            let secant = (floor - p) / compression;
            volume =
                VolumeStep { pressure: floor, tangent: 0.0, secant, secant_slope: -secant / compression };
        }
        // The shear modulus keeps the value of the least pressure below it.
        let least = theta * LEAST_PRESSURE;
        let (shear, shear_slope) = match self.shear {
            Shear::Modulus(modulus) => (modulus, 0.0),
            Shear::Ratio(ratio) if volume.secant < least => (ratio * least, 0.0),
            Shear::Ratio(ratio) => (ratio * volume.secant, ratio * volume.secant_slope),
        };
        let radial = RadialTrial::new(&old.stress, strain, shear, shear_slope);
        let (pressure, pressure_slope) = (volume.pressure, volume.tangent);
        CamClayTrial { theta, chi, pressure, pressure_slope, shear, shear_slope, radial, q: radial.q() }
    }

    /// The point after an elastic step.
    pub(super) fn elastic(
        &self,
        trial: &CamClayTrial,
        strain: &SymTensor,
        old: &Point<CamClayState>,
    ) -> Advance<CamClayState> {
        let state =
            CamClayState { void_ratio: void_ratio_after(old.state.void_ratio, strain.trace()), ..old.state };
        Advance { point: Point { stress: trial.radial.stress(trial.pressure, 1.0), state }, dissipated: 0.0 }
    }

    /// See [`SmallStrain::wave_modulus`].
    pub(super) fn wave_modulus(&self, point: &Point<CamClayState>) -> f64 {
        let p = point.stress.pressure().max(LEAST_PRESSURE);
        let bulk = (1.0 + point.state.void_ratio) * p / self.swelling;
        let shear = match self.shear {
            Shear::Ratio(ratio) => ratio * bulk,
            Shear::Modulus(modulus) => modulus,
        };
        1.1 * (bulk + 4.0 / 3.0 * shear)
    }
}

/// Names of the scalars of the Cam-clays.
pub(super) const OUTPUTS: &[&str] = &["void_ratio", "preconsolidation_pressure", "plastic_strain"];

impl CamClayState {
    pub(super) fn outputs(&self, out: &mut [f64]) {
        out.copy_from_slice(&[self.void_ratio, self.preconsolidation_pressure, self.plastic_strain]);
    }
}

/// The law. See the module's head for source and limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CamClay {
    constants: CamClayConstants,
}

/// Where the return of a step ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CamClayReturn {
    /// Pressure (Pa).
    pub pressure: f64,
    /// Deviatoric stress (Pa).
    pub q: f64,
    /// Pressure at the tip of the yield surface (Pa).
    pub preconsolidation_pressure: f64,
    /// Plastic multiplier `Δλ` (1/Pa).
    pub multiplier: f64,
}

impl CamClay {
    /// `q²/M² + p (p - p_c)` (Pa²).
    #[inline]
    pub fn yield_function(&self, pressure: f64, q: f64, preconsolidation_pressure: f64) -> f64 {
        (q / self.constants.critical).powi(2) + pressure * (pressure - preconsolidation_pressure)
    }

    /// The plastic volume compression that goes with a multiplier: root of
    /// `x = Δλ (2p - p_c)`, `p = p_tr exp(-θ x)`, `p_c = p_cn exp(χ x)`. Returns it with `p` and `p_c`.
    fn volume_part(trial: &CamClayTrial, size: f64, multiplier: f64, start: f64) -> Option<[f64; 3]> {
        let at = |x: f64| (trial.pressure * (-trial.theta * x).exp(), size * (trial.chi * x).exp());
        let end = multiplier * (2.0 * trial.pressure - size);
        let (low, high) = (end.min(0.0), end.max(0.0));
        let x = if end == 0.0 {
            0.0
        } else {
            falling_root(low, high, start, |x| {
                let (p, p_c) = at(x);
                (
                    less_round_off(multiplier * (2.0 * p - p_c) - x, multiplier * (2.0 * p + p_c)),
                    -multiplier * (2.0 * trial.theta * p + trial.chi * p_c) - 1.0,
                )
            })?
        };
        let (p, p_c) = at(x);
        Some([x, p, p_c])
    }

    /// The return of a trial; `None` where the trial is elastic.
    fn return_map(&self, trial: &CamClayTrial, size: f64) -> Result<Option<CamClayReturn>, MaterialError> {
        let m2 = self.constants.critical.powi(2);
        let (p_tr, q_tr) = (trial.pressure, trial.q);
        let excess = self.yield_function(p_tr, q_tr, size);
        let scale = q_tr * q_tr / m2 + p_tr * (p_tr + size);
        if excess <= ON_SURFACE * scale {
            return Ok(None);
        }
        if !excess.is_finite() {
            return Err(MaterialError::Motion { model: NAME, reason: "the trial stress is not finite" });
        }
        let failed = MaterialError::NotConverged { model: NAME, reason: "yield condition" };
        // Unknown a = 6 G Δλ/M², so that q = q_tr/(1 + a).
        let unit = m2 / (6.0 * trial.shear);
        let mut start = 0.0;
        let mut at = |a: f64| {
            let multiplier = a * unit;
            let Some([x, p, p_c]) = Self::volume_part(trial, size, multiplier, start) else {
                return (f64::NAN, f64::NAN, [f64::NAN; 4]);
            };
            start = x;
            let q = q_tr / (1.0 + a);
            let flow = 2.0 * p - p_c;
            let dx = unit * flow / (1.0 + multiplier * (2.0 * trial.theta * p + trial.chi * p_c));
            let slope = -2.0 * q * q / (m2 * (1.0 + a)) - p * (trial.theta * flow + trial.chi * p_c) * dx;
            let value = less_round_off(self.yield_function(p, q, p_c), q * q / m2 + p * (p + p_c));
            (value, slope, [p, q, p_c, multiplier])
        };
        // A multiplier that is large enough: the return ends inside as it grows.
        let (value, slope, _) = at(0.0);
        let mut low = 0.0;
        let mut high = (-value / slope).clamp(1e-12, 1.0);
        while at(high).0 > 0.0 {
            low = high;
            high *= 4.0;
            if !(high < 1e30) {
                return Err(failed);
            }
        }
        let root = falling_root(low, high, low, |a| {
            let (value, slope, _) = at(a);
            (value, slope)
        });
        let [pressure, q, preconsolidation_pressure, multiplier] = at(root.ok_or(failed)?).2;
        Ok(Some(CamClayReturn { pressure, q, preconsolidation_pressure, multiplier }))
    }

    /// One step: the return and the new point.
    fn step(
        &self,
        strain: &SymTensor,
        old: &Point<CamClayState>,
    ) -> Result<Advance<CamClayState>, MaterialError> {
        let trial = self.constants.trial(strain, old);
        let mut advance = self.constants.elastic(&trial, strain, old);
        if let Some(end) = self.return_map(&trial, old.state.preconsolidation_pressure)? {
            let m2 = self.constants.critical.powi(2);
            let CamClayReturn { pressure: p, q, preconsolidation_pressure: p_c, multiplier } = end;
            advance.point.stress = trial.radial.stress(p, keep(m2, &trial, multiplier));
            advance.point.state.preconsolidation_pressure = p_c;
            advance.point.state.plastic_strain += multiplier * 2.0 * q / m2;
            advance.dissipated = multiplier * (p * (2.0 * p - p_c) + 2.0 * q * q / m2);
        }
        Ok(advance)
    }

    /// The return of a step (sheet §3.7.5); `None` where the step is elastic.
    ///
    /// # Errors
    /// When the local solve fails.
    pub fn undivided_return(
        &self,
        strain: &SymTensor,
        old: &Point<CamClayState>,
    ) -> Result<Option<CamClayReturn>, MaterialError> {
        self.return_map(&self.constants.trial(strain, old), old.state.preconsolidation_pressure)
    }

    /// Consistent tangent, by the implicit-function theorem on
    /// `ln p - ln p_tr + θ Δλ (2p - p_c)`, `ln p_c - ln p_cn - χ Δλ (2p - p_c)` and `f`.
    fn step_tangent(&self, strain: &SymTensor, old: &Point<CamClayState>) -> Option<Tangent> {
        let trial = self.constants.trial(strain, old);
        let unit = SymTensor::IDENTITY;
        let Some(end) = self.return_map(&trial, old.state.preconsolidation_pressure).ok()? else {
            return Some(trial.radial.tangent(1.0, &(unit * -trial.pressure_slope), &SymTensor::ZERO));
        };
        let m2 = self.constants.critical.powi(2);
        let CamClayReturn { pressure: p, q, preconsolidation_pressure: p_c, multiplier } = end;
        let keep = keep(m2, &trial, multiplier);
        let flow = 2.0 * p - p_c;
        let (theta, chi) = (trial.theta, trial.chi);
        // Unknowns ln p, ln p_c and a = 6 G Δλ/M²; Δλ also falls with G at constant a.
        let per_a = m2 / (6.0 * trial.shear);
        let jacobian = Mat3([
            [1.0 + 2.0 * theta * multiplier * p, -theta * multiplier * p_c, theta * flow * per_a],
            [-2.0 * chi * multiplier * p, 1.0 + chi * multiplier * p_c, -chi * flow * per_a],
            [p * flow, -p * p_c, -2.0 * q * q * keep / m2],
        ]);
        let inverse = jacobian.inverse()?;
        let softer = multiplier * trial.shear_slope / trial.shear;
        let by_volume =
            [trial.pressure_slope / trial.pressure + theta * flow * softer, -chi * flow * softer, 0.0];
        let by_volume = inverse.apply(by_volume);
        // q²/M² by the trial deviator.
        let by_deviator = inverse.apply([0.0, 0.0, -1.0]);
        let deviator = trial.radial.slope(&(trial.radial.deviator * (3.0 * keep * keep / m2)));
        let slope = |row: usize| unit * -by_volume[row] + deviator * by_deviator[row];
        Some(trial.radial.tangent(keep, &(slope(0) * p), &(slope(2) * (-keep * keep))))
    }
}

/// `q/q_tr = 1/(1 + 6 G Δλ/M²)`.
fn keep(m2: f64, trial: &CamClayTrial, multiplier: f64) -> f64 {
    1.0 / (1.0 + 6.0 * trial.shear * multiplier / m2)
}

impl SmallStrain for CamClay {
    type State = CamClayState;

    fn name(&self) -> &'static str {
        NAME
    }

    fn initial(&self, initial: &InitialCondition) -> Result<Point<CamClayState>, MaterialError> {
        let m2 = self.constants.critical.powi(2);
        self.constants.initial(NAME, &initial.stress, |p, q| p + q * q / (m2 * p))
    }

    fn update(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<CamClayState>,
    ) -> Result<Point<CamClayState>, MaterialError> {
        self.step(strain, old).map(|advance| advance.point)
    }

    fn wave_modulus(&self, point: &Point<CamClayState>) -> f64 {
        self.constants.wave_modulus(point)
    }

    fn tangent(&self, strain: &SymTensor, _motion: &Motion, old: &Point<CamClayState>) -> Option<Tangent> {
        self.step_tangent(strain, old)
    }

    /// `f/p_c`, so that it is a stress.
    fn yield_value(&self, point: &Point<CamClayState>) -> Option<f64> {
        let size = point.state.preconsolidation_pressure;
        Some(self.yield_function(point.stress.pressure(), point.stress.q(), size) / size)
    }

    fn dissipation(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<CamClayState>,
        _new: &Point<CamClayState>,
    ) -> Option<f64> {
        self.step(strain, old).ok().map(|advance| advance.dissipated)
    }

    fn output_names(&self) -> &'static [&'static str] {
        OUTPUTS
    }

    fn outputs(&self, point: &Point<CamClayState>, out: &mut [f64]) {
        point.state.outputs(out);
    }
}
