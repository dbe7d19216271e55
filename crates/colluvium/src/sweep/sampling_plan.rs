//! Sampling plans: combinations of parameter values that are run.

use std::collections::BTreeMap;

use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::sweep::SweepParameter;

/// Largest number of runs of a sweep.
const MAX_RUNS: usize = 100_000;
/// Largest number of parameters of a Sobol sequence.
pub(crate) const SOBOL_DIMENSIONS: usize = sobol_burley::NUM_DIMENSIONS as usize;

/// Sampling plan: combinations of parameter values that are run.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum SamplingPlan {
    /// All combinations of the values (full factorial design).
    #[default]
    #[serde(rename = "grid")]
    FullFactorial,
    /// Values in parallel: the first values of all parameters, then the second ones, …
    #[serde(rename = "together")]
    Parallel,
    /// Latin hypercube sampling: random values, one in each of `runs` equal parts of each parameter's range (McKay, Beckman and Conover
    /// 1979).
    LatinHypercube {
        /// Number of runs.
        runs: usize,
        /// Seed of the random draws; equal seeds draw equal values.
        #[serde(default)]
        seed: u64,
    },
    /// Scrambled Sobol sequence (Owen 1998), whose first points fill the ranges evenly for any number of runs; powers of two are best.
    Sobol {
        /// Number of runs.
        runs: usize,
        /// Seed of the scrambling.
        #[serde(default)]
        seed: u32,
    },
}

impl SamplingPlan {
    /// Paths and problems of all errors.
    pub(super) fn validation_errors(
        &self,
        parameters: &BTreeMap<String, SweepParameter>,
    ) -> Vec<(String, String)> {
        let mut wrong = Vec::new();
        if let Self::FullFactorial | Self::Parallel = self {
            let ranges = parameters.iter().filter(|(_, parameter)| parameter.range.is_some());
            let problem = "applies to the plans latin-hypercube and sobol only; give values";
            wrong.extend(ranges.map(|(name, _)| (format!("parameters.{name}.range"), problem.to_owned())));
        }
        let mut counts = parameters.iter().map(|(name, parameter)| (name, parameter.values.len()));
        match self {
            Self::FullFactorial => {
                let runs = counts.try_fold(1, |runs: usize, (_, count)| runs.checked_mul(count));
                if runs.is_none_or(|runs| runs > MAX_RUNS) {
                    wrong.push(("plan".into(), format!("has more than {MAX_RUNS} runs")));
                }
            }
            Self::Parallel => {
                let Some((first, count)) = counts.next() else { return wrong };
                wrong.extend(counts.filter(|(_, other)| *other != count).map(|(name, other)| {
                    let problem =
                        format!("has {other} entries, and {first} has {count}: the plan together requires equal numbers");
                    (format!("parameters.{name}.values"), problem)
                }));
            }
            Self::LatinHypercube { runs, .. } | Self::Sobol { runs, .. } => {
                if !(1..=MAX_RUNS).contains(runs) {
                    wrong.push(("plan.runs".into(), format!("{runs} is not in 1..={MAX_RUNS}")));
                }
            }
        }
        if matches!(self, Self::Sobol { .. }) && parameters.len() > SOBOL_DIMENSIONS {
            let problem = format!(
                "are {}, and a Sobol sequence has {SOBOL_DIMENSIONS} dimensions at most",
                parameters.len()
            );
            wrong.push(("parameters".into(), problem));
        }
        wrong
    }

    /// Values of each run, in the order of the parameters' names.
    pub(super) fn values(&self, parameters: &BTreeMap<String, SweepParameter>) -> Vec<Vec<Value>> {
        let count = parameters.len();
        let drawn = |fractions: Vec<Vec<f64>>| {
            let of_run = |fractions: Vec<f64>| {
                parameters
                    .values()
                    .zip(fractions)
                    .map(|(parameter, u)| parameter.value_at_fraction(u))
                    .collect()
            };
            fractions.into_iter().map(of_run).collect()
        };
        match self {
            Self::FullFactorial => full_factorial(parameters),
            Self::Parallel => {
                let runs = parameters.values().map(|parameter| parameter.values.len()).min().unwrap_or(0);
                let of_run = |run: usize| parameters.values().map(|p| p.values[run].clone()).collect();
                (0..runs).map(of_run).collect()
            }
            Self::LatinHypercube { runs, seed } => drawn(latin_hypercube(*runs, count, *seed)),
            Self::Sobol { runs, seed } => drawn(sobol(*runs, count, *seed)),
        }
    }
}

/// All combinations of the values, with the last parameter varying fastest.
fn full_factorial(parameters: &BTreeMap<String, SweepParameter>) -> Vec<Vec<Value>> {
    parameters.values().fold(vec![Vec::new()], |runs, parameter| {
        let mut longer = Vec::with_capacity(runs.len() * parameter.values.len());
        for run in runs {
            longer.extend(
                parameter.values.iter().map(|value| [run.as_slice(), std::slice::from_ref(value)].concat()),
            );
        }
        longer
    })
}

/// Draws a Latin hypercube sample: for each run one fraction in `0..1` for each parameter.
fn latin_hypercube(runs: usize, parameters: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut fractions = vec![Vec::with_capacity(parameters); runs];
    for _ in 0..parameters {
        let mut parts: Vec<usize> = (0..runs).collect();
        parts.shuffle(&mut random);
        for (run, part) in fractions.iter_mut().zip(parts) {
            run.push((part as f64 + random.random::<f64>()) / runs as f64);
        }
    }
    fractions
}

/// Scrambled Sobol sequence: for each run one fraction in `0..1` for each parameter.
pub(crate) fn sobol(runs: usize, parameters: usize, seed: u32) -> Vec<Vec<f64>> {
    let point = |run: usize| {
        let coordinate = |k: usize| f64::from(sobol_burley::sample(run as u32, k as u32, seed));
        (0..parameters).map(coordinate).collect()
    };
    (0..runs).map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn latin_hypercube_samples_stratify_every_parameter() {
        let fractions = latin_hypercube(17, 3, 5);
        for parameter in 0..3 {
            let mut parts: Vec<usize> =
                fractions.iter().map(|run| (17.0 * run[parameter]) as usize).collect();
            assert_ne!(parts, (0..17).collect::<Vec<_>>(), "they are shuffled");
            parts.sort_unstable();
            assert_eq!(parts, (0..17).collect::<Vec<_>>());
        }
        assert_eq!(fractions, latin_hypercube(17, 3, 5));
        assert_ne!(fractions, latin_hypercube(17, 3, 6));
    }

    #[test]
    fn sobol_points_stratify_every_parameter_for_a_power_of_two() {
        for seed in [0, 9] {
            let fractions = sobol(64, 5, seed);
            for parameter in 0..5 {
                let mut parts: Vec<usize> =
                    fractions.iter().map(|run| (64.0 * run[parameter]) as usize).collect();
                parts.sort_unstable();
                assert_eq!(parts, (0..64).collect::<Vec<_>>());
            }
        }
    }
}
