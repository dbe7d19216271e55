//! Kinds of errors of a case.

use std::path::PathBuf;

use colluvium_constitutive::MaterialError;
use thiserror::Error;

use crate::Feature;

/// Reason of an error of a case, with its data; its text is the message without the path.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum CaseErrorKind {
    /// Key that no object of this place has.
    #[error("unknown key;{} allowed: {}", suggestion_sentence(suggestion.as_deref()), allowed.join(", "))]
    UnknownKey {
        /// Known key with a similar name.
        suggestion: Option<String>,
        /// Keys of this place.
        allowed: Vec<String>,
    },
    /// Value that is none of the choices of its key.
    #[error("{found} is not one of {}{}", choices.join(", "), suggestion_clause(suggestion.as_deref()))]
    UnknownChoice {
        /// Value as JSON, shortened.
        found: String,
        /// Choices of the key.
        choices: Vec<String>,
        /// Choice with a similar name.
        suggestion: Option<String>,
    },
    /// Name that the case does not define, for example of a body or a stage.
    #[error("{name:?} is not {expected}{}", suggestion_clause(suggestion.as_deref()))]
    UnknownName {
        /// Name in the case.
        name: String,
        /// Description of the names that are allowed: `the name of a body`.
        expected: String,
        /// Allowed name that is similar.
        suggestion: Option<String>,
    },
    /// Key of an earlier version.
    #[error("this key is now called {new:?}")]
    RenamedKey {
        /// Present name.
        new: String,
    },
    /// Choice of an earlier version.
    #[error("{old:?} is now called {new:?}")]
    RenamedChoice {
        /// Earlier name.
        old: String,
        /// Present name.
        new: String,
    },
    /// Required key that an object lacks.
    #[error("the key {key:?} is missing{}", choices_clause(choices))]
    MissingKey {
        /// Missing key.
        key: String,
        /// Values that the key may have, where it names the variant of the object.
        choices: Vec<String>,
    },
    /// Input that a method requires: bodies, materials, gravity, or its options.
    #[error("{problem}")]
    MissingInput {
        /// Name of the method.
        method: String,
        /// Message.
        problem: String,
    },
    /// Finite number outside its range.
    #[error("{value} {rule}")]
    OutOfRange {
        /// Given number, in the units of the case.
        value: f64,
        /// Violated rule, with unit: `is not in 0..=60 degrees`, `must be positive (m)`.
        rule: String,
    },
    /// Number that is NaN or infinite.
    #[error("{0}")]
    NotFinite(String),
    /// Value of another type than that of its key.
    #[error("{found} {rule}")]
    WrongType {
        /// Value as JSON, shortened.
        found: String,
        /// Violated rule: `is not of type number`.
        rule: String,
    },
    /// List with too few or too many entries.
    #[error("has {length} entries, {rule}")]
    WrongLength {
        /// Number of entries.
        length: usize,
        /// Violated rule: `2 are needed`.
        rule: String,
    },
    /// Text that is no JSON, or with a key twice in one object. The path of the error is its place in the text.
    #[error("{problem}")]
    Syntax {
        /// Line, from 1.
        line: usize,
        /// Column, from 1.
        column: usize,
        /// Message.
        problem: String,
    },
    /// Feature of the case that the method does not support.
    #[error("{}", reason.clone().unwrap_or_else(|| unavailable(*feature, method)))]
    NotSupported {
        /// Feature, whose path in the case is the path of the error.
        feature: Feature,
        /// Name of the method.
        method: String,
        /// Reason of the method and an alternative; `None` where the method has no rule for the feature.
        reason: Option<String>,
    },
    /// Law that rejects its parameters in combination, or the initial state.
    #[error(transparent)]
    Material(#[from] MaterialError),
    /// Case file, or another JSON file, that cannot be read. The path of the error is that of the file.
    #[error("{problem}")]
    Unreadable {
        /// File.
        file: PathBuf,
        /// Message.
        problem: String,
    },
    /// File that the case names, and that cannot be read or does not fit.
    #[error("{}: {problem}", file.display())]
    File {
        /// File.
        file: PathBuf,
        /// Code of the problem.
        code: &'static str,
        /// Message.
        problem: String,
    },
    /// Other error: keys that exclude each other, repeated names, positions that do not fit.
    #[error("{problem}")]
    Invalid {
        /// Code of the problem.
        code: &'static str,
        /// Message.
        problem: String,
    },
}

