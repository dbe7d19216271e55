//! Substepping (sheet: constitutive §3.8): a step that is too large, or whose local solve does not
//! converge, is divided into 2, 4, … 64 equal parts.

use crate::{MaterialError, Motion, Point, SymTensor};

/// Largest number of substeps.
const MAX_SUBSTEPS: u32 = 64;

/// Result of a step or substep.
#[derive(Clone, Debug)]
pub(crate) struct SubstepResult<S> {
    /// Stress and state at the end of the step.
    pub point: Point<S>,
    /// Work dissipated in the step (J/m³).
    pub dissipated_work: f64,
}

/// Initial number of equal sub-steps of a strain increment, each at most `largest`.
pub(crate) fn substep_count(strain: &SymTensor, largest: f64) -> u32 {
    let norm = strain.norm();
    let mut count = 1;
    while count < MAX_SUBSTEPS && norm > largest * f64::from(count) {
        count *= 2;
    }
    count
}

/// Applies a strain increment in equal sub-steps. Their number follows from its size, and doubles while the local solve does not converge.
///
/// # Errors
/// For a strain increment of 1 or more, and the error of `step` with the most substeps.
pub(crate) fn substepped<S: Clone>(
    model: &'static str,
    strain: &SymTensor,
    largest: f64,
    old: &Point<S>,
    step: impl Fn(&SymTensor, &Point<S>) -> Result<SubstepResult<S>, MaterialError>,
) -> Result<SubstepResult<S>, MaterialError> {
    // Written so that NaN is rejected.
    if !(strain.norm() < 1.0) {
        return Err(MaterialError::Motion { model, reason: "the strain increment is 1 or more" });
    }
    let mut count = substep_count(strain, largest);
    loop {
        match run_substeps(count, strain, old, &step) {
            Err(MaterialError::NotConverged { .. }) if count < MAX_SUBSTEPS => count *= 2,
            result => return result,
        }
    }
}

/// Applies a finite-strain motion in sub-steps like [`substepped`], with roots of its deformation gradient.
///
/// # Errors
/// The error of `step` with the most substeps.
pub(crate) fn substepped_motion<P>(
    motion: &Motion,
    largest: f64,
    old: &P,
    step: impl Fn(&Motion, &P) -> Result<P, MaterialError>,
) -> Result<P, MaterialError> {
    let mut count = substep_count(&motion.strain_increment(), largest);
    loop {
        // A motion without a root is applied whole.
        let part = if count > 1 { motion.equal_part(count) } else { None };
        let (part, parts) = part.map_or((*motion, 1), |part| (part, count));
        let mut result = step(&part, old);
        for _ in 1..parts {
            result = result.and_then(|point| step(&part, &point));
        }
        match result {
            Err(MaterialError::NotConverged { .. }) if count < MAX_SUBSTEPS => count *= 2,
            result => return result,
        }
    }
}

/// Divides a strain increment into `count` equal sub-steps and adds up their dissipated work.
fn run_substeps<S: Clone>(
    count: u32,
    strain: &SymTensor,
    old: &Point<S>,
    step: impl Fn(&SymTensor, &Point<S>) -> Result<SubstepResult<S>, MaterialError>,
) -> Result<SubstepResult<S>, MaterialError> {
    let part = *strain * (1.0 / f64::from(count));
    let mut advance = step(&part, old)?;
    for _ in 1..count {
        let next = step(&part, &advance.point)?;
        advance = SubstepResult {
            point: next.point,
            dissipated_work: advance.dissipated_work + next.dissipated_work,
        };
    }
    Ok(advance)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point_at_rest() -> Point<u32> {
        Point { stress: SymTensor::ZERO, state: 0 }
    }

    fn counting(limit: f64) -> impl Fn(&SymTensor, &Point<u32>) -> Result<SubstepResult<u32>, MaterialError> {
        move |strain, old| {
            if strain.norm() > limit {
                return Err(MaterialError::NotConverged { model: "test", reason: "too large" });
            }
            let point = Point { stress: old.stress + *strain, state: old.state + 1 };
            Ok(SubstepResult { point, dissipated_work: 0.5 })
        }
    }

    #[test]
    fn a_large_step_is_divided_and_a_failing_one_divided_further() {
        let strain = SymTensor::diagonal(0.03, 0.0, 0.0);
        for (limit, parts) in [(1.0, 4), (0.004, 8), (0.0005, 64)] {
            let advance = substepped("test", &strain, 0.01, &point_at_rest(), counting(limit)).unwrap();
            assert_eq!(advance.point.state, parts);
            assert!((advance.point.stress[0] - 0.03).abs() < 1e-15);
            assert!((advance.dissipated_work - 0.5 * f64::from(parts)).abs() < 1e-12);
        }
        let given_up = substepped("test", &strain, 0.01, &point_at_rest(), counting(1e-4));
        assert!(matches!(given_up, Err(MaterialError::NotConverged { .. })));
        for wild in [1.5, f64::NAN, f64::INFINITY] {
            let refused =
                substepped("test", &SymTensor::isotropic(wild), 0.01, &point_at_rest(), counting(1e9));
            assert!(matches!(refused, Err(MaterialError::Motion { .. })));
        }
    }
}
