//! Implicit return of a substep (sheet: constitutive §3.7.8) and its tangent.

use super::critical_state::{lode_cosine, lode_gradient};
use super::{NAME, Simsand, SimsandState};
use crate::laws::pressure_elastic::{MIN_PRESSURE, void_ratio_after};
use crate::return_maps::radial_return::RadialTrial;
use crate::return_maps::scalar_roots::{drop_round_off, falling_root};
use crate::return_maps::substepping::SubstepResult;
use crate::{MaterialError, Point, SymTensor, Tangent};

/// Round-off tolerance of a stress on the yield surface, relative to the terms of the yield function.
const ON_SURFACE: f64 = 64.0 * f64::EPSILON;

/// Elastic trial of a substep.
#[derive(Clone, Copy, Debug)]
struct SimsandTrial {
    bulk: f64,
    shear: f64,
    pressure: f64,
    q: f64,
    void_ratio: f64,
    plastic_strain: f64,
    /// Lode's cosine `cos 3θ`: 1 in extension, -1 in compression.
    lode: f64,
    radial: RadialTrial,
}

/// Result of the return of a substep.
#[derive(Clone, Copy, Debug, PartialEq)]
enum SimsandReturn {
    Elastic,
    /// Plastic flow: pressure (Pa) and plastic shear of the substep.
    Flow {
        pressure: f64,
        shear: f64,
    },
    Liquefied,
}

