//! Errors of the constitutive core.

use thiserror::Error;

use crate::driver::{ElementTest, LoadingPath, TestStage};
use crate::{Mat3, MaterialSpec, Motion, SymTensor};

/// Why a law refused its parameters, its initial state or a step.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum MaterialError {
    /// A parameter lies outside its range.
    #[error("{field}: {value} {rule}{}", model_suffix(model))]
    Parameter {
        /// Name of the model as it stands in a case file; empty where a law is built by itself.
        model: &'static str,
        /// Name of the parameter as it stands in a case file.
        field: String,
        /// The value given, in the units of the case file.
        value: f64,
        /// The rule it breaks, e.g. `is not in 0..=60 degrees`.
        rule: String,
    },
    /// Options that do not go together, or a part that is missing.
    #[error("{field}: {rule}{}", model_suffix(model))]
    Choice {
        /// Name of the model as it stands in a case file; empty where a law is built by itself.
        model: &'static str,
        /// Name of the option as it stands in a case file.
        field: String,
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
    /// As [`MaterialError::NotConverged`], with the step it happened in.
    #[error(transparent)]
    UnconvergedStep(Box<UnconvergedStep>),
}

/// A step whose stress no local solve found.
#[derive(Clone, Debug, PartialEq, Error)]
#[error(
    "{model}: the stress update did not converge ({reason}), from the stress {:?} Pa by the mid-step gradient {:?} \
     in {dt} s",
    stress.0,
    gradient.0
)]
pub struct UnconvergedStep {
    /// Model name.
    pub model: &'static str,
    /// Where the solve stopped.
    pub reason: &'static str,
    /// Stress before the step (Pa).
    pub stress: SymTensor,
    /// Velocity gradient times the step.
    pub gradient: Mat3,
    /// Step (s).
    pub dt: f64,
}

impl UnconvergedStep {
    /// The step as an element test of `material`, to look at it alone. Internal variables are those of a point that
    /// starts with this stress.
    pub fn element_test(&self, material: MaterialSpec) -> ElementTest {
        let velocity_gradient = (self.gradient * (1.0 / self.dt)).0;
        ElementTest {
            title: self.to_string(),
            material,
            initial_stress: self.stress.0,
            stages: vec![TestStage {
                path: LoadingPath::Flow { velocity_gradient },
                steps: 1,
                duration: self.dt,
            }],
        }
    }
}

/// The model's name behind a message.
fn model_suffix(model: &str) -> String {
    if model.is_empty() { String::new() } else { format!(" ({model})") }
}

impl MaterialError {
    /// `field` has the value `value`, which breaks `rule`.
    pub(crate) fn parameter(field: impl Into<String>, value: f64, rule: impl Into<String>) -> Self {
        Self::Parameter { model: "", field: field.into(), value, rule: rule.into() }
    }

    /// `field` was chosen against `rule`.
    pub(crate) fn choice(field: impl Into<String>, rule: impl Into<String>) -> Self {
        Self::Choice { model: "", field: field.into(), rule: rule.into() }
    }

    /// The same error of a parameter, said of `name`; an inner material's keeps its own name.
    pub(crate) fn with_model(mut self, name: &'static str) -> Self {
        if let Self::Parameter { model, .. } | Self::Choice { model, .. } = &mut self
            && model.is_empty()
        {
            *model = name;
        }
        self
    }

    /// The same error of a parameter, of a material that stands under the key `part` of another.
    pub(crate) fn under_key(mut self, part: &str) -> Self {
        if let Self::Parameter { field, .. } | Self::Choice { field, .. } = &mut self {
            *field = format!("{part}.{field}");
        }
        self
    }

    /// The same error of the parameter `from`, under the key `to`.
    pub(crate) fn with_key(mut self, from: &str, to: &str) -> Self {
        if let Self::Parameter { field, .. } | Self::Choice { field, .. } = &mut self
            && field == from
        {
            *field = to.to_owned();
        }
        self
    }

    /// Key of the parameter that the error is about, and what is wrong with it, the model's name included;
    /// `None` for errors about no parameter.
    pub fn parameter_problem(&self) -> Option<(&str, String)> {
        match self {
            Self::Parameter { model, field, value, rule } => {
                Some((field, format!("{value} {rule}{}", model_suffix(model))))
            }
            Self::Choice { model, field, rule } => Some((field, format!("{rule}{}", model_suffix(model)))),
            _ => None,
        }
    }
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

impl BatchError {
    /// The same error with the step that it happened in, where a solve failed.
    pub(crate) fn with_step(self, motion: impl Fn(usize) -> Motion, stresses: &[SymTensor]) -> Self {
        let MaterialError::NotConverged { model, reason } = self.source else { return self };
        let (stress, motion) = (stresses[self.index], motion(self.index));
        let unsolved =
            UnconvergedStep { model, reason, stress, gradient: motion.velocity_gradient_dt, dt: motion.dt };
        Self { source: MaterialError::UnconvergedStep(Box::new(unsolved)), ..self }
    }
}
