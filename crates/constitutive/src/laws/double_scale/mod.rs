//! Double-scale localisation (sheet: constitutive §2.16, §3.7.11; Bui & Nguyen 2021, eqs. 88–109): a
//! point, elastic or yielding, that is cut by one cohesive band.
//!
//! Outside the band `σ̇ = D : (ε̇ - n ⊗ u̇ / H)` with the jump `u` and the effective size `H` of the point
//! (volume over area of the cut); in the band of zero thickness an [`InterfaceLaw`], `σ n = t(u)`. The jump
//! of a step is implicit. Elastic surroundings and band are springs in series, which gives the band a scalar
//! equation; surroundings that yield (Drucker–Prager) need Newton's method on the jump. The energy of the
//! band is thus dissipated per area whatever the size of the points. A band is inserted where the band's own yield
//! function, or the largest principal stress, is first exceeded, or where the surroundings lose ellipticity;
//! of two equally critical conjugate planes the one with the larger shear strain is chosen, or, where the
//! strain does not differ, by the spin. Its normal then rotates with the material.
//!
//! Limits: one band a point; snap-back where `H` exceeds `E G/f_t²` (rejected unless allowed, and then the
//! step ends on the lower branch). For explicit formulas with a band of finite thickness see
//! [`crate::localisation`].

mod onset;
mod parameters;

use serde::{Deserialize, Serialize};

use super::cohesive_band::CohesiveBand;
use super::linear_elastic::LinearElastic;
use crate::contract::elasticity::Elasticity;
use crate::{
    InitialCondition, InterfaceLaw, InterfacePoint, Law, Mat3, MaterialError, Motion, Point, PointLaw,
    PrincipalReturn, SmallStrain, SymTensor, Tangent,
};

pub use parameters::{BandSpec, DoubleScaleSpec, LocalSolve, Onset, OutsideStrength};

/// Value of the key `model` in case files.
const NAME: &str = "double-scale";

/// Damage at which a band is removed under the intact-reset hypothesis.
const FULL_DAMAGE: f64 = 0.999;

/// Newton iterations of the local solve (sheet: constitutive §3.7.11).
const ITERATIONS: usize = 30;

/// Law that may surround a band.
pub trait BandSurroundings: PrincipalReturn<State: Copy> {}

impl<M: PrincipalReturn<State: Copy>> BandSurroundings for M {}

/// Law of a point that consists of a localisation band and its surrounding material. The comment of this module gives its source and limits.
#[derive(Clone, Debug, PartialEq)]
pub struct DoubleScale<B = CohesiveBand, M = LinearElastic> {
    outside: M,
    band: B,
    onset: Onset,
    /// Whether Newton's method on the jump replaces the band's return with its elastic surroundings.
    newton: bool,
    size: Option<f64>,
    /// Size above which a point is rejected (m).
    snap_back_size: f64,
    intact_reset: bool,
}

/// Internal variables of the surrounding material and, after localisation, of the band.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BandedState<S, T = ()> {
    /// Whether a band has been inserted.
    pub localised: bool,
    /// Frame of the band, one row per unit vector: normal and two tangents.
    pub frame: Mat3,
    /// Displacement jump across the band in its frame (m).
    pub jump: [f64; 3],
    /// Size of the point at the last step (m).
    pub size: f64,
    /// Internal variables of the interface law.
    pub band: S,
    /// Internal variables of the law outside.
    pub outside: T,
}

/// Jump increment (m), band and point outside after a step.
type BandSolution<B, M> =
    ([f64; 3], InterfacePoint<<B as InterfaceLaw>::State>, Point<<M as PointLaw>::State>);

/// State of a point with a localisation band law `B` and a law `M` of the surrounding material.
type DoubleScaleState<B, M> = BandedState<<B as InterfaceLaw>::State, <M as PointLaw>::State>;

/// Step of a banded point: the strain increment outside is `strain - n ⊗ Δu / H`.
struct BandedStep<'s, B: InterfaceLaw, M: SmallStrain> {
    strain: &'s SymTensor,
    motion: &'s Motion,
    /// Point outside before the step.
    previous: Point<M::State>,
    frame: Mat3,
    size: f64,
    /// Band before the step.
    band: InterfacePoint<B::State>,
}

impl<B: InterfaceLaw, M: SmallStrain> BandedStep<'_, B, M> {
    /// Strain increment of the surrounding material for a jump increment in the frame of the band (m).
    fn outside_strain(&self, jump: [f64; 3]) -> SymTensor {
        if jump == [0.0; 3] {
            return *self.strain;
        }
        let across = self.frame.transpose().apply(jump);
        *self.strain - SymTensor::symmetric_dyad(self.frame.0[0], across) * (1.0 / self.size)
    }
}

