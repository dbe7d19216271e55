//! Choice of the method of a run.

use thiserror::Error;

use crate::case::{Case, CaseError, CaseErrorKind, Method};

/// Reason why no method can be chosen.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum MethodChoiceError {
    /// The case names a method that does not exist, or no method.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// The case has options of several methods.
    #[error("the case has several methods, {}: choose one", names.join(", "))]
    Several {
        /// Names of the methods.
        names: Vec<String>,
    },
    /// The requested method does not exist.
    #[error("{name:?} is not a method; there are: {}", known.join(", "))]
    Unknown {
        /// Requested name.
        name: String,
        /// Names of all methods.
        known: Vec<&'static str>,
    },
}

impl MethodChoiceError {
    /// Stable code of the error, which `docs/messages.md` of the repository explains.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::Case(error) => error.code(),
            Self::Several { .. } => "several-methods",
            Self::Unknown { .. } => "unknown-method",
        }
    }
}

/// Method of a run: the requested one, or the only one that the case has options for.
///
/// # Errors
/// When the requested method or one in the case does not exist, and when the case has options for none or for several.
pub fn select_method(case: &Case, requested: Option<&str>) -> Result<&'static dyn Method, MethodChoiceError> {
    let known: Vec<&'static str> = crate::methods().iter().map(|method| method.name()).collect();
    for name in case.methods.keys() {
        if !known.contains(&name.as_str()) {
            let problem = format!("is not a method; there are: {}", known.join(", "));
            let kind = CaseErrorKind::coded("unknown-method", problem);
            return Err(CaseError::new(format!("methods.{name}"), kind).into());
        }
    }
    let mut names = case.methods.keys();
    let name = match (requested, names.next(), names.next()) {
        (Some(name), ..) => name,
        (None, Some(only), None) => only,
        (None, None, _) => {
            let problem = format!("is empty: give the options of a method, one of {}", known.join(", "));
            return Err(CaseError::new("methods", CaseErrorKind::coded("no-method", problem)).into());
        }
        (None, Some(_), Some(_)) => {
            return Err(MethodChoiceError::Several { names: case.methods.keys().cloned().collect() });
        }
    };
    crate::method(name).ok_or(MethodChoiceError::Unknown { name: name.to_owned(), known })
}
