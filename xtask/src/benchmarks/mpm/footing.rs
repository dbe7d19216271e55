//! Strip footing on Tresca clay (sheet: mpm A-29; Prandtl 1920).

use colluvium::case::description::Space;
use colluvium::case::{Case, RunReport};
use colluvium::plots::{LineChart, PointCloud, Series, Style};
use serde_json::json;

use crate::benchmarks::{Benchmark, BenchmarkOutcome, load_case, measure_series, run_mpm, set_mpm_option};

/// Benchmark of the bearing capacity of a strip footing on Tresca clay.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "mpm/footing",
    title: "Strip footing on Tresca clay",
    source: "Prandtl 1920, (2 + π) c_u; sheet: mpm A-29",
    short_seconds: Some(9),
    full_seconds: 105,
    run: benchmark,
};

/// Undrained strength of the clay (Pa).
const STRENGTH: f64 = 1e4;
/// Half width of the footing (m).
const HALF_WIDTH: f64 = 1.0;
/// Settlement at the end (m).
const SETTLEMENT: f64 = 0.12;

/// Prandtl's bearing capacity over the undrained strength.
const PRANDTL: f64 = 2.0 + std::f64::consts::PI;

/// Id of the case of the sheet, whose points keep their positions.
const FIXED_POINTS_ID: &str = "mpm/footing";
/// Id of the case whose footing sinks into the clay: points move, and the clay beside it heaves.
const SINKING_FOOTING_ID: &str = "mpm/footing-sinking";

/// Case of a footing with a number of cells under half of it.
fn footing(folder: &str, cells: usize) -> Result<Case, String> {
    let mut case = load_case(folder)?;
    set_mpm_option(&mut case, "cell_size", HALF_WIDTH / cells as f64);
    Ok(case)
}

/// Numbers of cells under half of the footing in the runs.
fn levels(quick: bool) -> &'static [usize] {
    if quick { &[8] } else { &[4, 8, 16] }
}

/// Pressure under the footing over the strength, over the settlement (m).
fn curve(report: &RunReport) -> Vec<(f64, f64)> {
    // Mean force between two rows, from the impulse.
    let impulse = measure_series(report, "footing.impulse.y");
    let settled = |time: f64| {
        let ramp = 0.123;
        0.05 * if time < ramp { 0.5 * time * time / ramp } else { time - 0.5 * ramp }
    };
    let mean = |pair: &[(f64, f64)]| {
        let force = (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0);
        (settled(0.5 * (pair[0].0 + pair[1].0)), force / (HALF_WIDTH * STRENGTH))
    };
    impulse.windows(2).map(mean).collect()
}

/// Mean pressure between two settlements (m).
fn mean_pressure_between(curve: &[(f64, f64)], low: f64, high: f64) -> f64 {
    let inside: Vec<f64> = curve.iter().filter(|(s, _)| (low..=high).contains(s)).map(|(_, q)| *q).collect();
    inside.iter().sum::<f64>() / inside.len() as f64
}

/// Mean pressure over the last 10 mm of settlement.
fn at_the_end(curve: &[(f64, f64)]) -> f64 {
    mean_pressure_between(curve, SETTLEMENT - 0.01, SETTLEMENT)
}

/// Relative rise of the pressure over the last 20 mm of settlement.
fn final_pressure_rise(curve: &[(f64, f64)]) -> f64 {
    at_the_end(curve) / mean_pressure_between(curve, SETTLEMENT - 0.03, SETTLEMENT - 0.02) - 1.0
}

/// Checks the pressure under a strip footing on clay against Prandtl's bearing capacity.
fn benchmark(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut chart = LineChart {
        series: vec![Series::new("Prandtl", vec![(0.0, PRANDTL), (SETTLEMENT, PRANDTL)], Style::Dashed)],
        ..LineChart::new("Strip footing on Tresca clay", "settlement (m)", "pressure over c_u")
    };
    let of_eight = check_smoothed(&mut outcome, &mut chart, quick)?;

    let mut plain = footing(FIXED_POINTS_ID, 8)?;
    set_mpm_option(&mut plain, "volumetric_strain", "point");
    let plain = curve(&run_mpm(&plain)?);
    let (reason, name) = ("the sheet: it locks", "A-29 not smoothed over smoothed, 8 cells");
    let ratio = at_the_end(&plain) / of_eight;
    outcome.assert_within(name, "above 1 (prototype 1.16)", ratio, (1.0, f64::INFINITY), reason);
    chart.series.push(Series::new("not smoothed, 8 cells", plain, Style::Line));

    let mut smooth = footing(FIXED_POINTS_ID, 8)?;
    smooth.stages[0].motions[0].velocity[0] = None;
    let smooth = at_the_end(&curve(&run_mpm(&smooth)?));
    let claim = "5.142 (prototype 5.300)";
    outcome.assert_within(
        "A-29 smoothed, smooth footing, 8 cells: pressure at the end over c_u",
        claim,
        smooth,
        (5.14, 5.60),
        "the sheet's band",
    );

    if !quick {
        triangles(&mut outcome, &mut chart)?;
        circular(&mut outcome)?;
    }
    check_sinking_footing(&mut outcome, &mut chart, quick)?;
    outcome.svg("Pressure under the footing.", &chart)?;
    Ok(outcome)
}

