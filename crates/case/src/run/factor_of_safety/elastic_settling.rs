//! How bodies that do not yield come to rest: the measure of time, of displacement and of unbalanced force for the trials.

use crate::run::RunError;
use crate::run::factor_of_safety::slope_scale::exceeded_displacement;
use crate::run::factor_of_safety::strength_trial::RunningTrial;
use crate::run::factor_of_safety::{REST_RATIO, SearchContext};

/// Steps between two looks.
const STEPS_PER_CHECK: u64 = 20;
/// Looks in a row at which the bodies must be at rest.
const CHECKS_AT_REST: usize = 3;
/// Looks before the unbalanced force is asked whether it still falls, and between two such questions.
const CHECKS_BEFORE_STAGNATION: usize = 64;
/// It no longer falls where its median over the last half of the time is more than this share of that over the quarter before.
const STILL_FALLS: f64 = 0.9;
/// More looks than any body takes whose time of rest is to be found.
const MAX_CHECKS: usize = 5000;
/// Shortest time of rest, in looks.
const MIN_CHECKS: usize = 3;

/// How bodies that do not yield come to rest.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ElasticSettling {
    /// Time that they take (s).
    pub time: f64,
    /// Unbalanced-force ratio below which a method does not come.
    pub floor: f64,
    /// What the whole weight settles them (m).
    pub displacement: f64,
}

fn median(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

/// The ratio at which a method stays that does not come to rest, from its ratios at all looks so far.
fn stagnation_ratio(ratios: &[f64]) -> Option<f64> {
    let count = ratios.len();
    if count < CHECKS_BEFORE_STAGNATION || !count.is_multiple_of(CHECKS_BEFORE_STAGNATION) {
        return None;
    }
    let [before, last] = [median(&ratios[count / 4..count / 2]), median(&ratios[count / 2..])];
    (last > STILL_FALLS * before).then_some(last)
}

impl ElasticSettling {
    /// Waits until bodies rest in the case of [`FactorOfSafety::unloading`](crate::description::FactorOfSafety::unloading); `None` when
    /// it is asked to stop.
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
            ratios.push(trial.unbalanced());
            times.push(trial.elapsed());
            let resting = ratios.iter().rev().take_while(|ratio| **ratio < REST_RATIO).count();
            if resting >= CHECKS_AT_REST {
                break Some((0.0, ratios.len() - resting));
            }
            if let Some(floor) = stagnation_ratio(&ratios) {
                let near = |ratio: &f64| *ratio < floor / STILL_FALLS;
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
                    time: trial.elapsed(),
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
    fn a_ratio_that_falls_does_not_stay() {
        let falling: Vec<f64> = (0..CHECKS_BEFORE_STAGNATION).map(|k| (-0.05 * k as f64).exp()).collect();
        assert_eq!(stagnation_ratio(&falling), None);
        let noisy: Vec<f64> = (0..CHECKS_BEFORE_STAGNATION)
            .map(|k| 0.01 + (-0.5 * k as f64).exp() + 1e-4 * (k % 3) as f64)
            .collect();
        assert!((stagnation_ratio(&noisy).unwrap() - 0.0101).abs() < 1e-4);
    }
}
