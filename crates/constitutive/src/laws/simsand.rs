//! Critical-state sand, "SIMSAND" (constitutive sheet §2.7, §3.7.8; Bui & Nguyen 2021, section 3.2.4, after
//! Jin et al. 2017).
//!
//! Compression positive, `η = q/p`, void ratio `e`:
//! `K = K₀ p_at (2.97-e)²/(1+e) (p/p_at)^ζ`, `G = 3(1-2ν)/(2(1+ν)) K`, `e_c = e_ref - λ (p/p_at)^ξ`,
//! `f = η - M_p ε_q/(k_p + ε_q) ≤ 0`, `dε_v/dε_q = A_d (M_pt - η)`,
//! `tan φ_p = (e_c/e)^n_p tan φ_c`, `tan φ_pt = (e_c/e)^(-n_d) tan φ_c`, `M_x = 6 sin φ_x/(3 - sin φ_x)`, with
//! the accumulated plastic shear `ε_q`. The return is implicit with the moduli of the start of the (sub)step:
//! for a plastic shear the pressure is the root of a rising function, and the yield condition remains.
//! Steps above 1 % strain are divided. Where pressure would fall below 1 Pa the point carries no stress
//! and is flagged liquefied until it is compressed again. Limits: no plastic flow at constant stress
//! ratio, reversals are elastic, stiffness is frozen over a substep.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::linear_elastic::stiff_warnings;
use super::pressure_elastic::{LEAST_PRESSURE, check_poissons_ratio, shear_ratio, void_ratio_after};
use super::radial::RadialTrial;
use super::root::{falling_root, less_round_off};
use super::substep::Advance;
use crate::model::{Facts, Kind, Model, check, not_negative, positive};
use crate::{
    Corotational, InitialCondition, Material, MaterialError, Motion, Point, SmallStrain, SymTensor, Tangent,
};

const NAME: &str = "simsand";

/// Plastic shear every point starts with, so that the surface has a slope at zero stress ratio.
const FIRST_SHEAR: f64 = 1e-9;

/// Void ratio at which the stiffness of the formula vanishes.
const LOOSEST: f64 = 2.97;

/// Void ratios and critical void ratios are taken between these in stiffness and friction.
const VOID_RANGE: (f64, f64) = (0.01, 2.9);

/// Round-off of a stress that lies on the yield surface, relative to the terms of the yield function.
const ON_SURFACE: f64 = 64.0 * f64::EPSILON;

/// Parameters of `simsand`, angles in degrees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SimsandSpec {
    /// Density (kg/m³), > 0.
    pub density: f64,
    /// Initial void ratio `e`, 0 to 2.9 (both excluded).
    pub void_ratio: f64,
    /// Elastic stiffness constant `K₀`, > 0.
    pub stiffness_constant: f64,
    /// Exponent `ζ` of pressure in the stiffness, 0 to 1.
    pub stiffness_exponent: f64,
    /// Poisson's ratio, between -1 and 0.5.
    pub poissons_ratio: f64,
    /// Friction angle `φ_c` of the critical state (degrees), 0 to 90 (both excluded).
    pub critical_friction_angle: f64,
    /// Critical void ratio at zero pressure `e_ref`, > 0.
    pub reference_void_ratio: f64,
    /// Factor `λ` of the critical state line, > 0.
    pub critical_state_factor: f64,
    /// Exponent `ξ` of pressure in the critical state line, > 0.
    pub critical_state_exponent: f64,
    /// Dilatancy constant `A_d`, not negative.
    pub dilatancy_constant: f64,
    /// Exponent `n_d` of the density in the phase-transformation angle, not negative.
    pub dilatancy_exponent: f64,
    /// Exponent `n_p` of the density in the peak angle, not negative.
    pub peak_exponent: f64,
    /// Plastic shear strain `k_p` at half of the strength, > 0.
    pub hardening_constant: f64,
    /// Atmospheric pressure `p_at` (Pa), > 0.
    #[serde(default = "atmospheric_pressure")]
    pub atmospheric_pressure: f64,
    /// Whether strength falls from triaxial compression to extension.
    #[serde(default)]
    pub lode_dependence: bool,
}

fn atmospheric_pressure() -> f64 {
    100e3
}

