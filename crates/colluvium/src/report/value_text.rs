//! Values as text.

use serde_json::Value;

/// Value of a file as text.
pub(super) fn value_text(value: &Value) -> String {
    match value {
        Value::Null => "–".to_owned(),
        Value::String(text) => text.clone(),
        Value::Number(number) => number.as_f64().map_or_else(|| number.to_string(), five_digits),
        other => other.to_string(),
    }
}

/// Number to five digits, without an exponent where that is short.
pub(super) fn five_digits(value: f64) -> String {
    let size = value.abs();
    if !value.is_finite() {
        return "–".to_owned();
    }
    if size != 0.0 && !(1e-4..1e9).contains(&size) {
        return format!("{value:.4e}");
    }
    let digits = if size > 0.0 { (4.0 - size.log10().floor()).max(0.0) as usize } else { 0 };
    let plain = format!("{:.digits$}", value + 0.0);
    if plain.contains('.') { plain.trim_end_matches('0').trim_end_matches('.').to_owned() } else { plain }
}

/// Duration as text.
pub(super) fn duration_text(seconds: f64) -> String {
    match seconds {
        s if s < 10.0 => format!("{s:.1} s"),
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_five_digits_and_times_the_unit_that_suits_them() {
        assert_eq!(
            [0.15000000000000002, 1234567.0, -0.0, 1.5e-7].map(five_digits),
            ["0.15", "1234567", "0", "1.5000e-7"]
        );
        assert_eq!([0.25, 33.3, 240.0, 9000.0].map(duration_text), ["0.2 s", "33 s", "4 min", "2.5 h"]);
    }
}
