//! Materials around another material (sheet: constitutive §3.11): common steps before and after the call of the
//! inner law.

use std::sync::Arc;

use serde::{Serialize, de::DeserializeOwned};

use crate::{
    BLOCK_SIZE, BatchError, InitialCondition, Law, Material, MaterialError, Motion, MotionBlock, StateBlock,
    States, SymTensor, Tangent, UpdateCost,
};

/// Modification of an inner material by an outer one, such as an eigenstrain. [`WrappedMaterial`] makes a [`Material`] of it.
pub(crate) trait Wrapper: Send + Sync + 'static {
    /// Internal variables of the wrapper at a point, without those of the inner law.
    type OwnState: Clone + Send + Sync + Serialize + DeserializeOwned + 'static;

    /// Name of the model in a case file.
    const NAME: &'static str;

    /// Internal variables of the wrapper at the start.
    fn start(&self) -> Self::OwnState;

    /// Stress passed to the inner law (Pa) for the stress `stress` of the point.
    fn inner_stress(&self, stress: &SymTensor, own: &Self::OwnState) -> SymTensor;

    /// Stress of the point (Pa) for the stress `inner` of the inner law.
    fn outer_stress(&self, inner: &SymTensor, own: &Self::OwnState) -> SymTensor;

    /// Motion that is passed to the inner law, and internal variables of the wrapper at the end of the step.
    fn step(&self, motion: &Motion, own: &Self::OwnState) -> (Motion, Self::OwnState);

    /// Whether the motion of the point is passed to the inner law without a change.
    const KEEPS_MOTION: bool = false;

    /// Whether the motion passed to the inner law depends on time, see [`crate::Law::is_time_dependent`].
    const TIME_DEPENDENT: bool = false;

    /// Modulus added to the wave modulus of the inner law (Pa).
    fn added_modulus(&self) -> f64 {
        0.0
    }

    /// Tangent of the wrapped material for a step, from the tangent `inner` of the inner law.
    fn tangent(&self, inner: Tangent, _motion: &Motion, _own: &Self::OwnState) -> Tangent {
        inner
    }

    /// Energy stored in addition to that of the inner law (J/m³).
    fn added_energy(&self, _own: &Self::OwnState) -> f64 {
        0.0
    }

    /// Name of the output value of the wrapper, if it has one.
    const OUTPUT: Option<&'static str> = None;

    /// Value of the output that [`Wrapper::OUTPUT`] names.
    fn output(&self, _own: &Self::OwnState) -> f64 {
        0.0
    }
}

/// Material that consists of a wrapper and an inner material.
pub(crate) struct WrappedMaterial<W> {
    wrapper: W,
    inner: Arc<dyn Material>,
    outputs: Vec<&'static str>,
}

impl<W: Wrapper> WrappedMaterial<W> {
    /// Wraps a material; the output of the wrapper follows those of the inner material.
    pub(crate) fn new(wrapper: W, inner: Arc<dyn Material>) -> Self {
        let outputs = inner.output_names().iter().copied().chain(W::OUTPUT).collect();
        Self { wrapper, inner, outputs }
    }

    /// Stresses that are passed to the inner law (Pa).
    fn inner_stresses(&self, stresses: &[SymTensor], own: &[W::OwnState]) -> [SymTensor; BLOCK_SIZE] {
        let mut inner = [SymTensor::ZERO; BLOCK_SIZE];
        for ((slot, stress), own) in inner.iter_mut().zip(stresses).zip(own) {
            *slot = self.wrapper.inner_stress(stress, own);
        }
        inner
    }

    /// Sets the stresses of points from those of the inner law (Pa).
    ///
    /// # Errors
    /// The first point whose stress is not finite.
    fn set_outer_stresses(
        &self,
        stresses: &mut [SymTensor],
        inner: &[SymTensor],
        own: &[W::OwnState],
    ) -> Result<(), BatchError> {
        for (index, ((stress, inner), own)) in stresses.iter_mut().zip(inner).zip(own).enumerate() {
            *stress = self.wrapper.outer_stress(inner, own);
            if !stress.is_finite() {
                let source = MaterialError::Motion { model: W::NAME, reason: "the stress is not finite" };
                return Err(BatchError { index, source });
            }
        }
        Ok(())
    }
}

