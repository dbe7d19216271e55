//! Implicit return map of a step (sheet: constitutive §3.7.5) and its tangent.

use super::{CamClay, CamClayState, NAME};
use crate::laws::cam_clay::common::CamClayTrial;
use crate::return_maps::scalar_roots::{drop_round_off, falling_root};
use crate::return_maps::substepping::SubstepResult;
use crate::{Mat3, MaterialError, Point, SymTensor, Tangent};

/// Round-off tolerance of a stress on the yield surface, relative to the terms of the yield function.
const ON_SURFACE: f64 = 64.0 * f64::EPSILON;

/// Round-off of the terms of a residual at which Newton's method ends.
const NEWTON_TOLERANCE: f64 = 8.0 * f64::EPSILON;

/// Result of the return of a step.
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
    /// Yield function `q²/M² + p (p - p_c)` (Pa²).
    #[inline]
    pub fn yield_function(&self, pressure: f64, q: f64, preconsolidation_pressure: f64) -> f64 {
        (q / self.constants.critical).powi(2) + pressure * (pressure - preconsolidation_pressure)
    }

    /// Plastic volume compression of a multiplier: root of
    /// `x = Δλ (2p - p_c)`, `p = p_tr exp(-θ x)`, `p_c = p_cn exp(χ x)`. Returns it with `p` and `p_c`.
    fn plastic_compression(trial: &CamClayTrial, size: f64, multiplier: f64, start: f64) -> Option<[f64; 3]> {
        let at = |x: f64| (trial.pressure * (-trial.theta * x).exp(), size * (trial.chi * x).exp());
        let end = multiplier * (2.0 * trial.pressure - size);
        let (low, high) = (end.min(0.0), end.max(0.0));
        let x = if end == 0.0 {
            0.0
        } else {
            falling_root(low, high, start, |x| {
                let (p, p_c) = at(x);
                (
                    drop_round_off(multiplier * (2.0 * p - p_c) - x, multiplier * (2.0 * p + p_c)),
                    -multiplier * (2.0 * trial.theta * p + trial.chi * p_c) - 1.0,
                )
            })?
        };
        let (p, p_c) = at(x);
        Some([x, p, p_c])
    }

    /// Return of a trial outside the yield surface by Newton's method for the plastic volume compression `x` and `a = 6 G Δλ/M²` together.
    /// `None` where it does not converge in a few steps.
    fn newton_return(&self, trial: &CamClayTrial, size: f64) -> Option<CamClayReturn> {
        let m2 = self.constants.critical.powi(2);
        let (unit, theta, chi) = (m2 / (6.0 * trial.shear), trial.theta, trial.chi);
        let (mut x, mut a) = (0.0, 0.0);
        for _ in 0..12 {
            let (p, p_c) = (trial.pressure * (-theta * x).exp(), size * (chi * x).exp());
            let keep = 1.0 / (1.0 + a);
            let (q, multiplier, flow) = (trial.q * keep, a * unit, 2.0 * p - p_c);
            let shear = q * q / m2;
            let (value, volume) = (shear + p * (p - p_c), multiplier * flow - x);
            let is_solved = value.abs() <= NEWTON_TOLERANCE * (shear + p * (p + p_c))
                && volume.abs() <= NEWTON_TOLERANCE * (multiplier * (2.0 * p + p_c));
            if is_solved {
                let end = CamClayReturn { pressure: p, q, preconsolidation_pressure: p_c, multiplier };
                return (a > 0.0).then_some(end);
            }
            // Derivatives of both residuals by x and a.
            let (value_x, value_a) = (-p * (theta * flow + chi * p_c), -2.0 * shear * keep);
            let (volume_x, volume_a) = (-multiplier * (2.0 * theta * p + chi * p_c) - 1.0, unit * flow);
            let inverse = 1.0 / (value_x * volume_a - value_a * volume_x);
            let step_x = (value_a * volume - volume_a * value) * inverse;
            let step_a = (volume_x * value - value_x * volume) * inverse;
            (x, a) = (x + step_x, a + step_a);
            // Written so that NaN is rejected.
            if !(a >= 0.0 && (theta + chi) * step_x.abs() < 1.0) {
                return None;
            }
        }
        None
    }

    /// Return of a trial; `None` where the trial is elastic.
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
        match self.newton_return(trial, size) {
            Some(end) => Ok(Some(end)),
            None => self.bracketed_return(trial, size).map(Some),
        }
    }

    /// Return of a trial outside the yield surface by a bracketed root in `a`, at which the volume part is solved.
    fn bracketed_return(&self, trial: &CamClayTrial, size: f64) -> Result<CamClayReturn, MaterialError> {
        let m2 = self.constants.critical.powi(2);
        let q_tr = trial.q;
        let failed = MaterialError::NotConverged { model: NAME, reason: "yield condition" };
        // Unknown a = 6 G Δλ/M², so that q = q_tr/(1 + a).
        let unit = m2 / (6.0 * trial.shear);
        let mut start = 0.0;
        let mut at = |a: f64| {
            let multiplier = a * unit;
            let Some([x, p, p_c]) = Self::plastic_compression(trial, size, multiplier, start) else {
                return (f64::NAN, f64::NAN, [f64::NAN; 4]);
            };
            start = x;
            let q = q_tr / (1.0 + a);
            let flow = 2.0 * p - p_c;
            let dx = unit * flow / (1.0 + multiplier * (2.0 * trial.theta * p + trial.chi * p_c));
            let slope = -2.0 * q * q / (m2 * (1.0 + a)) - p * (trial.theta * flow + trial.chi * p_c) * dx;
            let value = drop_round_off(self.yield_function(p, q, p_c), q * q / m2 + p * (p + p_c));
            (value, slope, [p, q, p_c, multiplier])
        };
        // A sufficiently large multiplier: with growing multiplier the return ends inside.
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
        Ok(CamClayReturn { pressure, q, preconsolidation_pressure, multiplier })
    }

    /// Updates a point by one step: return map, new stress and new state.
    pub(super) fn step(
        &self,
        strain: &SymTensor,
        old: &Point<CamClayState>,
    ) -> Result<SubstepResult<CamClayState>, MaterialError> {
        let trial = self.constants.trial(strain, old);
        let mut advance = self.constants.elastic(&trial, strain, old);
        if let Some(end) = self.return_map(&trial, old.state.preconsolidation_pressure)? {
            let m2 = self.constants.critical.powi(2);
            let CamClayReturn { pressure: p, q, preconsolidation_pressure: p_c, multiplier } = end;
            advance.point.stress = trial.radial.stress(p, deviator_scale(m2, &trial, multiplier));
            advance.point.state.preconsolidation_pressure = p_c;
            advance.point.state.plastic_strain += multiplier * 2.0 * q / m2;
            advance.dissipated_work = multiplier * (p * (2.0 * p - p_c) + 2.0 * q * q / m2);
        }
        Ok(advance)
    }

    /// Result of the return map of a step (sheet: constitutive §3.7.5); `None` for an elastic step.
    ///
    /// # Errors
    /// When the local solve fails.
    pub fn single_step_return(
        &self,
        strain: &SymTensor,
        old: &Point<CamClayState>,
    ) -> Result<Option<CamClayReturn>, MaterialError> {
        self.return_map(&self.constants.trial(strain, old), old.state.preconsolidation_pressure)
    }

    /// Consistent tangent, by the implicit-function theorem on
    /// `ln p - ln p_tr + θ Δλ (2p - p_c)`, `ln p_c - ln p_cn - χ Δλ (2p - p_c)` and `f`.
    pub(super) fn step_tangent(&self, strain: &SymTensor, old: &Point<CamClayState>) -> Option<Tangent> {
        let trial = self.constants.trial(strain, old);
        let unit = SymTensor::IDENTITY;
        let Some(end) = self.return_map(&trial, old.state.preconsolidation_pressure).ok()? else {
            return Some(trial.radial.tangent(1.0, &(unit * -trial.pressure_slope), &SymTensor::ZERO));
        };
        let m2 = self.constants.critical.powi(2);
        let CamClayReturn { pressure: p, q, preconsolidation_pressure: p_c, multiplier } = end;
        let keep = deviator_scale(m2, &trial, multiplier);
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
        // Derivative of q²/M² by the trial deviator.
        let by_deviator = inverse.apply([0.0, 0.0, -1.0]);
        let deviator = trial.radial.slope(&(trial.radial.deviator * (3.0 * keep * keep / m2)));
        let slope = |row: usize| unit * -by_volume[row] + deviator * by_deviator[row];
        Some(trial.radial.tangent(keep, &(slope(0) * p), &(slope(2) * (-keep * keep))))
    }
}

