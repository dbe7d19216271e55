//! Co-rotational adapter: an objective stress update from a small-strain law.

use crate::contract::component_arrays::{ComponentArrays, Rotations};
use crate::contract::elasticity::Elasticity;
use crate::contract::tangent::numerical_tangent;
use crate::return_maps::substepping;
use crate::return_maps::substepping::{SubstepResult, substepped};
use crate::{
    BatchError, InitialCondition, Law, Mat3, MaterialError, Motion, MotionBlock, Point, PointLaw,
    SmallStrain, StressUpdate, SymTensor, Tangent,
};

/// Objective stress update from a [`SmallStrain`] law (sheet: constitutive §3.2). The stress is rotated by half the Hughes–Winget rotation
/// of the step, updated with the strain increment, and rotated by the other half. Second-order accurate, exact for a rigid step, and keeps
/// the yield condition of isotropic laws. Steps larger than [`SmallStrain::max_strain_increment`] are divided (§3.8).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corotational<L>(pub L);

/// Upper bound of the strain increment of a step.
const MAX_STRAIN_INCREMENT: f64 = 1.0 - f64::EPSILON;

/// Half of the Hughes–Winget rotation `Q = (1 - W/2)⁻¹(1 + W/2)` of the spin increment `W = dt W`:
/// `Q_h² = Q` to machine precision. `None` where there is no spin.
#[inline]
pub fn half_rotation(gradient: &Mat3) -> Option<Mat3> {
    let g = &gradient.0;
    // Axial vector of the skew part.
    let w = [0.5 * (g[2][1] - g[1][2]), 0.5 * (g[0][2] - g[2][0]), 0.5 * (g[1][0] - g[0][1])];
    let square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
    if square == 0.0 {
        return None;
    }
    // tan of a quarter of the rotation angle, per unit of the axial vector.
    let t2 = 0.25 * square;
    let factor = 0.5 / (1.0 + (1.0 + t2).sqrt());
    let a = w.map(|c| factor * c);
    let a2 = factor * factor * square;
    // Cayley map of the axial vector a = tan(angle/2) axis: Q_h = 1 + 2/(1+a²) (X + X²).
    let c = 2.0 / (1.0 + a2);
    Some(Mat3([
        [1.0 - c * (a[1] * a[1] + a[2] * a[2]), c * (a[0] * a[1] - a[2]), c * (a[0] * a[2] + a[1])],
        [c * (a[0] * a[1] + a[2]), 1.0 - c * (a[0] * a[0] + a[2] * a[2]), c * (a[1] * a[2] - a[0])],
        [c * (a[0] * a[2] - a[1]), c * (a[1] * a[2] + a[0]), 1.0 - c * (a[0] * a[0] + a[1] * a[1])],
    ]))
}

impl<L: SmallStrain> Corotational<L> {
    /// Advances the law by one step in the co-rotating frame.
    #[inline]
    fn advance(
        &self,
        strain: &SymTensor,
        motion: &Motion,
        old: &Point<L::State>,
    ) -> Result<Point<L::State>, MaterialError> {
        let largest = self.0.max_strain_increment();
        if strain.dot(strain) <= largest * largest {
            match self.0.update(strain, motion, old) {
                Err(MaterialError::NotConverged { .. }) => {}
                result => return result,
            }
        }
        Ok(self.substepped(strain, motion, old)?.point)
    }

    /// Advances the law in sub-steps and adds up the dissipated work.
    #[cold]
    fn substepped(
        &self,
        strain: &SymTensor,
        motion: &Motion,
        old: &Point<L::State>,
    ) -> Result<SubstepResult<L::State>, MaterialError> {
        let whole = strain.norm();
        substepped(self.0.name(), strain, self.0.max_strain_increment(), old, |part, from| {
            let share = part.norm() / whole;
            let motion = Motion {
                velocity_gradient_dt: motion.velocity_gradient_dt * share,
                dt: motion.dt * share,
                ..*motion
            };
            let point = self.0.update(part, &motion, from)?;
            let dissipated_work = self.0.dissipation(part, &motion, from, &point).unwrap_or(0.0);
            Ok(SubstepResult { point, dissipated_work })
        })
    }

    /// Whether the strain increment exceeds the maximum of the law, so that the step is divided into sub-steps.
    fn needs_substeps(&self, strain: &SymTensor) -> bool {
        substepping::substep_count(strain, self.0.max_strain_increment()) > 1
    }

    /// Point rotated by `rotation`: stress and tensorial state.
    #[inline]
    fn rotated(&self, point: &Point<L::State>, rotation: &Mat3) -> Point<L::State> {
        let mut turned = Point { stress: point.stress.rotated(rotation), state: point.state.clone() };
        self.0.rotate_state(&mut turned.state, rotation);
        turned
    }

