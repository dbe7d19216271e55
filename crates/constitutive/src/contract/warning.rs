//! Warnings with codes.

use std::borrow::Cow;
use std::fmt;

use serde::{Deserialize, Serialize};

/// Warning, remark or note of the program: a stable code, and a text with path, problem and cure.
///
/// `docs/messages.md` of the repository lists all codes. A text may change, its code does not.
///
/// ```
/// use colluvium_constitutive::Warning;
///
/// let of_law = Warning::new("large-friction-angle", "friction_angle: 72 degrees is more than that of any soil");
/// let warning = of_law.at("materials.sand");
/// assert_eq!(warning.code, "large-friction-angle");
/// assert!(warning.line("warning").starts_with("warning[large-friction-angle]: materials.sand."));
/// assert_eq!(warning.to_string(), "materials.sand.friction_angle: 72 degrees is more than that of any soil");
/// ```
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Warning {
    /// Code: lower-case words with hyphens between them.
    pub code: Cow<'static, str>,
    /// Text: path, problem with its numbers, and cure.
    pub text: String,
}

impl Warning {
    /// Warning of a code with a text.
    #[must_use]
    pub fn new(code: impl Into<Cow<'static, str>>, text: impl Into<String>) -> Self {
        Self { code: code.into(), text: text.into() }
    }

    /// Warning of an inner part as that of the part at `path`: the text begins with both paths.
    #[must_use]
    pub fn at(self, path: impl fmt::Display) -> Self {
        Self { text: format!("{path}.{}", self.text), ..self }
    }

    /// Line for a terminal, as `warning[large-friction-angle]: …`; `kind` is its first word.
    #[must_use]
    pub fn line(&self, kind: &str) -> String {
        format!("{kind}[{}]: {}", self.code, self.text)
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}