impl<W: Wrapper> Law for WrappedMaterial<W> {
    fn name(&self) -> &'static str {
        W::NAME
    }

    fn is_isotropic(&self) -> bool {
        self.inner.is_isotropic()
    }

    fn is_hypoelastic(&self) -> bool {
        self.inner.is_hypoelastic()
    }

    fn is_time_dependent(&self) -> bool {
        W::TIME_DEPENDENT || self.inner.is_time_dependent()
    }

    fn stress_tolerance(&self) -> f64 {
        self.inner.stress_tolerance()
    }

    fn update_cost(&self) -> Option<UpdateCost> {
        self.inner.update_cost()
    }

    fn requires_plane_strain(&self) -> bool {
        self.inner.requires_plane_strain()
    }

    fn output_names(&self) -> &[&'static str] {
        &self.outputs
    }
}

impl<W: Wrapper> Material for WrappedMaterial<W> {
    fn initial(&self, initial: &[InitialCondition]) -> Result<(Vec<SymTensor>, States), BatchError> {
        let own = self.wrapper.start();
        let inside = |condition: &InitialCondition| InitialCondition {
            stress: self.wrapper.inner_stress(&condition.stress, &own),
            ..*condition
        };
        let inside: Vec<InitialCondition> = initial.iter().map(inside).collect();
        let (stresses, states) = self.inner.initial(&inside)?;
        let stresses = stresses.iter().map(|stress| self.wrapper.outer_stress(stress, &own)).collect();
        let around = |block: StateBlock| StateBlock::wrap(vec![own.clone(); block.len()], block);
        Ok((stresses, States::from_blocks(states.into_blocks().into_iter().map(around).collect())))
    }

    fn update(
        &self,
        motions: &[Motion],
        stresses: &mut [SymTensor],
        states: &mut StateBlock,
    ) -> Result<(), BatchError> {
        for (index, motion) in motions.iter().enumerate() {
            motion.check(W::NAME).map_err(|source| BatchError { index, source })?;
        }
        let (own, block) = states.own_and_inner_mut::<W::OwnState>();
        let count = stresses.len();
        let mut inner = self.inner_stresses(stresses, own);
        let mut inside = [Motion::AT_REST; BLOCK_SIZE];
        for ((slot, motion), own) in inside.iter_mut().zip(motions).zip(own.iter_mut()) {
            (*slot, *own) = self.wrapper.step(motion, own);
        }
        self.inner.update(&inside[..count], &mut inner[..count], block)?;
        self.set_outer_stresses(stresses, &inner, own)
    }

    fn update_block(
        &self,
        motions: &MotionBlock,
        stresses: &mut [SymTensor],
        states: &mut StateBlock,
    ) -> Result<(), BatchError> {
        let count = stresses.len();
        if !W::KEEPS_MOTION {
            return self.update(&motions.to_array(count)[..count], stresses, states);
        }
        motions.check(W::NAME, count)?;
        let (own, block) = states.own_and_inner_mut::<W::OwnState>();
        let mut inner = self.inner_stresses(stresses, own);
        for (index, own) in own.iter_mut().enumerate() {
            *own = self.wrapper.step(&motions.motion(index), own).1;
        }
        self.inner.update_block(motions, &mut inner[..count], block)?;
        self.set_outer_stresses(stresses, &inner, own)
    }

    fn wave_moduli(&self, stresses: &[SymTensor], states: &StateBlock, out: &mut [f64]) {
        let (own, block) = states.own_and_inner::<W::OwnState>();
        self.inner.wave_moduli(&self.inner_stresses(stresses, own)[..stresses.len()], block, out);
        out.iter_mut().for_each(|modulus| *modulus += self.wrapper.added_modulus());
    }

