//! Finite-strain adapter: multiplicative plasticity in principal logarithmic strains.

mod batch;
mod planar;
mod series;

use serde::{Deserialize, Serialize};

use crate::contract::elasticity::Elasticity;
use crate::contract::tangent::{from_spatial, kirchhoff_tangent, numerical_tangent, shear_moduli};
use crate::return_maps::substepping;
use crate::return_maps::substepping::substepped_motion;
use crate::{
    BatchError, InitialCondition, Law, Mat3, MaterialError, Motion, MotionBlock, Point, PointLaw,
    SmallStrain, Spectrum, StressUpdate, SymTensor, Tangent,
};

pub use crate::adapters::hencky::batch::SimdBatch;
pub(crate) use crate::adapters::hencky::batch::{any_nonzero, push_forward_in_plane, select};
pub use crate::adapters::hencky::planar::{InvariantReturn, ReturnResult, StressInvariants};

/// Return map in principal stresses, of a law with linear elasticity. The map serves both the
/// rate form and, through [`Hencky`], finite strain.
pub trait PrincipalReturn: SmallStrain {
    /// Constants of the linear elasticity of the law.
    fn elasticity(&self) -> &Elasticity;

    /// Principal stresses and state after the elastic trial `trial` (Pa, descending).
    ///
    /// # Errors
    /// When the local solve fails.
    fn return_principal(
        &self,
        trial: [f64; 3],
        state: &Self::State,
    ) -> Result<([f64; 3], Self::State), MaterialError>;

    /// Whether [`PrincipalReturn::return_batch`] is implemented.
    fn supports_batch(&self) -> bool {
        false
    }

    /// Return map of several trial stresses that keeps the principal directions of the trial deviators. Stresses and states are updated in
    /// place, with the same operations for any number of points. States change only where points yield.
    #[inline]
    fn return_batch<const N: usize>(&self, few: &mut SimdBatch<N>, _states: &mut [Self::State; N]) {
        few.fallback = [1.0; N];
    }

    /// Tangent `∂σ_A/∂ε_B` of the principal stresses with respect to the principal trial strains (Pa); `None` if the law has no closed
    /// form.
    fn principal_tangent(&self, _trial: [f64; 3], _state: &Self::State) -> Option<[[f64; 3]; 3]> {
        None
    }
}

/// Small-strain tangent (eq. 3.11) of a law that returns in principal stresses, at the elastic trial.
pub(crate) fn small_strain_tangent<L: PrincipalReturn>(
    law: &L,
    trial: &SymTensor,
    state: &L::State,
) -> Option<Tangent> {
    let spectrum = trial.spectrum();
    let block = law.principal_tangent(spectrum.values, state)?;
    let (stress, _) = law.return_principal(spectrum.values, state).ok()?;
    let strains = spectrum.values.map(|s| s / (2.0 * law.elasticity().shear_modulus));
    Some(Tangent::spectral(&spectrum, &block, shear_moduli(stress, strains, &block)))
}

/// Adapter of a law with linear elasticity to finite strain (sheet: constitutive §3.3). The elastic left Cauchy–Green tensor is pushed
/// forward by the step, and its logarithm is the elastic strain. The return map works on Kirchhoff stresses `τ = J σ`, on which the
/// strengths act.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hencky<L>(pub L);

/// State of a [`Hencky`] law.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HenckyState<S> {
    /// Elastic left Cauchy–Green tensor minus the unit tensor, `b - 1`, which resolves small strains without cancellation.
    pub elastic: SymTensor,
    /// Volume ratio `J`, current over initial volume.
    pub jacobian: f64,
    /// Internal variables of the inner law.
    pub inner_state: S,
}

/// Principal stresses (Pa) from principal logarithmic strains.
fn stresses(elasticity: &Elasticity, strains: [f64; 3]) -> [f64; 3] {
    let volumetric = elasticity.lame() * strains.iter().sum::<f64>();
    strains.map(|e| volumetric + 2.0 * elasticity.shear_modulus * e)
}

/// Principal logarithmic strains from principal stresses (Pa).
fn strains(elasticity: &Elasticity, stresses: [f64; 3]) -> [f64; 3] {
    let mean = stresses.iter().sum::<f64>() / 3.0;
    stresses.map(|s| (s - mean) / (2.0 * elasticity.shear_modulus) + mean / (3.0 * elasticity.bulk_modulus))
}

/// Push-forward `f (1 + b) fᵀ - 1` of a left Cauchy–Green tensor minus the unit tensor.
#[inline(always)]
pub(crate) fn push_forward(elastic: &SymTensor, step: &Mat3) -> SymTensor {
    let change = *step - Mat3::IDENTITY;
    let [[a, b, c], [d, e, f], [g, h, k]] = change.0;
    let square = SymTensor([
        a * a + b * b + c * c,
        d * d + e * e + f * f,
        g * g + h * h + k * k,
        a * d + b * e + c * f,
        d * g + e * h + f * k,
        g * a + h * b + k * c,
    ]);
    elastic.rotated(step) + change.sym() * 2.0 + square
}

