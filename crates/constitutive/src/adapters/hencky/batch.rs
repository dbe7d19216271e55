//! Steps of several points at once at finite strain, for laws whose return keeps the directions of the trial. The
//! operations on a point do not depend on the number of points in the batch.

use crate::adapters::hencky::series::{MAX_EXP_NORM_SQUARED, MAX_LOG_NORM_SQUARED, exp_minus_one, half_log};
use crate::adapters::hencky::{Hencky, HenckyState, PrincipalReturn, push_forward, wave_modulus};
use crate::contract::component_arrays::{Spectra, set_tensor, tensor};
use crate::{BatchError, Mat3, Motion, Point, StressUpdate, SymTensor};

/// Number of points of a batch.
pub(super) const WIDTH: usize = 16;

/// Stresses of the points of a batch, before and after the return map ([`PrincipalReturn::return_batch`]).
pub struct SimdBatch<const N: usize> {
    /// Kirchhoff stresses (Pa), trial at first, component by component.
    pub stress: [[f64; N]; 6],
    /// Flag of each point: 1 if its trial stress yields, else 0.
    pub is_yielding: [f64; N],
    /// Flag of each point: 1 if the batch cannot return it and [`PrincipalReturn::return_principal`] must, else 0.
    pub fallback: [f64; N],
}

/// Value of [`SimdBatch::fallback`] for a point without motion, whose state is unchanged.
const AT_REST: f64 = 2.0;

impl<const N: usize> SimdBatch<N> {
    /// Converts Kirchhoff to Cauchy stresses and flags points with a non-finite stress and points without motion.
    #[inline(never)]
    fn convert_to_cauchy_stress<const PLANAR: bool>(&mut self, trials: &TrialBatch<'_, N>) {
        let TrialBatch { deformation: [a, b, c, d, e, f, g, h, k], jacobian, .. } = trials;
        for i in 0..N {
            let stress = self.stress_of(i) * (1.0 / jacobian[i]);
            let sum = (stress.0[0] + stress.0[1] + stress.0[2]) + (stress.0[3] + stress.0[4] + stress.0[5]);
            let still = (a[i] == 1.0) & (b[i] == 0.0) & (d[i] == 0.0) & (e[i] == 1.0) & (k[i] == 1.0);
            let across = (c[i] == 0.0) & (f[i] == 0.0) & (g[i] == 0.0) & (h[i] == 0.0);
            self.set_stress(i, &stress);
            // NaN and infinity make the product NaN.
            let left = if sum * 0.0 == 0.0 { self.fallback[i] } else { 1.0 };
            self.fallback[i] = if still & (PLANAR | across) { AT_REST } else { left };
        }
    }

    /// Principal values and directions of the stresses.
    #[inline(always)]
    pub(crate) fn spectra(&self) -> Spectra<N> {
        let mut spectra = Spectra::EMPTY;
        spectra.compute(&self.stress);
        spectra
    }

    /// Stress of point `index` of the batch.
    #[inline(always)]
    pub fn stress_of(&self, index: usize) -> SymTensor {
        tensor(&self.stress, index)
    }

    /// Sets the stress of one point.
    #[inline(always)]
    pub fn set_stress(&mut self, index: usize, stress: &SymTensor) {
        set_tensor(&mut self.stress, index, stress);
    }
}

/// Deformations, elastic states and trial stresses of the points of a batch.
struct TrialBatch<'a, const N: usize> {
    deformation: &'a [[f64; N]; 9],
    elastic: [[f64; N]; 6],
    jacobian: [f64; N],
}

/// Returns `a` if `first` is true, else `b`, without a branch.
#[inline(always)]
pub(crate) fn select(first: bool, a: &SymTensor, b: &SymTensor) -> SymTensor {
    let of = |x: f64, y: f64| if first { x } else { y };
    let (a, b) = (&a.0, &b.0);
    SymTensor([
        of(a[0], b[0]),
        of(a[1], b[1]),
        of(a[2], b[2]),
        of(a[3], b[3]),
        of(a[4], b[4]),
        of(a[5], b[5]),
    ])
}

/// Whether any of the flags is not zero.
#[inline(always)]
pub(crate) fn any_nonzero<const N: usize>(flags: &[f64; N]) -> bool {
    let mut bits = 0;
    for i in 0..N {
        bits |= flags[i].to_bits();
    }
    bits != 0
}

