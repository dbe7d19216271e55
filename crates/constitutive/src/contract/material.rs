//! Type-erased, batched interface of a law for solvers.

use std::any::Any;
use std::fmt;

use crate::{
    BatchError, InitialCondition, Law, MaterialError, Motion, MotionBlock, Point, PointLaw, StressUpdate,
    SymTensor, Tangent,
};

/// Number of points in a block of [`States`], which a material updates in one call. A block's motions fit in the first-level cache.
pub const BLOCK_SIZE: usize = 64;

/// States of up to [`BLOCK_SIZE`] points, with the type erased.
pub struct StateBlock(Box<dyn ErasedBlock>);

/// States of all points of one material, in blocks of [`BLOCK_SIZE`].
///
/// Blocks can be given to different threads (`blocks_mut`), reordered with the points
/// ([`States::permuted`]), cloned, and saved through the material that made them.
#[derive(Debug, Default)]
pub struct States {
    blocks: Vec<StateBlock>,
    len: usize,
}

/// State block of any material, with the type of the states erased.
trait ErasedBlock: Any + Send + Sync {
    /// Copy of the block in a new box.
    fn clone_box(&self) -> Box<dyn ErasedBlock>;
    /// Copies the states of another block into the existing memory; false, without a change, if the other block is of another material.
    fn copy_from(&mut self, other: &StateBlock) -> bool;
    fn len(&self) -> usize;
    /// Block with the states of the points with indices `order` in all `blocks`.
    fn gather(&self, blocks: &[&StateBlock], order: &[u32]) -> Box<dyn ErasedBlock>;
    /// Block as `Any`, to downcast it to the type of the states.
    fn as_any(&self) -> &dyn Any;
    /// Mutable block as `Any`, to downcast it to the type of the states.
    fn as_any_mut(&mut self) -> &mut dyn Any;
}

impl<S: Clone + Send + Sync + 'static> ErasedBlock for Vec<S> {
    fn clone_box(&self) -> Box<dyn ErasedBlock> {
        Box::new(self.clone())
    }
    fn copy_from(&mut self, other: &StateBlock) -> bool {
        let other = other.0.as_any().downcast_ref::<Self>();
        other.inspect(|other| self.clone_from(other)).is_some()
    }
    fn len(&self) -> usize {
        self.len()
    }
    fn gather(&self, blocks: &[&StateBlock], order: &[u32]) -> Box<dyn ErasedBlock> {
        let pick = |&old: &u32| {
            let old = old as usize;
            downcast_states::<S>(blocks[old / BLOCK_SIZE])[old % BLOCK_SIZE].clone()
        };
        Box::new(order.iter().map(pick).collect::<Vec<S>>())
    }
    fn as_any(&self) -> &dyn Any {
        self
    }
    fn as_any_mut(&mut self) -> &mut dyn Any {
        self
    }
}

/// States of a wrapped material: those of the wrapper and those of the inner material.
struct WrappedStates<S> {
    outer_states: Vec<S>,
    inner: StateBlock,
}

impl<S: Clone + Send + Sync + 'static> ErasedBlock for WrappedStates<S> {
    fn clone_box(&self) -> Box<dyn ErasedBlock> {
        Box::new(Self { outer_states: self.outer_states.clone(), inner: self.inner.clone() })
    }
    fn copy_from(&mut self, other: &StateBlock) -> bool {
        let Some(other) = other.0.as_any().downcast_ref::<Self>() else { return false };
        self.outer_states.clone_from(&other.outer_states);
        self.inner.clone_from(&other.inner);
        true
    }
    fn len(&self) -> usize {
        self.outer_states.len()
    }
    fn gather(&self, blocks: &[&StateBlock], order: &[u32]) -> Box<dyn ErasedBlock> {
        let nested: Vec<&Self> = blocks.iter().map(|block| block.nested::<S>()).collect();
        let inner: Vec<&StateBlock> = nested.iter().map(|block| &block.inner).collect();
        let own = order
            .iter()
            .map(|old| nested[*old as usize / BLOCK_SIZE].outer_states[*old as usize % BLOCK_SIZE].clone());
        Box::new(Self { outer_states: own.collect(), inner: StateBlock(self.inner.0.gather(&inner, order)) })
    }
    fn as_any(&self) -> &dyn Any {
        self
    }
    fn as_any_mut(&mut self) -> &mut dyn Any {
        self
    }
}

/// States of a block as the type of the material that made it.
fn downcast_states<S: 'static>(block: &StateBlock) -> &[S] {
    let states = block.0.as_any().downcast_ref::<Vec<S>>();
    states.expect("a state block is only ever used with the material that made it")
}

