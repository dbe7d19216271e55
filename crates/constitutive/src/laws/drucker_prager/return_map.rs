//! Closest-point return to the cone or its apex (sheet: constitutive §3.7.1).

use super::{Cone, DruckerPrager, NAME, PlasticStrain};
use crate::{MaterialError, Point, SymTensor};

/// Square root of three.
const ROOT_3: f64 = 1.732_050_807_568_877_2;

/// Invariants of a stress: deviator, `√J2` (Pa) and `I1` (Pa).
pub(super) struct StressInvariantValues {
    /// Stress deviator (Pa).
    pub deviator: SymTensor,
    /// Square root of the second deviatoric invariant, `√J2` (Pa).
    pub root_j2: f64,
    /// First invariant `I1`, the trace of the stress, tension positive (Pa).
    pub i1: f64,
}

impl StressInvariantValues {
    /// Invariants of a stress (Pa).
    #[inline]
    pub(super) fn from_stress(stress: &SymTensor) -> Self {
        let deviator = stress.deviator();
        Self { deviator, root_j2: (0.5 * deviator.dot(&deviator)).sqrt(), i1: stress.trace() }
    }
}

/// Result of the return of a trial.
pub(super) enum ConeReturn {
    Elastic,
    /// Return to the cone: multiplier and the cone at the end of the step.
    Cone {
        multiplier: f64,
        cone: Cone,
    },
    Apex {
        mean: f64,
        plastic: f64,
    },
}

impl DruckerPrager {
    /// Closest-point return of a trial stress.
    pub(super) fn closest_point(
        &self,
        trial: &SymTensor,
        state: PlasticStrain,
    ) -> Result<Point<PlasticStrain>, MaterialError> {
        let invariants = StressInvariantValues::from_stress(trial);
        let end = self.return_map(&invariants, state.deviatoric)?;
        Ok(self.state_after_return(trial, &invariants, &end, state))
    }

    /// Return map in invariants (sheet: constitutive §3.7.1) of a trial, from plastic strain `kappa`.
    #[inline]
    pub(super) fn return_map(
        &self,
        trial: &StressInvariantValues,
        kappa: f64,
    ) -> Result<ConeReturn, MaterialError> {
        if self.has_constant_cone { self.peak_return(trial) } else { self.softening_return(trial, kappa) }
    }

    /// Updates stress for a constant cone, without branches: new stress and increment of plastic strain.
    #[inline(always)]
    pub(super) fn peak_step(&self, strain: &SymTensor, stress: &SymTensor) -> (SymTensor, f64) {
        let trial = *stress + self.elasticity.stress(strain);
        let at = StressInvariantValues::from_stress(&trial);
        let (cone, g) = (&self.peak, self.elasticity.shear_modulus);
        let excess = cone.yield_value(at.root_j2, at.i1);
        let flows = excess > cone.yield_tolerance(&at);
        let multiplier = excess * self.inverse_plastic_modulus;
        // Not at zero, where both may have vanished in rounding: that is the apex.
        let on_cone = at.root_j2 - g * multiplier > 0.0;
        let mean = at.i1 / 3.0 - 3.0 * self.elasticity.bulk_modulus * cone.dilatancy * multiplier;
        // `r - G Δλ`, from the yield condition, which is then satisfied to the last digit of the result.
        let kept = (cone.strength - 3.0 * cone.friction * mean).max(0.0);
        let keep = if on_cone { kept / at.root_j2 } else { 0.0 };
        let mean = if on_cone { mean } else { cone.strength / (3.0 * cone.friction) };
        let plastic = if on_cone { multiplier / ROOT_3 } else { at.root_j2 / (g * ROOT_3) };
        let returned = at.deviator * keep + SymTensor::isotropic(mean);
        let mut stress = trial;
        for c in 0..6 {
            stress[c] = if flows { returned[c] } else { trial[c] };
        }
        (stress, if flows { plastic } else { 0.0 })
    }

    /// Return to a constant cone.
    #[inline]
    pub(super) fn peak_return(&self, trial: &StressInvariantValues) -> Result<ConeReturn, MaterialError> {
        let cone = &self.peak;
        let excess = cone.yield_value(trial.root_j2, trial.i1);
        if excess <= cone.yield_tolerance(trial) {
            return Ok(ConeReturn::Elastic);
        }
        if !excess.is_finite() {
            return Err(self.not_finite());
        }
        let multiplier = excess * self.inverse_plastic_modulus;
        if trial.root_j2 - self.elasticity.shear_modulus * multiplier >= 0.0 {
            return Ok(ConeReturn::Cone { multiplier, cone: *cone });
        }
        let plastic = trial.root_j2 / (self.elasticity.shear_modulus * ROOT_3);
        Ok(ConeReturn::Apex { mean: cone.strength / (3.0 * cone.friction), plastic })
    }

