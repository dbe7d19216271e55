//! Errors in a case.

use std::path::Path;

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

/// Everything found wrong in a case file, at least one error; displayed one a line.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{}", lines(.0))]
pub struct CaseErrors(pub Vec<CaseError>);

fn lines(errors: &[CaseError]) -> String {
    let lines: Vec<String> = errors.iter().map(ToString::to_string).collect();
    lines.join("\n")
}

impl CaseErrors {
    /// A single error.
    pub fn one(error: CaseError) -> Self {
        Self(vec![error])
    }

    /// The same errors, with the file that they are in before their places.
    #[must_use]
    pub fn in_file(self, file: &Path) -> Self {
        let located =
            |error: CaseError| CaseError::new(format!("{}: {}", file.display(), error.path), error.problem);
        Self(self.0.into_iter().map(located).collect())
    }

    /// The first error.
    pub fn first(&self) -> &CaseError {
        &self.0[0]
    }
}

impl From<CaseError> for CaseErrors {
    fn from(error: CaseError) -> Self {
        Self::one(error)
    }
}
