//! Cohesive Cam Clay with the invariants of the plane (`d = 2`, as printed by Gaume et al. 2020, eqs. 54–55).
//!
//! `p = -(τ_xx + τ_yy)/2`, `s` the deviator in the plane, `K = λ + μ`; the return in `(p, q)` is that of the law.
//! The stress across the plane does no work; it is given as the mean of those in the plane, with which the
//! invariants of the whole tensor are those of the plane.

use super::{CohesiveCamClay, CohesiveCamClayState, Landing};
use crate::hencky::{HenckyState, carried};
use crate::laws::substep::divided;
use crate::{
    InitialCondition, Law, Mat3, MaterialError, Motion, Point, Pointwise, SmallStrain, StressUpdate,
    SymTensor,
};

/// The law at finite strain in the plane.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Planar(pub(super) CohesiveCamClay);

type State = HenckyState<CohesiveCamClayState>;

/// Largest shear or stretch across the plane that counts as none.
const ACROSS: f64 = 1e-12;

impl Planar {
    fn invalid(reason: &'static str) -> MaterialError {
        MaterialError::Motion { model: super::NAME, reason }
    }

    /// Stress and elastic deformation at `pressure` with the deviator `deviator`.
    fn point(
        &self,
        pressure: f64,
        deviator: &SymTensor,
        jacobian: f64,
        inner: CohesiveCamClayState,
    ) -> Point<State> {
        let elasticity = &self.0.elasticity;
        let (k, two_mu) = (elasticity.bulk_modulus, 2.0 * elasticity.shear_modulus);
        let stress = (*deviator - SymTensor::isotropic(pressure)) * (1.0 / jacobian);
        let spectrum = deviator.spectrum();
        let strains = spectrum.values.map(|s| s / two_mu - 0.5 * pressure / k);
        let mut elastic = spectrum.compose(strains.map(|e| (2.0 * e).exp_m1()));
        elastic[2] = 0.0;
        Point { stress, state: HenckyState { elastic, jacobian, inner } }
    }

    fn undivided(&self, motion: &Motion, old: &Point<State>) -> Result<Point<State>, MaterialError> {
        let f = &motion.deformation;
        if *f == Mat3::IDENTITY {
            return Ok(old.clone());
        }
        let stretch = f.determinant();
        // Written so that NaN is refused.
        if !(stretch > 0.0 && stretch.is_finite() && f.is_finite()) {
            return Err(Self::invalid("the step inverts the point"));
        }
        let across = [f.0[0][2], f.0[1][2], f.0[2][0], f.0[2][1], f.0[2][2] - 1.0];
        if across.iter().any(|c| c.abs() > ACROSS) {
            return Err(Self::invalid("the motion leaves the plane that the invariants are taken in"));
        }
        let trial = carried(&old.state.elastic, f);
        let [xx, yy, _, xy, ..] = trial.0;
        let plane = SymTensor([xx, yy, 0.0, xy, 0.0, 0.0]);
        let spectrum = plane.spectrum();
        if !(spectrum.values[2] > -1.0) {
            return Err(Self::invalid("the elastic deformation is singular"));
        }
        let strain = spectrum.compose(spectrum.values.map(|b| 0.5 * b.ln_1p()));
        let volumetric = strain[0] + strain[1];
        let elasticity = &self.0.elasticity;
        let mean = SymTensor([0.5 * volumetric, 0.5 * volumetric, 0.0, 0.0, 0.0, 0.0]);
        let deviator = (strain - mean) * (2.0 * elasticity.shear_modulus);
        let (pressure, q) = (-elasticity.bulk_modulus * volumetric, deviator.q());
        let (landing, inner) = self.0.land((pressure, q), &old.state.inner)?;
        let jacobian = old.state.jacobian * stretch;
        Ok(match landing {
            Landing::Elastic => {
                let stress = (deviator - SymTensor::isotropic(pressure)) * (1.0 / jacobian);
                Point { stress, state: HenckyState { elastic: plane, jacobian, inner } }
            }
            Landing::Free => self.point(0.0, &SymTensor::ZERO, jacobian, inner),
            Landing::Surface(surface) => {
                let share = if q > 0.0 { surface.projection.q / q } else { 0.0 };
                self.point(surface.projection.pressure, &(deviator * share), jacobian, inner)
            }
        })
    }

    /// The point in Kirchhoff stresses.
    fn inner(point: &Point<State>) -> Point<CohesiveCamClayState> {
        Point { stress: point.stress * point.state.jacobian, state: point.state.inner }
    }
}

impl Law for Planar {
    fn name(&self) -> &'static str {
        super::NAME
    }

    /// The axis across the plane is another than those in it.
    fn is_isotropic(&self) -> bool {
        false
    }

    fn output_names(&self) -> &[&'static str] {
        Law::output_names(&self.0)
    }
}

impl Pointwise for Planar {
    type State = State;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<State>, MaterialError> {
        let [xx, yy, _, xy, ..] = initial.stress.0;
        let plane = SymTensor([xx, yy, 0.5 * (xx + yy), xy, 0.0, 0.0]);
        let inner = Pointwise::initial(&self.0, &InitialCondition { stress: plane, ..*initial })?;
        Ok(self.point(inner.stress.pressure(), &inner.stress.deviator(), 1.0, inner.state))
    }

    fn wave_modulus(&self, point: &Point<State>) -> f64 {
        let elasticity = &self.0.elasticity;
        let least = point.stress.principal_values()[2] * point.state.jacobian;
        // λ + 2μ in the plane.
        (elasticity.bulk_modulus + elasticity.shear_modulus - least.min(0.0)) / point.state.jacobian
    }

    fn yield_value(&self, point: &Point<State>) -> Option<f64> {
        Pointwise::yield_value(&self.0, &Self::inner(point))
    }

    fn outputs(&self, point: &Point<State>, out: &mut [f64]) {
        Pointwise::outputs(&self.0, &Self::inner(point), out);
    }
}

impl StressUpdate for Planar {
    fn update(&self, motion: &Motion, old: &Point<State>) -> Result<Point<State>, MaterialError> {
        divided(motion, self.0.largest_step(), old, |part, from| self.undivided(part, from))
    }
}
