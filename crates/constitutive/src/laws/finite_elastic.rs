//! Common parts of the finite-strain elastic laws (sheet: constitutive §2.13): the left Cauchy–Green tensor as
//! state, its step, and the inverse from a stress to its stretches. Such a law is a [`FiniteElastic`].

use serde::{Deserialize, Serialize};

use super::Elasticity;
use crate::adapters::hencky::push_forward;
use crate::contract::tangent::from_spatial;
use crate::{
    InitialCondition, Law, Mat3, MaterialError, Motion, Point, PointLaw, StressUpdate, SymTensor, Tangent,
};

/// Left Cauchy–Green tensor of a point minus the unit tensor, `b - 1`, which resolves small strains without cancellation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LeftCauchyGreen(pub SymTensor);

/// Kirchhoff stresses of principal stretches, and their slopes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrincipalStress {
    /// Principal Kirchhoff stresses `τ_A` (Pa).
    pub stress: [f64; 3],
    /// Slope `∂τ_A/∂ε_B` with respect to the principal logarithmic strains (Pa).
    pub slope: [[f64; 3]; 3],
}

/// Isotropic elastic law in the left Cauchy–Green tensor `b`; its functions take `b - 1`.
pub trait FiniteElastic: Send + Sync + 'static {
    /// Name of the model in a case file.
    const NAME: &'static str;

    /// Cauchy stress (Pa).
    fn cauchy_stress(&self, b: &SymTensor) -> SymTensor;

    /// Tensor `b - 1` that has the Cauchy stress `stress` (Pa).
    ///
    /// # Errors
    /// When no deformation of moderate size gives the stress.
    fn deformation_for_stress(&self, stress: &SymTensor) -> Result<SymTensor, MaterialError>;

    /// Spatial tangent (Pa) of the Kirchhoff stress.
    fn spatial_tangent(&self, b: &SymTensor) -> Tangent;

    /// P-wave modulus (Pa) in the stiffest direction; `stress` is the Cauchy stress (Pa).
    fn max_wave_modulus(&self, b: &SymTensor, stress: &SymTensor) -> f64;

    /// Energy per unit initial volume (J/m³).
    fn initial_energy(&self, b: &SymTensor) -> f64;
}

impl<L: FiniteElastic> Law for L {
    fn name(&self) -> &'static str {
        L::NAME
    }
}

impl<L: FiniteElastic> PointLaw for L {
    type State = LeftCauchyGreen;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<LeftCauchyGreen>, MaterialError> {
        let b = self.deformation_for_stress(&initial.stress)?;
        Ok(Point { stress: self.cauchy_stress(&b), state: LeftCauchyGreen(b) })
    }

    fn wave_modulus(&self, point: &Point<LeftCauchyGreen>) -> f64 {
        self.max_wave_modulus(&point.state.0, &point.stress)
    }

    fn stored_energy(&self, point: &Point<LeftCauchyGreen>) -> Option<f64> {
        let b = &point.state.0;
        Some(self.initial_energy(b) * (-log_jacobian(b)).exp())
    }
}

impl<L: FiniteElastic> StressUpdate for L {
    #[inline]
    fn update(
        &self,
        motion: &Motion,
        old: &Point<LeftCauchyGreen>,
    ) -> Result<Point<LeftCauchyGreen>, MaterialError> {
        let b = updated_left_cauchy_green(L::NAME, &old.state.0, motion)?;
        Ok(Point { stress: check_finite(L::NAME, self.cauchy_stress(&b))?, state: LeftCauchyGreen(b) })
    }

    fn tangent(&self, motion: &Motion, old: &Point<LeftCauchyGreen>) -> Result<Tangent, MaterialError> {
        let new = self.update(motion, old)?;
        let b = &new.state.0;
        let singular = MaterialError::Motion { model: L::NAME, reason: "the step inverts the point" };
        from_spatial(&self.spatial_tangent(b), motion, log_jacobian(b).exp(), &new.stress).ok_or(singular)
    }

