//! Laws in pressure and deviatoric stress with the invariants of the plane (`d = 2`, as printed by Gaume et al. 2020, eqs. 54–55).
//!
//! `p = -(τ_xx + τ_yy)/2`, `s` the deviator in the plane, `K = λ + μ`; the return in `(p, q)` is that of the law.
//! The stress across the plane does no work; it is given as the mean of those in the plane, with which the
//! invariants of the whole tensor are those of the plane.

use std::sync::Arc;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::adapters::hencky::{Hencky, HenckyState, PrincipalReturn, push_forward};
use crate::contract::elasticity::Elasticity;
use crate::return_maps::substepping::substepped_motion;
use crate::{
    InitialCondition, Law, Mat3, Material, MaterialError, Motion, Point, PointLaw, StressUpdate, SymTensor,
};

/// Tensor of pressure and deviatoric stress.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StressInvariants {
    /// Whole tensor, `d = 3`: plane strain has out-of-plane stress.
    #[default]
    Space,
    /// Tensor in the plane, `d = 2`, as in Gaume et al. and Klar et al.: `p = -(τ_xx + τ_yy)/2`, `K = λ + μ`. For in-plane motions; another
    /// material than in space.
    Plane,
}

impl StressInvariants {
    /// Number of dimensions `d` of the trace.
    pub fn dimensions(self) -> f64 {
        match self {
            Self::Space => 3.0,
            Self::Plane => 2.0,
        }
    }

    /// Elastic constants of `d` dimensions, with the bulk modulus `λ + 2μ/d`, from those of three dimensions.
    pub fn elasticity(self, space: Elasticity) -> Elasticity {
        match self {
            Self::Space => space,
            Self::Plane => Elasticity { bulk_modulus: space.lame() + space.shear_modulus, ..space },
        }
    }

    /// Wraps a law at finite strain with these invariants and the elastic constants of [`StressInvariants::elasticity`].
    pub(crate) fn wrap<L: InvariantReturn>(self, law: L) -> Arc<dyn Material> {
        match self {
            Self::Space => Arc::new(Hencky(law)),
            Self::Plane => Arc::new(PlanarHencky(law)),
        }
    }
}

/// Pressure and `q` (Pa) after the return of a trial, `None` for an elastic step, and the new state.
pub type ReturnResult<S> = Result<(Option<(f64, f64)>, S), MaterialError>;

/// Return map in pressure and deviatoric stress that keeps the directions of the trial's deviator.
pub trait InvariantReturn: PrincipalReturn {
    /// Pressure and `q` (Pa) after the return of the trial `(p, q)` (Pa), `None` for an elastic step, and the new state.
    ///
    /// # Errors
    /// When the local solve fails.
    fn return_invariants(&self, trial: (f64, f64), state: &Self::State) -> ReturnResult<Self::State>;
}

/// Finite-strain law in the plane, with elastic constants of two dimensions.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PlanarHencky<L>(pub(crate) L);

/// Tolerance of out-of-plane shear and stretch, below which a motion is plane.
const OUT_OF_PLANE_TOLERANCE: f64 = 1e-12;

impl<L: InvariantReturn> PlanarHencky<L> {
    /// Error of a motion that the law cannot compute, for the given reason.
    fn invalid(&self, reason: &'static str) -> MaterialError {
        MaterialError::Motion { model: self.0.name(), reason }
    }

    /// Stress and elastic deformation at `pressure` with the deviator `deviator`.
    fn point(
        &self,
        pressure: f64,
        deviator: &SymTensor,
        jacobian: f64,
        inner_state: L::State,
    ) -> Point<HenckyState<L::State>> {
        let elasticity = self.0.elasticity();
        let (k, two_mu) = (elasticity.bulk_modulus, 2.0 * elasticity.shear_modulus);
        let stress = (*deviator - SymTensor::isotropic(pressure)) * (1.0 / jacobian);
        let spectrum = deviator.spectrum();
        let strains = spectrum.values.map(|s| s / two_mu - 0.5 * pressure / k);
        let mut elastic = spectrum.compose(strains.map(|e| (2.0 * e).exp_m1()));
        elastic[2] = 0.0;
        Point { stress, state: HenckyState { elastic, jacobian, inner_state } }
    }

