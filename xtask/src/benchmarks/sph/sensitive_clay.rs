//! Retrogressive failure of a slope of sensitive clay (sheet: sph B-12).

use colluvium::case::{Case, RunReport, Snapshot};
use colluvium::plots::{LineChart, PointCloud, Series, Style};

use crate::analysis::{MaxOrNan, connected_front};
use crate::benchmarks::{
    Benchmark, BenchmarkOutcome, load_case, run_in_memory, set_material, set_method_option, vectors,
};

/// Benchmark of the retrogressive failure of a slope of sensitive clay.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "sph/sensitive-clay",
    title: "Retrogressive slope of sensitive clay, SPH",
    source: "Bui & Nguyen 2021, Figs. 31–33; sheet: sph B-12 with its reference run",
    short_seconds: None,
    full_seconds: 62,
    run,
};

/// Benchmark of the retrogressive failure of a slope of sensitive clay at the resolutions of the source.
pub const FINE_RUNS: Benchmark = Benchmark {
    id: "sph/sensitive-clay-fine",
    title: "Retrogressive slope of sensitive clay at the source's resolutions, SPH",
    short_seconds: None,
    full_seconds: 5200,
    run: |_| slopes(false),
    ..BENCHMARK
};

/// Position of the toe at the start (m).
const TOE: f64 = 25.0;
/// Duration of gravity before the release (s).
const RELEASE: f64 = 1.0;
/// Spacing of the sheet's reference runs (m).
const COARSE: f64 = 0.24;
/// Reference run of the sheet, with the compression cone: time after release (s) and advance of the front (m).
const SHEET: [(f64, f64); 7] =
    [(2.0, 3.2), (4.0, 12.0), (6.0, 17.9), (9.0, 20.9), (13.0, 24.5), (18.0, 26.9), (20.0, 27.3)];

/// Advance of the front beyond the toe (m) over time since the release (s).
fn advance(report: &RunReport, spacing: f64) -> Vec<(f64, f64)> {
    report.frames.iter().map(|frame| (frame.time - RELEASE, connected_front(frame, spacing) - TOE)).collect()
}

/// Value of a curve at the record nearest to a time.
fn value_at(curve: &[(f64, f64)], time: f64) -> f64 {
    curve
        .iter()
        .min_by(|a, b| (a.0 - time).abs().total_cmp(&(b.0 - time).abs()))
        .map_or(f64::NAN, |point| point.1)
}

/// Position of the scarp: the foremost crest particle that has sunk by less than a metre (m).
fn scarp(snapshot: &Snapshot) -> f64 {
    let moved = vectors(snapshot, "displacement");
    let stands = |(x, u): &(&[f64; 3], &[f64; 3])| x[1] - u[1] > 4.7 && u[1] > -1.0;
    let standing = snapshot.positions.iter().zip(&moved).filter(stands);
    standing.map(|(x, u)| x[0] - u[0]).max_or_nan()
}

/// Number of retrogressive failures: times at which the scarp moved back by more than `step` (m) within a frame.
fn slides(report: &RunReport, step: f64) -> usize {
    let places: Vec<f64> = report.frames.iter().map(scarp).collect();
    let (mut count, mut moving) = (0, false);
    for pair in places.windows(2) {
        let moves = pair[0] - pair[1] > step;
        count += usize::from(moves && !moving);
        moving = moves;
    }
    count
}

/// Checks the short form: the coarse run, and one with the cone of plane strain.
fn run(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = slopes(true)?;
    let mut case = load_case("sph/clay")?;
    set_material(&mut case, "clay", &[("matching", "plane-strain".into())])?;
    let curve = advance(&run_in_memory("sph", &case)?, COARSE);
    let reason = "not judged: B-12 judges the cone through triaxial compression and has this one reported";
    for (time, place) in [(2.0, "4.1"), (4.0, "13.9")] {
        let name = format!("coarse, cone of plane strain: advance of the front after {time} s (m)");
        outcome.info(name, place, value_at(&curve, time), reason);
    }
    Ok(outcome)
}

/// Checks the run at the spacing of the sheet's reference run and, in the full form, runs at the resolutions of the source.
fn slopes(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut chart =
        LineChart::new("Front of the sliding clay", "time after release (s)", "advance beyond the toe (m)");
    let mut case = load_case("sph/clay")?;
    if !quick {
        case.stages[1].duration = 20.0;
    }
    coarse(&mut outcome, &mut chart, &case)?;
    if !quick {
        check_fine_runs(&mut outcome, &mut chart, &case)?;
    }
    outcome.svg("Advance of the front, the sheet's reference run as markers.", &chart)?;
    Ok(outcome)
}

/// Checks the run at the spacing of the sheet's reference run.
fn coarse(outcome: &mut BenchmarkOutcome, chart: &mut LineChart, case: &Case) -> Result<(), String> {
    let report = run_in_memory("sph", case)?;
    let curve = advance(&report, COARSE);
    let name = "coarse: advance of the front after 4 s (m)";
    let reason =
        "B-12, for continuous integration: 12.0 ± 2 m at 4 s, the sheet's reference run at the same spacing";
    outcome.assert_within(name, "12.0 ± 2", value_at(&curve, 4.0), (10.0, 14.0), reason);
    for (time, place) in
        SHEET.into_iter().filter(|(time, _)| *time != 4.0 && *time <= curve[curve.len() - 1].0)
    {
        let name = format!("coarse: advance of the front after {time} s (m)");
        outcome.info(name, &place.to_string(), value_at(&curve, time), "not judged: the sheet judges 4 s");
    }
    let (claim, steps) = ("at least 2 at the source's resolution", slides(&report, 0.5) as f64);
    outcome.info("coarse: steps of the scarp", claim, steps, "not judged: coarse");
    chart.series.push(Series::new("coarse", curve, Style::Line));
    chart.series.push(Series::new("sheet, coarse", SHEET.to_vec(), Style::Markers));
    if let Some(cloud) = PointCloud::from_snapshot(&report.snapshot, "displacement", [0, 1]) {
        outcome.png("Displacement at the end, coarse.", &cloud)?;
    }
    Ok(())
}

/// Checks runs at the resolutions of the source.
fn check_fine_runs(outcome: &mut BenchmarkOutcome, chart: &mut LineChart, case: &Case) -> Result<(), String> {
    let mut ends = Vec::new();
    for spacing in [0.12, 0.10, 0.08] {
        let mut fine = case.clone();
        set_method_option(&mut fine, "sph", "spacing", spacing);
        set_method_option(&mut fine, "sph", "smoothing", 0.144 / spacing);
        let report = run_in_memory("sph", &fine)?;
        let curve = advance(&report, spacing);
        let name = format!("spacing {spacing} m: run-out after 20 s (m)");
        let reason = "B-12: 20 m -5/+9 m at 20 s with the source's smoothing length";
        outcome.assert_within(name, "20 -5/+9", value_at(&curve, 20.0), (15.0, 29.0), reason);
        let name = format!("spacing {spacing} m: steps of the scarp");
        let stages = slides(&report, 0.5) as f64;
        outcome.assert_within(name, "at least 2", stages, (2.0, 100.0), "B-12: two distinct stages");
        ends.push(value_at(&curve, 20.0));
        chart.series.push(Series::new(format!("spacing {spacing} m"), curve, Style::Line));
    }
    let name = "run-out with a spacing of 0.12 m over that with 0.1 m";
    let claim = "1 ± 0.15; the source: nearly identical";
    outcome.assert_within(name, claim, ends[0] / ends[1], (0.85, 1.15), "B-12: 15 %");
    Ok(())
}
