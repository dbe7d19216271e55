//! Common parts of the finite-strain elastic laws (sheet: constitutive §2.13): the left Cauchy–Green tensor as
//! state, its step, and the inverse from a stress to its stretches. Such a law is a [`FiniteElastic`].

use serde::{Deserialize, Serialize};

use super::Elasticity;
use crate::adapters::hencky::{push_forward, push_forward_in_plane};
use crate::contract::component_arrays::{set_tensor, tensor};
use crate::contract::motion::OUT_OF_PLANE_COMPONENTS;
use crate::contract::tangent::from_spatial;
use crate::{
    BLOCK_SIZE, BatchError, InitialCondition, Law, Mat3, MaterialError, Motion, MotionBlock, Point, PointLaw,
    StressUpdate, SymTensor, Tangent,
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

    /// Cauchy stress (Pa) of a tensor with the third axis as principal axis.
    #[inline(always)]
    fn cauchy_stress_in_plane(&self, b: &SymTensor) -> SymTensor {
        self.cauchy_stress(b)
    }

    /// Tensor `b - 1` that has the Cauchy stress `stress` (Pa).
    ///
    /// # Errors
    /// When no deformation of moderate size gives the stress.
    fn deformation_for_stress(&self, stress: &SymTensor) -> Result<SymTensor, MaterialError>;

    /// Spatial tangent (Pa) of the Kirchhoff stress.
    fn spatial_tangent(&self, b: &SymTensor) -> Tangent;

    /// P-wave modulus (Pa) in the stiffest direction; `stress` is the Cauchy stress (Pa), `largest` the largest principal value of `b - 1`.
    fn max_wave_modulus(&self, b: &SymTensor, largest: f64, stress: &SymTensor) -> f64;

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
        let b = &point.state.0;
        let largest = match b.lies_in_plane() {
            true => b.greatest_principal_value_in_plane(),
            false => b.greatest_principal_value(),
        };
        self.max_wave_modulus(b, largest, &point.stress)
    }

    fn wave_moduli_batch(&self, stresses: &[SymTensor], states: &[LeftCauchyGreen], out: &mut [f64]) {
        for ((stresses, states), out) in
            stresses.chunks(BLOCK_SIZE).zip(states.chunks(BLOCK_SIZE)).zip(out.chunks_mut(BLOCK_SIZE))
        {
            let mut b = [[0.0; BLOCK_SIZE]; 6];
            load(states, &mut b);
            let largest = largest_changes(&b);
            for (i, (stress, state)) in stresses.iter().zip(states).enumerate() {
                out[i] = self.max_wave_modulus(&state.0, largest[i], stress);
            }
        }
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
        let step: [_; 9] = std::array::from_fn(|c| [motion.deformation.0[c / 3][c % 3]]);
        let mut lanes = DeformationArrays::<1>::UNIT;
        lanes.b = old.state.0.0.map(|value| [value]);
        lanes.step(self, &step.each_ref(), 1);
        lanes.check(L::NAME, 0)?;
        Ok(Point { stress: lanes.stress_of(0), state: LeftCauchyGreen(tensor(&lanes.b, 0)) })
    }

    fn update_block(
        &self,
        motions: &MotionBlock,
        stresses: &mut [SymTensor],
        states: &mut [LeftCauchyGreen],
    ) -> Result<(), BatchError> {
        let zero = [0.0; BLOCK_SIZE];
        let mut step = motions.deformation.each_ref();
        if motions.in_plane {
            OUT_OF_PLANE_COMPONENTS.iter().for_each(|c| step[*c] = &zero);
        }
        let mut lanes = DeformationArrays::<BLOCK_SIZE>::UNIT;
        load(states, &mut lanes.b);
        lanes.step(self, &step, stresses.len());
        if !lanes.are_valid(stresses.len()) {
            for index in 0..stresses.len() {
                lanes.check(L::NAME, index).map_err(|source| BatchError { index, source })?;
            }
        }
        for (i, (stress, state)) in stresses.iter_mut().zip(states).enumerate() {
            *stress = lanes.stress_of(i);
            state.0 = tensor(&lanes.b, i);
        }
        Ok(())
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

/// Tensors `b - 1` and stresses of up to `N` points, in one array per component (xx, yy, zz, xy, yz, zx), and the volume ratios of a step.
struct DeformationArrays<const N: usize> {
    b: [[f64; N]; 6],
    stress: [[f64; N]; 6],
    ratio: [f64; N],
}

/// Copies the tensors of states to arrays per component.
#[inline(always)]
fn load(states: &[LeftCauchyGreen], b: &mut [[f64; BLOCK_SIZE]; 6]) {
    for (i, state) in states.iter().enumerate().take(BLOCK_SIZE) {
        set_tensor(b, i, &state.0);
    }
}

/// Largest principal values of tensors in arrays per component, each as in [`PointLaw::wave_modulus`].
#[inline(never)]
fn largest_changes(b: &[[f64; BLOCK_SIZE]; 6]) -> [f64; BLOCK_SIZE] {
    let mut largest = [0.0; BLOCK_SIZE];
    for i in 0..BLOCK_SIZE {
        largest[i] = tensor(b, i).greatest_principal_value_in_plane();
    }
    if (0..BLOCK_SIZE).any(|i| !tensor(b, i).lies_in_plane()) {
        for i in 0..BLOCK_SIZE {
            let (b, in_plane) = (tensor(b, i), largest[i]);
            largest[i] = if b.lies_in_plane() { in_plane } else { b.greatest_principal_value() };
        }
    }
    largest
}

impl<const N: usize> DeformationArrays<N> {
    /// Points without strain and stress.
    const UNIT: Self = Self { b: [[0.0; N]; 6], stress: [[0.0; N]; 6], ratio: [1.0; N] };

    /// Stress of point `index` (Pa).
    #[inline(always)]
    fn stress_of(&self, index: usize) -> SymTensor {
        tensor(&self.stress, index)
    }

    /// Updates tensors and stresses of the first `count` points by a step with the deformations `step`. The arithmetic of a point depends
    /// on its own step and tensor only.
    #[inline(always)]
    fn step<L: FiniteElastic>(&mut self, law: &L, step: &[&[f64; N]; 9], count: usize) {
        let planar = (0..count).filter(|i| self.is_planar(step, *i)).count();
        if planar == count {
            return self.step_in_plane(law, step);
        }
        if planar == 0 {
            return self.step_in_space(law, step);
        }
        for i in 0..count {
            let own: [_; 9] = std::array::from_fn(|c| [step[c][i]]);
            let mut alone = DeformationArrays::<1>::UNIT;
            alone.b = tensor(&self.b, i).0.map(|value| [value]);
            match self.is_planar(step, i) {
                true => alone.step_in_plane(law, &own.each_ref()),
                false => alone.step_in_space(law, &own.each_ref()),
            }
            set_tensor(&mut self.b, i, &tensor(&alone.b, 0));
            set_tensor(&mut self.stress, i, &alone.stress_of(0));
            self.ratio[i] = alone.ratio[0];
        }
    }

    /// Whether step and tensor of a point leave the third axis unchanged.
    #[inline(always)]
    fn is_planar(&self, [_, _, c, _, _, f, g, h, _]: &[&[f64; N]; 9], i: usize) -> bool {
        let along = (c[i] == 0.0) & (f[i] == 0.0) & (g[i] == 0.0) & (h[i] == 0.0);
        along & tensor(&self.b, i).lies_in_plane()
    }

    /// Step of points that neither move nor are sheared out of the plane of the first two axes.
    #[inline(never)]
    fn step_in_plane<L: FiniteElastic>(&mut self, law: &L, [a, b, _, d, e, _, _, _, k]: &[&[f64; N]; 9]) {
        for i in 0..N {
            let [xx, yy, zz, xy, ..] = tensor(&self.b, i).0;
            let (new, ratio) = push_forward_in_plane([xx, yy, zz, xy], [a[i], b[i], d[i], e[i], k[i]]);
            let stress = law.cauchy_stress_in_plane(&new);
            set_tensor(&mut self.b, i, &new);
            set_tensor(&mut self.stress, i, &stress);
            self.ratio[i] = ratio;
        }
    }

    /// Step of points with any motion.
    #[inline(never)]
    fn step_in_space<L: FiniteElastic>(&mut self, law: &L, [a, b, c, d, e, f, g, h, k]: &[&[f64; N]; 9]) {
        for i in 0..N {
            let step = Mat3([[a[i], b[i], c[i]], [d[i], e[i], f[i]], [g[i], h[i], k[i]]]);
            let new = push_forward(&tensor(&self.b, i), &step);
            let stress = law.cauchy_stress(&new);
            set_tensor(&mut self.b, i, &new);
            set_tensor(&mut self.stress, i, &stress);
            self.ratio[i] = step.determinant();
        }
    }

    /// Whether the first `count` points pass [`DeformationArrays::check`].
    #[inline(always)]
    fn are_valid(&self, count: usize) -> bool {
        let mut valid = true;
        for i in 0..count {
            valid &= (self.ratio[i] > 0.0) & is_finite(&tensor(&self.b, i)) & is_finite(&self.stress_of(i));
        }
        valid
    }

    /// Checks the result of a step.
    ///
    /// # Errors
    /// When the motion inverts the point or is not finite, or the stress is not finite.
    fn check(&self, model: &'static str, index: usize) -> Result<(), MaterialError> {
        // Written so that NaN is rejected.
        if !(self.ratio[index] > 0.0 && is_finite(&tensor(&self.b, index))) {
            return Err(MaterialError::Motion { model, reason: "the step inverts the point" });
        }
        check_finite(model, self.stress_of(index)).map(drop)
    }
}

/// Whether no component is infinite or not-a-number, without a branch.
#[inline(always)]
fn is_finite(tensor: &SymTensor) -> bool {
    let [xx, yy, zz, xy, yz, zx] = tensor.0;
    // NaN and infinity make the product NaN.
    ((xx + yy + zz) + (xy + yz + zx)) * 0.0 == 0.0
}

/// Volume ratio `J` of `b - 1`, from `J² - 1 = I1 + I2 + I3` of that tensor.
#[inline(always)]
pub(super) fn jacobian(b: &SymTensor) -> f64 {
    let i1 = b.trace();
    let i2 = 0.5 * (i1 * i1 - b.dot(b));
    (1.0 + (i1 + i2 + b.determinant())).sqrt()
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
