//! Plane shear at constant pressure: `μ(I)` and `φ(I)` (sheet: dem §5, B11).

use colluvium::case::RunReport;
use colluvium::plots::{LineChart, Series, Style};
use serde_json::json;

use crate::analysis::max_or_nan;
use crate::benchmarks::dem::case_builders::{load, method_options, parse_case};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, measure_series, run_in_memory};

/// Benchmark of plane shear of disks at two shear rates.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "dem/plane-shear",
    title: "Plane shear of 900 disks, μ(I) and φ(I), two rates, DEM",
    source: "sheet: dem §5, B11; da Cruz et al. 2005",
    short_seconds: None,
    full_seconds: 40,
    run: |_| rates(&SHEET[2..4], 8.0),
};

/// Benchmark of plane shear of disks at all shear rates of the sheet.
pub const TABLE: Benchmark = Benchmark {
    id: "dem/plane-shear-table",
    title: "Plane shear of 900 disks, μ(I) and φ(I), all rates, DEM",
    source: "sheet: dem §5, B11; da Cruz et al. 2005",
    short_seconds: None,
    full_seconds: 700,
    run: |_| rates(&SHEET, f64::INFINITY),
};

/// Row of the sheet: inertial number, ratio of stresses, solid fraction, coordination number, and strain of the shear.
type PlaneShearRow = (f64, f64, f64, f64, f64);

/// Table of the sheet, from fast to slow shear.
const SHEET: [PlaneShearRow; 8] = [
    (0.3, 0.550, 0.7187, 0.48, 60.0),
    (0.2, 0.486, 0.7514, 0.69, 40.0),
    (0.1, 0.390, 0.7823, 1.17, 25.0),
    (0.05, 0.336, 0.7977, 1.65, 14.0),
    (0.02, 0.298, 0.8058, 2.15, 8.0),
    (0.01, 0.283, 0.8100, 2.41, 6.0),
    (0.003, 0.263, 0.8143, 2.70, 4.0),
    (0.001, 0.269, 0.8143, 2.83, 3.0),
];

/// Report of shear at one rate from the compacted state, with the start and end of the shear (s).
fn shear_report((rate, .., strain): &PlaneShearRow, limit: f64) -> Result<(RunReport, (f64, f64)), String> {
    let mut value = load("plane-shear")?;
    let start = value["stages"][0]["duration"].as_f64().ok_or("no duration")?;
    let duration = strain.min(limit) / rate;
    if let Some(stages) = value["stages"].as_array_mut() {
        stages.push(json!({ "name": "shear", "duration": duration }));
    }
    method_options(&mut value)["stages"]["shear"] =
        json!({ "cell": { "xy": { "rate": rate }, "yy": { "stress": -1 } } });
    Ok((run_in_memory("dem", &parse_case(&value)?)?, (start, start + duration)))
}

/// Mean of a measure over the last 60 % of a stage.
fn mean(report: &RunReport, name: &str, (start, end): (f64, f64)) -> f64 {
    let from = start + 0.4 * (end - start);
    let values: Vec<f64> = measure_series(report, name)
        .into_iter()
        .filter(|(t, _)| *t > from && *t <= end + 1e-6)
        .map(|(_, v)| v)
        .collect();
    values.iter().sum::<f64>() / values.len() as f64
}

