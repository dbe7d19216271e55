//! Errors in a case.

use std::path::Path;

use thiserror::Error;

/// What is wrong in a case file, and where: `materials.sand.friction_angle: 95 is not in 0..=60 degrees`.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{}", printable(&format!("{path}: {problem}")))]
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

/// A message as one line that a terminal can show: control characters and those that turn the direction of writing, which
/// names and texts of a file may hold, become escapes, and numbers of more than 24 digits get an exponent.
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
            _ if first.is_control() || turns(first) => line.extend(first.escape_default()),
            _ => line.push(first),
        }
        rest = &rest[taken..];
    }
    line
}

/// Whether a character breaks a line or turns the direction of writing.
fn turns(c: char) -> bool {
    matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_is_one_line_whatever_names_hold() {
        assert_eq!(printable("bodies.a\nb\u{1b}[31m: \u{202e}is"), "bodies.a\\nb\\u{1b}[31m: \\u{202e}is");
        assert_eq!(printable("Böschung: 0.25 m, −3 °"), "Böschung: 0.25 m, −3 °");
    }

    #[test]
    fn numbers_stay_short_and_equal() {
        for (value, short) in [(1e300, "1e300"), (-1.5e-200, "-1.5e-200"), (1e22, "10000000000000000000000")]
        {
            assert_eq!(printable(&format!("radius: {value} is not")), format!("radius: {short} is not"));
        }
        // Names and versions are no numbers.
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