    /// Return of a trial stress to the cone with softening, from the equivalent plastic strain `κ` at the start of the step.
    fn softening_return(
        &self,
        trial: &StressInvariantValues,
        kappa: f64,
    ) -> Result<ConeReturn, MaterialError> {
        let StressInvariantValues { root_j2, i1, .. } = *trial;
        let cone = self.cone_at(kappa);
        let excess = cone.yield_value(root_j2, i1);
        if excess <= cone.yield_tolerance(trial) {
            return Ok(ConeReturn::Elastic);
        }
        if !excess.is_finite() {
            return Err(self.not_finite());
        }
        let (k, g) = (self.elasticity.bulk_modulus, self.elasticity.shear_modulus);
        let start = excess / (g + 9.0 * k * cone.friction * cone.dilatancy);
        let at = |x: f64| {
            let cone = self.cone_at(kappa + x / ROOT_3);
            (cone.yield_value(root_j2 - g * x, i1 - 9.0 * k * cone.dilatancy * x), cone)
        };
        let (multiplier, cone) = solve_softening(at, start, excess, root_j2 / g, root_j2)?;
        if root_j2 - g * multiplier >= 0.0 {
            return Ok(ConeReturn::Cone { multiplier, cone });
        }
        // The deviatoric strain of the trial becomes plastic.
        let plastic = root_j2 / (g * ROOT_3);
        let cone = self.cone_at(kappa + plastic);
        Ok(ConeReturn::Apex { mean: cone.strength / (3.0 * cone.friction), plastic })
    }

    /// Error of a trial stress with NaN or infinite components.
    #[cold]
    fn not_finite(&self) -> MaterialError {
        MaterialError::Motion { model: self.name, reason: "the trial stress is not finite" }
    }

    /// Point at the end of a return.
    #[inline]
    pub(super) fn state_after_return(
        &self,
        trial: &SymTensor,
        invariants: &StressInvariantValues,
        end: &ConeReturn,
        state: PlasticStrain,
    ) -> Point<PlasticStrain> {
        match *end {
            ConeReturn::Elastic => Point { stress: *trial, state },
            ConeReturn::Cone { multiplier, cone } => {
                let mean =
                    invariants.i1 / 3.0 - 3.0 * self.elasticity.bulk_modulus * cone.dilatancy * multiplier;
                // `r - G Δλ`, from the yield condition, which is then satisfied to the last digit of the result.
                let kept = (cone.strength - 3.0 * cone.friction * mean).max(0.0);
                let keep = if invariants.root_j2 > 0.0 { kept / invariants.root_j2 } else { 0.0 };
                let state = PlasticStrain { deviatoric: state.deviatoric + multiplier / ROOT_3 };
                Point { stress: invariants.deviator * keep + SymTensor::isotropic(mean), state }
            }
            ConeReturn::Apex { mean, plastic } => {
                let state = PlasticStrain { deviatoric: state.deviatoric + plastic };
                Point { stress: SymTensor::isotropic(mean), state }
            }
        }
    }
}

/// Root of `at` between 0, where it is `excess > 0`, and `end`, by the secant method in a bracket. The result is beyond `end`, for a return
/// to the apex, if there is no root. Returns the root and the cone at the root.
fn solve_softening(
    at: impl Fn(f64) -> (f64, Cone),
    start: f64,
    excess: f64,
    end: f64,
    scale: f64,
) -> Result<(f64, Cone), MaterialError> {
    let (at_end, cone) = at(end);
    if at_end > 0.0 {
        return Ok((end * (1.0 + 1e-9) + f64::MIN_POSITIVE, cone));
    }
    let (mut low, mut high) = ((0.0, excess), (end, at_end));
    let (mut last, mut x) = ((0.0, excess), start.clamp(0.0, end));
    for _ in 0..100 {
        let (value, cone) = at(x);
        if value.abs() <= 2.0 * f64::EPSILON * scale || high.0 - low.0 <= f64::EPSILON * end {
            return Ok((x, cone));
        }
        if value > 0.0 {
            low = (x, value);
        } else {
            high = (x, value);
        }
        let secant = x - value * (x - last.0) / (value - last.1);
        last = (x, value);
        x = if secant > low.0 && secant < high.0 { secant } else { 0.5 * (low.0 + high.0) };
    }
    Err(MaterialError::NotConverged { model: NAME, reason: "softening return" })
}