/// Checks effective friction and solid fraction in plane shear, at several inertial numbers.
fn rates(rows: &[PlaneShearRow], limit: f64) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let (mut friction, mut fraction, mut error) = (Vec::new(), Vec::new(), 0.0);
    for row in rows {
        let (report, span) = shear_report(row, limit)?;
        let (ratio, solid) = judge(&mut outcome, row, &report, span);
        friction.push((row.0, ratio));
        fraction.push((row.0, solid));
        let own = measure_series(&report, "energy_error").last().map_or(f64::NAN, |(_, error)| error.abs());
        error = max_or_nan(error, own);
    }
    monotone(&mut outcome, &friction, &fraction);
    outcome.assert_below("B11, error of the energy balance over input", "0", error, 0.01, "§2.14: 1 %");
    let law = |from: f64, slope: f64| {
        (0..=20).map(|k| 0.01 * f64::from(k)).map(|i| (i, from + slope * i)).collect()
    };
    let ratios = rows.iter().map(|row| (row.0, row.1)).collect();
    draw(&mut outcome, "Ratio of shear stress to pressure", "ratio", (friction, ratios, law(0.25, 1.1)))?;
    let solids = rows.iter().map(|row| (row.0, row.2)).collect();
    draw(
        &mut outcome,
        "Solid fraction in plane shear",
        "solid fraction",
        (fraction, solids, law(0.81, -0.3)),
    )?;
    Ok(outcome)
}

/// Checks the ratio of stresses and the solid fraction in a stage of shear, and returns both.
fn judge(
    outcome: &mut BenchmarkOutcome,
    row: &PlaneShearRow,
    report: &RunReport,
    span: (f64, f64),
) -> (f64, f64) {
    let &(rate, ratio, solid, contacts, _) = row;
    let pressure = -mean(report, "cell_stress.yy", span);
    let found = mean(report, "cell_stress.xy", span).abs() / pressure.abs();
    let filled = mean(report, "solid_fraction", span);
    for (what, exact, value, width) in
        [("ratio of stresses", ratio, found, 0.02), ("solid fraction", solid, filled, 0.006)]
    {
        let (name, claim) = (format!("B11, I = {rate}: {what}"), format!("{exact}"));
        if rate <= 0.2 {
            let reason = format!("B11: ± {width}");
            outcome.assert_within(name, &claim, value, (exact - width, exact + width), &reason);
        } else {
            outcome.info(name, &claim, value, "not judged: the sheet bounds I ≤ 0.2");
        }
    }
    let reason = "not judged: the sheet gives no bounds";
    let name = |what: &str| format!("B11, I = {rate}: {what}");
    let coordination = mean(report, "coordination", span);
    outcome.info(name("contacts of a grain"), &format!("{contacts}"), coordination, reason);
    outcome.info(name("pressure"), "1; the sheet's code 0.992 to 1.006", pressure, reason);
    (found, filled)
}

/// Checks that the ratio of stresses rises and the solid fraction falls with the rate, above the rates at which the sheet's values scatter.
fn monotone(outcome: &mut BenchmarkOutcome, friction: &[(f64, f64)], fraction: &[(f64, f64)]) {
    let largest = |curve: &[(f64, f64)], sign: f64| {
        let pairs = curve.windows(2).filter(|pair| pair[1].0 >= 0.01);
        pairs.map(|pair| sign * (pair[1].1 - pair[0].1)).fold(f64::NEG_INFINITY, max_or_nan)
    };
    let reason =
        "B11: monotone; judged for I ≥ 0.01, below which the sheet's own ratios differ by their scatter";
    let name = "B11, ratio of stresses: largest rise to a slower rate";
    outcome.assert_below(name, "falls", largest(friction, 1.0), 0.0, reason);
    let name = "B11, solid fraction: largest loss to a slower rate";
    outcome.assert_below(name, "rises", largest(fraction, -1.0), 0.0, reason);
}

/// Curves of this code, of the sheet, and of da Cruz et al.
type RheologyCurves = (Vec<(f64, f64)>, Vec<(f64, f64)>, Vec<(f64, f64)>);

/// Draws a quantity over the inertial number, with a law of the literature and the values of the sheet.
fn draw(
    outcome: &mut BenchmarkOutcome,
    title: &str,
    label: &str,
    (found, sheet, law): RheologyCurves,
) -> Result<(), String> {
    let mut picture: LineChart = LineChart::new(title, "inertial number", label);
    picture.series.push(Series::new("da Cruz et al. 2005", law, Style::Dashed));
    picture.series.push(Series::new("sheet's code", sheet, Style::Line));
    picture.series.push(Series::new("DEM", found, Style::Markers));
    outcome.svg("B11.", &picture)
}