    fn viscosities(&self, stresses: &[SymTensor], states: &StateBlock, out: &mut [f64]) {
        let (own, block) = states.own_and_inner::<W::OwnState>();
        self.inner.viscosities(&self.inner_stresses(stresses, own)[..stresses.len()], block, out);
    }

    fn stored_energies(&self, stresses: &[SymTensor], states: &StateBlock, out: &mut [f64]) -> bool {
        let (own, block) = states.own_and_inner::<W::OwnState>();
        let inner = self.inner_stresses(stresses, own);
        let defined = self.inner.stored_energies(&inner[..stresses.len()], block, out);
        if defined {
            out.iter_mut().zip(own).for_each(|(energy, own)| *energy += self.wrapper.added_energy(own));
        }
        defined
    }

    fn yield_values(&self, stresses: &[SymTensor], states: &StateBlock, out: &mut [f64]) {
        let (own, block) = states.own_and_inner::<W::OwnState>();
        self.inner.yield_values(&self.inner_stresses(stresses, own)[..stresses.len()], block, out);
    }

    fn outputs(&self, stresses: &[SymTensor], states: &StateBlock, out: &mut [f64]) {
        let (own, block) = states.own_and_inner::<W::OwnState>();
        let inner = self.inner_stresses(stresses, own);
        let width = self.inner.output_names().len();
        if W::OUTPUT.is_none() {
            return self.inner.outputs(&inner[..stresses.len()], block, out);
        }
        // The inner law writes its rows contiguously at the front; they are spread from the back.
        self.inner.outputs(&inner[..stresses.len()], block, &mut out[..stresses.len() * width]);
        for (index, own) in own.iter().enumerate().rev() {
            out.copy_within(index * width..(index + 1) * width, index * (width + 1));
            out[index * (width + 1) + width] = self.wrapper.output(own);
        }
    }

    fn tangent(
        &self,
        motion: &Motion,
        stress: &SymTensor,
        states: &StateBlock,
        index: usize,
    ) -> Result<Tangent, MaterialError> {
        let (own, block) = states.own_and_inner::<W::OwnState>();
        let inner = self.wrapper.inner_stress(stress, &own[index]);
        let (inside, _) = self.wrapper.step(motion, &own[index]);
        let tangent = self.inner.tangent(&inside, &inner, block, index)?;
        Ok(self.wrapper.tangent(tangent, motion, &own[index]))
    }

    fn dissipation(
        &self,
        motion: &Motion,
        old: (&SymTensor, &StateBlock),
        new: (&SymTensor, &StateBlock),
    ) -> Option<f64> {
        let (own, block) = old.1.own_and_inner::<W::OwnState>();
        let (own_new, block_new) = new.1.own_and_inner::<W::OwnState>();
        let (before, after) = (
            self.wrapper.inner_stress(old.0, own.first()?),
            self.wrapper.inner_stress(new.0, own_new.first()?),
        );
        let (inside, _) = self.wrapper.step(motion, own.first()?);
        self.inner.dissipation(&inside, (&before, block), (&after, block_new))
    }

    fn state_size(&self) -> usize {
        size_of::<W::OwnState>() + self.inner.state_size()
    }

    fn save(&self, states: &States) -> Vec<u8> {
        let own: Vec<&W::OwnState> =
            states.blocks().iter().flat_map(|block| block.own_and_inner::<W::OwnState>().0).collect();
        let inner = States::from_blocks(
            states.blocks().iter().map(|b| b.own_and_inner::<W::OwnState>().1.clone()).collect(),
        );
        postcard::to_stdvec(&(own, self.inner.save(&inner)))
            .expect("states of plain numbers always serialise")
    }

    fn load(&self, bytes: &[u8]) -> Option<States> {
        let (own, inner): (Vec<W::OwnState>, Vec<u8>) = postcard::from_bytes(bytes).ok()?;
        let inner = self.inner.load(&inner)?;
        if inner.len() != own.len() {
            return None;
        }
        let parts = own.chunks(BLOCK_SIZE).zip(inner.into_blocks());
        Some(States::from_blocks(parts.map(|(own, block)| StateBlock::wrap(own.to_vec(), block)).collect()))
    }
}
