//! Texts of numbers and states.

use maud::{Markup, html};

use crate::benchmarks::{Check, CheckVerdict, Criterion};
use crate::report::{BenchmarkEntry, BenchmarkStatus};

/// Style sheet of all pages.
pub const STYLE: &str = include_str!("report.css");

/// Text on the number of checks that fail as open defects, by criterion.
pub fn open_defect_text(entries: &[BenchmarkEntry]) -> String {
    let known: Vec<Criterion> = entries
        .iter()
        .flat_map(|entry| &entry.outcome.checks)
        .filter(|check| check.verdict() == CheckVerdict::Open)
        .filter_map(|check| Some(check.defect.as_ref()?.criterion))
        .collect();
    let kinds = Criterion::ALL.map(|kind| (known.iter().filter(|&&k| k == kind).count(), kind.text()));
    let kinds: Vec<String> = kinds
        .iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, words)| format!("{count} {words}"))
        .collect();
    match kinds.is_empty() {
        true => "no check fails as an open defect".to_owned(),
        false => format!("{} checks fail as open defects ({})", known.len(), kinds.join(", ")),
    }
}

/// Badge of a status, with a colour, sign and word.
pub fn status_badge(status: BenchmarkStatus) -> Markup {
    let sign = match status {
        BenchmarkStatus::Pass => "✓",
        BenchmarkStatus::Open => "◐",
        BenchmarkStatus::Fail => "✗",
    };
    html! { span class={ "badge " (status.name()) } { (sign) " " (status.name()) } }
}

/// Badge of the verdict of a check.
pub fn verdict_badge(check: &Check) -> Markup {
    match check.verdict() {
        CheckVerdict::Unbounded => html! { span class="badge shown" { "not judged" } },
        CheckVerdict::Open => status_badge(BenchmarkStatus::Open),
        CheckVerdict::Pass => status_badge(BenchmarkStatus::Pass),
        CheckVerdict::Fail => status_badge(BenchmarkStatus::Fail),
    }
}

/// Text of a number, plain where that is short.
pub fn number_text(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 {
        "0".to_owned()
    } else if (1e-3..1e6).contains(&size) {
        let text = format!("{value:.6}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        format!("{value:.4e}")
    }
}

/// Text of a duration (s).
pub fn duration_text(value: f64) -> String {
    match value {
        value if value < 10.0 => format!("{value:.1} s"),
        value if value < 120.0 => format!("{value:.0} s"),
        value => format!("{:.0} min", value / 60.0),
    }
}

/// Text of the bounds of a check.
pub fn bounds_text(range: Option<(f64, f64)>) -> String {
    let Some((low, high)) = range else { return "–".to_owned() };
    match (low.is_finite(), high.is_finite()) {
        (true, true) => format!("{} … {}", number_text(low), number_text(high)),
        (true, false) => format!("≥ {}", number_text(low)),
        (false, true) => format!("≤ {}", number_text(high)),
        (false, false) => "any".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_times_and_bounds_are_short() {
        assert_eq!([0.0, 0.5, 1e-5, -3.25].map(number_text), ["0", "0.5", "1.0000e-5", "-3.25"]);
        assert_eq!([0.04, 42.3, 600.0].map(duration_text), ["0.0 s", "42 s", "10 min"]);
        assert_eq!(bounds_text(Some((f64::NEG_INFINITY, 2.0))), "≤ 2");
        assert_eq!(bounds_text(None), "–");
    }

    #[test]
    fn the_three_states_differ_in_colour_sign_and_word() {
        let all = [BenchmarkStatus::Pass, BenchmarkStatus::Open, BenchmarkStatus::Fail]
            .map(|status| status_badge(status).into_string());
        for (text, word) in all.iter().zip(["✓ pass", "◐ open", "✗ fail"]) {
            assert!(text.contains(word), "{text}");
        }
        for class in ["pass", "open", "fail"] {
            assert!(STYLE.contains(&format!(".badge.{class} {{")), "{class}");
        }
    }
}
