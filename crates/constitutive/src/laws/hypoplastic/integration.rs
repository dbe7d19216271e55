//! Modified Euler integration of the rate equation with local error control (sheet: constitutive §3.7.10), and
//! its derivative.
//!
//! A step is divided into pieces by its size, a piece into equal substeps whose number is the least power of two
//! that keeps the local error. The update is therefore smooth but for the few strains at which a number changes.

use super::super::pressure_elastic::VoidRatio;
use super::{Hypoplastic, NAME};
use crate::return_maps::substepping;
use crate::return_maps::substepping::{SubstepResult, substepped};
use crate::{MaterialError, Point, SymTensor, Tangent};

/// Largest strain increment that is integrated with one error control (sheet: constitutive §3.8); larger ones are divided.
const MAX_PIECE_STRAIN: f64 = 1e-2;
/// Local error of a substep, relative to the stress (sheet: constitutive §3.7.10).
const TOLERANCE: f64 = 1e-4;
/// Largest number of doublings of the number of sub-steps: 1024 sub-steps (1000 in the sheet).
const DOUBLINGS: u32 = 10;

/// Derivatives of stress and void ratio with respect to one component of the strain increment of the step.
#[derive(Clone, Copy)]
struct StateDerivative {
    stress: SymTensor,
    void_ratio: f64,
}

/// Sub-step of a strain increment.
#[derive(Clone, Copy)]
struct Substep {
    strain: SymTensor,
    /// Factor `exp(tr Δε)`.
    growth: f64,
}

impl Substep {
    /// Sub-step of a strain increment, with the volume ratio `exp(tr ε)`.
    fn new(strain: SymTensor) -> Self {
        Self { strain, growth: strain.trace().exp() }
    }

    /// Void ratio at the end of the sub-step, from the one at its start.
    fn void_ratio_after(&self, void_ratio: f64) -> f64 {
        (1.0 + void_ratio) * self.growth - 1.0
    }
}

impl Hypoplastic {
    /// Point after the strain increment `strain`.
    pub(super) fn integrate(
        &self,
        strain: &SymTensor,
        old: &Point<VoidRatio>,
    ) -> Result<SubstepResult<VoidRatio>, MaterialError> {
        substepped(NAME, strain, MAX_PIECE_STRAIN, old, |part, from| {
            let (_, point) = self.integrate_piece(part, from)?;
            Ok(SubstepResult { point, dissipated_work: 0.0 })
        })
    }

    /// Integrates a strain increment with the smallest number of sub-steps that satisfies the error tolerance: that number and the new
    /// point.
    fn integrate_piece(
        &self,
        strain: &SymTensor,
        old: &Point<VoidRatio>,
    ) -> Result<(u32, Point<VoidRatio>), MaterialError> {
        (0..=DOUBLINGS)
            .find_map(|k| self.integrate_substeps(1 << k, strain, old).map(|point| (1 << k, point)))
            .ok_or(MaterialError::NotConverged { model: NAME, reason: "too many substeps" })
    }

    /// Integrates `count` sub-steps; `None` if the local error of one of them exceeds the tolerance.
    fn integrate_substeps(
        &self,
        count: u32,
        strain: &SymTensor,
        old: &Point<VoidRatio>,
    ) -> Option<Point<VoidRatio>> {
        let part = Substep::new(*strain * (1.0 / f64::from(count)));
        let Point { mut stress, state: VoidRatio { mut void_ratio } } = *old;
        for _ in 0..count {
            stress = self.limit_to_min_pressure(stress);
            if self.is_strained(&stress, &part) {
                let [first, second] = self.slopes(&stress, void_ratio, &part);
                let error = 0.5 * (second - first).norm() / stress.norm();
                // A substep that loses half the pressure is too long irrespective of the error.
                let kept = (stress + first).pressure() > 0.5 * stress.pressure();
                if !(error < TOLERANCE && kept) {
                    return None;
                }
                stress += (first + second) * 0.5;
            }
            void_ratio = part.void_ratio_after(void_ratio);
        }
        Some(Point { stress: self.limit_to_min_pressure(stress), state: VoidRatio { void_ratio } })
    }