/// Checks the pressures with averaged volumetric strains, and returns the pressure at the end with 8 cells.
fn check_smoothed(outcome: &mut BenchmarkOutcome, chart: &mut LineChart, quick: bool) -> Result<f64, String> {
    let (mut pressures, mut of_eight) = (Vec::new(), f64::NAN);
    for &cells in levels(quick) {
        let report = run_mpm(&footing(FIXED_POINTS_ID, cells)?)?;
        let curve = curve(&report);
        let last = at_the_end(&curve);
        pressures.push(last);
        let name = format!("A-29 smoothed, rough, {cells} cells: pressure at the end over c_u");
        match cells {
            8 => {
                outcome.assert_within(
                    name,
                    "5.142 (prototype 5.371)",
                    last,
                    (5.14, 5.60),
                    "the sheet's band",
                );
            }
            16 => {
                outcome.assert_within(
                    name,
                    "5.142 (prototype 5.255)",
                    last,
                    (5.14, 5.40),
                    "the sheet's band",
                );
            }
            _ => outcome.info(name, "5.142 (prototype 5.587)", last, "the sheet judges 8 and 16 cells"),
        }
        if cells >= 8 {
            let name = format!("A-29 smoothed, rough, {cells} cells: rise over the last 20 mm");
            outcome.assert_within(
                name,
                "a plateau",
                final_pressure_rise(&curve),
                (-0.01, 0.01),
                "the sheet's 1 %",
            );
        }
        if cells == 8 {
            of_eight = last;
            let cloud = PointCloud::from_snapshot(&report.snapshot, "displacement", [0, 1])
                .ok_or("no displacement")?;
            outcome.png("Displacement under the footing at the end.", &cloud)?;
        }
        chart.series.push(Series::new(format!("smoothed, {cells} cells"), curve, Style::Line));
    }
    if !quick {
        let falls = pressures.windows(2).all(|pair| pair[1] < pair[0] && pair[1] > PRANDTL);
        let reason = "the sheet: monotonically towards 5.14";
        outcome.assert_close(
            "A-29 smoothed: finer cells come closer (1: yes)",
            1.0,
            0.0,
            f64::from(falls),
            reason,
        );
    }
    Ok(of_eight)
}

/// Checks triangles with one point each and nodal averages of strains, the elements of the source.
fn triangles(outcome: &mut BenchmarkOutcome, chart: &mut LineChart) -> Result<(), String> {
    let mut case = footing(FIXED_POINTS_ID, 8)?;
    set_mpm_option(&mut case, "mesh", json!({ "kind": "box" }));
    set_mpm_option(&mut case, "points_per_cell", 1);
    set_mpm_option(&mut case, "volumetric_strain", "nodal");
    let curve = curve(&run_mpm(&case)?);
    outcome.assert_within(
        "A-29 on triangles, nodal strains, rough, 8 cells: pressure at the end over c_u",
        "5.142",
        at_the_end(&curve),
        (5.14, 5.60),
        "the sheet's band for squares: the two kinds of smoothing alike",
    );
    chart.series.push(Series::new("triangles, 8 cells", curve, Style::Line));
    Ok(())
}

/// Checks the bearing capacity of a circular footing of equal radius.
fn circular(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut chart = LineChart::new("Circular footing on Tresca clay", "settlement (m)", "pressure over c_u");
    for (kind, exact) in [("smooth", 5.69), ("rough", 6.05)] {
        for cells in [8, 16] {
            let mut case = footing(FIXED_POINTS_ID, cells)?;
            case.space = Space::Axisymmetric;
            if kind == "smooth" {
                case.stages[0].motions[0].velocity[0] = None;
            }
            // The force is per radian: on half the square of the radius.
            let curve: Vec<(f64, f64)> =
                curve(&run_mpm(&case)?).into_iter().map(|(s, q)| (s, 2.0 * q / HALF_WIDTH)).collect();
            let name = format!("A-29 circular, {kind}, {cells} cells: pressure at the end over c_u");
            let last = at_the_end(&curve);
            if cells == 16 {
                outcome.assert_within(
                    name,
                    &exact.to_string(),
                    last,
                    (exact, 1.08 * exact),
                    "the sheet allows 8 % more",
                );
            } else {
                outcome.info(name, &exact.to_string(), last, "judged with 16 cells; the sheet names none");
            }
            chart.series.push(Series::new(format!("{kind}, {cells} cells"), curve, Style::Line));
        }
        let line = vec![(0.0, exact), (SETTLEMENT, exact)];
        chart.series.push(Series::new(format!("{kind}, exact"), line, Style::Dashed));
    }
    outcome.svg("Pressure under a circular footing.", &chart)
}

/// Checks a footing that sinks into clay, which heaves beside it.
fn check_sinking_footing(
    outcome: &mut BenchmarkOutcome,
    chart: &mut LineChart,
    quick: bool,
) -> Result<(), String> {
    for &cells in levels(quick) {
        let curve = curve(&run_mpm(&footing(SINKING_FOOTING_ID, cells)?)?);
        let name = format!("A-29 with points that move, {cells} cells: pressure at the end over c_u");
        let last = at_the_end(&curve);
        let reason = "the sheet's figures are those of the geometry at the start";
        match cells {
            8 => outcome.assert_within(name, "5.142", last, (5.14, 5.60), "the sheet's band"),
            _ => outcome.info(name, "5.142", last, reason),
        }
        outcome.info(
            format!("A-29 with points that move, {cells} cells: rise over the last 20 mm"),
            "",
            final_pressure_rise(&curve),
            reason,
        );
        chart.series.push(Series::new(format!("points that move, {cells} cells"), curve, Style::Line));
    }
    Ok(())
}
