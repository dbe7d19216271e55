//! Axisymmetric granular column collapse (sheet: mpm A-28; Lube et al. 2004).

use colluvium::case::Case;
use colluvium::plots::{LineChart, PointCloud, Series, Style};

use crate::analysis::crest;
use crate::benchmarks::{Benchmark, BenchmarkOutcome, load_case, measure_series, run_mpm};

/// Benchmark of the axisymmetric collapse of granular columns.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "mpm/column-axisymmetric",
    title: "Axisymmetric granular column collapse",
    source: "Lube et al. 2004; sheet: mpm A-28",
    short_seconds: Some(25),
    full_seconds: 60,
    run: benchmark,
};

/// Radius of the column (m).
const RADIUS: f64 = 0.1;
/// Cell size (m).
const CELL: f64 = 0.005;

/// Case of a column with an aspect ratio.
fn column(aspect: f64) -> Result<Case, String> {
    let mut case = load_case("mpm/column-axisymmetric")?;
    let height = aspect * RADIUS;
    let shape = serde_json::json!({ "kind": "box", "min": [0.0, 0.0], "max": [RADIUS, height] });
    case.bodies[0].shape = serde_json::from_value(shape).map_err(|error| error.to_string())?;
    let cells = |length: f64| (length / CELL).ceil() * CELL;
    case.domain.max = vec![cells(RADIUS * (1.6 + 2.2 * aspect)), cells(height + 0.02)];
    case.stages[0].duration = 6.0 * (height / 9.81).sqrt();
    case.output.frames = Some(case.stages[0].duration / 6.0);
    case.output.measures = Some(case.stages[0].duration / 120.0);
    Ok(case)
}

/// Run-out and final height over the radius by the laws of Lube et al. (2004), who have no height for aspect ratios between 1 and 1.7.
fn laws(aspect: f64) -> [f64; 2] {
    let run_out = if aspect < 1.7 { 1.24 * aspect } else { 1.6 * aspect.sqrt() };
    [run_out, if aspect < 1.7 { aspect } else { 0.88 * aspect.powf(1.0 / 6.0) }]
}

/// Checks run-out and height of axisymmetric columns against the laws of Lube et al.
fn benchmark(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut advance =
        LineChart::new("Advance of the front, axisymmetric", "t / sqrt(H/g)", "run-out over radius");
    let aspects: &[f64] = if quick { &[0.5, 1.0] } else { &[0.5, 1.0, 2.0] };
    for &aspect in aspects {
        let report = run_mpm(&column(aspect)?)?;
        let run_out = measure_series(&report, "run_out");
        let end = run_out.last().map_or(f64::NAN, |row| row.1);
        let scale = (aspect * RADIUS / 9.81).sqrt();
        let stopped = run_out.iter().find(|(_, r)| *r > 0.98 * end).map_or(f64::NAN, |(t, _)| t / scale);
        let height = crest(&report.snapshot, CELL) / RADIUS;
        let [farthest, highest] = laws(aspect);
        let name = |what: &str| format!("A-28 a = {aspect}: {what}");
        for (what, exact, found) in
            [("run-out over radius", farthest, end), ("height at the axis over radius", highest, height)]
        {
            outcome.assert_close(name(what), exact, 0.2, found, "the sheet's 20 %");
        }
        let reason = "not judged: about 3, and no word of when a flow has ended; here at 98 % of its run-out";
        outcome.info(name("duration over sqrt(H/g)"), "about 3", stopped, reason);
        let kept = report.end.mass / report.start.mass;
        outcome.assert_close(
            name("mass at the end over the start"),
            1.0,
            1e-12,
            kept,
            "points carry their mass",
        );
        let points = run_out.iter().map(|(t, r)| (t / scale, *r)).collect();
        advance.series.push(Series::new(format!("a = {aspect}"), points, Style::Line));
        advance.series.push(Series::new(
            format!("Lube, a = {aspect}"),
            vec![(0.0, farthest), (6.0, farthest)],
            Style::Dashed,
        ));
        if aspect == 1.0 {
            let cloud = PointCloud::from_snapshot(&report.snapshot, "displacement", [0, 1])
                .ok_or("no displacement")?;
            outcome.png(
                "Deposit of the column with a = 1 (radius to the right), coloured by displacement.",
                &cloud,
            )?;
        }
    }
    outcome.svg("Run-out of axisymmetric columns, with the published laws.", &advance)?;
    Ok(outcome)
}