    /// Returns the stress, or the isotropic stress at the minimum pressure if its pressure is lower.
    fn limit_to_min_pressure(&self, stress: SymTensor) -> SymTensor {
        if stress.pressure() <= self.minimum_pressure {
            SymTensor::isotropic(-self.minimum_pressure)
        } else {
            stress
        }
    }

    /// Whether the sub-step strains the skeleton. A stress-free skeleton stays so while its volume increases.
    fn is_strained(&self, stress: &SymTensor, part: &Substep) -> bool {
        stress.pressure() > self.minimum_pressure || part.strain.trace() < 0.0
    }

    /// Stress increments of a sub-step with the rates at its start and at its predicted end.
    fn slopes(&self, stress: &SymTensor, void_ratio: f64, part: &Substep) -> [SymTensor; 2] {
        let first = self.slope(stress, void_ratio, &part.strain);
        [first, self.slope(&(*stress + first), part.void_ratio_after(void_ratio), &part.strain)]
    }

    /// Derivative of the update by the strain increment, along its substeps.
    pub(super) fn substepped_tangent(&self, strain: &SymTensor, old: &Point<VoidRatio>) -> Option<Tangent> {
        let pieces = substepping::substep_count(strain, MAX_PIECE_STRAIN);
        let piece = *strain * (1.0 / f64::from(pieces));
        if piece.norm() == 0.0 {
            return None;
        }
        let mut slopes = [StateDerivative { stress: SymTensor::ZERO, void_ratio: 0.0 }; 6];
        let mut point = *old;
        for _ in 0..pieces {
            let (count, next) = self.integrate_piece(&piece, &point).ok()?;
            let part = Substep::new(piece * (1.0 / f64::from(count)));
            let share = 1.0 / f64::from(count * pieces);
            for (component, slope) in slopes.iter_mut().enumerate() {
                // Engineering shear: half in each of the two entries.
                let mut direction = SymTensor::ZERO;
                direction[component] = if component < 3 { share } else { 0.5 * share };
                *slope = self.propagate_derivative(*slope, count, &part, &direction, &point);
            }
            point = next;
        }
        Some(Tangent(std::array::from_fn(|row| slopes.map(|slope| slope.stress[row]))))
    }

    /// Propagates the derivative `slope` of stress and void ratio through `count` sub-steps from `old`. `direction` is the derivative of
    /// the strain of each sub-step.
    fn propagate_derivative(
        &self,
        mut slope: StateDerivative,
        count: u32,
        part: &Substep,
        direction: &SymTensor,
        old: &Point<VoidRatio>,
    ) -> StateDerivative {
        let Point { mut stress, state: VoidRatio { mut void_ratio } } = *old;
        let floored = |stress: &SymTensor| stress.pressure() <= self.minimum_pressure;
        for _ in 0..count {
            if floored(&stress) {
                (stress, slope.stress) = (self.limit_to_min_pressure(stress), SymTensor::ZERO);
            }
            let next = part.void_ratio_after(void_ratio);
            let by_next = slope.void_ratio * part.growth + (1.0 + next) * direction.trace();
            if self.is_strained(&stress, part) {
                let [first, second] = self.slopes(&stress, void_ratio, part);
                let by_first = self.slope_change((&stress, void_ratio), part, slope, direction);
                let predicted = StateDerivative { stress: slope.stress + by_first, void_ratio: by_next };
                let by_second = self.slope_change((&(stress + first), next), part, predicted, direction);
                stress += (first + second) * 0.5;
                slope.stress += (by_first + by_second) * 0.5;
            }
            (void_ratio, slope.void_ratio) = (next, by_next);
        }
        if floored(&stress) {
            slope.stress = SymTensor::ZERO;
        }
        slope
    }

    /// Derivative of the stress increment of a sub-step in a direction of strain, by the chain rule over stress and void ratio.
    fn slope_change(
        &self,
        (stress, void_ratio): (&SymTensor, f64),
        part: &Substep,
        by: StateDerivative,
        direction: &SymTensor,
    ) -> SymTensor {
        let trace = stress.trace();
        let by_density = self
            .critical_state
            .as_ref()
            .map_or(0.0, |c| c.density_change(trace, void_ratio, (by.stress.trace(), by.void_ratio)));
        self.constants.rate_change(
            (stress, &part.strain, self.density_function(stress, void_ratio)),
            (&by.stress, direction, by_density),
        )
    }
}