/// Push-forward [`push_forward`] by a step that leaves the third axis unchanged, with the volume ratio of the step.
#[inline(always)]
pub(crate) fn push_forward_in_plane(
    [xx, yy, zz, xy]: [f64; 4],
    [a, b, d, e, k]: [f64; 5],
) -> (SymTensor, f64) {
    let (t0, t1) = (a * xx + b * xy, a * xy + b * yy);
    let (t3, t4) = (d * xx + e * xy, d * xy + e * yy);
    let (along, upward, across) = (a - 1.0, e - 1.0, k - 1.0);
    let trial = SymTensor([
        (t0 * a + t1 * b) + along * 2.0 + (along * along + b * b),
        (t3 * d + t4 * e) + upward * 2.0 + (d * d + upward * upward),
        k * zz * k + across * 2.0 + across * across,
        (t0 * d + t1 * e) + (b + d) + (along * d + b * upward),
        0.0,
        0.0,
    ]);
    (trial, a * (e * k) - b * (d * k))
}

impl<const N: usize> TrialBatch<'_, N> {
    /// Number of steps and elastic deformations that leave the third axis unchanged.
    #[inline(always)]
    fn count_planar(&self) -> usize {
        let ([_, _, c, _, _, f, g, h, _], [_, _, _, _, yz, zx]) = (self.deformation, &self.elastic);
        let mut count = 0;
        for i in 0..N {
            let step = (c[i] == 0.0) & (f[i] == 0.0) & (g[i] == 0.0) & (h[i] == 0.0);
            count += usize::from(step & (yz[i] == 0.0) & (zx[i] == 0.0));
        }
        count
    }
}

/// Array of one component of the points of a batch.
#[inline(always)]
fn component<const N: usize>(of: impl Fn(usize) -> f64) -> [f64; N] {
    let mut lane = [0.0; N];
    for i in 0..N {
        lane[i] = of(i);
    }
    lane
}

/// Copies the components of separate motions to arrays per component, as [`MotionBlock::deformation_components`] does for motions stored
/// that way.
#[inline(always)]
pub(super) fn deformation_components(motions: &[Motion], largest: f64, to: &mut [[f64; WIDTH]; 9]) -> bool {
    let maximum = largest * largest;
    let mut within = true;
    for motion in motions {
        let strain = motion.strain_increment();
        within &= strain.dot(&strain) <= maximum;
    }
    let last = motions.len() - 1;
    for c in 0..9 {
        (0..WIDTH).for_each(|i| to[c][i] = motions[i.min(last)].deformation.0[c / 3][c % 3]);
    }
    within
}

/// Deformations and elastic states of the points of a batch, in one array per component.
#[inline(always)]
fn component_arrays<'a, const N: usize, S>(
    deformation: &'a [[f64; N]; 9],
    states: &[HenckyState<S>; N],
) -> TrialBatch<'a, N> {
    let elastic = |index: usize| component(|i| states[i].elastic.0[index]);
    TrialBatch {
        deformation,
        elastic: [elastic(0), elastic(1), elastic(2), elastic(3), elastic(4), elastic(5)],
        jacobian: component(|i| states[i].jacobian),
    }
}

/// Wave moduli of up to [`WIDTH`] points.
#[inline(always)]
pub(super) fn wave_moduli<S>(
    elastic: f64,
    stresses: &[SymTensor],
    states: &[HenckyState<S>],
    out: &mut [f64],
) {
    let (mut lanes, mut jacobians, mut moduli) = ([[0.0; WIDTH]; 6], [1.0; WIDTH], [0.0; WIDTH]);
    for (i, (stress, state)) in stresses.iter().zip(states).enumerate() {
        set_tensor(&mut lanes, i, stress);
        jacobians[i] = state.jacobian;
    }
    let mut planar = true;
    for i in 0..WIDTH {
        planar &= tensor(&lanes, i).lies_in_plane();
    }
    if planar {
        for i in 0..WIDTH {
            let smallest = tensor(&lanes, i).least_principal_value_in_plane();
            moduli[i] = elastic / jacobians[i] - smallest.min(0.0);
        }
    } else {
        for i in 0..WIDTH {
            moduli[i] = wave_modulus(elastic, &tensor(&lanes, i), jacobians[i]);
        }
    }
    out.copy_from_slice(&moduli[..out.len()]);
}

/// Reads a number at the start and the end of each state, so that the processor loads the memory of all states at the same time.
#[inline(always)]
pub(super) fn prefetch<S>(states: &[HenckyState<S>]) {
    let mut bits = 0;
    for state in states {
        bits |= state.elastic.0[0].to_bits() | state.jacobian.to_bits();
    }
    std::hint::black_box(bits);
}

