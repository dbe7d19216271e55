//! Steps of several points at once at finite strain, for laws whose return keeps the directions of the trial. The
//! operations on a point are the same however many stand beside it.

use super::series::{LARGEST_EXP, LARGEST_LOG, exp_less_one, half_log};
use super::{Hencky, HenckyState, PrincipalReturn, carried};
use crate::{BatchError, Mat3, Motion, Point, StressUpdate, SymTensor};

/// Points that are taken at once.
pub(super) const WIDTH: usize = 8;

/// Stresses of several points and what a law makes of them: [`PrincipalReturn::return_few`].
pub struct Few<const N: usize> {
    /// Kirchhoff stresses (Pa), trial at first, component by component.
    pub stress: [[f64; N]; 6],
    /// One for points that yield, else zero.
    pub yields: [f64; N],
    /// One for points that the law leaves to [`PrincipalReturn::return_principal`], else zero.
    pub left: [f64; N],
}

impl<const N: usize> Few<N> {
    /// Stress of one point.
    #[inline(always)]
    pub fn stress_of(&self, index: usize) -> SymTensor {
        SymTensor(std::array::from_fn(|c| self.stress[c][index]))
    }

    /// Gives a point its stress.
    #[inline(always)]
    pub fn set_stress(&mut self, index: usize, stress: &SymTensor) {
        for (lane, value) in self.stress.iter_mut().zip(stress.0) {
            lane[index] = value;
        }
    }
}

/// Trials of several points.
struct Trials<const N: usize> {
    deformation: [[f64; N]; 9],
    elastic: [[f64; N]; 6],
    jacobian: [f64; N],
}

#[inline(always)]
fn tensor<const N: usize>(lanes: &[[f64; N]; 6], index: usize) -> SymTensor {
    SymTensor(std::array::from_fn(|c| lanes[c][index]))
}

#[inline(always)]
fn put<const N: usize>(lanes: &mut [[f64; N]; 6], index: usize, value: &SymTensor) {
    for (lane, value) in lanes.iter_mut().zip(value.0) {
        lane[index] = value;
    }
}

/// Whether step and elastic deformation leave the third axis alone.
#[inline]
fn is_planar<S>(motion: &Motion, state: &HenckyState<S>) -> bool {
    let f = &motion.deformation.0;
    [f[0][2], f[1][2], f[2][0], f[2][1], state.elastic[4], state.elastic[5]] == [0.0; 6]
}

impl<L: PrincipalReturn> Hencky<L> {
    /// One step of `N` points, whatever their size, in place; tells which points it leaves as they are, because the
    /// series do not reach so far or the law wants them alone.
    #[inline]
    fn few<const N: usize>(
        &self,
        motions: &[Motion; N],
        stresses: &mut [SymTensor; N],
        states: &mut [HenckyState<L::State>; N],
    ) -> [f64; N] {
        let planar = motions.iter().zip(&*states).filter(|(motion, state)| is_planar(motion, state)).count();
        if planar == N {
            return self.few_of::<N, true>(motions, stresses, states);
        }
        if planar == 0 {
            return self.few_of::<N, false>(motions, stresses, states);
        }
        let mut left = [0.0; N];
        for i in 0..N {
            let (mut stress, mut state) = ([stresses[i]], [states[i].clone()]);
            let alone = self.few::<1>(&[motions[i]], &mut stress, &mut state);
            [stresses[i]] = stress;
            [states[i]] = state;
            left[i] = alone[0];
        }
        left
    }

    #[inline(never)]
    fn few_of<const N: usize, const PLANAR: bool>(
        &self,
        motions: &[Motion; N],
        stresses: &mut [SymTensor; N],
        states: &mut [HenckyState<L::State>; N],
    ) -> [f64; N] {
        let mut trials = Trials { deformation: [[0.0; N]; 9], elastic: [[0.0; N]; 6], jacobian: [0.0; N] };
        for i in 0..N {
            for (lane, value) in trials.deformation.iter_mut().zip(motions[i].deformation.0.as_flattened()) {
                lane[i] = *value;
            }
            put(&mut trials.elastic, i, &states[i].elastic);
            trials.jacobian[i] = states[i].jacobian;
        }
        let mut few = Few { stress: [[0.0; N]; 6], yields: [0.0; N], left: [0.0; N] };
        self.trials::<N, PLANAR>(&mut trials, &mut few);
        let mut inner: [L::State; N] = std::array::from_fn(|i| states[i].inner.clone());
        self.0.return_few(&mut few, &mut inner);
        if few.yields.iter().any(|&yields| yields != 0.0) {
            self.keep::<N, PLANAR>(&mut trials, &mut few);
        }
        for (i, inner) in inner.into_iter().enumerate() {
            let stress = few.stress_of(i) * (1.0 / trials.jacobian[i]);
            if motions[i].deformation == Mat3::IDENTITY {
                few.left[i] = 0.0;
                continue;
            }
            if few.left[i] != 0.0 || !stress.is_finite() {
                few.left[i] = 1.0;
                continue;
            }
            stresses[i] = stress;
            states[i] =
                HenckyState { elastic: tensor(&trials.elastic, i), jacobian: trials.jacobian[i], inner };
        }
        few.left
    }