/// Mutable states of a block; panics if the block is of another material.
fn downcast_states_mut<S: 'static>(block: &mut StateBlock) -> &mut [S] {
    let states = block.0.as_any_mut().downcast_mut::<Vec<S>>();
    states.expect("a state block is only ever used with the material that made it")
}

impl StateBlock {
    /// State block of the given states, one per point.
    fn new<S: Clone + Send + Sync + 'static>(states: Vec<S>) -> Self {
        Self(Box::new(states))
    }

    /// States of a wrapper and its inner material; panics if the block is of another material.
    fn nested<S: 'static>(&self) -> &WrappedStates<S> {
        self.0
            .as_any()
            .downcast_ref()
            .expect("a state block is only ever used with the material that made it")
    }

    /// Block of a wrapped material, from the states of the wrapper and the block of the inner material.
    pub(crate) fn wrap<S: Clone + Send + Sync + 'static>(outer_states: Vec<S>, inner: Self) -> Self {
        Self(Box::new(WrappedStates { outer_states, inner }))
    }

    /// States of the wrapper and the block of the inner material.
    pub(crate) fn own_and_inner<S: 'static>(&self) -> (&[S], &Self) {
        let nested = self.nested::<S>();
        (&nested.outer_states, &nested.inner)
    }

    /// Mutable states of the wrapper and mutable block of the inner material.
    pub(crate) fn own_and_inner_mut<S: 'static>(&mut self) -> (&mut [S], &mut Self) {
        let nested = self.0.as_any_mut().downcast_mut::<WrappedStates<S>>();
        let nested = nested.expect("a state block is only ever used with the material that made it");
        (&mut nested.outer_states, &mut nested.inner)
    }

    /// Number of points in the block.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether the block has no points.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Clone for StateBlock {
    fn clone(&self) -> Self {
        Self(self.0.clone_box())
    }

    fn clone_from(&mut self, other: &Self) {
        if !self.0.copy_from(other) {
            *self = other.clone();
        }
    }
}

impl Clone for States {
    fn clone(&self) -> Self {
        Self { blocks: self.blocks.clone(), len: self.len }
    }

    /// Allocates nothing where `self` has capacity for as many states of the same material.
    fn clone_from(&mut self, other: &Self) {
        self.blocks.clone_from(&other.blocks);
        self.len = other.len;
    }
}

impl fmt::Debug for StateBlock {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "StateBlock({} points)", self.len())
    }
}

impl States {
    /// States of all points, divided into blocks of [`BLOCK_SIZE`] points.
    fn from_points<S: Clone + Send + Sync + 'static>(states: &[S]) -> Self {
        let blocks = states.chunks(BLOCK_SIZE).map(|chunk| StateBlock::new(chunk.to_vec())).collect();
        Self { blocks, len: states.len() }
    }

    /// States from blocks of [`BLOCK_SIZE`] points, the last one possibly shorter.
    pub(crate) fn from_blocks(blocks: Vec<StateBlock>) -> Self {
        let len = blocks.iter().map(StateBlock::len).sum();
        Self { blocks, len }
    }

    /// Blocks of the states in the order of the points.
    pub(crate) fn into_blocks(self) -> Vec<StateBlock> {
        self.blocks
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are no points.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Blocks; all but the last have exactly [`BLOCK_SIZE`] points.
    pub fn blocks(&self) -> &[StateBlock] {
        &self.blocks
    }

    /// Mutable blocks, to be zipped with `chunks_mut(BLOCK_SIZE)` of the other arrays of the points.
    pub fn blocks_mut(&mut self) -> &mut [StateBlock] {
        &mut self.blocks
    }

    /// States in a new order: point `i` of the result is point `order[i]` of `self`.
    #[must_use]
    pub fn permuted(&self, order: &[u32]) -> Self {
        let all: Vec<&StateBlock> = self.blocks.iter().collect();
        Self::gather_from_blocks(&all, order)
    }

    /// States gathered from several state arrays of one material: point `i` of the result is point `k` of `parts[part]`, where `(part, k)`
    /// is `picks[i]`.
    #[must_use]
    pub fn gathered(parts: &[&Self], picks: &[(u32, u32)]) -> Self {
        let all: Vec<&StateBlock> = parts.iter().flat_map(|part| &part.blocks).collect();
        let starts: Vec<u32> = parts
            .iter()
            .scan(0, |next, part| {
                let start = *next;
                *next += (part.blocks.len() * BLOCK_SIZE) as u32;
                Some(start)
            })
            .collect();
        let order: Vec<u32> = picks.iter().map(|&(part, k)| starts[part as usize] + k).collect();
        Self::gather_from_blocks(&all, &order)
    }

    /// States of `self`, followed by those of `other` of the same material.
    #[must_use]
    pub fn followed_by(&self, other: &Self) -> Self {
        let picks = |part: u32, len: usize| (0..len as u32).map(move |k| (part, k));
        let picks: Vec<(u32, u32)> = picks(0, self.len).chain(picks(1, other.len)).collect();
        Self::gathered(&[self, other], &picks)
    }

    /// States of the points with indices `order`, where each block has [`BLOCK_SIZE`] indices, even if it has fewer points.
    fn gather_from_blocks(all: &[&StateBlock], order: &[u32]) -> Self {
        let Some(first) = all.first() else { return Self::default() };
        let blocks = order.chunks(BLOCK_SIZE).map(|part| StateBlock(first.0.gather(all, part))).collect();
        Self { blocks, len: order.len() }
    }
}