impl<L: PrincipalReturn> Hencky<L> {
    /// Updates `N` points by one step in place, without sub-steps. The result flags the points that are left unchanged and need the scalar
    /// update.
    #[inline]
    fn step_batch<const N: usize>(
        &self,
        deformation: &[[f64; N]; 9],
        stresses: &mut [SymTensor; N],
        states: &mut [HenckyState<L::State>; N],
    ) -> [f64; N] {
        let mut trials = component_arrays(deformation, states);
        let planar = trials.count_planar();
        if planar == N {
            return self.step_batch_of::<N, true>(&mut trials, stresses, states);
        }
        if planar == 0 {
            return self.step_batch_of::<N, false>(&mut trials, stresses, states);
        }
        let mut left = [0.0; N];
        for i in 0..N {
            let (mut stress, mut state) = ([stresses[i]], [states[i].clone()]);
            let alone = self.step_batch::<1>(&deformation.map(|lane| [lane[i]]), &mut stress, &mut state);
            [stresses[i]] = stress;
            [states[i]] = state;
            left[i] = alone[0];
        }
        left
    }

    /// Updates stresses and states of `N` points together; `PLANAR` omits the out-of-plane shear. Non-zero entries of the result mark
    /// points that the scalar update must repeat.
    #[inline(never)]
    fn step_batch_of<const N: usize, const PLANAR: bool>(
        &self,
        trials: &mut TrialBatch<'_, N>,
        stresses: &mut [SymTensor; N],
        states: &mut [HenckyState<L::State>; N],
    ) -> [f64; N] {
        let mut few = SimdBatch { stress: [[0.0; N]; 6], is_yielding: [0.0; N], fallback: [0.0; N] };
        self.elastic_trials::<N, PLANAR>(trials, &mut few);
        let mut inner: [L::State; N] = std::array::from_fn(|i| states[i].inner_state.clone());
        self.0.return_batch(&mut few, &mut inner);
        let yielding = any_nonzero(&few.is_yielding);
        if yielding {
            self.update_elastic_deformation::<N, PLANAR>(trials, &mut few);
        }
        few.convert_to_cauchy_stress::<PLANAR>(trials);
        for i in 0..N {
            if few.fallback[i] == 0.0 {
                stresses[i] = few.stress_of(i);
                (states[i].elastic, states[i].jacobian) = (tensor(&trials.elastic, i), trials.jacobian[i]);
            }
        }
        if yielding {
            for i in (0..N).filter(|&i| few.fallback[i] == 0.0) {
                states[i].inner_state.clone_from(&inner[i]);
            }
        }
        // A point at rest keeps its state.
        component(|i| if few.fallback[i] == 1.0 { 1.0 } else { 0.0 })
    }

    /// Elastic trial: `b - 1`, volume and Kirchhoff stress.
    #[inline(never)]
    fn elastic_trials<const N: usize, const PLANAR: bool>(
        &self,
        trials: &mut TrialBatch<'_, N>,
        few: &mut SimdBatch<N>,
    ) {
        let elasticity = self.0.elasticity();
        let (lame, two_mu) = (elasticity.lame(), 2.0 * elasticity.shear_modulus);
        let TrialBatch { deformation: [a, b, c, d, e, f, g, h, k], elastic, jacobian } = trials;
        for i in 0..N {
            let old = tensor(elastic, i);
            let (trial, stretch) = if PLANAR {
                push_forward_in_plane(
                    [old.0[0], old.0[1], old.0[2], old.0[3]],
                    [a[i], b[i], d[i], e[i], k[i]],
                )
            } else {
                let step = Mat3([[a[i], b[i], c[i]], [d[i], e[i], f[i]], [g[i], h[i], k[i]]]);
                (push_forward(&old, &step), step.determinant())
            };
            let strain = half_log::<PLANAR>(&trial);
            let stress = strain * two_mu + SymTensor::isotropic(lame * strain.trace());
            // Written so that NaN falls back.
            let reached =
                (trial.dot(&trial) <= MAX_LOG_NORM_SQUARED) & (stretch > 0.0) & (stretch < f64::MAX);
            set_tensor(elastic, i, &trial);
            set_tensor(&mut few.stress, i, &stress);
            jacobian[i] *= stretch;
            few.fallback[i] = if reached { 0.0 } else { 1.0 };
        }
    }