    /// Elastic trial: `b - 1`, volume and Kirchhoff stress.
    #[inline(never)]
    fn trials<const N: usize, const PLANAR: bool>(&self, trials: &mut Trials<N>, few: &mut Few<N>) {
        let elasticity = self.0.elasticity();
        let (lame, two_mu) = (elasticity.lame(), 2.0 * elasticity.shear_modulus);
        let Trials { deformation: [a, b, c, d, e, f, g, h, k], elastic, jacobian } = trials;
        for i in 0..N {
            let step = if PLANAR {
                Mat3([[a[i], b[i], 0.0], [d[i], e[i], 0.0], [0.0, 0.0, k[i]]])
            } else {
                Mat3([[a[i], b[i], c[i]], [d[i], e[i], f[i]], [g[i], h[i], k[i]]])
            };
            let mut trial = tensor(elastic, i);
            if PLANAR {
                (trial[4], trial[5]) = (0.0, 0.0);
            }
            let trial = carried(&trial, &step);
            let stretch = step.determinant();
            let strain = half_log::<PLANAR>(&trial);
            let stress = strain * two_mu + SymTensor::isotropic(lame * strain.trace());
            // Written so that NaN is left.
            let reached = (trial.dot(&trial) <= LARGEST_LOG) & (stretch > 0.0) & (stretch < f64::MAX);
            put(elastic, i, &trial);
            put(&mut few.stress, i, &stress);
            jacobian[i] *= stretch;
            few.left[i] = if reached { 0.0 } else { 1.0 };
        }
    }

    /// Elastic deformation that belongs to the stress of the points that yield.
    #[inline(never)]
    fn keep<const N: usize, const PLANAR: bool>(&self, trials: &mut Trials<N>, few: &mut Few<N>) {
        let elasticity = self.0.elasticity();
        let (per_shear, per_bulk) = (1.0 / elasticity.shear_modulus, 2.0 / (3.0 * elasticity.bulk_modulus));
        for i in 0..N {
            let stress = tensor(&few.stress, i);
            let mean = stress.trace() / 3.0;
            let doubled =
                (stress - SymTensor::isotropic(mean)) * per_shear + SymTensor::isotropic(mean * per_bulk);
            let kept = exp_less_one::<PLANAR>(&doubled);
            let yields = few.yields[i] != 0.0;
            let reached = doubled.dot(&doubled) <= LARGEST_EXP;
            for (lane, value) in trials.elastic.iter_mut().zip(kept.0) {
                lane[i] = if yields { value } else { lane[i] };
            }
            few.left[i] = if yields & !reached { 1.0 } else { few.left[i] };
        }
    }

    /// One step of a point by itself, where the series reach and the law does not leave it.
    #[inline]
    pub(super) fn alone(
        &self,
        motion: &Motion,
        old: &Point<HenckyState<L::State>>,
    ) -> Option<Point<HenckyState<L::State>>> {
        let (mut stress, mut state) = ([old.stress], [old.state.clone()]);
        let [left] = self.few::<1>(&[*motion], &mut stress, &mut state);
        let ([stress], [state]) = (stress, state);
        (left == 0.0).then_some(Point { stress, state })
    }

    /// A batch, [`WIDTH`] points at a time; what the last of these do not fill is not looked at.
    #[inline]
    pub(super) fn together(
        &self,
        motions: &[Motion],
        stresses: &mut [SymTensor],
        states: &mut [HenckyState<L::State>],
    ) -> Result<(), BatchError> {
        let largest = self.0.largest_step();
        let parts = motions.as_chunks::<WIDTH>().0.iter().zip(stresses.as_chunks_mut::<WIDTH>().0);
        for (group, ((motions, stresses), states)) in parts.zip(states.as_chunks_mut::<WIDTH>().0).enumerate()
        {
            let small = |motion: &Motion| {
                let strain = motion.strain_increment();
                strain.dot(&strain) <= largest * largest
            };
            let small = motions.iter().all(small);
            let left = if small { self.few::<WIDTH>(motions, stresses, states) } else { [1.0; WIDTH] };
            for i in (0..WIDTH).filter(|&i| left[i] != 0.0) {
                let index = group * WIDTH + i;
                self.one(&motions[i], &mut stresses[i], &mut states[i])
                    .map_err(|source| BatchError { index, source })?;
            }
        }
        Ok(())
    }

    /// A point of a batch by itself.
    pub(super) fn one(
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
