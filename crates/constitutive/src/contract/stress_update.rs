//! Contract of a material law.

use serde::{Serialize, de::DeserializeOwned};

use crate::contract::component_arrays::ComponentArrays;
use crate::contract::elasticity::Elasticity;
use crate::contract::tangent::numerical_tangent;
use crate::{BatchError, MaterialError, Motion, MotionBlock, SymTensor, Tangent};

/// Material point: Cauchy (effective) stress and internal variables of the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point<S> {
    /// Cauchy stress, effective where there is a pore fluid (Pa, tension-positive).
    pub stress: SymTensor,
    /// Internal variables of the law.
    pub state: S,
}

/// Initial condition of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialCondition {
    /// Initial Cauchy (effective) stress (Pa).
    pub stress: SymTensor,
    /// Initial density (kg/m³).
    pub density: f64,
}

/// Properties of a law that do not depend on the point, common to [`StressUpdate`], [`SmallStrain`] and [`crate::Material`].
pub trait Law: Send + Sync {
    /// Name of the model in a case file.
    fn name(&self) -> &'static str;

    /// Whether the law is isotropic: a rotation of motion, stress and state rotates the new stress.
    fn is_isotropic(&self) -> bool {
        true
    }

    /// Whether the law is in rate form: a step starts from the stress of the point, so that a stress that the method has smoothed is
    /// retained. Other laws compute their stress from the state or the motion alone.
    fn is_hypoelastic(&self) -> bool {
        false
    }

    /// Whether stress or state change with time in a step without motion, as by viscosity.
    fn is_time_dependent(&self) -> bool {
        false
    }

    /// Relative change of stress below the accuracy of the law: implicit solvers and the element driver do not
    /// iterate further.
    fn stress_tolerance(&self) -> f64 {
        0.0
    }

    /// Estimated computing time of a stress update (s); `None` if it is small compared with the rest of a step.
    fn update_cost(&self) -> Option<UpdateCost> {
        None
    }

    /// Whether the law rejects strain out of the plane of x and y.
    fn requires_plane_strain(&self) -> bool {
        false
    }

    /// Names of the output scalars, in the order of [`PointLaw::outputs`].
    fn output_names(&self) -> &[&'static str] {
        &[]
    }
}

/// Approximate computing time of the update of a point on one thread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UpdateCost {
    /// Least time of an update with motion (s).
    pub update: f64,
    /// Time per strain, where that is longer (s).
    pub strain: f64,
}

/// Pointwise quantities of a law, common to [`StressUpdate`] and [`SmallStrain`].
pub trait PointLaw: Law + 'static {
    /// Internal variables of one point (hardening, elastic strain, …): a typed struct.
    type State: Clone + Send + Sync + Serialize + DeserializeOwned + 'static;

    /// Stress and state at the start.
    ///
    /// # Errors
    /// When the initial stress is not admissible for the law.
    fn initial(&self, initial: &InitialCondition) -> Result<Point<Self::State>, MaterialError>;

    /// Upper bound on the P-wave modulus at this state (Pa): the solvers' time-step limit.
    fn wave_modulus(&self, point: &Point<Self::State>) -> f64;

    /// Computes the wave moduli of several points (Pa), equal to [`PointLaw::wave_modulus`].
    #[inline]
    fn wave_moduli_batch(&self, stresses: &[SymTensor], states: &[Self::State], out: &mut [f64]) {
        for ((stress, state), slot) in stresses.iter().zip(states).zip(out) {
            *slot = self.wave_modulus(&Point { stress: *stress, state: state.clone() });
        }
    }

    /// Elastic constants of a law with linear elasticity, from which stored energy and dissipation follow.
    fn linear_elasticity(&self) -> Option<&Elasticity> {
        None
    }

    /// Yield function at the point (Pa), not positive inside the yield surface; `None` for laws without one.
    fn yield_value(&self, _point: &Point<Self::State>) -> Option<f64> {
        None
    }

    /// Effective dynamic viscosity (Pa s), for the viscous time-step limit.
    fn viscosity(&self, _point: &Point<Self::State>) -> f64 {
        0.0
    }

    /// Recoverable energy per unit current volume (J/m³); `None` if the law does not define it.
    fn stored_energy(&self, point: &Point<Self::State>) -> Option<f64> {
        self.linear_elasticity().map(|elasticity| elasticity.energy(&point.stress))
    }

    /// Computes the scalars named by [`Law::output_names`]; `out` has that length.
    fn outputs(&self, _point: &Point<Self::State>, _out: &mut [f64]) {}
}

