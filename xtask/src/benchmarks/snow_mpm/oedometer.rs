//! Compaction by a moving plate against the path of a single point (sheet: snow-mpm V17, V6).

use colluvium::case::Snapshot;
use colluvium::plots::{LineChart, Series, Style};
use serde_json::json;

use super::{case_with_options, run_snow_case};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, final_measure, scalars, stresses};

/// Benchmark of the compaction of a block of snow in an oedometer.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "snow-mpm/oedometer",
    title: "Oedometer: a plate compacts a block of snow",
    source: "sheet: snow-mpm V17; path of V6 by an independent integration of the rates",
    short_seconds: Some(10),
    full_seconds: 10,
    run: benchmark,
};

/// Logarithmic strain and axial Kirchhoff stress (Pa) of the single point of V6 with d = 3.
const PATH: [(f64, f64); 5] =
    [(0.01, 27_522.876), (0.02, 42_381.579), (0.05, 87_570.641), (0.1, 163_077.986), (0.2, 314_351.353)];

/// Mean logarithmic strain of the points of a frame, and their mean axial Kirchhoff stress (Pa), compression positive. `initial` is the
/// initial volume.
fn state(frame: &Snapshot, initial: f64) -> (f64, f64) {
    let volumes = scalars(frame, "volume");
    let force: f64 = stresses(frame).iter().zip(&volumes).map(|(s, v)| -s[1] * v).sum();
    (-(volumes.iter().sum::<f64>() / initial).ln(), force / initial)
}

/// Value at `x` by linear interpolation between points.
fn value_at(points: &[(f64, f64)], x: f64) -> f64 {
    let pair = points.windows(2).find(|pair| pair[0].0 <= x && x < pair[1].0);
    pair.map_or(f64::NAN, |pair| {
        let [(a, y), (b, z)] = [pair[0], pair[1]];
        y + (z - y) * (x - a) / (b - a)
    })
}

/// Checks stresses in compaction of a block against the path of a single point.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut chart = LineChart {
        series: vec![Series::new("path of a point", PATH.to_vec(), Style::Markers)],
        ..LineChart::new("Axial stress", "logarithmic strain", "axial Kirchhoff stress (Pa)")
    };
    for cell in [0.05, 0.025] {
        let report = run_snow_case(&case_with_options("oedometer", &json!({ "cell_size": cell }))?)?;
        let initial: f64 =
            report.frames.first().map_or(f64::NAN, |frame| scalars(frame, "volume").iter().sum());
        let path: Vec<(f64, f64)> = report.frames.iter().map(|frame| state(frame, initial)).collect();
        for (strain, exact) in &PATH[2..] {
            let name = format!("V17, cells of {cell} m: mean axial stress at a strain of {strain} (Pa)");
            if cell < 0.03 {
                outcome.assert_close(
                    name,
                    *exact,
                    0.05,
                    value_at(&path, *strain),
                    "the sheet's criterion: 5 %",
                );
            } else {
                let claim = format!("{exact}; the sheet's prototype has 3.6 % more at a strain of 0.19");
                outcome.info(name, &claim, value_at(&path, *strain), "the sheet judges the finer grid");
            }
        }
        let last = |name: &str| final_measure(&report, name);
        let taken = last("energy_numerical") / last("energy_plastic");
        let name = format!("V17, cells of {cell} m: what the numerics take over what the snow does");
        outcome.assert_within(
            name,
            "small and not negative",
            taken,
            (-0.01, 0.05),
            "FLIP 1 does not dissipate by itself",
        );
        chart.series.push(Series::new(format!("cells of {cell} m"), path, Style::Line));
    }
    outcome.svg("Mean over the points of the block.", &chart)?;
    Ok(outcome)
}
