//! Estimated cost of a search for a factor of safety, before the run.

use colluvium_constitutive::MaterialSpec;

use crate::description::FactorOfSafety;
use crate::run::factor_of_safety::slope_scale::youngs_modulus;
use crate::run::factor_of_safety::strength_trial::WINDOWS;
use crate::{Case, Plan};

/// Settling time of bodies without yielding under strong local damping, over the time of a wave of speed `√(E/ρ)` through their height: 11
/// for a slope by SPH, 28 for one on a foundation by MPM (`compare/slope-cut`, `compare/slope-layers`).
const SETTLING_TIME_RATIO: f64 = 20.0;
/// Mean number of windows of a trial: stable bodies rest after two to four, failing ones are recognised after two to seven.
const LIKELY_WINDOWS: f64 = 4.0;

/// Estimated cost of a search for a factor of safety, in addition to the stages of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SearchCost {
    /// Likely and largest number of trials. The likely one is that of a search whose trials are all decided; around undecided factors the
    /// interval is narrowed from both sides.
    pub trials: [u32; 2],
    /// Largest number of time windows of a trial, in which it is evaluated.
    pub windows: usize,
    /// Duration of a time window of a trial (s), given by the case or estimated. Not-a-number where no stiffness is known for the estimate.
    pub window: f64,
    /// Likely and largest time of the search (s on one thread). Not-a-number where the duration of a window is.
    pub seconds: [f64; 2],
}

impl FactorOfSafety {
    /// Likely number of trials, of a search whose trials are all decided, and largest number.
    fn likely_and_largest_trials(&self) -> [u32; 2] {
        let [low, high] = self.range;
        let halvings = ((high - low) / self.tolerance).log2().ceil().max(0.0) as u32;
        // An undecided trial in the middle leaves two halves to search.
        [2 + halvings, 2 + halvings.max((2 * halvings).saturating_sub(1))]
    }
}

/// Travel time of a wave in the softest body through the height of all bodies along gravity (s).
fn passage(case: &Case) -> f64 {
    let size = case.gravity_magnitude();
    let (mut low, mut high, mut slowest) = (f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY);
    for body in case.bodies.iter().filter(|body| !body.rigid) {
        let (from, to) = body.shape.bounds(case.dimension());
        let ends = |up: bool| {
            let of =
                |((g, from), to): ((&f64, &f64), &f64)| g / size * if (*g > 0.0) == up { to } else { from };
            case.gravity.iter().zip(&from).zip(&to).map(of).sum::<f64>()
        };
        (low, high) = (low.min(ends(false)), high.max(ends(true)));
        let density = case.materials.get(&body.material).map(MaterialSpec::density);
        let Some((modulus, density)) = youngs_modulus(case, &body.material).zip(density) else {
            return f64::NAN;
        };
        slowest = slowest.min((modulus / density).sqrt());
    }
    // Gravity whose magnitude is lost in round-off has no direction.
    let passage = (high - low) / slowest;
    if passage.is_finite() { passage } else { f64::NAN }
}

impl SearchCost {
    /// Estimates the cost of `search` in a case with this plan.
    pub fn of_case(case: &Case, plan: &Plan, search: &FactorOfSafety) -> Self {
        let trials = search.likely_and_largest_trials();
        let window = search
            .duration
            .map_or_else(|| SETTLING_TIME_RATIO * passage(case), |duration| duration / WINDOWS as f64);
        let each = plan.points as f64 * (window / plan.time_step.dt) / plan.updates_per_second;
        // The elastic settling takes one more window.
        let seconds = |trials: u32, windows: f64| each * (1.0 + f64::from(trials) * windows);
        let seconds = [seconds(trials[0], LIKELY_WINDOWS), seconds(trials[1], WINDOWS as f64)];
        Self { trials, windows: WINDOWS, window, seconds }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::factor_of_safety::{SafetyResult, StrengthTrial, TrialVerdict};

    /// Number of trials of a search in which bodies are stable below the factor `stands`, fail above `falls`, and are undecided between.
    fn trial_count(search: &FactorOfSafety, stands: f64, falls: f64) -> u32 {
        let mut safety = SafetyResult {
            stable_factor: 0.0,
            failing_factor: f64::INFINITY,
            tolerance: search.tolerance,
            height: 1.0,
            window: 1.0,
            trials: Vec::new(),
        };
        while let Some(factor) = safety.next_factor(search.range) {
            let verdict = match factor {
                f if f <= stands => TrialVerdict::Stable,
                f if f >= falls => TrialVerdict::Failed,
                _ => TrialVerdict::Undecided,
            };
            let [time, displacement, dimensionless_displacement, unbalanced_force] = [0.0; 4];
            safety.add(StrengthTrial {
                factor,
                verdict,
                time,
                displacement,
                dimensionless_displacement,
                unbalanced_force,
            });
        }
        safety.trials.len() as u32
    }

    #[test]
    fn searches_need_no_more_trials_than_estimated() {
        for tolerance in [0.01, 0.04, 0.3, 5.0] {
            let json = format!(r#"{{ "after": "rest", "tolerance": {tolerance} }}"#);
            let search: FactorOfSafety = serde_json::from_str(&json).unwrap();
            let [decided, upper_bound] = search.likely_and_largest_trials();
            let mut largest = 0;
            for k in 0..500 {
                let true_factor = 0.5 + 0.005 * f64::from(k);
                assert_eq!(
                    trial_count(&search, true_factor, true_factor),
                    decided,
                    "{tolerance} {true_factor}"
                );
                for wide in [0.002, 0.02, 0.2, 1.0, 3.0] {
                    largest = largest.max(trial_count(&search, true_factor, true_factor + wide));
                }
            }
            assert!(largest <= upper_bound, "{tolerance}: {largest} trials for {upper_bound}");
            assert!(
                tolerance > 0.1 || largest + 1 >= upper_bound,
                "{tolerance}: {largest} trials for {upper_bound}"
            );
        }
    }
}
