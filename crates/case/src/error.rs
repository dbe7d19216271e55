//! Errors in a case.

use thiserror::Error;

/// What is wrong in a case file, and where: `materials.sand.friction_angle: 95 is not in 0..=60 degrees`.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{path}: {problem}")]
pub struct CaseError {
    /// JSON path of the offending value, e.g. `bodies[1].shape.radius`.
    pub path: String,
    /// What is wrong with it, naming value and rule.
    pub problem: String,
}

impl CaseError {
    /// An error at `path`.
    pub fn new(path: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { path: path.into(), problem: problem.into() }
    }
}