/// Law with the type of its state erased, updated a batch at a time. Blanket-implemented for
/// every [`StressUpdate`]; solvers own an `Arc<dyn Material>`.
///
/// In all batch calls `motions`, `stresses` and the block have the same length, at most [`BLOCK_SIZE`].
pub trait Material: Law {
    /// Stresses and states of points that start from `initial`.
    ///
    /// # Errors
    /// The first point whose initial condition is not admissible.
    fn initial(&self, initial: &[InitialCondition]) -> Result<(Vec<SymTensor>, States), BatchError>;

    /// Updates a batch by one step, in place. On error the batch is of no further use: some of its points have been
    /// updated.
    ///
    /// # Errors
    /// The first point that fails.
    fn update(
        &self,
        motions: &[Motion],
        stresses: &mut [SymTensor],
        states: &mut StateBlock,
    ) -> Result<(), BatchError>;

    /// Updates a batch like [`Material::update`], with motions stored in one array per component.
    ///
    /// # Errors
    /// As [`Material::update`].
    fn update_block(
        &self,
        motions: &MotionBlock,
        stresses: &mut [SymTensor],
        states: &mut StateBlock,
    ) -> Result<(), BatchError> {
        let count = stresses.len();
        self.update(&motions.to_array(count)[..count], stresses, states)
    }

    /// Computes upper bounds on the P-wave modulus (Pa), one per point.
    fn wave_moduli(&self, stresses: &[SymTensor], states: &StateBlock, out: &mut [f64]);

    /// Computes effective viscosities (Pa s), one per point.
    fn viscosities(&self, stresses: &[SymTensor], states: &StateBlock, out: &mut [f64]);

    /// Computes recoverable energies per unit current volume (J/m³), zero where not defined. Returns whether
    /// the law defines them.
    fn stored_energies(&self, stresses: &[SymTensor], states: &StateBlock, out: &mut [f64]) -> bool;

    /// Computes yield function values (Pa), `-inf` for laws without one.
    fn yield_values(&self, stresses: &[SymTensor], states: &StateBlock, out: &mut [f64]);

    /// Computes the output values of all points, point by point: `out.len() = points × names`.
    fn outputs(&self, stresses: &[SymTensor], states: &StateBlock, out: &mut [f64]);

    /// Consistent tangent (Pa) of a step from the state of point `index` of the block.
    ///
    /// # Errors
    /// As [`Material::update`].
    fn tangent(
        &self,
        motion: &Motion,
        stress: &SymTensor,
        states: &StateBlock,
        index: usize,
    ) -> Result<Tangent, MaterialError>;

    /// Dissipated work of a step of a single point per unit current volume (J/m³), from `old` to `new`; `None` if the law does not define
    /// it.
    fn dissipation(
        &self,
        motion: &Motion,
        old: (&SymTensor, &StateBlock),
        new: (&SymTensor, &StateBlock),
    ) -> Option<f64>;

    /// Memory of the state of a point (bytes), see [`StressUpdate::state_size`].
    fn state_size(&self) -> usize;

    /// Saves the states as bytes, for a checkpoint.
    fn save(&self, states: &States) -> Vec<u8>;

    /// Loads states from the bytes of [`Material::save`]; `None` for other bytes.
    fn load(&self, bytes: &[u8]) -> Option<States>;
}

/// Rejects an initial stress that is NaN or infinite.
fn check_finite(model: &'static str, initial: &InitialCondition) -> Result<(), MaterialError> {
    if initial.stress.is_finite() {
        return Ok(());
    }
    let reason = format!("the stress must be finite (stress {:?} Pa)", initial.stress.0);
    Err(MaterialError::Initial { model, reason })
}

