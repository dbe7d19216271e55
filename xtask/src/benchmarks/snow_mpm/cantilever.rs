//! Cantilever with large deflection under its weight, against the elastica (sheet: snow-mpm V16 and its amendment).

use colluvium::plots::{LineChart, Series, Style};
use serde_json::json;

use super::{case_with_options, run_snow_case};
use crate::analysis::MaxOrNan;
use crate::benchmarks::{Benchmark, BenchmarkOutcome, initial_positions};

/// Benchmark of a cantilever at large rotation under its weight.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "snow-mpm/cantilever",
    title: "Cantilever at large rotation under its weight",
    source: "sheet: snow-mpm V16, elastica with wL³/(E'I) = 4",
    short_seconds: Some(15),
    full_seconds: 100,
    run: benchmark,
};

/// Drop of the tip and its position along the beam at rest, over the length (sheet: snow-mpm V16, α = 4).
const TIP: [f64; 2] = [0.425_159, 0.890_111];

/// Beam at rest: drop and position of its tip over the length (1 m), and its axis.
struct BentBeam {
    tip: [f64; 2],
    axis: Vec<(f64, f64)>,
}

/// Beam at rest under its weight on cells of `cell` (m).
fn bent_beam(cell: f64) -> Result<BentBeam, String> {
    let report = run_snow_case(&case_with_options("cantilever", &json!({ "cell_size": cell }))?)?;
    let (start, now) = (initial_positions(&report.snapshot), &report.snapshot.positions);
    let spacing = 0.5 * cell;
    let end = start.iter().map(|x| x[0]).max_or_nan();
    let column = |place: f64| {
        let of = |(x, now): (&[f64; 2], &[f64; 3])| ((x[0] - place).abs() < 0.1 * spacing).then_some(*now);
        let all: Vec<[f64; 3]> = start.iter().zip(now).filter_map(of).collect();
        [0, 1].map(|c| all.iter().map(|x| x[c]).sum::<f64>() / all.len() as f64)
    };
    let (last, before) = (column(end), column(end - spacing));
    // The end face lies half a spacing beyond the last points.
    let tip = [0, 1].map(|c| 1.5 * last[c] - 0.5 * before[c]);
    let count = ((end - 0.5 * spacing) / spacing) as usize;
    let axis = (0..=count).map(|k| column(end - k as f64 * spacing)).map(|[x, y]| (x, y)).collect();
    Ok(BentBeam { tip: [-tip[1], tip[0]], axis })
}

/// Checks the tip of a bent beam against the elastica.
fn benchmark(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut chart = LineChart::new("Axis of the beam", "x (m)", "y (m)");
    let grids = if quick { 1 } else { 2 };
    for (cells, width, prototype) in
        [(4.0, 0.08, "0.440 and 0.878, still creeping"), (8.0, 0.04, "not run")].into_iter().take(grids)
    {
        let BentBeam { tip, axis } = bent_beam(0.1 / cells)?;
        for ((what, exact), found) in [("drop", TIP[0]), ("place", TIP[1])].iter().zip(tip) {
            let name = format!("V16, {cells} cells over the height: {what} of the tip over the length");
            let claim = format!("{exact} (sheet's prototype: {prototype})");
            let range = (exact * (1.0 - width), exact * (1.0 + width));
            outcome.assert_within(name, &claim, found, range, "the sheet's criterion");
        }
        chart.series.push(Series::new(format!("{cells} cells over the height"), axis, Style::Line));
    }
    chart.series.push(Series::new("tip of the elastica", vec![(TIP[1], -TIP[0])], Style::Markers));
    outcome.svg("Rest under weight.", &chart)?;
    Ok(outcome)
}
