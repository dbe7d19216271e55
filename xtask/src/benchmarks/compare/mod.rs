//! One case with several methods: what they must agree on, and by how much.

mod aluminium_bars;
mod dam_break;
mod elastic_bar;
mod grain_cell;
mod inclined_block;
mod slide;
mod slope_clays;
mod slope_cut;

use colluvium::plots::LineChart;

use crate::benchmarks::Benchmark;

/// The benchmarks, in the order of the report.
pub const ALL: &[Benchmark] = &[
    elastic_bar::BENCHMARK,
    grain_cell::BENCHMARK,
    inclined_block::BENCHMARK,
    dam_break::BENCHMARK,
    aluminium_bars::BENCHMARK,
    slope_cut::BENCHMARK,
    slope_clays::LAYERS,
    slope_clays::WEAK,
    slide::BENCHMARK,
];

/// A chart with its labels.
fn chart(title: &str, x: &str, y: &str) -> LineChart {
    LineChart { title: title.into(), x_label: x.into(), y_label: y.into(), ..LineChart::default() }
}