    fn dissipation(
        &self,
        _motion: &Motion,
        _old: &Point<LeftCauchyGreen>,
        _new: &Point<LeftCauchyGreen>,
    ) -> Option<f64> {
        Some(0.0)
    }
}

/// Logarithm `ln J` of `b - 1`, from `J² - 1 = I1 + I2 + I3` of that tensor.
pub(super) fn log_jacobian(b: &SymTensor) -> f64 {
    let i1 = b.trace();
    let i2 = 0.5 * (i1 * i1 - b.dot(b));
    0.5 * (i1 + i2 + b.determinant()).ln_1p()
}

/// Volume change `J - 1` of principal elongations (stretches minus one).
pub(super) fn volume_change(elongations: [f64; 3]) -> f64 {
    let [a, b, c] = elongations;
    a + b + c + a * b + b * c + c * a + a * b * c
}

/// Principal elongations (stretches minus one) from the principal values of `b - 1`.
pub(super) fn elongations(changes: [f64; 3]) -> [f64; 3] {
    changes.map(|b| b / (1.0 + (1.0 + b).sqrt()))
}

/// Tensor `b - 1` after a step.
///
/// # Errors
/// When the motion inverts the point or is not finite.
pub(super) fn updated_left_cauchy_green(
    model: &'static str,
    b: &SymTensor,
    motion: &Motion,
) -> Result<SymTensor, MaterialError> {
    let new = push_forward(b, &motion.deformation);
    // Written so that NaN is rejected.
    if motion.deformation.determinant() > 0.0 && new.is_finite() {
        Ok(new)
    } else {
        Err(MaterialError::Motion { model, reason: "the step inverts the point" })
    }
}

/// Returns the stress, or an error if it is not finite.
pub(super) fn check_finite(model: &'static str, stress: SymTensor) -> Result<SymTensor, MaterialError> {
    if stress.is_finite() {
        Ok(stress)
    } else {
        Err(MaterialError::Motion { model, reason: "the stress is not finite" })
    }
}

/// Tensor `b - 1` that has the Cauchy stress `stress` (Pa). `principal` gives the Kirchhoff stresses of principal elongations, by which
/// Newton's method iterates.
///
/// # Errors
/// When no deformation of moderate size gives the stress.
pub(super) fn solve_deformation(
    model: &'static str,
    stress: &SymTensor,
    elasticity: &Elasticity,
    principal: impl Fn([f64; 3]) -> PrincipalStress,
) -> Result<SymTensor, MaterialError> {
    let refuse = || {
        let reason = "no moderate deformation gives this stress".to_owned();
        MaterialError::Initial { model, reason }
    };
    if !stress.is_finite() {
        return Err(refuse());
    }
    let spectrum = stress.spectrum();
    let small =
        elasticity.strain(&SymTensor::diagonal(spectrum.values[0], spectrum.values[1], spectrum.values[2]));
    let mut strains = [small[0], small[1], small[2]];
    let mut last = f64::INFINITY;
    for _ in 0..50 {
        let at = principal(strains.map(f64::exp_m1));
        let jacobian = strains.iter().sum::<f64>().exp();
        let residual: [f64; 3] = std::array::from_fn(|a| at.stress[a] - jacobian * spectrum.values[a]);
        let size = residual.iter().fold(0.0, |m: f64, r| m.max(r.abs()));
        if size == 0.0 || (size >= last && size <= 1e-12 * stress.norm()) {
            return Ok(spectrum.compose(strains.map(|e| (2.0 * e).exp_m1())));
        }
        last = size;
        let slope = Mat3(std::array::from_fn(|a| {
            std::array::from_fn(|b| at.slope[a][b] - jacobian * spectrum.values[a])
        }));
        let step = slope.inverse().ok_or_else(refuse)?.apply(residual);
        let largest = step.iter().fold(0.0, |m: f64, s| m.max(s.abs()));
        let factor = if largest > 0.2 { 0.2 / largest } else { 1.0 };
        strains = std::array::from_fn(|a| strains[a] - factor * step[a]);
        if !strains.iter().all(|e| e.abs() < 2.0) {
            return Err(refuse());
        }
    }
    Err(refuse())
}
