//! Ticks of axes: round coordinates, distinct labels, and the constant that all labels share.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::Ranged;

/// Font size of the labels of an axis (pixels).
pub(crate) const LETTERS: u32 = 14;
/// Width of a digit over the font size.
const WIDTH: f64 = 0.6;
/// Largest number of ticks of an axis.
const MAX_TICKS: usize = 8;
/// Largest number of characters of a label; longer ones are written relative to a constant.
const MAX_TEXT_LENGTH: usize = 8;
/// Largest number of characters of a label without exponent.
const MAX_PLAIN_LENGTH: usize = 6;
/// Smallest distance of labels beside each other, and of lines of text (pixels).
const GAPS: [f64; 2] = [14.0, 24.0];

/// Direction of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AxisDirection {
    /// Horizontal axis, to the right: labels beside each other.
    Horizontal,
    /// Vertical axis, upward: labels above each other.
    Vertical,
}

/// Axis of numbers with its ticks.
pub(crate) struct NumberAxis {
    scale: RangedCoordf64,
    ticks: Ticks,
}

impl NumberAxis {
    /// Returns an axis over `range`.
    pub fn new(range: Range<f64>, ticks: Ticks) -> Self {
        Self { scale: range.into(), ticks }
    }
}

impl Ranged for NumberAxis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        self.scale.map(value, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() { Vec::new() } else { self.ticks.coordinates.clone() }
    }

    fn range(&self) -> Range<f64> {
        self.scale.range()
    }
}

impl ValueFormatter<f64> for NumberAxis {
    fn format(place: &f64) -> String {
        crate::label(place)
    }

    fn format_ext(&self, place: &f64) -> String {
        self.ticks.text(*place)
    }
}

/// Ticks of an axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Ticks {
    /// Coordinates, ascending. On a logarithmic axis they are exponents of ten.
    pub coordinates: Vec<f64>,
    /// Label of each tick.
    texts: Vec<String>,
    /// Constant added to all labels, with its sign; `None` where the labels are the values themselves.
    constant: Option<String>,
}

impl Ticks {
    /// Ticks of an axis of length `pixels`.
    pub fn linear(range: &Range<f64>, pixels: f64, along: AxisDirection) -> Self {
        let tries = (2..=MAX_TICKS).rev().map(|largest| Self::with_max_count(range, largest));
        let mut last = Self::default();
        for ticks in tries {
            if ticks.fits(range, pixels, along) {
                return ticks;
            }
            last = ticks;
        }
        // A single label is better than two that overlap.
        last.coordinates.truncate(1);
        last.texts.truncate(1);
        last
    }

    /// Ticks of a logarithmic axis, whose coordinates are exponents of ten.
    pub fn logarithmic(range: &Range<f64>, pixels: f64, along: AxisDirection) -> Self {
        let fine: [&[i32]; 3] = [&[1, 2, 3, 4, 5, 6, 7, 8, 9], &[1, 2, 5], &[1]];
        let every = [2, 3, 5, 10, 20, 50, 100, 200];
        let tries = fine.into_iter().map(|parts| (parts, 1)).chain(every.map(|stride| (fine[2], stride)));
        let mut tries = tries.map(|(parts, stride)| Self::decades(range, parts, stride));
        let enough = |ticks: &Self| ticks.coordinates.len() > 1 && ticks.fits(range, pixels, along);
        tries.find(enough).unwrap_or_else(|| {
            // Less than a decade: round values as on a linear axis.
            let mut ticks = Self::with_max_count(&(10f64.powf(range.start)..10f64.powf(range.end)), 4);
            ticks.coordinates.iter_mut().for_each(|place| *place = place.log10());
            ticks
        })
    }

    /// Ticks at round values, of which there are at most `limit`.
    fn with_max_count(range: &Range<f64>, limit: usize) -> Self {
        let span = range.end - range.start;
        let first = (span / limit as f64).log10().floor() as i32;
        let steps = (first..first + 3).flat_map(|power| [1.0, 2.0, 5.0].map(|part| (part, power)));
        for (part, power) in steps {
            // Only a division of two whole numbers gives exactly 0.1.
            let step = if power < 0 { part / 10f64.powi(-power) } else { part * 10f64.powi(power) };
            let from = (range.start / step - 1e-9).ceil();
            let count = (range.end / step + 1e-9).floor() - from + 1.0;
            if count <= limit as f64 {
                let whole: Vec<f64> = (0..count.max(0.0) as usize).map(|k| from + k as f64).collect();
                return Self::multiples_of(&whole, step, power, span);
            }
        }
        Self::default()
    }

