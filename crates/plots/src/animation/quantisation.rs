//! Quantisation of numbers as whole steps of a range: positions and widths in 16 bits, values in 8.

use colluvium_case::Snapshot;
use serde_json::{Value, json};

use crate::animation::colour_fields::ColourSource;
use crate::animation::decimation::{DecimationBlock, DecimationBlocks};
use crate::animation::{Panel, View, text};

/// Number of steps of a position or a width.
const POSITION_STEPS: u32 = 65_535;
/// Number of steps of a value; the next number stands for a missing value.
const VALUE_STEPS: u32 = 254;

/// Range divided into whole steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuantisedRange {
    /// Lower end of the range.
    pub low: f64,
    /// Upper end, above the lower one.
    pub high: f64,
    /// Number of steps.
    pub steps: u32,
}

impl QuantisedRange {
    /// Range of 16 bits.
    pub fn with_16_bits(low: f64, high: f64) -> Self {
        Self { low, high, steps: POSITION_STEPS }
    }

    /// Range of 8 bits, with one number reserved for NaN.
    pub fn coarse(low: f64, high: f64) -> Self {
        Self { low, high, steps: VALUE_STEPS }
    }

    /// Size of a step.
    pub fn step(&self) -> f64 {
        (self.high - self.low) / f64::from(self.steps)
    }

    /// Nearest step. Values beyond the range are quantised to its ends; NaN is the number after the last step.
    pub fn quantise(&self, value: f64) -> u32 {
        if value.is_nan() {
            return self.steps + 1;
        }
        ((value - self.low) / self.step()).round().clamp(0.0, f64::from(self.steps)) as u32
    }

    /// Value of a step.
    pub fn decode(&self, number: u32) -> f64 {
        if number > self.steps { f64::NAN } else { self.low + f64::from(number) * self.step() }
    }
}

/// Extent of all frames along each axis, including the widths of the points; `None` where there are no points.
pub(super) fn bounds(panels: &[Panel<'_>], axes: &[usize]) -> Option<Vec<QuantisedRange>> {
    let frames = || panels.iter().flat_map(|panel| &panel.frames);
    let one = |axis: &usize| {
        let ends = frames().flat_map(|frame| {
            let points = frame.positions.iter().zip(&frame.extents);
            points.flat_map(move |(x, e)| [x[*axis] - 0.5 * e[*axis], x[*axis] + 0.5 * e[*axis]])
        });
        let (low, high) = ends
            .filter(|end| end.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        (low <= high).then_some((low, high))
    };
    let ends: Option<Vec<(f64, f64)>> = axes.iter().map(one).collect();
    let ends = ends?;
    let spread = ends.iter().map(|(low, high)| high - low).fold(0.0, f64::max);
    // A line of points has no height: it gets some, since a range without length has no steps.
    let smallest = if spread > 0.0 { 0.05 * spread } else { 1.0 };
    let scale = |(low, high): (f64, f64)| {
        let half = if high > low { 0.0 } else { 0.5 * smallest };
        QuantisedRange::with_16_bits(low - half, high + half)
    };
    Some(ends.into_iter().map(scale).collect())
}

/// Largest width of all points (m).
pub(super) fn max_width(panels: &[Panel<'_>], axes: &[usize]) -> f64 {
    let frames = panels.iter().flat_map(|panel| &panel.frames);
    let widths = frames.flat_map(|frame| &frame.extents).flat_map(|e| axes.iter().map(|axis| e[*axis]));
    widths.filter(|width| width.is_finite()).fold(0.0, f64::max)
}

/// Encoder of the frames of a run, one after the other.
pub(super) struct Encoder<'a> {
    bounds: &'a [QuantisedRange],
    width: QuantisedRange,
    view: &'a View,
    fields: &'a [ColourSource],
    last: Vec<u8>,
}

impl<'a> Encoder<'a> {
    /// Encoder of frames of points within bounds.
    pub fn new(
        bounds: &'a [QuantisedRange],
        largest: f64,
        view: &'a View,
        fields: &'a [ColourSource],
    ) -> Self {
        let width = QuantisedRange::with_16_bits(0.0, if largest > 0.0 { largest } else { 1.0 });
        Self { bounds, width, view, fields, last: Vec::new() }
    }

    /// Encodes a frame: positions, widths where they differ from those of the previous frame, and values. With `blocks` only the
    /// representative points are encoded.
    pub fn frame(&mut self, frame: &Snapshot, blocks: Option<&DecimationBlocks>) -> Value {
        let all = DecimationBlock { width_ratio: [1.0; 3], offset: [0.0; 3] };
        let block = |i: usize| blocks.map_or(Some(&all), |blocks| blocks.get(frame.ids[i]));
        let shown: Vec<(usize, &DecimationBlock)> =
            (0..frame.ids.len()).filter_map(|i| Some((i, block(i)?))).collect();
        let (mut places, mut widths) = (Vec::new(), Vec::new());
        for &(i, block) in &shown {
            for (scale, &axis) in self.bounds.iter().zip(&self.view.axes) {
                let place = frame.positions[i][axis] + block.offset[axis];
                places.extend((scale.quantise(place) as u16).to_le_bytes());
                let width = frame.extents[i][axis] * block.width_ratio[axis];
                let width = if width.is_nan() { 0.0 } else { width };
                widths.extend((self.width.quantise(width) as u16).to_le_bytes());
            }
        }
        let values = |field: &ColourSource| -> Vec<u8> {
            let all = field.values(frame);
            shown.iter().map(|&(i, _)| field.number(all[i])).collect()
        };
        let values: Vec<String> = self.fields.iter().map(|field| text(&values(field))).collect();
        let same = widths == self.last;
        let written = if same { Value::Null } else { json!(text(&widths)) };
        self.last = widths;
        json!({ "n": shown.len(), "x": text(&places), "w": written, "v": values })
    }
}
