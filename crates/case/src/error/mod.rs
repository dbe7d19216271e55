//! Errors of a case and of its files.

mod kind;

use std::path::{Path, PathBuf};

use colluvium_constitutive::MaterialError;
use thiserror::Error;

pub use crate::error::kind::{CaseErrorKind, closest};

/// Error in a case file, with its path: `materials.sand.friction_angle: 95 is not in 0..=60 degrees`.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{}", printable(&format!("{path}: {kind}")))]
pub struct CaseError {
    /// JSON path of the invalid value, e.g. `bodies[1].shape.radius`.
    pub path: String,
    /// Reason of the error, with value and rule.
    pub kind: CaseErrorKind,
}

impl CaseError {
    /// Error at `path`. A text is the reason of an error of the general kind.
    pub fn new(path: impl Into<String>, kind: impl Into<CaseErrorKind>) -> Self {
        Self { path: path.into(), kind: kind.into() }
    }

    /// Error of the material at `path`: at the key of the parameter, where the error concerns one.
    pub fn of_material(path: &str, error: MaterialError) -> Self {
        match error.parameter_rule() {
            Some((field, Some(value), rule)) => {
                Self::new(format!("{path}.{field}"), CaseErrorKind::out_of_range(value, rule))
            }
            Some((field, None, rule)) => {
                Self::new(format!("{path}.{field}"), CaseErrorKind::coded("incompatible-options", rule))
            }
            None => Self::new(path, error),
        }
    }

    /// Message without the path.
    #[must_use]
    pub fn problem(&self) -> String {
        self.kind.to_string()
    }

    /// Stable code of the error, as [`CaseErrorKind::code`].
    #[must_use]
    pub fn code(&self) -> &'static str {
        self.kind.code()
    }
}

/// Error of writing or reading a file.
#[derive(Debug, Error)]
#[error("{}: {problem}", path.display())]
pub struct OutputError {
    /// Path of the file.
    pub path: PathBuf,
    /// Code of the problem.
    pub code: &'static str,
    /// Description of the problem.
    pub problem: String,
}

impl OutputError {
    /// Creates an error about `path`.
    pub fn new(path: &Path, problem: impl std::fmt::Display) -> Self {
        Self::coded(path, "output", problem)
    }

    /// Creates an error about `path` with the code `code`.
    pub fn coded(path: &Path, code: &'static str, problem: impl std::fmt::Display) -> Self {
        Self { path: path.to_owned(), code, problem: format!("{problem}") }
    }
}

/// Message as one line for a terminal. Control characters and those that change the direction of writing become escapes; numbers of more
/// than 24 digits get an exponent.
pub fn printable(message: &str) -> String {
    let mut line = String::with_capacity(message.len());
    let mut rest = message;
    while let Some(first) = rest.chars().next() {
        let number = rest.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(rest.len());
        let inside_word = line.ends_with(|c: char| c.is_alphanumeric() || c == '_');
        let taken = number.max(first.len_utf8());
        match rest[..taken].parse::<f64>() {
            Ok(value) if number > 24 && !inside_word => line.push_str(&format!("{value:e}")),
            _ if number > 0 => line.push_str(&rest[..taken]),
            _ if first.is_control() || breaks_line(first) => line.extend(first.escape_default()),
            _ => line.push(first),
        }
        rest = &rest[taken..];
    }
    line
}

/// Longest word of a message that is not shortened (characters).
const MAX_WORD: usize = 240;

/// Longest message that is not shortened (characters).
const MAX_MESSAGE: usize = 2000;

/// Message without the middle of words and texts that are too long.
pub fn shortened(message: &str) -> String {
    if message.len() <= MAX_WORD {
        return message.to_owned();
    }
    let words: String = message.split_inclusive(' ').map(|word| shorten_middle(word, MAX_WORD)).collect();
    shorten_middle(&words, MAX_MESSAGE)
}

/// Text of at most `limit` characters. A longer text keeps two thirds of them from its beginning and a third from its end.
fn shorten_middle(text: &str, limit: usize) -> String {
    let count = text.chars().count();
    if count <= limit {
        return text.to_owned();
    }
    let (from, to) = (2 * limit / 3, count - limit / 3);
    let begin: String = text.chars().take(from).collect();
    let end: String = text.chars().skip(to).collect();
    format!("{begin}… ({} characters) …{end}", to - from)
}

/// Whether a character breaks a line or changes the direction of writing.
fn breaks_line(c: char) -> bool {
    matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// All errors of a case file, at least one; displayed one per line.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{}", error_lines(.0))]
pub struct CaseErrors(pub Vec<CaseError>);

/// Text of several errors, one a line.
fn error_lines(errors: &[CaseError]) -> String {
    let lines: Vec<String> = errors.iter().map(ToString::to_string).collect();
    lines.join("\n")
}

impl CaseErrors {
    /// List of a single error.
    pub fn from_error(error: CaseError) -> Self {
        Self(vec![error])
    }

    /// Errors with the name of their file before their paths.
    #[must_use]
    pub fn with_file_name(self, file: &Path) -> Self {
        let located =
            |error: CaseError| CaseError::new(format!("{}: {}", file.display(), error.path), error.kind);
        Self(self.0.into_iter().map(located).collect())
    }

    /// First error.
    pub fn first(&self) -> &CaseError {
        &self.0[0]
    }
}

impl From<CaseError> for CaseErrors {
    fn from(error: CaseError) -> Self {
        Self::from_error(error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_in_messages_are_escaped_to_one_line() {
        assert_eq!(printable("bodies.a\nb\u{1b}[31m: \u{202e}is"), "bodies.a\\nb\\u{1b}[31m: \\u{202e}is");
        assert_eq!(printable("Böschung: 0.25 m, −3 °"), "Böschung: 0.25 m, −3 °");
    }

    #[test]
    fn long_names_in_messages_are_shortened_and_paths_remain() {
        let name = "n".repeat(5000);
        let short = shortened(&format!("materials.{name}.friction_angle: 95 is not in 0..=60 degrees"));
        assert!(short.starts_with("materials.nnn") && short.len() < 400, "{short}");
        assert!(short.ends_with("nnn.friction_angle: 95 is not in 0..=60 degrees"), "{short}");
        let short = shortened(&format!("bodies.{}: is too large", "ein Name ".repeat(600)));
        assert!(short.ends_with(": is too large") && short.chars().count() < 2100, "{short}");
        let as_it_is = "bodies[0].shape: reaches beyond the domain ".repeat(40);
        assert_eq!(shortened(&as_it_is), as_it_is);
    }

    #[test]
    fn numbers_in_messages_are_printed_in_short_exact_form() {
        for (value, short) in [(1e300, "1e300"), (-1.5e-200, "-1.5e-200"), (1e22, "10000000000000000000000")]
        {
            assert_eq!(printable(&format!("radius: {value} is not")), format!("radius: {short} is not"));
        }
        // Digits in names and versions are not numbers.
        let name = format!("a{}", "1".repeat(40));
        assert_eq!(printable(&name), name);
        let dots = "1.2.3.4.5.6.7.8.9.10.11.12.13.14";
        assert_eq!(printable(dots), dots);
    }

    #[test]
    fn errors_are_one_line_each() {
        let errors = CaseErrors(vec![CaseError::new("a\nb", "no"), CaseError::new("c", "x\ry")]);
        assert_eq!(errors.to_string(), "a\\nb: no\nc: x\\ry");
    }
}
