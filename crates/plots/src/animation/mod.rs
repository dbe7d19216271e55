//! Animations to play, scrub and turn in a browser: points in time with their fields, quantised into the page, and a
//! small player that needs no other file.

mod colour_fields;
mod decimation;
mod geometry_data;
mod quantisation;

#[cfg(test)]
mod tests;

use base64::Engine;
use colluvium_case::Snapshot;
use serde_json::{Value, json};

pub use crate::animation::colour_fields::PointClasses;
pub use crate::animation::quantisation::QuantisedRange;

use super::{PALETTE, RigidGeometry};
use crate::pictures::point_cloud::{COLOUR_STOPS, RADIUS};

/// Script of the player, which turns every [`Animation::element`] of the page into a player. Once on a page.
pub const SCRIPT: &str = include_str!("player.js");

/// Style sheet of the player. Once on a page.
pub const STYLE: &str = include_str!("player.css");

/// Run of an animation: points in time under a name.
#[derive(Clone, Debug)]
pub struct Panel<'a> {
    /// Name above the picture.
    pub name: String,
    /// States, in the order of time.
    pub frames: Vec<&'a Snapshot>,
    /// Number of frames of the run; larger than the length of `frames` where some were left out.
    pub frame_count: usize,
}

/// Selection of axes, fields and geometry of an animation.
#[derive(Clone, Debug, Default)]
pub struct View {
    /// Axes shown: two, or all three for a picture that can be turned.
    pub axes: Vec<usize>,
    /// Index of the axis against gravity.
    pub vertical_axis: usize,
    /// Fields that colour the points; the default fields when empty.
    pub fields: Vec<String>,
    /// Classes that colour the points: bodies, materials.
    pub classes: Vec<PointClasses>,
    /// Rigid geometry behind the points.
    pub ground: RigidGeometry,
    /// Largest size of the points (bytes); frames and points are left out beyond.
    pub bytes: usize,
}

/// Default size of an animation (bytes): the page grows by four thirds of it.
pub const DEFAULT_BYTES: usize = 2_000_000;

/// Animation, ready for a page.
#[derive(Clone, Debug)]
pub struct Animation {
    /// Data of the player.
    data: Value,
    /// Text on the parts left out; empty where nothing was.
    pub omission_note: String,
}

impl Animation {
    /// Animation of runs side by side, with one scale, one set of axes and one time for all. `None` where no frame has points, or
    /// no run has two frames.
    pub fn from_panels(panels: &[Panel<'_>], view: &View) -> Option<Self> {
        if panels.iter().all(|panel| panel.frames.len() < 2) {
            return None;
        }
        let fields = colour_fields::colour_sources(panels, view);
        let (kept, thinned) = decimation::decimate(panels, view, fields.len());
        let bounds = quantisation::bounds(panels, &view.axes)?;
        let wider = kept
            .iter()
            .filter_map(|one| one.blocks.as_ref())
            .map(decimation::DecimationBlocks::widest)
            .fold(1.0, f64::max);
        let largest = wider * quantisation::max_width(panels, &view.axes);
        let times = times(&kept.iter().map(|one| one.panel.frames.as_slice()).collect::<Vec<_>>());
        let end = times.last().copied().unwrap_or(0.0);
        let panel = |one: &decimation::DecimatedRun<'_>| {
            let mut encoder = quantisation::Encoder::new(&bounds, largest, view, &fields);
            let frames: Vec<Value> =
                one.panel.frames.iter().map(|frame| encoder.frame(frame, one.blocks.as_ref())).collect();
            json!({
                "name": one.panel.name, "shape": shape(&one.panel), "frames": frames,
                "at": times.iter().map(|time| frame_at(&one.panel.frames, *time, end)).collect::<Vec<_>>(),
            })
        };
        let rgb = |colour: &plotters::style::RGBColor| [colour.0, colour.1, colour.2];
        let data = json!({
            "axes": view.axes.iter().map(|axis| ["x", "y", "z"][*axis]).collect::<Vec<_>>(),
            "up": view.axes.iter().position(|axis| *axis == view.vertical_axis),
            "low": bounds.iter().map(|scale| scale.low).collect::<Vec<_>>(),
            "high": bounds.iter().map(|scale| scale.high).collect::<Vec<_>>(),
            "largest": largest,
            "times": times,
            "fields": fields.iter().map(colour_fields::ColourSource::json).collect::<Vec<_>>(),
            "colours": COLOUR_STOPS, "palette": PALETTE.iter().map(rgb).collect::<Vec<_>>(),
            "thinned": thinned, "ground": geometry_data::geometry_data(&view.ground, &times), "missing": view.ground.missing,
            "panels": kept.iter().map(panel).collect::<Vec<_>>(),
        });
        Some(Self { data, omission_note: thinned })
    }

    /// HTML element that [`SCRIPT`] turns into a player.
    pub fn element(&self) -> String {
        // A title or a name cannot end the element.
        let data = self.data.to_string().replace('<', "\\u003c");
        format!(
            "<div class=\"player\"><script type=\"application/json\">{data}</script><noscript>The animation needs \
             JavaScript.</noscript></div>"
        )
    }
}

/// Shape of the points of a run: disks for grains, columns over their bed for a flow, squares for all others.
fn shape(panel: &Panel<'_>) -> &'static str {
    let all = |name: &str| panel.frames.iter().all(|frame| frame.field(name).is_some());
    match (all(RADIUS), all("depth") && all("bed")) {
        (true, _) => "disk",
        (_, true) => "depth",
        _ => "square",
    }
}

/// All times of several series of frames, ascending; times that agree to a millionth of the whole are one.
fn times(series: &[&[&Snapshot]]) -> Vec<f64> {
    let mut times: Vec<f64> =
        series.iter().flat_map(|frames| frames.iter().map(|frame| frame.time)).collect();
    times.sort_by(f64::total_cmp);
    let near = 1e-6 * times.last().copied().unwrap_or(0.0).abs();
    times.dedup_by(|later, earlier| *later - *earlier <= near);
    times
}

/// Index of the last frame at or before a time; the first where there is none.
fn frame_at(frames: &[&Snapshot], time: f64, end: f64) -> usize {
    let near = 1e-6 * end.abs();
    frames.iter().rposition(|frame| frame.time <= time + near).unwrap_or(0)
}

/// Bytes as text.
fn text(bytes: &[u8]) -> String {
    base64::engine::general_purpose::STANDARD.encode(bytes)
}