impl From<String> for CaseErrorKind {
    fn from(problem: String) -> Self {
        Self::coded("invalid", problem)
    }
}

impl From<&str> for CaseErrorKind {
    fn from(problem: &str) -> Self {
        Self::coded("invalid", problem)
    }
}

impl CaseErrorKind {
    /// Number outside its range, or a number that is not finite.
    pub fn out_of_range(value: f64, rule: impl Into<String>) -> Self {
        let rule = rule.into();
        if value.is_finite() {
            Self::OutOfRange { value, rule }
        } else {
            Self::NotFinite(format!("{value} {rule}"))
        }
    }

    /// Name that is none of the known ones; `expected` describes those.
    pub fn unknown_name(name: &str, known: &[&str], expected: impl Into<String>) -> Self {
        let suggestion = closest(name, known).map(str::to_owned);
        Self::UnknownName { name: name.to_owned(), expected: expected.into(), suggestion }
    }

    /// Name that is not as expected, without a suggestion.
    pub fn other_name(name: &str, expected: impl Into<String>) -> Self {
        Self::UnknownName { name: name.to_owned(), expected: expected.into(), suggestion: None }
    }

    /// Input that a method requires and the case lacks.
    pub fn missing_input(method: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::MissingInput { method: method.into(), problem: problem.into() }
    }

    /// File that does not fit.
    pub fn file(file: impl Into<PathBuf>, problem: impl Into<String>) -> Self {
        Self::coded_file(file, "file", problem)
    }

    /// File with a problem of the code `code`.
    pub fn coded_file(file: impl Into<PathBuf>, code: &'static str, problem: impl Into<String>) -> Self {
        Self::File { file: file.into(), code, problem: problem.into() }
    }

    /// Error in the content of `file`; an error without a code of its own is one of a column.
    pub fn in_table(self, file: impl Into<PathBuf>) -> Self {
        let code = if self.code() == "invalid" { "wrong-column" } else { self.code() };
        Self::coded_file(file, code, self.to_string())
    }

    /// Other error of the code `code`.
    pub fn coded(code: &'static str, problem: impl Into<String>) -> Self {
        Self::Invalid { code, problem: problem.into() }
    }

    /// Stable code of the error, which `docs/messages.md` of the repository explains.
    #[must_use]
    pub fn code(&self) -> &'static str {
        match self {
            Self::UnknownKey { .. } => "unknown-key",
            Self::UnknownChoice { .. } => "unknown-choice",
            Self::UnknownName { .. } => "unknown-name",
            Self::RenamedKey { .. } => "renamed-key",
            Self::RenamedChoice { .. } => "renamed-choice",
            Self::MissingKey { .. } => "missing-key",
            Self::MissingInput { .. } => "missing-input",
            Self::OutOfRange { .. } => "out-of-range",
            Self::NotFinite(_) => "not-finite",
            Self::WrongType { .. } => "wrong-type",
            Self::WrongLength { .. } => "wrong-length",
            Self::Syntax { .. } => "syntax",
            Self::NotSupported { .. } => "not-supported",
            Self::Material(error) => error.code(),
            Self::Unreadable { .. } => "unreadable-file",
            Self::File { code, .. } | Self::Invalid { code, .. } => code,
        }
    }
}

/// Name in `names` that `word` probably stands for.
pub fn closest<'n>(word: &str, names: &[&'n str]) -> Option<&'n str> {
    let likeness = |name: &&str| strsim::damerau_levenshtein(word, name);
    let best = names.iter().min_by_key(|name| likeness(name))?;
    (likeness(best) <= 1 + word.len() / 4).then_some(*best)
}

/// Question for a similar name, as a sentence of a message.
fn suggestion_sentence(name: Option<&str>) -> String {
    name.map_or(String::new(), |name| format!(" did you mean {name:?}?"))
}

/// Question for a similar name, at the end of a message.
fn suggestion_clause(name: Option<&str>) -> String {
    name.map_or(String::new(), |name| format!("; did you mean {name:?}?"))
}

/// Choices of a missing key, at the end of a message.
fn choices_clause(choices: &[String]) -> String {
    if choices.is_empty() { String::new() } else { format!("; it is one of {}", choices.join(", ")) }
}

/// Message for a feature without a rule of the method.
fn unavailable(feature: Feature, method: &str) -> String {
    match feature.variant() {
        Some(variant) => format!("{variant:?} is not available with {method}"),
        None => format!("is not available with {method}"),
    }
}
