//! Number of a case file that may be infinite.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Number, or `"none"` for an infinite value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected a number or \"none\"")]
pub enum MaybeInfinite {
    /// Finite value.
    Number(f64),
    /// Infinite value.
    Word(NoneWord),
}

/// Word `"none"`, an infinite value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum NoneWord {
    /// Infinite.
    None,
}

impl MaybeInfinite {
    /// Infinite value.
    pub const INFINITE: Self = Self::Word(NoneWord::None);

    /// Value of the number; infinity for `"none"`.
    pub fn or_infinity(self) -> f64 {
        match self {
            Self::Number(value) => value,
            Self::Word(NoneWord::None) => f64::INFINITY,
        }
    }

    /// Checks that the number is positive and finite; `"none"` is always valid. `unit` is the unit in the error message.
    ///
    /// # Errors
    /// When the number is not positive and finite.
    pub fn check_positive(self, field: &'static str, unit: &str) -> Result<f64, crate::MaterialError> {
        if let Self::Number(value) = self {
            crate::contract::parameter_checks::positive(field, value, unit)?;
        }
        Ok(self.or_infinity())
    }
}

impl From<f64> for MaybeInfinite {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}