    /// Ticks at multiples of a step; `power` is the power of ten of which the step is a multiple.
    fn multiples_of(whole: &[f64], step: f64, power: i32, span: f64) -> Self {
        let coordinates: Vec<f64> = whole.iter().map(|k| k * step).collect();
        let texts = texts(&coordinates, power);
        if texts.iter().all(|text| text.trim_start_matches('-').len() <= MAX_TEXT_LENGTH) {
            return Self { coordinates, texts, constant: None };
        }
        let unit = span.log10().ceil() as i32;
        let lowest = (coordinates[0] / 10f64.powi(unit)).floor();
        let constant: f64 = format!("{lowest}e{unit}").parse().unwrap_or(coordinates[0]);
        let rest = |place: &f64| ((place - constant) / step).round() * step;
        let texts = self::texts(&coordinates.iter().map(rest).collect::<Vec<_>>(), power);
        Self { coordinates, texts, constant: Some(format!("{constant:+e}")) }
    }

    /// Ticks of a logarithmic axis: multiples of powers of ten, at every `stride`-th power.
    fn decades(range: &Range<f64>, parts: &[i32], stride: i32) -> Self {
        let near = 1e-9 * (range.end - range.start);
        let (first, last) = (range.start.floor() as i32, range.end.ceil() as i32);
        let mut ticks = Self::default();
        for power in (first..=last).filter(|power| power.rem_euclid(stride) == 0) {
            for part in parts {
                let place = f64::from(power) + f64::from(*part).log10();
                if place >= range.start - near && place <= range.end + near {
                    ticks.coordinates.push(place);
                    ticks.texts.push(match power {
                        0..=4 => format!("{part}{}", "0".repeat(power as usize)),
                        -3..=-1 => format!("0.{}{part}", "0".repeat((-power - 1) as usize)),
                        _ => format!("{part}e{power}"),
                    });
                }
            }
        }
        ticks
    }

    /// Whether no label overlaps the next one.
    fn fits(&self, range: &Range<f64>, pixels: f64, along: AxisDirection) -> bool {
        let letters = self.texts.iter().map(String::len).max().unwrap_or(0);
        let room = match along {
            AxisDirection::Horizontal => letters as f64 * WIDTH * f64::from(LETTERS) + GAPS[0],
            AxisDirection::Vertical => GAPS[1],
        };
        let scale = pixels / (range.end - range.start);
        self.coordinates.windows(2).all(|pair| (pair[1] - pair[0]) * scale >= room)
    }

    /// Label at a coordinate.
    pub fn text(&self, place: f64) -> String {
        let off = |k: &usize| (self.coordinates[*k] - place).abs();
        let nearest = (0..self.coordinates.len()).min_by(|a, b| off(a).total_cmp(&off(b)));
        nearest.map_or_else(String::new, |k| self.texts[k].clone())
    }

    /// Labels with their coordinates.
    pub fn visible_labels(&self) -> impl Iterator<Item = (f64, &str)> {
        self.coordinates.iter().copied().zip(self.texts.iter().map(String::as_str))
    }

    /// Description of the axis, with the constant that its tick labels leave out.
    pub fn axis_label(&self, axis: &str) -> String {
        match &self.constant {
            Some(constant) => format!("{axis} [{constant}]"),
            None => axis.to_owned(),
        }
    }
}

