//! Warnings and notes on the result of a fit.

use colluvium_case::Warning;

use crate::fit::{FitSolution, FittedParameter};

/// Distance from an end of the range that counts as on it (share of the range).
const AT_END: f64 = 1e-3;
/// Correlation above which a pair of parameters is named.
const CORRELATED: f64 = 0.95;
/// Misfit above which the law does not describe the data.
const POOR_MISFIT: f64 = 2.0;

impl FittedParameter {
    /// End of the range at which the value is: `lower`, `upper` or none.
    pub fn end_of_range(&self) -> Option<&'static str> {
        match self.range.share(self.fitted) {
            share if share < AT_END => Some("lower"),
            share if share > 1.0 - AT_END => Some("upper"),
            _ => None,
        }
    }
}

impl FitSolution {
    /// Warnings about the search and the values, each with its remedy.
    pub fn warnings(&self) -> Vec<Warning> {
        let mut all = Vec::new();
        if self.is_exhausted {
            all.push(Warning::new(
                "fit-limit",
                format!(
                    "the search ended at its limit of evaluations ({}): raise search.evaluations",
                    self.evaluations
                ),
            ));
        }
        for parameter in &self.parameters {
            let (name, value) = (&parameter.name, short(parameter.fitted));
            if !parameter.is_determined {
                all.push(Warning::new("undetermined-parameter", format!(
                    "{name} is not determined by these tests (standard deviation above a quarter of its range): add a test or a curve \
                     that depends on it, or fix it"
                )));
            } else if let Some(end) = parameter.end_of_range() {
                all.push(Warning::new("parameter-at-end", format!(
                    "{name} = {value} is at the {end} end of its range: extend the range if values beyond it are possible"
                )));
            }
        }
        if let Some(other) = &self.other_minimum {
            let pairs = self.parameters.iter().zip(&other.values);
            let values: Vec<String> =
                pairs.map(|(parameter, value)| format!("{} = {}", parameter.name, short(*value))).collect();
            all.push(Warning::new("several-minima", format!(
                "other values fit equally well (misfit {:.3}): {}; add a test that separates them, or narrow the ranges",
                other.misfit,
                values.join(", ")
            )));
        }
        all
    }

    /// Notes on correlated parameters, failed trials and a poor fit.
    pub fn notes(&self) -> Vec<Warning> {
        let mut all = Vec::new();
        for (i, first) in self.parameters.iter().enumerate() {
            for (j, second) in self.parameters.iter().enumerate().skip(i + 1) {
                let correlation = self.correlations[i][j];
                if correlation.abs() > CORRELATED {
                    all.push(Warning::new("correlated-parameters", format!(
                        "{} and {} are correlated ({correlation:.3}): these tests determine a combination of them",
                        first.name, second.name
                    )));
                }
            }
        }
        if let Some(reason) = &self.failure_reason {
            all.push(Warning::new(
                "failed-trials",
                format!(
                    "{} of {} evaluations failed and count as an infinite misfit, as {reason}",
                    self.failures, self.evaluations
                ),
            ));
        }
        if self.misfit > POOR_MISFIT {
            all.push(Warning::new("poor-fit", format!(
                "the misfit {:.2} is above {POOR_MISFIT}: the law does not reproduce these tests within their tolerances",
                self.misfit
            )));
        }
        all
    }
}

/// Number with five significant digits, with an exponent if it is very large or small.
pub fn short(value: f64) -> String {
    rounded(value, 4)
}

/// Uncertainty with two significant digits, with an exponent if it is very large or small.
pub fn uncertainty_text(value: f64) -> String {
    rounded(value, 1)
}

/// Number with `decimals` digits after the first one.
fn rounded(value: f64, decimals: usize) -> String {
    let value: f64 = format!("{value:.decimals$e}").parse().unwrap_or(value);
    let is_plain = value == 0.0 || (1e-4..1e5).contains(&value.abs());
    if is_plain { format!("{value}") } else { format!("{value:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_numbers_have_five_digits_and_uncertainties_two() {
        let numbers = [0.0, 30.0, 2e8, 1.234567e7, 0.0312349, -3.5, 1e-9];
        let texts = ["0", "30", "2e8", "1.2346e7", "0.031235", "-3.5", "1e-9"];
        assert_eq!(numbers.map(short), texts);
        assert_eq!([0.062085, 302_330.0].map(uncertainty_text), ["0.062", "3e5"]);
    }
}