impl Simsand {
    /// Elastic trial of a strain increment with the moduli of the old state.
    fn trial(&self, strain: &SymTensor, old: &Point<SimsandState>) -> SimsandTrial {
        let p = old.stress.pressure();
        let bulk = self.bulk_modulus(p, old.state.void_ratio);
        let shear = self.shear_ratio * bulk;
        let radial = RadialTrial::new(&old.stress, strain, shear, 0.0);
        SimsandTrial {
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

    /// Pressure at the plastic shear `shear`, and its slope: root of
    /// `p - p_tr + K Δ A_d (M_pt - q/p)`, which rises with `p`. Not below the least pressure.
    fn pressure_at_plastic_shear(&self, trial: &SimsandTrial, shear: f64, start: f64) -> Option<(f64, f64)> {
        let q = (trial.q - 3.0 * trial.shear * shear).max(0.0);
        let rate = trial.bulk * self.spec.dilatancy_constant;
        let dilatant = rate * shear;
        let excess = |p: f64| {
            let [_, transformation] = self.slopes(p, trial.void_ratio, trial.lode);
            let value = p - trial.pressure + dilatant * (transformation.value - q / p);
            let terms = p + trial.pressure.abs() + dilatant * (transformation.value + q / p);
            let value = drop_round_off(value, terms);
            (value, 1.0 + dilatant * (transformation.by_pressure + q / (p * p)), transformation.value)
        };
        if !(excess(MIN_PRESSURE).0 < 0.0) {
            return Some((MIN_PRESSURE, 0.0));
        }
        // Without the contraction M_pt the pressure would be higher.
        let half = 0.5 * trial.pressure;
        let root = (half * half + dilatant * q).sqrt();
        let high = if half > 0.0 { half + root } else { dilatant * q / (root - half) };
        let high = (high * (1.0 + 1e-9)).max(MIN_PRESSURE * 2.0);
        let p = falling_root(MIN_PRESSURE, high, start, |p| {
            let (value, slope, _) = excess(p);
            (-value, -slope)
        })?;
        let (_, slope, transformation) = excess(p);
        let by_shear = rate * (transformation - q / p) + 3.0 * trial.shear * dilatant / p;
        Some((p, -by_shear / slope))
    }

    /// Return of an elastic trial to the yield surface, or its liquefaction at zero pressure.
    fn return_map(&self, trial: &SimsandTrial) -> Result<SimsandReturn, MaterialError> {
        let q_tr = trial.q;
        if !(q_tr.is_finite() && trial.pressure.is_finite()) {
            return Err(MaterialError::Motion { model: NAME, reason: "the trial stress is not finite" });
        }
        if trial.pressure >= MIN_PRESSURE {
            let [peak, _] = self.slopes(trial.pressure, trial.void_ratio, trial.lode);
            let strength = trial.pressure * peak.value * self.mobilised_share(trial.plastic_strain).0;
            if q_tr - strength <= ON_SURFACE * (q_tr + strength) {
                return Ok(SimsandReturn::Elastic);
            }
        } else if q_tr == 0.0 {
            return Ok(SimsandReturn::Liquefied);
        }
        let largest = q_tr / (3.0 * trial.shear);
        let mut last = (trial.pressure.max(MIN_PRESSURE), 0.0, 0.0);
        let mut at = |shear: f64| {
            let (p, p_slope, at) = last;
            let Some((p, slope)) = self.pressure_at_plastic_shear(trial, shear, p + p_slope * (shear - at))
            else {
                return (f64::NAN, f64::NAN);
            };
            last = (p, slope, shear);
            let q = q_tr - 3.0 * trial.shear * shear;
            let [peak, _] = self.slopes(p, trial.void_ratio, trial.lode);
            let (share, share_slope) = self.mobilised_share(trial.plastic_strain + shear);
            let by_pressure = -(peak.value + p * peak.by_pressure) * share;
            let strength = p * peak.value * share;
            (
                drop_round_off(q - strength, q_tr + strength),
                -3.0 * trial.shear + by_pressure * slope - p * peak.value * share_slope,
            )
        };
        let failed = MaterialError::NotConverged { model: NAME, reason: "yield condition" };
        let shear = falling_root(0.0, largest, 0.0, &mut at).ok_or(failed.clone())?;
        let (pressure, _) = self.pressure_at_plastic_shear(trial, shear, last.0).ok_or(failed)?;
        if pressure <= MIN_PRESSURE {
            return Ok(SimsandReturn::Liquefied);
        }
        Ok(SimsandReturn::Flow { pressure, shear })
    }

    /// Stress, state and dissipated work after a sub-step.
    pub(super) fn step(
        &self,
        strain: &SymTensor,
        old: &Point<SimsandState>,
    ) -> Result<SubstepResult<SimsandState>, MaterialError> {
        let trial = self.trial(strain, old);
        let mut state = SimsandState { void_ratio: trial.void_ratio, liquefied: false, ..old.state };
        let (stress, dissipated_work) = match self.return_map(&trial)? {
            SimsandReturn::Elastic => (trial.radial.stress(trial.pressure, 1.0), 0.0),
            SimsandReturn::Liquefied => {
                state.liquefied = true;
                (SymTensor::ZERO, 0.0)
            }
            SimsandReturn::Flow { pressure, shear } => {
                // From the yield condition, which is then satisfied to the last digit.
                state.plastic_strain += shear;
                let [peak, transformation] = self.slopes(pressure, trial.void_ratio, trial.lode);
                let q = pressure * peak.value * self.mobilised_share(state.plastic_strain).0;
                let dilatancy = self.spec.dilatancy_constant * (transformation.value - q / pressure);
                (trial.radial.stress(pressure, q / trial.q), shear * (q + pressure * dilatancy))
            }
        };
        Ok(SubstepResult { point: Point { stress, state }, dissipated_work })
    }

    /// Consistent tangent, by the implicit-function theorem on the pressure and yield
    /// conditions.
    pub(super) fn step_tangent(&self, strain: &SymTensor, old: &Point<SimsandState>) -> Option<Tangent> {
        let trial = self.trial(strain, old);
        let unit = SymTensor::IDENTITY;
        let (p, shear) = match self.return_map(&trial).ok()? {
            SimsandReturn::Elastic => {
                return Some(trial.radial.tangent(1.0, &(unit * -trial.bulk), &SymTensor::ZERO));
            }
            SimsandReturn::Liquefied => return Some(Tangent::ZERO),
            SimsandReturn::Flow { pressure, shear } => (pressure, shear),
        };
        let [peak, transformation] = self.slopes(p, trial.void_ratio, trial.lode);
        let (share, share_slope) = self.mobilised_share(trial.plastic_strain + shear);
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
