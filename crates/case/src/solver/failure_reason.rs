//! Reasons of failed points and steps.

use colluvium_constitutive::MaterialError;
use colluvium_points::SearchError;
use thiserror::Error;

/// Reason why a point or a step cannot be continued.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FailureReason {
    /// Law that refuses the motion or the stress of the point.
    #[error("{error}")]
    Law {
        /// Name of the material in the case; empty where it is not known.
        material: String,
        /// Error of the law.
        error: Box<MaterialError>,
    },
    /// Position, velocity or stress that is not finite.
    #[error("{0}")]
    NotFinite(String),
    /// Point that moves too far in one step: the run has become unstable.
    #[error("{0}")]
    Unstable(String),
    /// Point that has left the domain, the mesh or the terrain.
    #[error("{0}")]
    LeftDomain(String),
    /// Fixed time step of the case that exceeds the critical one.
    #[error("{0}")]
    FixedStep(String),
    /// Step after a failed one.
    #[error("an earlier step has failed: build a new solver")]
    HasFailed,
    /// Step after the end of the last stage.
    #[error("the last stage has ended: add a stage to the case, or make the last one longer")]
    IsComplete,
    /// Other reason, in words.
    #[error("{reason}")]
    Other {
        /// Code of the reason.
        code: &'static str,
        /// Reason.
        reason: String,
    },
}

impl FailureReason {
    /// Reason of the code `code`, in words.
    pub fn coded(code: &'static str, reason: impl Into<String>) -> Self {
        Self::Other { code, reason: reason.into() }
    }

    /// Stable code of the reason, which `docs/messages.md` of the repository explains.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::Law { error, .. } => error.code(),
            Self::NotFinite(_) => "state-not-finite",
            Self::Unstable(_) => "unstable",
            Self::LeftDomain(_) => "left-domain",
            Self::FixedStep(_) => "fixed-step-too-long",
            Self::HasFailed => "solver-has-failed",
            Self::IsComplete => "stages-complete",
            Self::Other { code, .. } => code,
        }
    }

    /// Reason with the name of the material, where a law refuses the step.
    #[must_use]
    pub fn of_material(mut self, name: &str) -> Self {
        if let Self::Law { material, .. } = &mut self {
            name.clone_into(material);
        }
        self
    }
}

impl From<MaterialError> for FailureReason {
    fn from(error: MaterialError) -> Self {
        Self::Law { material: String::new(), error: Box::new(error) }
    }
}

impl From<SearchError> for FailureReason {
    fn from(error: SearchError) -> Self {
        match error {
            SearchError::NotFinite(_) => Self::NotFinite(error.to_string()),
            other => Self::coded(other.code(), other.to_string()),
        }
    }
}

impl From<String> for FailureReason {
    fn from(reason: String) -> Self {
        Self::coded("step-failed", reason)
    }
}

impl From<&str> for FailureReason {
    fn from(reason: &str) -> Self {
        Self::coded("step-failed", reason)
    }
}