/// Labels of multiples of a power of ten, with all digits that distinguish them. They have an exponent where they would be long without.
fn texts(places: &[f64], power: i32) -> Vec<String> {
    let decimals = (-power).max(0) as usize;
    let zero = |text: String, place: f64| if place == 0.0 { "0".to_owned() } else { text };
    let plain: Vec<String> = places.iter().map(|x| zero(format!("{x:.decimals$}"), *x)).collect();
    let largest = places.iter().fold(0.0f64, |maximum, x| maximum.max(x.abs()));
    let figures = (largest.log10().floor() as i32 - power).clamp(0, 15) as usize;
    let powers: Vec<String> = places.iter().map(|x| zero(format!("{x:.figures$e}"), *x)).collect();
    let longest = |texts: &[String]| texts.iter().map(|t| t.trim_start_matches('-').len()).max().unwrap_or(0);
    let (of_plain, of_powers) = (longest(&plain), longest(&powers));
    if of_plain <= MAX_PLAIN_LENGTH || of_plain <= of_powers { plain } else { powers }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts_of(range: Range<f64>) -> (Vec<String>, Option<String>) {
        let ticks = Ticks::linear(&range, 400.0, AxisDirection::Vertical);
        (ticks.texts, ticks.constant)
    }

    #[test]
    fn tick_labels_of_any_range_are_distinct() {
        let middles = [0.0, 1.0, -3.5, 6.0e5, 2.67e11, -2.67e11, 4.2e-7, 101_325.0, 5.2e6];
        for middle in middles {
            for power in -9..12 {
                let half = 10f64.powi(power);
                // Narrower ranges are widened before they are drawn.
                if half < 1e-11 * f64::abs(middle) {
                    continue;
                }
                let range = middle - 1.3 * half..middle + half;
                for (along, pixels) in [
                    (AxisDirection::Horizontal, 660.0),
                    (AxisDirection::Vertical, 380.0),
                    (AxisDirection::Vertical, 90.0),
                ] {
                    let ticks = Ticks::linear(&range, pixels, along);
                    let mut texts = ticks.texts.clone();
                    texts.sort();
                    texts.dedup();
                    assert_eq!(texts.len(), ticks.coordinates.len(), "{range:?}: {:?}", ticks.texts);
                    assert!(
                        !texts.is_empty() && texts.iter().all(|text| text.len() <= MAX_TEXT_LENGTH + 1),
                        "{texts:?}"
                    );
                    // Label plus constant gives the coordinate.
                    let constant = ticks.constant.as_deref().map_or(0.0, |text| text.parse::<f64>().unwrap());
                    for (place, text) in ticks.visible_labels() {
                        let read = constant + text.parse::<f64>().unwrap();
                        let near = 1e-3 * (range.end - range.start) + 4.0 * f64::EPSILON * constant.abs();
                        assert!((read - place).abs() <= near, "{place} reads {text} {:?}", ticks.constant);
                    }
                }
            }
        }
    }

    #[test]
    fn tick_labels_are_plain_when_short_and_relative_to_a_constant_when_long() {
        assert_eq!(texts_of(0.0..0.4).0, ["0", "0.1", "0.2", "0.3", "0.4"]);
        assert_eq!(texts_of(6.0e5..6.0005e5).0[..2], ["600000", "600010"]);
        let (texts, constant) = texts_of(2.6701e11..2.67013e11);
        assert_eq!(constant.as_deref(), Some("+2.6701e11"));
        assert_eq!(texts[..2], ["0", "5.0e5"]);
        assert_eq!(texts_of(1.0e-12..5.0e-12).0[0], "1e-12");
        assert_eq!(texts_of(-1e-17..0.25).0[0], "0");
    }

    #[test]
    fn logarithmic_ticks_do_not_overlap_and_any_range_has_some() {
        for (low, high) in
            [(-30.0, 12.0), (-9.0, -2.0), (-0.2, 2.1), (0.31, 0.95), (3.001, 3.01), (-250.0, 199.0)]
        {
            for along in [AxisDirection::Horizontal, AxisDirection::Vertical] {
                let ticks = Ticks::logarithmic(&(low..high), 380.0, along);
                assert!(!ticks.coordinates.is_empty(), "{low} {high}");
                assert!(ticks.coordinates.iter().all(|place| (low - 1e-9..high + 1e-9).contains(place)));
                let sized = |pair: &[f64]| (pair[1] - pair[0]) * 380.0 / (high - low);
                let widest = ticks.texts.iter().map(String::len).max().unwrap() as f64;
                let room = if along == AxisDirection::Horizontal { 8.0 * widest } else { 14.0 };
                assert!(ticks.coordinates.windows(2).all(|pair| sized(pair) > room), "{:?}", ticks.texts);
                for (place, text) in ticks.visible_labels() {
                    assert!((text.parse::<f64>().unwrap().log10() - place).abs() < 1e-3, "{place} {text}");
                }
            }
        }
    }
}
