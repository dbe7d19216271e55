//! Elastic settling of bodies without yielding: time, displacement and unbalanced force by which trials are judged.

use crate::run::RunError;
use crate::run::factor_of_safety::slope_scale::exceeded_displacement;
use crate::run::factor_of_safety::strength_trial::RunningTrial;
use crate::run::factor_of_safety::{REST_RATIO, SearchContext};

/// Steps between two checks.
const STEPS_PER_CHECK: u64 = 20;
/// Consecutive checks at which the bodies must be at rest.
const CHECKS_AT_REST: usize = 3;
/// Checks before the first test for stagnation of the unbalanced force, and between two tests.
const CHECKS_BEFORE_STAGNATION: usize = 64;
/// Ratio of the median unbalanced force in the last half of the checks to that in the quarter before, above which the force stagnates.
const NO_DECREASE_RATIO: f64 = 0.9;
/// Most checks for settling with an unknown duration.
const MAX_CHECKS: usize = 5000;
/// Shortest settling time (checks).
const MIN_CHECKS: usize = 3;

/// Elastic settling of bodies without yielding.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ElasticSettling {
    /// Time until the bodies rest (s).
    pub time: f64,
    /// Least unbalanced-force ratio that the method reaches; 0 where the bodies come to rest.
    pub floor: f64,
    /// Elastic settlement under the full weight (m).
    pub displacement: f64,
}

/// Upper median of values; NaN without values.
fn median(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Unbalanced-force ratio at which a method stagnates, from the ratios at all checks; `None` where the ratio still decreases.
fn stagnation_ratio(ratios: &[f64]) -> Option<f64> {
    let count = ratios.len();
    if count < CHECKS_BEFORE_STAGNATION || !count.is_multiple_of(CHECKS_BEFORE_STAGNATION) {
        return None;
    }
    let [before, last] = [median(&ratios[count / 4..count / 2]), median(&ratios[count / 2..])];
    (last > NO_DECREASE_RATIO * before).then_some(last)
}

impl ElasticSettling {
    /// Steps a trial of the case of [`FactorOfSafety::unloading`](crate::description::FactorOfSafety::unloading) until the bodies rest;
    /// `None` when the run is to stop.
    pub fn find(context: &SearchContext<'_>, mut trial: RunningTrial<'_>) -> Result<Option<Self>, RunError> {
        let SearchContext { case, name, search, .. } = context;
        if case.gravity.iter().all(|g| *g == 0.0) {
            return Ok(Some(Self::default()));
        }
        let (mut ratios, mut times) = (Vec::new(), Vec::new());
        let found = loop {
            if context.is_to_stop() {
                return Ok(None);
            }
            trial.advance(STEPS_PER_CHECK, f64::INFINITY)?;
            ratios.push(trial.unbalanced_ratio());
            times.push(trial.elapsed_time());
            let resting = ratios.iter().rev().take_while(|ratio| **ratio < REST_RATIO).count();
            if resting >= CHECKS_AT_REST {
                break Some((0.0, ratios.len() - resting));
            }
            if let Some(floor) = stagnation_ratio(&ratios) {
                let near = |ratio: &f64| *ratio < floor / NO_DECREASE_RATIO;
                break Some((floor, ratios.iter().position(near).unwrap_or(ratios.len() - 1)));
            }
            if ratios.len() >= MAX_CHECKS {
                break None;
            }
        };
        let (floor, look) = match found {
            Some(found) => found,
            None if search.duration.is_some() => (median(&ratios[ratios.len() / 2..]), ratios.len() - 1),
            None => {
                let unbalanced = ratios.last().copied().unwrap_or(f64::NAN);
                return Err(RunError::NeverAtRest {
                    measure: (*name).to_owned(),
                    unbalanced,
                    time: trial.elapsed_time(),
                });
            }
        };
        let displacement = 2.0 * exceeded_displacement(&trial.solver.snapshot(), &trial.start, &case.domain);
        Ok(Some(Self { time: times[look.max(MIN_CHECKS.min(times.len()) - 1)], floor, displacement }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_decreasing_force_ratio_does_not_count_as_stagnation() {
        let falling: Vec<f64> = (0..CHECKS_BEFORE_STAGNATION).map(|k| (-0.05 * k as f64).exp()).collect();
        assert_eq!(stagnation_ratio(&falling), None);
        let noisy: Vec<f64> = (0..CHECKS_BEFORE_STAGNATION)
            .map(|k| 0.01 + (-0.5 * k as f64).exp() + 1e-4 * (k % 3) as f64)
            .collect();
        assert!((stagnation_ratio(&noisy).unwrap() - 0.0101).abs() < 1e-4);
    }
}
