//! Checks of parameters.

use crate::MaterialError;

/// Returns an error of the parameter `field` if the condition is false.
pub(crate) fn check(field: &'static str, value: f64, holds: bool, rule: &str) -> Result<(), MaterialError> {
    if holds { Ok(()) } else { Err(MaterialError::parameter(field, value, rule)) }
}

/// Checks that `value` is finite and positive; `unit` is named in the error.
pub(crate) fn positive(field: &'static str, value: f64, unit: &str) -> Result<(), MaterialError> {
    let rule =
        if unit.is_empty() { "must be positive".to_owned() } else { format!("must be positive ({unit})") };
    check(field, value, value.is_finite() && value > 0.0, &rule)
}

/// Checks that `value` is finite and not negative; `unit` is named in the error.
pub(crate) fn not_negative(field: &'static str, value: f64, unit: &str) -> Result<(), MaterialError> {
    let rule = if unit.is_empty() {
        "must not be negative".to_owned()
    } else {
        format!("must not be negative ({unit})")
    };
    check(field, value, value.is_finite() && value >= 0.0, &rule)
}

/// Checks that a value lies between `low` and `high`, bounds included.
pub(crate) fn within_range(
    field: &'static str,
    value: f64,
    low: f64,
    high: f64,
) -> Result<(), MaterialError> {
    check(field, value, (low..=high).contains(&value), &format!("is not between {low} and {high}"))
}