    /// Updates the elastic deformation of the points that yield from their stress.
    #[inline(never)]
    fn update_elastic_deformation<const N: usize, const PLANAR: bool>(
        &self,
        trials: &mut TrialBatch<'_, N>,
        few: &mut SimdBatch<N>,
    ) {
        let elasticity = self.0.elasticity();
        let (per_shear, per_bulk) = (1.0 / elasticity.shear_modulus, 2.0 / (3.0 * elasticity.bulk_modulus));
        let (mut elastic, mut left) = ([[0.0; N]; 6], [0.0; N]);
        for i in 0..N {
            let stress = tensor(&few.stress, i);
            let mean = stress.trace() / 3.0;
            let doubled =
                (stress - SymTensor::isotropic(mean)) * per_shear + SymTensor::isotropic(mean * per_bulk);
            let kept = exp_minus_one::<PLANAR>(&doubled);
            let yields = few.is_yielding[i] != 0.0;
            let reached = doubled.dot(&doubled) <= MAX_EXP_NORM_SQUARED;
            set_tensor(&mut elastic, i, &select(yields, &kept, &tensor(&trials.elastic, i)));
            left[i] = few.fallback[i].max(if yields & !reached { 1.0 } else { 0.0 });
        }
        (trials.elastic, few.fallback) = (elastic, left);
    }

    /// Updates a single point by one step with the arithmetic of the batch; false if the step is too large for the series or the law
    /// requires the scalar update.
    #[inline]
    pub(super) fn update_point(
        &self,
        motion: &Motion,
        old: &Point<HenckyState<L::State>>,
    ) -> Option<Point<HenckyState<L::State>>> {
        let [[a, b, c], [d, e, f], [g, h, k]] = motion.deformation.0;
        let (mut stress, mut state) = ([old.stress], [old.state.clone()]);
        let [left] = self.step_batch(&[[a], [b], [c], [d], [e], [f], [g], [h], [k]], &mut stress, &mut state);
        let ([stress], [state]) = (stress, state);
        (left == 0.0).then_some(Point { stress, state })
    }

    /// Updates a batch, [`WIDTH`] points at a time. `steps` gives the deformations of several points in one array per component and whether
    /// all steps are small enough. `each` gives the motion of a point.
    #[inline]
    pub(super) fn update_all(
        &self,
        steps: impl Fn(usize, usize, &mut [[f64; WIDTH]; 9]) -> bool,
        each: impl Fn(usize) -> Motion,
        stresses: &mut [SymTensor],
        states: &mut [HenckyState<L::State>],
    ) -> Result<(), BatchError> {
        let mut deformation = [[0.0; WIDTH]; 9];
        let groups = stresses.chunks_mut(WIDTH).zip(states.chunks_mut(WIDTH));
        for (group, (stresses, states)) in groups.enumerate() {
            let (first, count) = (group * WIDTH, stresses.len());
            let left = if steps(first, count, &mut deformation) {
                self.update_group(&deformation, stresses, states)
            } else {
                [1.0; WIDTH]
            };
            for i in (0..count).filter(|&i| left[i] != 0.0) {
                let index = first + i;
                self.update_one(&each(index), &mut stresses[i], &mut states[i])
                    .map_err(|source| BatchError { index, source })?;
            }
        }
        Ok(())
    }

    /// Updates up to [`WIDTH`] points; a group with fewer points is filled up with copies of the last one.
    #[inline]
    fn update_group(
        &self,
        deformation: &[[f64; WIDTH]; 9],
        stresses: &mut [SymTensor],
        states: &mut [HenckyState<L::State>],
    ) -> [f64; WIDTH] {
        if let ([stresses], [states]) = (stresses.as_chunks_mut().0, states.as_chunks_mut().0) {
            return self.step_batch::<WIDTH>(deformation, stresses, states);
        }
        let last = stresses.len() - 1;
        let mut some = std::array::from_fn(|i| stresses[i.min(last)]);
        let mut of_some = std::array::from_fn(|i| states[i.min(last)].clone());
        let left = self.step_batch::<WIDTH>(deformation, &mut some, &mut of_some);
        stresses.copy_from_slice(&some[..=last]);
        states.clone_from_slice(&of_some[..=last]);
        left
    }

    /// Updates a single point of a batch.
    pub(super) fn update_one(
        &self,
        motion: &Motion,
        stress: &mut SymTensor,
        state: &mut HenckyState<L::State>,
    ) -> Result<(), crate::MaterialError> {
        let new = self.update(motion, &Point { stress: *stress, state: state.clone() })?;
        *stress = new.stress;
        *state = new.state;
        Ok(())
    }
}