impl<L: StressUpdate> Material for L {
    fn initial(&self, initial: &[InitialCondition]) -> Result<(Vec<SymTensor>, States), BatchError> {
        let mut stresses = Vec::with_capacity(initial.len());
        let mut states = Vec::with_capacity(initial.len());
        for (index, condition) in initial.iter().enumerate() {
            let start = || PointLaw::initial(self, condition);
            let point = check_finite(self.name(), condition).and_then(|()| start());
            let point = point.map_err(|source| BatchError { index, source })?;
            stresses.push(point.stress);
            states.push(point.state);
        }
        Ok((stresses, States::from_points(&states)))
    }

    fn update(
        &self,
        motions: &[Motion],
        stresses: &mut [SymTensor],
        states: &mut StateBlock,
    ) -> Result<(), BatchError> {
        if !Motion::are_valid(motions) {
            for (index, motion) in motions.iter().enumerate() {
                motion.check(self.name()).map_err(|source| BatchError { index, source })?;
            }
        }
        let done = self.update_batch(motions, stresses, downcast_states_mut::<L::State>(states));
        done.map_err(|error| error.with_step(|index| motions[index], stresses))
    }

    fn update_block(
        &self,
        motions: &MotionBlock,
        stresses: &mut [SymTensor],
        states: &mut StateBlock,
    ) -> Result<(), BatchError> {
        let count = stresses.len();
        motions.check(self.name(), count)?;
        let done =
            StressUpdate::update_block(self, motions, stresses, downcast_states_mut::<L::State>(states));
        done.map_err(|error| error.with_step(|index| motions.motion(index), stresses))
    }

    fn wave_moduli(&self, stresses: &[SymTensor], states: &StateBlock, out: &mut [f64]) {
        PointLaw::wave_moduli_batch(self, stresses, downcast_states::<L::State>(states), out);
    }

    fn viscosities(&self, stresses: &[SymTensor], states: &StateBlock, out: &mut [f64]) {
        update_each::<L>(stresses, states, out, |point| self.viscosity(point));
    }

    fn stored_energies(&self, stresses: &[SymTensor], states: &StateBlock, out: &mut [f64]) -> bool {
        let mut defined = true;
        update_each::<L>(stresses, states, out, |point| {
            self.stored_energy(point).unwrap_or_else(|| {
                defined = false;
                0.0
            })
        });
        defined
    }

    fn yield_values(&self, stresses: &[SymTensor], states: &StateBlock, out: &mut [f64]) {
        update_each::<L>(stresses, states, out, |point| self.yield_value(point).unwrap_or(f64::NEG_INFINITY));
    }

    fn outputs(&self, stresses: &[SymTensor], states: &StateBlock, out: &mut [f64]) {
        let width = self.output_names().len();
        if width == 0 {
            return;
        }
        let states = downcast_states::<L::State>(states);
        for ((stress, state), row) in stresses.iter().zip(states).zip(out.chunks_mut(width)) {
            PointLaw::outputs(self, &Point { stress: *stress, state: state.clone() }, row);
        }
    }

    fn tangent(
        &self,
        motion: &Motion,
        stress: &SymTensor,
        states: &StateBlock,
        index: usize,
    ) -> Result<Tangent, MaterialError> {
        let state = downcast_states::<L::State>(states)[index].clone();
        StressUpdate::tangent(self, motion, &Point { stress: *stress, state })
    }

    fn dissipation(
        &self,
        motion: &Motion,
        old: (&SymTensor, &StateBlock),
        new: (&SymTensor, &StateBlock),
    ) -> Option<f64> {
        let point = |(stress, block): (&SymTensor, &StateBlock)| {
            Some(Point { stress: *stress, state: downcast_states::<L::State>(block).first()?.clone() })
        };
        StressUpdate::dissipation(self, motion, &point(old)?, &point(new)?)
    }

    fn state_size(&self) -> usize {
        StressUpdate::state_size(self)
    }

    fn save(&self, states: &States) -> Vec<u8> {
        let all: Vec<&L::State> = states.blocks.iter().flat_map(downcast_states::<L::State>).collect();
        postcard::to_stdvec(&all).expect("states of plain numbers always serialise")
    }

    fn load(&self, bytes: &[u8]) -> Option<States> {
        let all: Vec<L::State> = postcard::from_bytes(bytes).ok()?;
        Some(States::from_points(&all))
    }
}

/// Evaluates `value` at each point of a block and stores the results in `out`.
fn update_each<L: StressUpdate>(
    stresses: &[SymTensor],
    states: &StateBlock,
    out: &mut [f64],
    mut value: impl FnMut(&Point<L::State>) -> f64,
) {
    for ((stress, state), slot) in stresses.iter().zip(downcast_states::<L::State>(states)).zip(out) {
        *slot = value(&Point { stress: *stress, state: state.clone() });
    }
}