    /// Returns an error if a stress component is NaN or infinite.
    #[inline]
    fn check_finite(&self, stress: &SymTensor) -> Result<(), MaterialError> {
        // NaN and infinity make the sum NaN.
        if stress.0.iter().sum::<f64>() * 0.0 == 0.0 {
            Ok(())
        } else {
            Err(MaterialError::Motion { model: self.0.name(), reason: "the stress is not finite" })
        }
    }

    /// Updates the points of a batch one after another, for batches in which the motion of a point is invalid.
    #[cold]
    fn update_each(
        &self,
        motion: &dyn Fn(usize) -> Motion,
        stresses: &[SymTensor],
        states: &[L::State],
    ) -> Result<(), BatchError> {
        for (index, (stress, state)) in stresses.iter().zip(states).enumerate() {
            let old = Point { stress: *stress, state: state.clone() };
            self.update(&motion(index), &old).map_err(|source| BatchError { index, source })?;
        }
        Ok(())
    }

    /// Updates a batch of points. Rotations are computed for all points together, and so is the law if it has a variant for batches.
    fn update_all(
        &self,
        lanes: &mut ComponentArrays,
        motion: &dyn Fn(usize) -> Motion,
        stresses: &mut [SymTensor],
        states: &mut [L::State],
    ) -> Result<(), BatchError> {
        let mut rotations = Rotations::EMPTY;
        let small = lanes.strains_are_within(self.0.max_strain_increment().min(MAX_STRAIN_INCREMENT));
        if !small && !lanes.strains_are_within(MAX_STRAIN_INCREMENT) {
            return self.update_each(motion, stresses, states);
        }
        lanes.half_rotations(&mut rotations);
        rotations.rotate_stresses(&mut lanes.stress);
        if !(small && self.0.update_component_arrays(lanes, states)) {
            for (index, state) in states.iter_mut().enumerate() {
                let (motion, rotation) = (motion(index), rotations.rotation(index));
                let mut old = Point { stress: lanes.stress_of(index), state: state.clone() };
                self.0.rotate_state(&mut old.state, &rotation);
                let new = self.advance(&motion.strain_increment(), &motion, &old);
                let mut new = new.map_err(|source| BatchError { index, source })?;
                self.0.rotate_state(&mut new.state, &rotation);
                lanes.set_stress(index, &new.stress);
                *state = new.state;
            }
        }
        rotations.rotate_stresses(&mut lanes.stress);
        for (index, stress) in stresses.iter_mut().enumerate() {
            *stress = lanes.stress_of(index);
            self.check_finite(stress).map_err(|source| BatchError { index, source })?;
        }
        Ok(())
    }
}

impl<L: SmallStrain> Law for Corotational<L> {
    fn name(&self) -> &'static str {
        self.0.name()
    }

    fn is_isotropic(&self) -> bool {
        self.0.is_isotropic()
    }

    fn stress_tolerance(&self) -> f64 {
        self.0.stress_tolerance()
    }

    fn is_hypoelastic(&self) -> bool {
        true
    }

    fn is_time_dependent(&self) -> bool {
        self.0.is_time_dependent()
    }

    fn output_names(&self) -> &[&'static str] {
        self.0.output_names()
    }
}

impl<L: SmallStrain> PointLaw for Corotational<L> {
    type State = L::State;

    fn linear_elasticity(&self) -> Option<&Elasticity> {
        self.0.linear_elasticity()
    }

    fn initial(&self, initial: &InitialCondition) -> Result<Point<L::State>, MaterialError> {
        self.0.initial(initial)
    }

    fn wave_modulus(&self, point: &Point<L::State>) -> f64 {
        self.0.wave_modulus(point)
    }

    fn yield_value(&self, point: &Point<L::State>) -> Option<f64> {
        self.0.yield_value(point)
    }

    fn stored_energy(&self, point: &Point<L::State>) -> Option<f64> {
        self.0.stored_energy(point)
    }

    fn viscosity(&self, point: &Point<L::State>) -> f64 {
        self.0.viscosity(point)
    }

    fn outputs(&self, point: &Point<L::State>, out: &mut [f64]) {
        self.0.outputs(point, out);
    }
}