/// Traction of a stress on the band, in the frame of the band (Pa).
#[inline]
fn band_traction(frame: &Mat3, stress: &SymTensor) -> [f64; 3] {
    frame.apply(stress.apply(frame.0[0]))
}

impl<B: InterfaceLaw, M: BandSurroundings> DoubleScale<B, M> {
    /// Elasticity of the surrounding material.
    fn elasticity(&self) -> &Elasticity {
        self.outside.elasticity()
    }

    /// State of the band under `stress`.
    fn interface(state: &DoubleScaleState<B, M>, stress: &SymTensor) -> InterfacePoint<B::State> {
        InterfacePoint { traction: band_traction(&state.frame, stress), state: state.band }
    }

    /// Stiffness `n·D·n / H` of the surrounding elastic material in opening and sliding (Pa/m).
    fn surrounding_stiffness(&self, size: f64) -> [f64; 2] {
        [self.elasticity().p_wave_modulus() / size, self.elasticity().shear_modulus / size]
    }

    /// Couplings of stress and band jump for `stress = D : (Δε - n ⊗ e_k Δu_k / H)`: of the stress to each jump component, `D : n ⊗ e_k`,
    /// and of each traction component to strain, `n ⊗ e_k : D`.
    fn jump_couplings(frame: &Mat3, stiffness: &Tangent) -> ([SymTensor; 3], [SymTensor; 3]) {
        let dyads = frame.0.map(|a| SymTensor::symmetric_dyad(frame.0[0], a));
        (dyads.map(|dyad| stiffness.apply(&dyad)), dyads.map(|dyad| stiffness.apply_left(&dyad)))
    }

    /// Compliance `(K + n·D·n/H)⁻¹` of band and surroundings at a jump increment (m/Pa).
    fn compliance(
        &self,
        step: &BandedStep<'_, B, M>,
        jump: [f64; 3],
        stiffness: &Tangent,
    ) -> Result<Mat3, MaterialError> {
        let mut jacobian = Mat3(self.band.stiffness(jump, &step.band)?);
        let (traction_couplings, _) = Self::jump_couplings(&step.frame, stiffness);
        for (column, traction) in traction_couplings.iter().enumerate() {
            for (row, value) in band_traction(&step.frame, traction).into_iter().enumerate() {
                jacobian.0[row][column] += value / step.size;
            }
        }
        let singular = MaterialError::NotConverged { model: NAME, reason: "the band has no resistance" };
        jacobian.inverse().ok_or(singular)
    }

    /// Tangent stiffness of the surrounding material for its part of the strain (Pa); the elastic one if the law has none.
    fn stiffness_outside(&self, step: &BandedStep<'_, B, M>, jump: [f64; 3]) -> Tangent {
        let reduced = step.outside_strain(jump);
        let tangent = self.outside.tangent(&reduced, step.motion, &step.previous);
        tangent.unwrap_or_else(|| self.elasticity().tangent())
    }

    /// Solves for the jump by Newton's method with backtracking (sheet: constitutive §3.7.11): jump increment, state of the band and of the
    /// surroundings.
    fn newton(
        &self,
        step: &BandedStep<'_, B, M>,
        start: [f64; 3],
    ) -> Result<BandSolution<B, M>, MaterialError> {
        let at = |jump: [f64; 3]| -> Result<_, MaterialError> {
            let outside = self.outside.update(&step.outside_strain(jump), step.motion, &step.previous)?;
            let band = self.band.update(jump, &step.band)?;
            let traction = band_traction(&step.frame, &outside.stress);
            let residual: [f64; 3] = std::array::from_fn(|k| traction[k] - band.traction[k]);
            Ok((residual, band, outside))
        };
        let size = |r: [f64; 3]| r.iter().map(|c| c * c).sum::<f64>().sqrt();
        let scale = step.previous.stress.norm() + self.elasticity().p_wave_modulus() * step.strain.norm();
        let mut jump = start;
        let (mut residual, mut band, mut outside) = at(jump)?;
        for _ in 0..ITERATIONS {
            if size(residual) <= 1e-14 * scale {
                break;
            }
            let stiffness = self.stiffness_outside(step, jump);
            let change = self.compliance(step, jump, &stiffness)?.apply(residual);
            let mut share = 1.0;
            loop {
                let next = std::array::from_fn(|k| jump[k] + share * change[k]);
                match at(next) {
                    Ok((new, b, o)) if size(new) < size(residual) => {
                        (jump, residual, band, outside) = (next, new, b, o);
                        break;
                    }
                    _ if share > 1e-3 => share *= 0.5,
                    // No improvement: converged at the round-off of the tractions.
                    _ if size(residual) <= 1e-12 * scale => return Ok((jump, band, outside)),
                    _ => return Err(MaterialError::NotConverged { model: NAME, reason: "jump" }),
                }
            }
        }
        if size(residual) <= 1e-12 * scale {
            Ok((jump, band, outside))
        } else {
            Err(MaterialError::NotConverged { model: NAME, reason: "jump" })
        }
    }

