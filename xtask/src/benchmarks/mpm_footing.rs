//! Strip footing on Tresca clay (MPM sheet A-29; Prandtl 1920).

use colluvium::case::plot::{LineChart, PointCloud, Series, Style};
use colluvium::case::{Case, RunReport};

use super::{Benchmark, Outcome, case, run, series, set};

/// The benchmark.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "mpm/footing",
    title: "Strip footing on Tresca clay",
    source: "Prandtl 1920, (2 + π) c_u; MPM sheet A-29",
    run: benchmark,
};

/// Undrained strength (Pa), half width of the footing (m), settlement at the end (m).
const STRENGTH: f64 = 1e4;
const HALF_WIDTH: f64 = 1.0;
const SETTLEMENT: f64 = 0.12;

/// The case with a number of cells under half the footing, which is rough.
fn footing(cells: usize, smoothing: bool) -> Result<Case, String> {
    let mut case = case("mpm/footing")?;
    set(&mut case, "cell_size", HALF_WIDTH / cells as f64);
    if smoothing {
        set(&mut case, "volumetric_strain", "cell-average");
    }
    Ok(case)
}

/// Pressure under the footing over the strength against settlement (m).
fn curve(report: &RunReport) -> Vec<(f64, f64)> {
    // Mean force between two rows, from the impulse.
    let impulse = series(report, "footing.impulse.y");
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
fn between(curve: &[(f64, f64)], low: f64, high: f64) -> f64 {
    let inside: Vec<f64> = curve.iter().filter(|(s, _)| (low..=high).contains(s)).map(|(_, q)| *q).collect();
    inside.iter().sum::<f64>() / inside.len() as f64
}

fn benchmark(quick: bool) -> Result<Outcome, String> {
    let mut outcome = Outcome::default();
    let prandtl = 2.0 + std::f64::consts::PI;
    let mut chart = LineChart {
        title: "Strip footing on Tresca clay".into(),
        x_label: "settlement (m)".into(),
        y_label: "pressure over c_u".into(),
        series: vec![Series::new("Prandtl", vec![(0.0, prandtl), (SETTLEMENT, prandtl)], Style::Dashed)],
        ..LineChart::default()
    };
    let mut smoothed = Vec::new();
    let levels: &[usize] = if quick { &[8] } else { &[4, 8, 16] };
    for &cells in levels {
        let report = run(&footing(cells, true)?)?;
        let curve = curve(&report);
        let last = between(&curve, SETTLEMENT - 0.01, SETTLEMENT);
        smoothed.push(last);
        let name = format!("A-29 smoothed, rough, {cells} cells: pressure at the end over c_u");
        match cells {
            8 => outcome.within(name, "5.142 (prototype 5.371)", last, (5.14, 5.60), "the sheet's band"),
            16 => outcome.within(name, "5.142 (prototype 5.255)", last, (5.14, 5.40), "the sheet's band"),
            _ => outcome.show(name, "5.142 (prototype 5.587)", last, "the sheet judges 8 and 16 cells"),
        }
        let rise = last / between(&curve, SETTLEMENT - 0.03, SETTLEMENT - 0.02) - 1.0;
        if cells >= 8 {
            let name = format!("A-29 smoothed, rough, {cells} cells: rise over the last 20 mm");
            outcome.within(name, "a plateau", rise, (-0.01, 0.01), "the sheet's 1 %");
        }
        if cells == 8 {
            let cloud = PointCloud::of(&report.snapshot, "displacement", [0, 1]).ok_or("no displacement")?;
            outcome.png("Displacement under the footing at the end.", &cloud)?;
        }
        chart.series.push(Series::new(format!("smoothed, {cells} cells"), curve, Style::Line));
    }
    if !quick {
        let falls = smoothed.windows(2).all(|pair| pair[1] < pair[0]);
        let reason = "the sheet: monotonically towards 5.14";
        outcome.near("A-29 smoothed: finer cells come closer (1: yes)", 1.0, 0.0, f64::from(falls), reason);
    }
    let of_eight = smoothed[levels.iter().position(|cells| *cells == 8).unwrap_or(0)];
    let plain = curve(&run(&footing(8, false)?)?);
    let locked = between(&plain, SETTLEMENT - 0.01, SETTLEMENT);
    chart.series.push(Series::new("not smoothed, 8 cells", plain, Style::Line));
    let name = "A-29 not smoothed over smoothed, 8 cells";
    outcome.within(
        name,
        "above 1 (prototype 1.16)",
        locked / of_eight,
        (1.0, f64::INFINITY),
        "the sheet: it locks",
    );
    outcome.svg("Pressure under the footing.", &chart)?;
    Ok(outcome)
}