    /// Stress and state after a plane step without sub-steps.
    fn single_step(
        &self,
        motion: &Motion,
        old: &Point<HenckyState<L::State>>,
    ) -> Result<Point<HenckyState<L::State>>, MaterialError> {
        let f = &motion.deformation;
        if *f == Mat3::IDENTITY {
            return Ok(old.clone());
        }
        let stretch = f.determinant();
        // Written so that NaN is rejected.
        if !(stretch > 0.0 && stretch.is_finite() && f.is_finite()) {
            return Err(self.invalid("the step inverts the point"));
        }
        let across = [f.0[0][2], f.0[1][2], f.0[2][0], f.0[2][1], f.0[2][2] - 1.0];
        if across.iter().any(|c| c.abs() > OUT_OF_PLANE_TOLERANCE) {
            return Err(self.invalid("the motion leaves the plane of the invariants"));
        }
        let trial = push_forward(&old.state.elastic, f);
        let [xx, yy, _, xy, ..] = trial.0;
        let plane = SymTensor([xx, yy, 0.0, xy, 0.0, 0.0]);
        let spectrum = plane.spectrum();
        if !(spectrum.values[2] > -1.0) {
            return Err(self.invalid("the elastic deformation is singular"));
        }
        let strain = spectrum.compose(spectrum.values.map(|b| 0.5 * b.ln_1p()));
        let volumetric = strain[0] + strain[1];
        let elasticity = self.0.elasticity();
        let mean = SymTensor([0.5 * volumetric, 0.5 * volumetric, 0.0, 0.0, 0.0, 0.0]);
        let deviator = (strain - mean) * (2.0 * elasticity.shear_modulus);
        let (pressure, q) = (-elasticity.bulk_modulus * volumetric, deviator.q());
        let (end, inner_state) = self.0.return_invariants((pressure, q), &old.state.inner_state)?;
        let jacobian = old.state.jacobian * stretch;
        Ok(match end {
            None => {
                let stress = (deviator - SymTensor::isotropic(pressure)) * (1.0 / jacobian);
                Point { stress, state: HenckyState { elastic: plane, jacobian, inner_state } }
            }
            Some((0.0, 0.0)) => self.point(0.0, &SymTensor::ZERO, jacobian, inner_state),
            Some((pressure, kept)) => {
                let share = if q > 0.0 { kept / q } else { 0.0 };
                self.point(pressure, &(deviator * share), jacobian, inner_state)
            }
        })
    }

    /// Point with the Kirchhoff in place of the Cauchy stress.
    fn kirchhoff_point(point: &Point<HenckyState<L::State>>) -> Point<L::State> {
        Point { stress: point.stress * point.state.jacobian, state: point.state.inner_state.clone() }
    }
}

impl<L: InvariantReturn> Law for PlanarHencky<L> {
    fn name(&self) -> &'static str {
        self.0.name()
    }

    /// Whether the law is isotropic: false, since the out-of-plane axis differs from those in the plane.
    fn is_isotropic(&self) -> bool {
        false
    }

    fn requires_plane_strain(&self) -> bool {
        true
    }

    fn output_names(&self) -> &[&'static str] {
        self.0.output_names()
    }
}

impl<L: InvariantReturn> PointLaw for PlanarHencky<L> {
    type State = HenckyState<L::State>;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<HenckyState<L::State>>, MaterialError> {
        let [xx, yy, _, xy, ..] = initial.stress.0;
        let plane = SymTensor([xx, yy, 0.5 * (xx + yy), xy, 0.0, 0.0]);
        let inner = self.0.initial(&InitialCondition { stress: plane, ..*initial })?;
        Ok(self.point(inner.stress.pressure(), &inner.stress.deviator(), 1.0, inner.state))
    }

    fn wave_modulus(&self, point: &Point<HenckyState<L::State>>) -> f64 {
        let elasticity = self.0.elasticity();
        let smallest = point.stress.principal_values()[2] * point.state.jacobian;
        // λ + 2μ in the plane.
        (elasticity.bulk_modulus + elasticity.shear_modulus - smallest.min(0.0)) / point.state.jacobian
    }

    fn yield_value(&self, point: &Point<HenckyState<L::State>>) -> Option<f64> {
        self.0.yield_value(&Self::kirchhoff_point(point))
    }

    fn stored_energy(&self, point: &Point<HenckyState<L::State>>) -> Option<f64> {
        Some(self.0.stored_energy(&Self::kirchhoff_point(point))? / point.state.jacobian)
    }

    fn outputs(&self, point: &Point<HenckyState<L::State>>, out: &mut [f64]) {
        self.0.outputs(&Self::kirchhoff_point(point), out);
    }
}

impl<L: InvariantReturn> StressUpdate for PlanarHencky<L> {
    fn update(
        &self,
        motion: &Motion,
        old: &Point<HenckyState<L::State>>,
    ) -> Result<Point<HenckyState<L::State>>, MaterialError> {
        substepped_motion(motion, self.0.max_strain_increment(), old, |part, from| {
            self.single_step(part, from)
        })
    }
}
