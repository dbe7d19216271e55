//! Errors of the constitutive core.

use thiserror::Error;

/// Why a law refused its parameters, its initial state or a step.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum MaterialError {
    /// A parameter lies outside its range.
    #[error("{field}: {value} {rule}")]
    Parameter {
        /// Name of the parameter as it stands in a case file.
        field: &'static str,
        /// The value given, in the units of the case file.
        value: f64,
        /// The rule it breaks, e.g. `is not in 0..=60 degrees`.
        rule: String,
    },
    /// Options that do not go together, or a part that is missing.
    #[error("{field}: {rule}")]
    Choice {
        /// Name of the option as it stands in a case file.
        field: &'static str,
        /// The rule it breaks.
        rule: String,
    },
    /// The initial stress or state is not admissible.
    #[error("initial state of {model}: {reason}")]
    Initial {
        /// Model name.
        model: &'static str,
        /// What is wrong.
        reason: String,
    },
    /// The motion of a step cannot be used (not finite, inverted, too large).
    #[error("{model}: {reason}")]
    Motion {
        /// Model name.
        model: &'static str,
        /// What is wrong.
        reason: &'static str,
    },
    /// The local solve did not converge.
    #[error("{model}: the stress update did not converge ({reason})")]
    NotConverged {
        /// Model name.
        model: &'static str,
        /// Where it stopped.
        reason: &'static str,
    },
}

/// A [`MaterialError`] and the index, within the batch, of the point it happened at.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("point {index} of the batch: {source}")]
pub struct BatchError {
    /// Index within the batch.
    pub index: usize,
    /// What went wrong.
    pub source: MaterialError,
}
