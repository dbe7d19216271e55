//! Outcome of a benchmark: checks, their verdicts, and figures.

use colluvium::plots::Picture;
use serde::{Deserialize, Serialize};

/// Outcome of a benchmark.
#[derive(Default, Serialize, Deserialize)]
pub struct BenchmarkOutcome {
    /// Checks, each with measured value and bounds.
    pub checks: Vec<Check>,
    /// Pictures of the page of the benchmark.
    pub figures: Vec<BenchmarkFigure>,
    /// Runs as animations.
    #[serde(rename = "films")]
    pub animations: Vec<BenchmarkAnimation>,
    /// Comparison of several methods on one case: part of a page.
    #[serde(default)]
    pub comparison: Option<String>,
}

/// Animation of a run.
#[derive(Clone, Serialize, Deserialize)]
pub struct BenchmarkAnimation {
    /// Caption under the animation.
    pub caption: String,
    /// HTML element that the animation script takes.
    pub element: String,
}

/// Measured value with its bounds, or a value that is shown without bounds.
#[derive(Serialize, Deserialize)]
pub struct Check {
    /// Name of the checked quantity.
    pub name: String,
    /// Value or statement of the source.
    pub claim: String,
    /// Measured value.
    pub measured: f64,
    /// Lower and upper bound; `None` where the value is shown and not judged.
    pub range: Option<(f64, f64)>,
    /// Reason for the bounds, or for their absence.
    pub reason: String,
    /// Open defect of a check that fails.
    #[serde(skip)]
    pub defect: Option<OpenDefect>,
}

/// Known failure of a check, with an observation.
#[derive(Clone, Debug, Serialize)]
pub struct OpenDefect {
    /// Relation of the failure to the requirement of the source.
    pub criterion: Criterion,
    /// Observation that explains the failure.
    #[serde(rename = "found")]
    pub observation: String,
}

/// Relation of a failed check to the requirement of its source.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Criterion {
    /// The requirement of the source is not met.
    Missed,
    /// The requirement of the source disagrees with a closed form, with another of its references or with its own computation.
    Disputed,
    /// The requirement of the source is met elsewhere; this check goes beyond it.
    Met,
}

impl Criterion {
    /// All criteria, in the order of their weight.
    pub const ALL: [Self; 3] = [Self::Missed, Self::Disputed, Self::Met];

    /// Name of the criterion in the records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Missed => "missed",
            Self::Disputed => "disputed",
            Self::Met => "met",
        }
    }

    /// Text of the criterion, after a number of checks or before an observation.
    pub fn text(self) -> &'static str {
        match self {
            Self::Missed => "against a criterion of the source that is missed",
            Self::Disputed => "against a criterion that another reference contradicts",
            Self::Met => "beyond the criterion of the source, which is met",
        }
    }
}

/// Verdict of a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CheckVerdict {
    /// The value lies within its bounds.
    Pass,
    /// The value lies outside its bounds.
    Fail,
    /// The value lies outside its bounds, and the check is listed among the open defects.
    Open,
    /// The check has no bounds.
    Unbounded,
}

impl CheckVerdict {
    /// Name of the verdict.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Fail => "FAIL",
            Self::Open => "FAIL, open",
            Self::Unbounded => "not judged",
        }
    }
}

impl Check {
    /// Verdict: whether the measured value lies within the bounds; NaN never does.
    pub fn verdict(&self) -> CheckVerdict {
        match self.range {
            None => CheckVerdict::Unbounded,
            Some((low, high)) if self.measured >= low && self.measured <= high => CheckVerdict::Pass,
            Some(_) if self.defect.is_some() => CheckVerdict::Open,
            Some(_) => CheckVerdict::Fail,
        }
    }
}

/// Picture with its caption, as a file.
#[derive(Serialize, Deserialize)]
pub struct BenchmarkFigure {
    /// Caption under the picture.
    pub caption: String,
    /// Extension of the file: `svg` or `png`.
    pub extension: String,
    /// Content of the file.
    pub bytes: Vec<u8>,
}

/// Number of the source to ten digits, plain where that is short.
fn ten_digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.9e}").parse().unwrap_or(value);
    match rounded.abs() {
        0.0 => "0".to_owned(),
        1e-3..1e6 => format!("{rounded}"),
        _ => format!("{rounded:e}"),
    }
}

impl BenchmarkOutcome {
    /// Adds a check within an interval.
    pub fn assert_within(
        &mut self,
        name: impl Into<String>,
        claim: &str,
        measured: f64,
        range: (f64, f64),
        reason: &str,
    ) {
        let (name, claim, reason) = (name.into(), claim.to_owned(), reason.to_owned());
        self.checks.push(Check { name, claim, measured, range: Some(range), reason, defect: None });
    }

    /// Adds a value that is shown without bounds, with the reason.
    pub fn info(&mut self, name: impl Into<String>, claim: &str, measured: f64, reason: &str) {
        let (name, claim, reason) = (name.into(), claim.to_owned(), reason.to_owned());
        self.checks.push(Check { name, claim, measured, range: None, reason, defect: None });
    }

    /// Adds a check within a relative distance of the source's value (absolute for a value of zero).
    pub fn assert_close(
        &mut self,
        name: impl Into<String>,
        exact: f64,
        tolerance: f64,
        measured: f64,
        reason: &str,
    ) {
        let width = tolerance * if exact == 0.0 { 1.0 } else { exact.abs() };
        self.assert_within(name, &ten_digits(exact), measured, (exact - width, exact + width), reason);
    }

    /// Adds checks within one relative distance of values of one source. A row has the name, the value of the source and the measured
    /// value.
    pub fn assert_all_close<N: Into<String>>(
        &mut self,
        rows: impl IntoIterator<Item = (N, f64, f64)>,
        tolerance: f64,
        reason: &str,
    ) {
        for (name, exact, measured) in rows {
            self.assert_close(name, exact, tolerance, measured, reason);
        }
    }

    /// Adds a check above a lower bound.
    pub fn assert_above(
        &mut self,
        name: impl Into<String>,
        claim: &str,
        measured: f64,
        bound: f64,
        reason: &str,
    ) {
        self.assert_within(name, claim, measured, (bound, f64::INFINITY), reason);
    }

    /// Adds a check below an upper bound.
    pub fn assert_below(
        &mut self,
        name: impl Into<String>,
        claim: &str,
        measured: f64,
        bound: f64,
        reason: &str,
    ) {
        self.assert_within(name, claim, measured, (f64::NEG_INFINITY, bound), reason);
    }

    /// Adds a vector figure.
    pub fn svg(&mut self, caption: &str, picture: &impl Picture) -> Result<(), String> {
        let bytes = picture.to_svg()?.into_bytes();
        self.figures.push(BenchmarkFigure {
            caption: caption.to_owned(),
            extension: "svg".to_owned(),
            bytes,
        });
        Ok(())
    }

    /// Adds a raster figure.
    pub fn png(&mut self, caption: &str, picture: &impl Picture) -> Result<(), String> {
        let bytes = picture.to_png()?;
        self.figures.push(BenchmarkFigure {
            caption: caption.to_owned(),
            extension: "png".to_owned(),
            bytes,
        });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reference_values_are_printed_in_the_shortest_form_of_ten_digits() {
        let values = [0.404, 0.0, -2.5e-7, 1e9, 1.0 / 3.0, 0.1 + 0.2];
        assert_eq!(values.map(ten_digits), ["0.404", "0", "-2.5e-7", "1e9", "0.3333333333", "0.3"]);
    }
}