/// Wave modulus (Pa) of a stressed point, `max (c_AAAA + τ_A) / J` (sheet: constitutive §3.9), at least `(λ + 2μ) / J`. `elastic` is that
/// of the unstressed material.
#[inline(always)]
fn wave_modulus(elastic: f64, stress: &SymTensor, jacobian: f64) -> f64 {
    let planar = stress.lies_in_plane();
    let smallest =
        if planar { stress.least_principal_value_in_plane() } else { stress.least_principal_value() };
    elastic / jacobian - smallest.min(0.0)
}

/// Elastic trial of a step.
struct HenckyTrial {
    elastic: SymTensor,
    spectrum: Spectrum,
    strains: [f64; 3],
    stresses: [f64; 3],
    jacobian: f64,
}

impl<L: PrincipalReturn> Hencky<L> {
    /// Elastic trial state of a step: principal strains (-) and principal stresses (Pa) of the pushed-forward elastic deformation.
    fn trial(
        &self,
        motion: &Motion,
        old: &Point<HenckyState<L::State>>,
    ) -> Result<HenckyTrial, MaterialError> {
        let invalid = |reason| MaterialError::Motion { model: self.0.name(), reason };
        let stretch = motion.deformation.determinant();
        // Written so that NaN is rejected.
        if !(stretch > 0.0 && stretch.is_finite() && motion.deformation.is_finite()) {
            return Err(invalid("the step inverts the point"));
        }
        let elastic = push_forward(&old.state.elastic, &motion.deformation);
        let spectrum = elastic.spectrum();
        if !(spectrum.values[2] > -1.0) {
            return Err(invalid("the elastic deformation is singular"));
        }
        let strains = spectrum.values.map(|b| 0.5 * b.ln_1p());
        let stresses = stresses(self.0.elasticity(), strains);
        Ok(HenckyTrial { elastic, spectrum, strains, stresses, jacobian: old.state.jacobian * stretch })
    }

    /// Updates a point by the step without sub-steps.
    ///
    /// # Errors
    /// As [`StressUpdate::update`].
    #[inline]
    pub fn single_step(
        &self,
        motion: &Motion,
        old: &Point<HenckyState<L::State>>,
    ) -> Result<Point<HenckyState<L::State>>, MaterialError> {
        if motion.deformation == Mat3::IDENTITY {
            return Ok(old.clone());
        }
        if self.0.supports_batch()
            && let Some(new) = self.update_point(motion, old)
        {
            return Ok(new);
        }
        let HenckyTrial { elastic, spectrum, stresses, jacobian, .. } = self.trial(motion, old)?;
        let (stress, inner_state) = self.0.return_principal(stresses, &old.state.inner_state)?;
        let elastic = if stress == stresses {
            elastic
        } else {
            spectrum.compose(strains(self.0.elasticity(), stress).map(|e| (2.0 * e).exp_m1()))
        };
        let stress = spectrum.compose(stress) * (1.0 / jacobian);
        if !stress.is_finite() {
            return Err(MaterialError::Motion { model: self.0.name(), reason: "the stress is not finite" });
        }
        Ok(Point { stress, state: HenckyState { elastic, jacobian, inner_state } })
    }

    /// Dissipated work of a step without sub-steps, per current volume (J/m³); `None` if the trial state or the return fails.
    fn single_step_dissipation(
        &self,
        motion: &Motion,
        old: &Point<HenckyState<L::State>>,
        new: &Point<HenckyState<L::State>>,
    ) -> Option<f64> {
        let trial = self.trial(motion, old).ok()?;
        let (stress, _) = self.0.return_principal(trial.stresses, &old.state.inner_state).ok()?;
        let kept = strains(self.0.elasticity(), stress);
        let work: f64 = (0..3).map(|a| stress[a] * (trial.strains[a] - kept[a])).sum();
        Some(work / new.state.jacobian)
    }

    /// Whether the strain increment exceeds the maximum of the law, so that the step is divided into sub-steps.
    fn needs_substeps(&self, motion: &Motion) -> bool {
        substepping::substep_count(&motion.strain_increment(), self.0.max_strain_increment()) > 1
    }
}

impl<L: PrincipalReturn> Law for Hencky<L> {
    fn name(&self) -> &'static str {
        self.0.name()
    }

    fn is_isotropic(&self) -> bool {
        self.0.is_isotropic()
    }

    fn stress_tolerance(&self) -> f64 {
        self.0.stress_tolerance()
    }

    fn output_names(&self) -> &[&'static str] {
        self.0.output_names()
    }
}

impl<L: PrincipalReturn> PointLaw for Hencky<L> {
    type State = HenckyState<L::State>;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<Self::State>, MaterialError> {
        let inner = self.0.initial(initial)?;
        let spectrum = inner.stress.spectrum();
        let elastic = strains(self.0.elasticity(), spectrum.values).map(|e| (2.0 * e).exp_m1());
        let state =
            HenckyState { elastic: spectrum.compose(elastic), jacobian: 1.0, inner_state: inner.state };
        Ok(Point { stress: inner.stress, state })
    }