impl SimsandSpec {
    /// The sand of Bui & Nguyen (2021), Table 1, at a void ratio: they list 0.77 (dense), 0.81 (medium) and
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
    const FACTS: Facts = Facts {
        source: "Bui & Nguyen 2021, section 3.2.4; Jin et al. 2017",
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
        let mut warnings = stiff_warnings(self.poissons_ratio);
        let (e, reference) = (self.void_ratio, self.reference_void_ratio);
        if e >= reference {
            warnings.push(format!("void_ratio: {e} is looser than any critical state (below {reference})"));
        }
        if self.dilatancy_constant > 1.0 {
            warnings.push(format!(
                "dilatancy_constant: {} is above 1, plastic flow may give back work",
                self.dilatancy_constant
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

/// State of a point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SimsandState {
    /// Volume of voids over volume of grains.
    pub void_ratio: f64,
    /// Accumulated plastic shear strain `ε_q`.
    pub plastic_strain: f64,
    /// The point has lost its effective pressure and carries no stress.
    pub liquefied: bool,
}

/// The law. See the module's head for source and limits.
#[derive(Clone, Debug, PartialEq)]
pub struct Simsand {
    spec: SimsandSpec,
    shear_ratio: f64,
    tangent_critical: f64,
}

/// A stress ratio `M_x` with its derivatives by pressure (1/Pa), void ratio and Lode's cosine.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slope {
    /// `M_x`.
    pub value: f64,
    by_pressure: f64,
    by_void_ratio: f64,
    by_lode: f64,
}

/// Elastic trial of a substep.
#[derive(Clone, Copy, Debug)]
struct Trial {
    bulk: f64,
    shear: f64,
    pressure: f64,
    q: f64,
    void_ratio: f64,
    plastic_strain: f64,
    /// `cos 3θ`: 1 in extension, -1 in compression.
    lode: f64,
    radial: RadialTrial,
}

/// Where the return of a substep ends.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Return {
    Elastic,
    /// Pressure (Pa) and plastic shear of the substep.
    Flow {
        pressure: f64,
        shear: f64,
    },
    Liquefied,
}

/// Lode's cosine `cos 3θ` of a deviator.
fn lode_cosine(deviator: &SymTensor) -> f64 {
    let j2 = 0.5 * deviator.dot(deviator);
    if j2 <= f64::MIN_POSITIVE {
        return 0.0;
    }
    (1.5 * 3f64.sqrt() * deviator.determinant() / (j2 * j2.sqrt())).clamp(-1.0, 1.0)
}

impl Simsand {
    /// Bulk modulus (Pa) at a pressure (Pa) and void ratio.
    pub fn bulk_modulus(&self, pressure: f64, void_ratio: f64) -> f64 {
        let spec = &self.spec;
        let p = pressure.max(LEAST_PRESSURE) / spec.atmospheric_pressure;
        let e = void_ratio.clamp(VOID_RANGE.0, VOID_RANGE.1);
        let density = (LOOSEST - e).powi(2) / (1.0 + e);
        spec.stiffness_constant * spec.atmospheric_pressure * density * p.powf(spec.stiffness_exponent)
    }

    /// Void ratio of the critical state at a pressure (Pa).
    pub fn critical_void_ratio(&self, pressure: f64) -> f64 {
        let spec = &self.spec;
        let power = (pressure / spec.atmospheric_pressure).powf(spec.critical_state_exponent);
        spec.reference_void_ratio - spec.critical_state_factor * power
    }

    /// Pressure (Pa) of the critical state at a void ratio; `None` for one that has none.
    pub fn critical_pressure(&self, void_ratio: f64) -> Option<f64> {
        let spec = &self.spec;
        let ratio = (spec.reference_void_ratio - void_ratio) / spec.critical_state_factor;
        (ratio > 0.0).then(|| spec.atmospheric_pressure * ratio.powf(1.0 / spec.critical_state_exponent))
    }

    /// `M_c` of the critical state in triaxial compression.
    pub fn critical_slope(&self) -> f64 {
        let sin = self.tangent_critical / self.tangent_critical.hypot(1.0);
        6.0 * sin / (3.0 - sin)
    }

    /// `M_p` and `M_pt` at a pressure (Pa), void ratio and Lode cosine (1 extension, -1 compression).
    pub fn slopes(&self, pressure: f64, void_ratio: f64, lode: f64) -> [Slope; 2] {
        let spec = &self.spec;
        let power = (pressure / spec.atmospheric_pressure).powf(spec.critical_state_exponent);
        let free = spec.reference_void_ratio - spec.critical_state_factor * power;
        let critical = free.max(VOID_RANGE.0);
        let e = void_ratio.clamp(VOID_RANGE.0, VOID_RANGE.1);
        // Logarithmic derivatives of e_c/e; none where a bound holds.
        let log_by_pressure = if free < critical {
            0.0
        } else {
            -spec.critical_state_exponent * spec.critical_state_factor * power / (pressure * critical)
        };
        let log_by_void = if e == void_ratio { -1.0 / e } else { 0.0 };
        [spec.peak_exponent, -spec.dilatancy_exponent].map(|exponent| {
            let tan = (critical / e).powf(exponent) * self.tangent_critical;
            let root = tan.hypot(1.0);
            let sin = tan / root;
            // By ln tan φ.
            let sin_slope = tan / root.powi(3);
            let (mut value, mut by_sin) = (6.0 * sin / (3.0 - sin), 18.0 / (3.0 - sin).powi(2));
            let mut by_lode = 0.0;
            if spec.lode_dependence {
                let c = (3.0 - sin) / (3.0 + sin);
                let u = c.powi(4);
                let below = (1.0 + lode) + u * (1.0 - lode);
                let factor = (2.0 * u / below).powf(0.25);
                // d ln factor = d(2u/below) / (4 · 2u/below)
                let by_u = 0.25 * (1.0 + lode) / (u * below);
                let u_by_sin = 4.0 * c.powi(3) * (-6.0 / (3.0 + sin).powi(2));
                by_sin = factor * (by_sin + value * by_u * u_by_sin);
                by_lode = -0.25 * value * factor * (1.0 - u) / below;
                value *= factor;
            }
            let by_log = by_sin * sin_slope * exponent;
            Slope {
                value,
                by_pressure: by_log * log_by_pressure,
                by_void_ratio: by_log * log_by_void,
                by_lode,
            }
        })
    }

    /// Mobilised share of the strength, `ε_q/(k_p + ε_q)`, and its slope.
    fn mobilised(&self, plastic_strain: f64) -> (f64, f64) {
        let sum = self.spec.hardening_constant + plastic_strain;
        (plastic_strain / sum, self.spec.hardening_constant / (sum * sum))
    }

    fn trial(&self, strain: &SymTensor, old: &Point<SimsandState>) -> Trial {
        let p = old.stress.pressure();
        let bulk = self.bulk_modulus(p, old.state.void_ratio);
        let shear = self.shear_ratio * bulk;
        let radial = RadialTrial::new(&old.stress, strain, shear, 0.0);
        Trial {
            bulk,
            shear,
            pressure: p - bulk * strain.trace(),
            q: radial.q(),
            void_ratio: void_ratio_after(old.state.void_ratio, strain.trace()),
            plastic_strain: old.state.plastic_strain,
            lode: if self.spec.lode_dependence { lode_cosine(&radial.deviator) } else { -1.0 },
            radial,
        }
    }

    /// Pressure that goes with the plastic shear `shear`, and its slope: root of
    /// `p - p_tr + K Δ A_d (M_pt - q/p)`, which rises with `p`. Not below the least pressure.
    fn pressure_part(&self, trial: &Trial, shear: f64, start: f64) -> Option<(f64, f64)> {
        let q = (trial.q - 3.0 * trial.shear * shear).max(0.0);
        let rate = trial.bulk * self.spec.dilatancy_constant;
        let dilatant = rate * shear;
        let excess = |p: f64| {
            let [_, transformation] = self.slopes(p, trial.void_ratio, trial.lode);
            let value = p - trial.pressure + dilatant * (transformation.value - q / p);
            let terms = p + trial.pressure.abs() + dilatant * (transformation.value + q / p);
            let value = less_round_off(value, terms);
            (value, 1.0 + dilatant * (transformation.by_pressure + q / (p * p)), transformation.value)
        };
        if !(excess(LEAST_PRESSURE).0 < 0.0) {
            return Some((LEAST_PRESSURE, 0.0));
        }
        // Without the contraction M_pt the pressure would be higher.
        let half = 0.5 * trial.pressure;
        let root = (half * half + dilatant * q).sqrt();
        let high = if half > 0.0 { half + root } else { dilatant * q / (root - half) };
        let high = (high * (1.0 + 1e-9)).max(LEAST_PRESSURE * 2.0);
        let p = falling_root(LEAST_PRESSURE, high, start, |p| {
            let (value, slope, _) = excess(p);
            (-value, -slope)
        })?;
        let (_, slope, transformation) = excess(p);
        let by_shear = rate * (transformation - q / p) + 3.0 * trial.shear * dilatant / p;
        Some((p, -by_shear / slope))
    }

    fn return_map(&self, trial: &Trial) -> Result<Return, MaterialError> {
        let q_tr = trial.q;
        if !(q_tr.is_finite() && trial.pressure.is_finite()) {
            return Err(MaterialError::Motion { model: NAME, reason: "the trial stress is not finite" });
        }
        if trial.pressure >= LEAST_PRESSURE {
            let [peak, _] = self.slopes(trial.pressure, trial.void_ratio, trial.lode);
            let strength = trial.pressure * peak.value * self.mobilised(trial.plastic_strain).0;
            if q_tr - strength <= ON_SURFACE * (q_tr + strength) {
                return Ok(Return::Elastic);
            }
        } else if q_tr == 0.0 {
            return Ok(Return::Liquefied);
        }
        let most = q_tr / (3.0 * trial.shear);
        let mut last = (trial.pressure.max(LEAST_PRESSURE), 0.0, 0.0);
        let mut at = |shear: f64| {
            let (p, p_slope, at) = last;
            let Some((p, slope)) = self.pressure_part(trial, shear, p + p_slope * (shear - at)) else {
                return (f64::NAN, f64::NAN);
            };
            last = (p, slope, shear);
            let q = q_tr - 3.0 * trial.shear * shear;
            let [peak, _] = self.slopes(p, trial.void_ratio, trial.lode);
            let (share, share_slope) = self.mobilised(trial.plastic_strain + shear);
            let by_pressure = -(peak.value + p * peak.by_pressure) * share;
            let strength = p * peak.value * share;
            (
                less_round_off(q - strength, q_tr + strength),
                -3.0 * trial.shear + by_pressure * slope - p * peak.value * share_slope,
            )
        };
        let failed = MaterialError::NotConverged { model: NAME, reason: "yield condition" };
        let shear = falling_root(0.0, most, 0.0, &mut at).ok_or(failed.clone())?;
        let (pressure, _) = self.pressure_part(trial, shear, last.0).ok_or(failed)?;
        if pressure <= LEAST_PRESSURE {
            return Ok(Return::Liquefied);
        }
        Ok(Return::Flow { pressure, shear })
    }

    fn step(
        &self,
        strain: &SymTensor,
        old: &Point<SimsandState>,
    ) -> Result<Advance<SimsandState>, MaterialError> {
        let trial = self.trial(strain, old);
        let mut state = SimsandState { void_ratio: trial.void_ratio, liquefied: false, ..old.state };
        let (stress, dissipated) = match self.return_map(&trial)? {
            Return::Elastic => (trial.radial.stress(trial.pressure, 1.0), 0.0),
            Return::Liquefied => {
                state.liquefied = true;
                (SymTensor::ZERO, 0.0)
            }
            Return::Flow { pressure, shear } => {
                // From the yield condition, which then holds to the last digit.
                state.plastic_strain += shear;
                let [peak, transformation] = self.slopes(pressure, trial.void_ratio, trial.lode);
                let q = pressure * peak.value * self.mobilised(state.plastic_strain).0;
                let dilatancy = self.spec.dilatancy_constant * (transformation.value - q / pressure);
                (trial.radial.stress(pressure, q / trial.q), shear * (q + pressure * dilatancy))
            }
        };
        Ok(Advance { point: Point { stress, state }, dissipated })
    }

    /// Consistent tangent, by the implicit-function theorem on the pressure and yield
    /// conditions.
    fn step_tangent(&self, strain: &SymTensor, old: &Point<SimsandState>) -> Option<Tangent> {
        let trial = self.trial(strain, old);
        let unit = SymTensor::IDENTITY;
        let (p, shear) = match self.return_map(&trial).ok()? {
            Return::Elastic => {
                return Some(trial.radial.tangent(1.0, &(unit * -trial.bulk), &SymTensor::ZERO));
            }
            Return::Liquefied => return Some(Tangent::ZERO),
            Return::Flow { pressure, shear } => (pressure, shear),
        };
        let [peak, transformation] = self.slopes(p, trial.void_ratio, trial.lode);
        let (share, share_slope) = self.mobilised(trial.plastic_strain + shear);
        let three_g = 3.0 * trial.shear;
        let q = trial.q - three_g * shear;
        let dilatant = trial.bulk * self.spec.dilatancy_constant * shear;
        let rate = trial.bulk * self.spec.dilatancy_constant;
        // Unknowns p and Δ; g: pressure condition, f: yield condition times p.
        let g_p = 1.0 + dilatant * (transformation.by_pressure + q / (p * p));
        let g_shear = rate * (transformation.value - q / p) + three_g * dilatant / p;
        let f_p = -(peak.value + p * peak.by_pressure) * share;
        let f_shear = -three_g - p * peak.value * share_slope;
        let determinant = g_p * f_shear - g_shear * f_p;
        if determinant == 0.0 {
            return None;
        }
        let solve =
            |g: f64, f: f64| [-(f_shear * g - g_shear * f) / determinant, -(g_p * f - f_p * g) / determinant];
        // By the volume compression (p_tr and e), by q of the trial, by Lode's cosine.
        let e_slope = -(1.0 + trial.void_ratio);
        let by_volume = solve(
            -trial.bulk + dilatant * transformation.by_void_ratio * e_slope,
            -p * peak.by_void_ratio * share * e_slope,
        );
        let by_q = solve(-dilatant / p, 1.0);
        let by_lode = solve(dilatant * transformation.by_lode, -p * peak.by_lode * share);
        let s = trial.radial.deviator;
        let q_tr_slope = trial.radial.slope(&(s * (1.5 / trial.q)));
        let lode_slope =
            if self.spec.lode_dependence { trial.radial.slope(&lode_gradient(&s)) } else { SymTensor::ZERO };
        let slope = |k: usize| unit * -by_volume[k] + q_tr_slope * by_q[k] + lode_slope * by_lode[k];
        let keep = q / trial.q;
        let keep_slope = (q_tr_slope * (1.0 - keep) + slope(1) * -three_g) * (1.0 / trial.q);
        Some(trial.radial.tangent(keep, &slope(0), &keep_slope))
    }
}

/// Derivative of `cos 3θ = (3√3/2) J3/J2^(3/2)` by the deviator: a deviator.
fn lode_gradient(s: &SymTensor) -> SymTensor {
    let j2 = 0.5 * s.dot(s);
    let m = s.to_matrix();
    let squared = (m * m).sym().deviator();
    let c = 1.5 * 3f64.sqrt() / (j2 * j2.sqrt());
    squared * c + *s * (-1.5 * c * s.determinant() / j2)
}

impl SmallStrain for Simsand {
    type State = SimsandState;

    fn name(&self) -> &'static str {
        NAME
    }

    /// The plastic shear at the start is what puts the yield surface through the initial stress.
    fn initial(&self, initial: &InitialCondition) -> Result<Point<SimsandState>, MaterialError> {
        let stress = initial.stress;
        super::check_compressive(NAME, &stress)?;
        let (p, q) = (stress.pressure(), stress.q());
        let lode = lode_cosine(&stress.deviator());
        let [peak, _] = self.slopes(p, self.spec.void_ratio, lode);
        if q >= p * peak.value {
            let reason = format!(
                "the stress ratio q/p = {:.4} is not below the strength {:.4} (stress {:?} Pa)",
                q / p,
                peak.value,
                stress.0
            );
            return Err(MaterialError::Initial { model: NAME, reason });
        }
        let through = self.spec.hardening_constant * q / (p * peak.value - q);
        let state = SimsandState {
            void_ratio: self.spec.void_ratio,
            plastic_strain: through.max(FIRST_SHEAR),
            liquefied: false,
        };
        Ok(Point { stress, state })
    }

    fn update(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<SimsandState>,
    ) -> Result<Point<SimsandState>, MaterialError> {
        if *strain == SymTensor::ZERO {
            return Ok(*old);
        }
        self.step(strain, old).map(|advance| advance.point)
    }

    fn wave_modulus(&self, point: &Point<SimsandState>) -> f64 {
        let bulk = self.bulk_modulus(point.stress.pressure(), point.state.void_ratio);
        1.1 * bulk * (1.0 + 4.0 / 3.0 * self.shear_ratio)
    }

    fn tangent(&self, strain: &SymTensor, _motion: &Motion, old: &Point<SimsandState>) -> Option<Tangent> {
        self.step_tangent(strain, old)
    }

    /// `f p`, so that it is a stress.
    fn yield_value(&self, point: &Point<SimsandState>) -> Option<f64> {
        let p = point.stress.pressure();
        if !(p > 0.0) {
            return Some(0.0);
        }
        let lode = lode_cosine(&point.stress.deviator());
        let [peak, _] = self.slopes(p, point.state.void_ratio, lode);
        Some(point.stress.q() - p * peak.value * self.mobilised(point.state.plastic_strain).0)
    }

    fn dissipation(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<SimsandState>,
        _new: &Point<SimsandState>,
    ) -> Option<f64> {
        self.step(strain, old).ok().map(|advance| advance.dissipated)
    }

    fn output_names(&self) -> &'static [&'static str] {
        &["void_ratio", "plastic_strain", "liquefied"]
    }

    fn outputs(&self, point: &Point<SimsandState>, out: &mut [f64]) {
        let SimsandState { void_ratio, plastic_strain, liquefied } = point.state;
        out.copy_from_slice(&[void_ratio, plastic_strain, f64::from(u8::from(liquefied))]);
    }
}
