//! One case with several methods: what they must agree on, and by how much.

mod aluminium_bars;
mod dam_break;
mod elastic_bar;
mod grain_cell;
mod inclined_block;
mod slide;
mod slope_acads;
mod slope_clays;
mod slope_cut;

use colluvium::case::RunReport;
use colluvium::plots::{LineChart, PointCloud};

use crate::benchmarks::{Benchmark, Outcome};

/// The benchmarks, in the order of the report.
pub const ALL: &[Benchmark] = &[
    elastic_bar::BENCHMARK,
    grain_cell::BENCHMARK,
    inclined_block::BENCHMARK,
    dam_break::BENCHMARK,
    aluminium_bars::BENCHMARK,
    slope_cut::BENCHMARK,
    slope_acads::ONE,
    slope_acads::THREE,
    slope_clays::LAYERS,
    slope_clays::WEAK,
    slide::BENCHMARK,
];

/// A chart with its labels.
fn chart(title: &str, x: &str, y: &str) -> LineChart {
    LineChart { title: title.into(), x_label: x.into(), y_label: y.into(), ..LineChart::default() }
}

/// Draws the points at the end of the failing trial with the least factor of the search `safety`; `name` says whose.
fn failing(outcome: &mut Outcome, name: &str, report: &RunReport) -> Result<(), String> {
    let cloud = report.failing.get("safety").and_then(|end| PointCloud::of(end, "displacement", [0, 1]));
    let Some(cloud) = cloud else { return Ok(()) };
    outcome.png(&format!("{name}: displacement in the failing trial of the least factor."), &cloud)
}