    fn wave_modulus(&self, point: &Point<Self::State>) -> f64 {
        wave_modulus(self.0.elasticity().p_wave_modulus(), &point.stress, point.state.jacobian)
    }

    fn wave_moduli_batch(&self, stresses: &[SymTensor], states: &[Self::State], out: &mut [f64]) {
        let elastic = self.0.elasticity().p_wave_modulus();
        let groups = stresses.chunks(batch::WIDTH).zip(states.chunks(batch::WIDTH));
        for ((stresses, states), out) in groups.zip(out.chunks_mut(batch::WIDTH)) {
            batch::wave_moduli(elastic, stresses, states, out);
        }
    }

    fn yield_value(&self, point: &Point<Self::State>) -> Option<f64> {
        let stress = point.stress * point.state.jacobian;
        self.0.yield_value(&Point { stress, state: point.state.inner_state.clone() })
    }

    fn stored_energy(&self, point: &Point<Self::State>) -> Option<f64> {
        let stress = point.stress * point.state.jacobian;
        Some(self.0.elasticity().energy(&stress) / point.state.jacobian)
    }

    fn outputs(&self, point: &Point<Self::State>, out: &mut [f64]) {
        let stress = point.stress * point.state.jacobian;
        self.0.outputs(&Point { stress, state: point.state.inner_state.clone() }, out);
    }
}

impl<L: PrincipalReturn> StressUpdate for Hencky<L> {
    #[inline]
    fn update(&self, motion: &Motion, old: &Point<Self::State>) -> Result<Point<Self::State>, MaterialError> {
        let (strain, largest) = (motion.strain_increment(), self.0.max_strain_increment());
        if strain.dot(&strain) <= largest * largest {
            match self.single_step(motion, old) {
                Err(MaterialError::NotConverged { .. }) => {}
                result => return result,
            }
        }
        substepped_motion(motion, largest, old, |part, from| self.single_step(part, from))
    }

    /// Updates several points, together if the law has a variant for batches, else one after another.
    #[inline]
    fn update_batch(
        &self,
        motions: &[Motion],
        stresses: &mut [SymTensor],
        states: &mut [Self::State],
    ) -> Result<(), BatchError> {
        if self.0.supports_batch() {
            let largest = self.0.max_strain_increment();
            let steps = |first, count, to: &mut _| {
                batch::deformation_components(&motions[first..first + count], largest, to)
            };
            return self.update_all(steps, |index| motions[index], stresses, states);
        }
        for (index, ((motion, stress), state)) in motions.iter().zip(stresses).zip(states).enumerate() {
            self.update_one(motion, stress, state).map_err(|source| BatchError { index, source })?;
        }
        Ok(())
    }

    #[inline]
    fn update_block(
        &self,
        motions: &MotionBlock,
        stresses: &mut [SymTensor],
        states: &mut [Self::State],
    ) -> Result<(), BatchError> {
        if self.0.supports_batch() {
            batch::prefetch(states);
            let largest = self.0.max_strain_increment();
            let steps = |first, count, to: &mut _| {
                motions.deformation_components(first, count, to);
                motions.strains_are_within::<{ batch::WIDTH }>(first, count, largest)
            };
            return self.update_all(steps, |index| motions.motion(index), stresses, states);
        }
        let count = stresses.len();
        self.update_batch(&motions.to_array(count)[..count], stresses, states)
    }

    fn tangent(&self, motion: &Motion, old: &Point<Self::State>) -> Result<Tangent, MaterialError> {
        let trial = self.trial(motion, old)?;
        let analytic = || {
            if self.needs_substeps(motion) {
                return None;
            }
            let block = self.0.principal_tangent(trial.stresses, &old.state.inner_state)?;
            let (stress, _) = self.0.return_principal(trial.stresses, &old.state.inner_state).ok()?;
            let squares = trial.spectrum.values.map(|b| 1.0 + b);
            let c = kirchhoff_tangent(&trial.spectrum, stress, squares, &block);
            let cauchy = trial.spectrum.compose(stress) * (1.0 / trial.jacobian);
            from_spatial(&c, motion, trial.jacobian, &cauchy)
        };
        match analytic() {
            Some(tangent) => Ok(tangent),
            None => numerical_tangent(motion, |m| self.update(m, old).map(|p| p.stress)),
        }
    }

    fn dissipation(
        &self,
        motion: &Motion,
        old: &Point<Self::State>,
        new: &Point<Self::State>,
    ) -> Option<f64> {
        if self.needs_substeps(motion) {
            let sum = |part: &Motion, (sum, from): &(f64, Point<Self::State>)| {
                let next = self.single_step(part, from)?;
                let dissipated = self.single_step_dissipation(part, from, &next).unwrap_or(0.0);
                Ok((sum + dissipated, next))
            };
            let parts = substepped_motion(motion, self.0.max_strain_increment(), &(0.0, old.clone()), sum);
            return parts.ok().map(|(sum, _)| sum);
        }
        self.single_step_dissipation(motion, old, new)
    }
}
