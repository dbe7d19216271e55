//! Errors of the constitutive core.

use thiserror::Error;

use crate::{Mat3, Motion, SymTensor};

/// Error of a law: rejected parameters, initial state or step.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum MaterialError {
    /// Parameter outside its range.
    #[error("{field}: {value} {rule}{}", model_suffix(model))]
    Parameter {
        /// Name of the model in a case file; empty where a law is built by itself.
        model: &'static str,
        /// Name of the parameter in a case file.
        field: String,
        /// Given value, in the units of the case file.
        value: f64,
        /// Violated rule, e.g. `is not in 0..=60 degrees`.
        rule: String,
    },
    /// Incompatible options, or a missing part.
    #[error("{field}: {rule}{}", model_suffix(model))]
    IncompatibleOptions {
        /// Name of the model in a case file; empty where a law is built by itself.
        model: &'static str,
        /// Name of the option in a case file.
        field: String,
        /// Violated rule.
        rule: String,
    },
    /// Initial stress or state that is not admissible.
    #[error("initial state of {model}: {reason}")]
    Initial {
        /// Name of the model.
        model: &'static str,
        /// Reason.
        reason: String,
    },
    /// Motion of a step that cannot be used (not finite, inverted, too large).
    #[error("{model}: {reason}")]
    Motion {
        /// Name of the model.
        model: &'static str,
        /// Reason.
        reason: &'static str,
    },
    /// Local solve that did not converge.
    #[error("{model}: the stress update did not converge ({reason})")]
    NotConverged {
        /// Name of the model.
        model: &'static str,
        /// Reason of the stop.
        reason: &'static str,
    },
    /// Step that a law of the program refuses.
    #[error("{law}: {reason}")]
    Update {
        /// Name of the law.
        law: String,
        /// Reason.
        reason: String,
    },
    /// Unconverged solve as [`MaterialError::NotConverged`], with its step.
    #[error(transparent)]
    UnconvergedStep(Box<UnconvergedStep>),
}

/// Step without a converged local solve.
#[derive(Clone, Debug, PartialEq, Error)]
#[error(
    "{model}: the stress update did not converge ({reason}), from the stress {:?} Pa by the mid-step gradient {:?} \
     in {dt} s",
    stress.0,
    gradient.0
)]
pub struct UnconvergedStep {
    /// Name of the model.
    pub model: &'static str,
    /// Reason for which the step did not converge.
    pub reason: &'static str,
    /// Stress before the step (Pa).
    pub stress: SymTensor,
    /// Velocity gradient times the step.
    pub gradient: Mat3,
    /// Step (s).
    pub dt: f64,
}

/// Name of the model as the suffix of a message.
fn model_suffix(model: &str) -> String {
    if model.is_empty() { String::new() } else { format!(" ({model})") }
}

impl MaterialError {
    /// Stable code of the error, which `docs/messages.md` of the repository explains.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::Parameter { .. } => "parameter",
            Self::IncompatibleOptions { .. } => "incompatible-options",
            Self::Initial { .. } => "initial-state",
            Self::Motion { .. } => "motion",
            Self::NotConverged { .. } | Self::UnconvergedStep(_) => "not-converged",
            Self::Update { .. } => "law-refuses-step",
        }
    }

    /// Error of a step that the law `law` refuses, for laws of a program.
    pub fn update(law: impl Into<String>, reason: impl Into<String>) -> Self {
        Self::Update { law: law.into(), reason: reason.into() }
    }

    /// Error of `field` with the value `value`, which violates `rule`.
    pub fn parameter(field: impl Into<String>, value: f64, rule: impl Into<String>) -> Self {
        Self::Parameter { model: "", field: field.into(), value, rule: rule.into() }
    }

    /// Error of the choice of `field` against `rule`.
    pub(crate) fn incompatible_options(field: impl Into<String>, rule: impl Into<String>) -> Self {
        Self::IncompatibleOptions { model: "", field: field.into(), rule: rule.into() }
    }

    /// Sets the model name of a parameter error, unless an inner material has already set it.
    pub(crate) fn with_model(mut self, name: &'static str) -> Self {
        if let Self::Parameter { model, .. } | Self::IncompatibleOptions { model, .. } = &mut self
            && model.is_empty()
        {
            *model = name;
        }
        self
    }

    /// Adds the prefix `part`, the key of an inner material, to the parameter key of the error.
    pub(crate) fn under_key(mut self, part: &str) -> Self {
        if let Self::Parameter { field, .. } | Self::IncompatibleOptions { field, .. } = &mut self {
            *field = if field.is_empty() { part.to_owned() } else { format!("{part}.{field}") };
        }
        self
    }

    /// Renames the parameter `from` of the error to the key `to`.
    pub(crate) fn with_key(mut self, from: &str, to: &str) -> Self {
        if let Self::Parameter { field, .. } | Self::IncompatibleOptions { field, .. } = &mut self
            && field == from
        {
            *field = to.to_owned();
        }
        self
    }

    /// Key of the invalid parameter and the reason with the name of the model; `None` for errors that concern no parameter.
    pub fn parameter_problem(&self) -> Option<(&str, String)> {
        self.parameter_rule().map(|(field, value, rule)| match value {
            Some(value) => (field, format!("{value} {rule}")),
            None => (field, rule),
        })
    }

    /// Key of the invalid parameter, its value where it is a number out of its range, and the violated rule with the name of the model;
    /// `None` for errors that concern no parameter.
    pub fn parameter_rule(&self) -> Option<(&str, Option<f64>, String)> {
        match self {
            Self::Parameter { model, field, value, rule } => {
                Some((field, Some(*value), format!("{rule}{}", model_suffix(model))))
            }
            Self::IncompatibleOptions { model, field, rule } => {
                Some((field, None, format!("{rule}{}", model_suffix(model))))
            }
            _ => None,
        }
    }
}

/// A [`MaterialError`] with the index of its point within the batch.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("point {index} of the batch: {source}")]
pub struct BatchError {
    /// Index of the point within the batch.
    pub index: usize,
    /// Error of the point.
    pub source: MaterialError,
}

impl BatchError {
    /// Adds motion and stress of the failed point to the error, if its local solve did not converge.
    pub(crate) fn with_step(self, motion: impl Fn(usize) -> Motion, stresses: &[SymTensor]) -> Self {
        let MaterialError::NotConverged { model, reason } = self.source else { return self };
        let (stress, motion) = (stresses[self.index], motion(self.index));
        let unsolved =
            UnconvergedStep { model, reason, stress, gradient: motion.velocity_gradient_dt, dt: motion.dt };
        Self { source: MaterialError::UnconvergedStep(Box::new(unsolved)), ..self }
    }
}