/// Material law: update of stress and state by the motion of a point.
///
/// `old` is never changed, so an implicit solver can call [`StressUpdate::update`] once per Newton
/// iteration. A law never panics: a failure is a [`MaterialError`].
pub trait StressUpdate: PointLaw {
    /// Updates a point by one step.
    ///
    /// # Errors
    /// When the motion cannot be used or the local solve fails.
    fn update(&self, motion: &Motion, old: &Point<Self::State>) -> Result<Point<Self::State>, MaterialError>;

    /// Updates a batch of at most [`crate::BLOCK_SIZE`] points by one step in place, with the results of [`StressUpdate::update`]. On error
    /// the batch is of no further use.
    ///
    /// # Errors
    /// The first point that fails.
    #[inline]
    fn update_batch(
        &self,
        motions: &[Motion],
        stresses: &mut [SymTensor],
        states: &mut [Self::State],
    ) -> Result<(), BatchError> {
        for (index, ((motion, stress), state)) in motions.iter().zip(stresses).zip(states).enumerate() {
            let old = Point { stress: *stress, state: state.clone() };
            let new = self.update(motion, &old).map_err(|source| BatchError { index, source })?;
            *stress = new.stress;
            *state = new.state;
        }
        Ok(())
    }

    /// Updates a batch like [`StressUpdate::update_batch`], with motions in one array per component.
    ///
    /// # Errors
    /// The first point that fails.
    #[inline]
    fn update_block(
        &self,
        motions: &MotionBlock,
        stresses: &mut [SymTensor],
        states: &mut [Self::State],
    ) -> Result<(), BatchError> {
        let count = stresses.len();
        self.update_batch(&motions.to_array(count)[..count], stresses, states)
    }

    /// Memory of the state of a point (bytes), with its allocations.
    fn state_size(&self) -> usize {
        size_of::<Self::State>()
    }

    /// Consistent tangent of [`StressUpdate::update`]; by central differences unless the law overrides it.
    ///
    /// # Errors
    /// As [`StressUpdate::update`].
    fn tangent(&self, motion: &Motion, old: &Point<Self::State>) -> Result<Tangent, MaterialError> {
        numerical_tangent(motion, |m| self.update(m, old).map(|p| p.stress))
    }

    /// Dissipated work of a step per unit current volume (J/m³). It is never negative for associated flow or for `0 ≤ ψ ≤ φ`.
    fn dissipation(
        &self,
        _motion: &Motion,
        _old: &Point<Self::State>,
        _new: &Point<Self::State>,
    ) -> Option<f64> {
        None
    }
}

/// Small-strain law: stress from a strain increment, in a frame that rotates with the material.
///
/// Implement this and wrap the law in [`crate::Corotational`] to get an objective [`StressUpdate`]. A tensorial internal
/// variable is rotated with the material by [`SmallStrain::rotate_state`].
pub trait SmallStrain: PointLaw {
    /// New stress and state after the strain increment `strain` (tension-positive) over `motion.dt`.
    ///
    /// # Errors
    /// When the local solve fails.
    fn update(
        &self,
        strain: &SymTensor,
        motion: &Motion,
        old: &Point<Self::State>,
    ) -> Result<Point<Self::State>, MaterialError>;

    /// Updates a batch whose strain increments are at most [`SmallStrain::max_strain_increment`], for laws without tensorial state that
    /// compute several points at once. Returns false if the law has no such update.
    #[inline]
    fn update_component_arrays(&self, _lanes: &mut ComponentArrays, _states: &mut [Self::State]) -> bool {
        false
    }

    /// Norm of the strain increment above which a step is divided into sub-steps (sheet: constitutive §3.8). It is infinite for laws that
    /// are exact at any size or divide steps themselves.
    fn max_strain_increment(&self) -> f64 {
        1e-2
    }

    /// Rotates the tensorial internal variables of a law, if it has any.
    #[inline]
    fn rotate_state(&self, _state: &mut Self::State, _rotation: &crate::Mat3) {}

    /// Tangent `∂σ/∂ε` of [`SmallStrain::update`] (Pa); `None` if the law has no closed form.
    fn tangent(&self, _strain: &SymTensor, _motion: &Motion, _old: &Point<Self::State>) -> Option<Tangent> {
        None
    }

    /// Dissipated work (J/m³) between two stresses in the co-rotating frame, see [`StressUpdate::dissipation`]. With linear elasticity it
    /// is the work on the strain between elastic trial and new stress.
    fn dissipation(
        &self,
        strain: &SymTensor,
        _motion: &Motion,
        old: &Point<Self::State>,
        new: &Point<Self::State>,
    ) -> Option<f64> {
        let elasticity = self.linear_elasticity()?;
        let trial = old.stress + elasticity.stress(strain);
        Some(elasticity.dissipation(&trial, &new.stress))
    }
}