/// Ratio `q/q_tr = 1/(1 + 6 G Δλ/M²)`.
fn deviator_scale(m2: f64, trial: &CamClayTrial, multiplier: f64) -> f64 {
    1.0 / (1.0 + 6.0 * trial.shear * multiplier / m2)
}

#[cfg(test)]
mod tests {
    use crate::laws::CamClaySpec;
    use crate::laws::cam_clay::CamClayState;
    use crate::laws::model::Model;
    use crate::{Point, SymTensor};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_return_of_newton_is_the_bracketed_one(
            pressure in 1e3..1e6f64, ratio in 0.5..4.0f64, strain in proptest::array::uniform6(-1.0..1.0f64), size in -5.0..-2.0f64,
        ) {
            for spec in CamClaySpec::examples() {
                let law = spec.law().unwrap();
                let state = CamClayState { preconsolidation_pressure: ratio * pressure, void_ratio: 1.0, plastic_strain: 0.0 };
                let old = Point { stress: SymTensor::isotropic(-pressure), state };
                let strain = SymTensor(strain) * 10f64.powf(size);
                let trial = law.constants.trial(&strain, &old);
                let size = state.preconsolidation_pressure;
                if law.return_map(&trial, size).unwrap().is_none() {
                    continue;
                }
                let newton = law.newton_return(&trial, size);
                // Larger steps may need the bracket.
                prop_assert!(newton.is_some() || strain.norm() > 1e-4, "{trial:?}");
                let Some(newton) = newton else { continue };
                let bracketed = law.bracketed_return(&trial, size).unwrap();
                for (a, b) in [
                    (newton.pressure, bracketed.pressure),
                    (newton.q, bracketed.q),
                    (newton.preconsolidation_pressure, bracketed.preconsolidation_pressure),
                ] {
                    prop_assert!((a - b).abs() <= 1e-11 * size, "{newton:?} {bracketed:?}");
                }
            }
        }
    }
}