    /// Jump increment, band and point outside after the step.
    fn solve_jump(&self, step: &BandedStep<'_, B, M>) -> Result<BandSolution<B, M>, MaterialError> {
        if self.newton {
            match self.newton(step, [0.0; 3]) {
                Err(MaterialError::NotConverged { .. }) => {}
                result => return result,
            }
        }
        let trial = step.previous.stress + self.elasticity().stress(step.strain);
        let resistance = self.surrounding_stiffness(step.size);
        let (jump, band) =
            self.band.relax_with_surroundings(band_traction(&step.frame, &trial), resistance, &step.band)?;
        if self.newton {
            // Where the band softens faster than the surroundings yield, these unload.
            return self.newton(step, jump);
        }
        let outside = self.outside.update(&step.outside_strain(jump), step.motion, &step.previous)?;
        Ok((jump, band, outside))
    }

    /// Effective size of the point in this step (m). A size with snap-back is rejected when the band forms. The size grows as the crack
    /// opens.
    fn size(&self, motion: &Motion, begins: bool) -> Result<f64, MaterialError> {
        let size = self.size.unwrap_or(motion.size);
        let invalid = |reason| Err(MaterialError::Motion { model: NAME, reason });
        if !(size > 0.0 && size.is_finite()) {
            return invalid("the size of the point must be positive");
        }
        if begins && size >= self.snap_back_size {
            return invalid("the point is so large that its band shows snap-back (see allow_snapback)");
        }
        Ok(size)
    }

    /// Stress and state after a strain increment, with the onset of localisation and, after it, the band.
    fn step(
        &self,
        strain: &SymTensor,
        motion: &Motion,
        old: &Point<DoubleScaleState<B, M>>,
    ) -> Result<Point<DoubleScaleState<B, M>>, MaterialError> {
        let before = Point { stress: old.stress, state: old.state.outside };
        let mut state = old.state;
        if !state.localised {
            let intact = self.outside.update(strain, motion, &before)?;
            let Some(frame) = self.onset(&before, &intact, strain, motion) else {
                let state = BandedState { outside: intact.state, ..state };
                return Ok(Point { stress: intact.stress, state });
            };
            let band = self.band.initial(band_traction(&frame, &old.stress));
            state = BandedState { localised: true, frame, jump: [0.0; 3], band, ..state };
        }
        state.size = self.size(motion, !old.state.localised)?;
        let band = Self::interface(&state, &old.stress);
        let step =
            BandedStep { strain, motion, previous: before, frame: state.frame, size: state.size, band };
        let (jump, band, outside) = self.solve_jump(&step)?;
        state.band = band.state;
        state.outside = outside.state;
        state.jump = std::array::from_fn(|k| state.jump[k] + jump[k]);
        let stress = outside.stress;
        if self.intact_reset
            && self.band.damage(&state.band) >= FULL_DAMAGE
            && self.intact_yield(&stress).0 <= 0.0
        {
            let (frame, band, outside) = (Mat3::ZERO, B::State::default(), state.outside);
            state = BandedState { localised: false, frame, jump: [0.0; 3], size: 0.0, band, outside };
        }
        Ok(Point { stress, state })
    }
}

impl<B: InterfaceLaw, M: BandSurroundings> Law for DoubleScale<B, M> {
    fn name(&self) -> &'static str {
        NAME
    }

    fn output_names(&self) -> &[&'static str] {
        &["localised", "damage", "opening", "slip"]
    }
}

impl<B: InterfaceLaw, M: BandSurroundings> PointLaw for DoubleScale<B, M> {
    type State = DoubleScaleState<B, M>;

    fn initial(&self, initial: &InitialCondition) -> Result<Point<Self::State>, MaterialError> {
        let Point { stress, state: outside } = self.outside.initial(initial)?;
        let (excess, _) = self.intact_yield(&stress);
        super::check_initial(NAME, &stress, excess, self.band.tensile_strength() + stress.norm())?;
        let (frame, band) = (Mat3::ZERO, B::State::default());
        let state = BandedState { localised: false, frame, jump: [0.0; 3], size: 0.0, band, outside };
        Ok(Point { stress, state })
    }

