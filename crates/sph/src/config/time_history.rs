//! Factors that vary in time.

use colluvium_case::CaseErrorKind;
use colluvium_case::files::piecewise_linear as lines;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Factor in time: linear between values, constant outside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TimeHistory {
    /// Times of the run (s), ascending.
    pub times: Vec<f64>,
    /// Factors.
    pub factors: Vec<f64>,
}

impl TimeHistory {
    /// Factors (-) at times of the run (s) in ascending order.
    #[must_use]
    pub fn new(times: impl Into<Vec<f64>>, factors: impl Into<Vec<f64>>) -> Self {
        Self { times: times.into(), factors: factors.into() }
    }

    /// Checks the history: not empty, as many factors as times, finite values, increasing times.
    ///
    /// # Errors
    /// The problem, as (key, problem).
    pub fn validate(&self) -> Result<(), (String, CaseErrorKind)> {
        if self.times.is_empty() {
            return Err(("times".to_owned(), "is empty: at least one time is needed".into()));
        }
        if self.times.len() != self.factors.len() {
            let problem = format!("has {} entries for {} times", self.factors.len(), self.times.len());
            return Err(("factors".to_owned(), problem.into()));
        }
        for (key, values) in [("times", &self.times), ("factors", &self.factors)] {
            if let Some(number) = values.iter().position(|value| !value.is_finite()) {
                let problem = format!("{} is not finite", values[number]);
                return Err((format!("{key}[{number}]"), CaseErrorKind::NotFinite(problem)));
            }
        }
        let descent = lines::non_ascending(self.times.iter().copied(), false).next();
        descent.map_or(Ok(()), |(number, time, before)| {
            let rule = format!("s is not later than the time before, {before} s");
            Err((format!("times[{number}]"), CaseErrorKind::out_of_range(time, rule)))
        })
    }

    /// Factor at `time` (s).
    pub fn factor_at(&self, time: f64) -> f64 {
        lines::value_at(&self.times, |t| *t, |number| self.factors[number], time).unwrap_or(1.0)
    }

    /// Mean factor from `start` to `end` (s), with which the displacement of a step is exact for any step length.
    pub fn mean(&self, start: f64, end: f64) -> f64 {
        let (area, last, rest) = self.integral_pieces(start, end);
        if last == start { rest } else { (area + (end - last) * rest) / (end - start) }
    }

    /// Integral of the factor from `start` to `end` (s).
    pub fn integral(&self, start: f64, end: f64) -> f64 {
        let (area, last, rest) = self.integral_pieces(start, end);
        area + (end - last) * rest
    }

    /// Integral of the factor from `start` to its last time value before `end`, this time, and the mean from there to `end`.
    fn integral_pieces(&self, start: f64, end: f64) -> (f64, f64, f64) {
        let (mut area, mut last) = (0.0, (start, self.factor_at(start)));
        let first = self.times.partition_point(|t| *t <= start);
        for (&time, &factor) in self.times[first..].iter().zip(&self.factors[first..]) {
            if time >= end {
                break;
            }
            area += (time - last.0) * 0.5 * (last.1 + factor);
            last = (time, factor);
        }
        (area, last.0, 0.5 * (last.1 + self.factor_at(end)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn history() -> TimeHistory {
        TimeHistory { times: vec![1.0, 2.0, 4.0], factors: vec![0.0, 3.0, -1.0] }
    }

    #[test]
    fn factors_lie_on_straight_lines_and_stay_beyond_the_ends() {
        for (time, factor) in
            [(-1.0, 0.0), (1.0, 0.0), (1.5, 1.5), (2.0, 3.0), (3.5, 0.0), (4.0, -1.0), (9.0, -1.0)]
        {
            assert_eq!(history().factor_at(time), factor, "{time}");
        }
        let step = TimeHistory { times: vec![2.0], factors: vec![0.7] };
        assert_eq!((step.factor_at(0.0), step.mean(0.0, 5.0)), (0.7, 0.7));
    }

    #[test]
    fn means_are_those_of_the_lines() {
        let h = history();
        // ∫ is 1.5 over the first line and 2 over the second.
        assert!((h.mean(0.0, 5.0) - (1.5 + 2.0 - 1.0) / 5.0).abs() < 1e-15);
        assert!((h.integral(0.0, 5.0) - 2.5).abs() < 1e-15 && h.integral(3.0, 3.0) == 0.0);
        assert!((h.mean(1.0, 1.5) - 0.75).abs() < 1e-15);
        assert!((h.mean(1.5, 3.0) - (1.125 + 2.0) / 1.5).abs() < 1e-15);
        let (mut sum, mut time) = (0.0, 0.0);
        for k in 0..500 {
            let next = f64::from(k + 1) * 0.01;
            sum += h.mean(time, next) * (next - time);
            time = next;
        }
        assert!((sum - 2.5).abs() < 1e-13);
    }

    #[test]
    fn invalid_time_histories_are_refused_by_key() {
        for (times, factors, key) in [
            (vec![], vec![], "times"),
            (vec![0.0, 1.0], vec![1.0], "factors"),
            (vec![0.0, f64::NAN], vec![1.0, 1.0], "times[1]"),
            (vec![0.0, 1.0], vec![1.0, f64::INFINITY], "factors[1]"),
            (vec![0.0, 1.0, 1.0], vec![1.0, 1.0, 2.0], "times[2]"),
        ] {
            assert_eq!(TimeHistory { times, factors }.validate().unwrap_err().0, key);
        }
    }
}