impl<L: SmallStrain> StressUpdate for Corotational<L> {
    #[inline]
    fn update(&self, motion: &Motion, old: &Point<L::State>) -> Result<Point<L::State>, MaterialError> {
        let strain = motion.strain_increment();
        // One comparison for all components: NaN and infinity make the sum NaN.
        if !((motion.velocity_gradient_dt.0.as_flattened().iter().sum::<f64>() * 0.0) == 0.0) {
            return Err(MaterialError::Motion { model: self.0.name(), reason: "the motion is not finite" });
        }
        if strain.dot(&strain) >= 1.0 {
            return Err(MaterialError::Motion {
                model: self.0.name(),
                reason: "a strain of more than 1 in one step",
            });
        }
        let Some(half) = half_rotation(&motion.velocity_gradient_dt) else {
            let new = self.advance(&strain, motion, old)?;
            return self.check_finite(&new.stress).map(|()| new);
        };
        let mut new = self.advance(&strain, motion, &self.rotated(old, &half))?;
        new.stress = new.stress.rotated(&half);
        self.0.rotate_state(&mut new.state, &half);
        self.check_finite(&new.stress).map(|()| new)
    }

    #[inline]
    fn update_batch(
        &self,
        motions: &[Motion],
        stresses: &mut [SymTensor],
        states: &mut [L::State],
    ) -> Result<(), BatchError> {
        let mut lanes = ComponentArrays::EMPTY;
        lanes.fill(motions, stresses);
        self.update_all(&mut lanes, &|index| motions[index], stresses, states)
    }

    #[inline]
    fn update_block(
        &self,
        motions: &MotionBlock,
        stresses: &mut [SymTensor],
        states: &mut [L::State],
    ) -> Result<(), BatchError> {
        let mut lanes = ComponentArrays::EMPTY;
        lanes.fill_from_block(motions, stresses);
        self.update_all(&mut lanes, &|index| motions.motion(index), stresses, states)
    }

    fn tangent(&self, motion: &Motion, old: &Point<L::State>) -> Result<Tangent, MaterialError> {
        let strain = motion.strain_increment();
        let analytic = match half_rotation(&motion.velocity_gradient_dt) {
            _ if self.needs_substeps(&strain) => None,
            None => self.0.tangent(&strain, motion, old),
            // The spin is fixed, so that its rotation is that of the stress rows alone.
            Some(half) => {
                self.0.tangent(&strain, motion, &self.rotated(old, &half)).map(|t| t.rotated(&half))
            }
        };
        match analytic {
            Some(tangent) => Ok(tangent),
            None => numerical_tangent(motion, |m| self.update(m, old).map(|p| p.stress)),
        }
    }

    fn dissipation(&self, motion: &Motion, old: &Point<L::State>, new: &Point<L::State>) -> Option<f64> {
        let strain = motion.strain_increment();
        let rotation = half_rotation(&motion.velocity_gradient_dt).unwrap_or(Mat3::IDENTITY);
        let (old, new) = (self.rotated(old, &rotation), self.rotated(new, &rotation.transpose()));
        let whole = self.0.dissipation(&strain, motion, &old, &new)?;
        if self.needs_substeps(&strain) {
            return Some(self.substepped(&strain, motion, &old).ok()?.dissipated_work);
        }
        Some(whole)
    }
}

/// One-term spin update `σ + ΔW σ - σ ΔW`, followed by the small-strain law: Algorithms 1 and 2 of Bui & Nguyen 2021 with the sign
/// corrected (sheet: constitutive §3.2). For comparison only: a full turn in steps of ten degrees ends at twice the stress, and the yield
/// condition is not kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstOrderSpin<L>(pub L);

impl<L: SmallStrain> Law for FirstOrderSpin<L> {
    fn name(&self) -> &'static str {
        self.0.name()
    }

    fn is_isotropic(&self) -> bool {
        self.0.is_isotropic()
    }

    fn stress_tolerance(&self) -> f64 {
        self.0.stress_tolerance()
    }

    fn is_hypoelastic(&self) -> bool {
        true
    }

    fn is_time_dependent(&self) -> bool {
        self.0.is_time_dependent()
    }
}

impl<L: SmallStrain> PointLaw for FirstOrderSpin<L> {
    type State = L::State;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<L::State>, MaterialError> {
        self.0.initial(initial)
    }

    fn wave_modulus(&self, point: &Point<L::State>) -> f64 {
        self.0.wave_modulus(point)
    }
}

impl<L: SmallStrain> StressUpdate for FirstOrderSpin<L> {
    fn update(&self, motion: &Motion, old: &Point<L::State>) -> Result<Point<L::State>, MaterialError> {
        let (spin, stress) = (motion.velocity_gradient_dt.skew(), old.stress.to_matrix());
        // W σ - σ W is symmetric, and twice the symmetric part of W σ.
        let turned = Point { stress: old.stress + (spin * stress).sym() * 2.0, state: old.state.clone() };
        self.0.update(&motion.strain_increment(), motion, &turned)
    }
}