    fn wave_modulus(&self, _point: &Point<Self::State>) -> f64 {
        self.elasticity().p_wave_modulus()
    }

    fn yield_value(&self, point: &Point<Self::State>) -> Option<f64> {
        let band = if point.state.localised {
            self.band.yield_value(&Self::interface(&point.state, &point.stress))
        } else {
            self.intact_yield(&point.stress).0
        };
        let outside = Point { stress: point.stress, state: point.state.outside };
        Some(self.outside.yield_value(&outside).map_or(band, |value| value.max(band)))
    }

    /// Elastic constants of the material outside the band.
    fn linear_elasticity(&self) -> Option<&Elasticity> {
        Some(self.elasticity())
    }

    fn outputs(&self, point: &Point<Self::State>, out: &mut [f64]) {
        let BandedState { localised, jump, band, .. } = &point.state;
        out[0] = f64::from(u8::from(*localised));
        out[1] = if *localised { self.band.damage(band) } else { 0.0 };
        out[2] = jump[0];
        out[3] = jump[1].hypot(jump[2]);
    }
}

impl<B: InterfaceLaw, M: BandSurroundings> SmallStrain for DoubleScale<B, M> {
    fn update(
        &self,
        strain: &SymTensor,
        motion: &Motion,
        old: &Point<Self::State>,
    ) -> Result<Point<Self::State>, MaterialError> {
        if *strain == SymTensor::ZERO {
            return Ok(*old);
        }
        self.step(strain, motion, old)
    }

    /// Infinite strain increment: the local solve is implicit, and a step is divided only after it has failed.
    fn max_strain_increment(&self) -> f64 {
        f64::INFINITY
    }

    fn rotate_state(&self, state: &mut Self::State, rotation: &Mat3) {
        if state.localised {
            state.frame = state.frame * rotation.transpose();
        }
        self.outside.rotate_state(&mut state.outside, rotation);
    }

    /// Tangent `D - (D n)(K + n·D·n/H)⁻¹(n D)/H` (Pa) (sheet: constitutive §3.7.11). In the step of localisation, in which the normal
    /// depends on the strain, it is computed by differences.
    fn tangent(&self, strain: &SymTensor, motion: &Motion, old: &Point<Self::State>) -> Option<Tangent> {
        let before = Point { stress: old.stress, state: old.state.outside };
        if !old.state.localised {
            let intact = self.outside.update(strain, motion, &before).ok()?;
            let whole = self.onset(&before, &intact, strain, motion).is_none();
            return if whole { self.outside.tangent(strain, motion, &before) } else { None };
        }
        let (size, frame) = (self.size(motion, false).ok()?, old.state.frame);
        let band = Self::interface(&old.state, &old.stress);
        let step = BandedStep { strain, motion, previous: before, frame, size, band };
        let (jump, band, _) = self.solve_jump(&step).ok()?;
        if self.intact_reset && self.band.damage(&band.state) >= FULL_DAMAGE {
            return None;
        }
        let mut tangent = self.stiffness_outside(&step, jump);
        let compliance = self.compliance(&step, jump, &tangent).ok()?;
        let (traction_couplings, gains) = Self::jump_couplings(&frame, &tangent);
        for (row, a) in compliance.0.iter().zip(&traction_couplings) {
            for (value, b) in row.iter().zip(&gains) {
                tangent.add_dyad(-value / size, a, b);
            }
        }
        Some(tangent)
    }

    fn dissipation(
        &self,
        strain: &SymTensor,
        motion: &Motion,
        old: &Point<Self::State>,
        new: &Point<Self::State>,
    ) -> Option<f64> {
        let outside = |point: &Point<Self::State>| Point { stress: point.stress, state: point.state.outside };
        if !new.state.localised {
            // A band removed in this step took its dissipation with it.
            let lost = || self.outside.dissipation(strain, motion, &outside(old), &outside(new));
            return if old.state.localised { None } else { lost() };
        }
        let (frame, size) = (new.state.frame, new.state.size);
        let (band, start) = if old.state.localised {
            (old.state.band, old.state.jump)
        } else {
            (self.band.initial(band_traction(&frame, &old.stress)), [0.0; 3])
        };
        let before = InterfacePoint { traction: band_traction(&frame, &old.stress), state: band };
        let after = Self::interface(&new.state, &new.stress);
        let step = BandedStep::<B, M> { strain, motion, previous: outside(old), frame, size, band: before };
        let jump = std::array::from_fn(|k| new.state.jump[k] - start[k]);
        let lost =
            self.outside.dissipation(&step.outside_strain(jump), motion, &step.previous, &outside(new))?;
        Some(lost + self.band.dissipation(&before, &after) / size)
    }
}
