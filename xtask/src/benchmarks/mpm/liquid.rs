//! Liquids of one phase: at rest, between plates, and after a dam break (sheet: mpm ).

use std::f64::consts::PI;

use colluvium::case::{RunReport, Snapshot};
use colluvium::plots::{LineChart, PointCloud, Series, Style};

use crate::analysis::{MaxOrNan, regression_slope};
use crate::benchmarks::{
    Benchmark, BenchmarkOutcome, initial_positions, load_case, measure_series, reference_curve,
    reference_table, run_mpm, set_mpm_option, stresses, vectors,
};

/// Benchmark of water at rest in a tank.
pub const HYDROSTATIC: Benchmark = Benchmark {
    id: "mpm/hydrostatic",
    title: "Still water in a tank",
    source: "sheet: mpm A-24, closed form",
    short_seconds: Some(2),
    full_seconds: 2,
    run: hydrostatic,
};

/// Benchmark of Couette and Poiseuille flow between plates.
pub const VISCOUS: Benchmark = Benchmark {
    id: "mpm/viscous-flow",
    title: "Couette and Poiseuille flow, periodic",
    source: "sheet: mpm A-26, closed forms",
    short_seconds: Some(6),
    full_seconds: 6,
    run: viscous,
};

/// Benchmark of a dam break in a tank.
pub const DAM_BREAK: Benchmark = Benchmark {
    id: "mpm/dam-break",
    title: "Dam break in a tank",
    source: "sheet: mpm A-25; Martin & Moyce 1952, Koshizuka & Oka 1996; bound of Ritter 1892",
    short_seconds: Some(3),
    full_seconds: 20,
    run: dam_break,
};

/// Density of the water (kg/m³).
const DENSITY: f64 = 1000.0;
/// Gravitational acceleration (m/s²).
const GRAVITY: f64 = 9.81;
/// Bulk modulus of the water (Pa).
const BULK: f64 = 2e6;

/// Checks the pressure of water at rest.
fn hydrostatic(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut chart = LineChart::new("Pressure over depth", "height at the start (m)", "pressure (kPa)");
    for shape in ["linear", "ugimp"] {
        let mut case = load_case("mpm/hydrostatic")?;
        set_mpm_option(&mut case, "shape", shape);
        let report = run_mpm(&case)?;
        let (starts, stress) = (initial_positions(&report.snapshot), stresses(&report.snapshot));
        let exact = |y: f64| DENSITY * GRAVITY * (1.0 - y);
        let count = stress.len() as f64;
        let square =
            starts.iter().zip(&stress).map(|(x, s)| (s.pressure() - exact(x[1])).powi(2)).sum::<f64>();
        outcome.assert_below(
            format!("{shape}: RMS error of pressure over that at the bottom"),
            "p = rho_0 g (H - Y) by mass",
            (square / count).sqrt() / exact(0.0),
            0.02,
            "the sheet's 2 %",
        );
        let settled = DENSITY * GRAVITY / (2.0 * BULK);
        let tops = report.snapshot.positions.iter().zip(&starts).filter(|(_, start)| start[1] > 0.975);
        let (sum, number) = tops.fold((0.0, 0.0), |(sum, n), (x, _)| (sum + x[1] + 0.0125, n + 1.0));
        outcome.assert_close(
            format!("{shape}: level of the surface (m)"),
            1.0 - settled,
            0.001,
            sum / number,
            "the sheet's 0.1 %: above the mean of the uppermost points by half their width",
        );
        outcome.assert_close(
            format!("{shape}: how far the surface has settled (m)"),
            settled,
            0.02,
            1.0 - sum / number,
            "2 %, as the pressure: 0.1 % of the level would hide the settlement, which is 0.25 %",
        );
        let points = starts.iter().zip(&stress).map(|(x, s)| (x[1], 1e-3 * s.pressure())).collect();
        chart.series.push(Series::new(shape, points, Style::Markers));
    }
    let line = vec![(0.0, 1e-3 * DENSITY * GRAVITY), (1.0, 0.0)];
    chart.series.push(Series::new("closed form", line, Style::Dashed));
    outcome.svg("Pressure of the points at rest.", &chart)?;
    Ok(outcome)
}

/// Velocity along the plates at an initial height of the points (m), from the two nearest rows of points.
fn at_height(snapshot: &Snapshot, height: f64) -> f64 {
    let velocity = vectors(snapshot, "velocity");
    let mut rows: Vec<(f64, f64, f64)> = Vec::new();
    for (x, v) in snapshot.positions.iter().zip(&velocity) {
        match rows.iter_mut().find(|row| (row.0 / row.2 - x[1]).abs() < 1e-3) {
            Some(row) => *row = (row.0 + x[1], row.1 + v[0], row.2 + 1.0),
            None => rows.push((x[1], v[0], 1.0)),
        }
    }
    let mut rows: Vec<(f64, f64)> = rows.iter().map(|(y, v, n)| (y / n, v / n)).collect();
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    let pair = rows.windows(2).find(|w| w[0].0 <= height && height <= w[1].0);
    pair.map_or(f64::NAN, |w| w[0].1 + (w[1].1 - w[0].1) * (height - w[0].0) / (w[1].0 - w[0].0))
}

/// Height (m) and horizontal velocity (m/s) of the points.
fn profile(snapshot: &Snapshot) -> Vec<(f64, f64)> {
    let velocity = vectors(snapshot, "velocity");
    snapshot.positions.iter().zip(&velocity).map(|(x, v)| (x[1], v[0])).collect()
}

/// Height of the uppermost row of points over the gap: a quarter of one of 40 cells below the plate.
const TOP_ROW_HEIGHT: f64 = 1.0 - 0.25 / 40.0;

/// Mean velocity of the uppermost row of points (m/s).
fn top_row_velocity(snapshot: &Snapshot) -> f64 {
    let of_row = |(y, _): &(f64, f64)| (y - TOP_ROW_HEIGHT).abs() < 1e-3;
    let row: Vec<f64> = profile(snapshot).into_iter().filter(of_row).map(|(_, v)| v).collect();
    row.iter().sum::<f64>() / row.len() as f64
}

/// Velocity of the start-up of Couette flow, over that of the plate. `y` is the height over the gap, and `time` the time over the gap
/// squared times the viscosity.
fn couette(y: f64, time: f64) -> f64 {
    let term = |m: i32| {
        let (m, sign) = (f64::from(m), if m % 2 == 0 { 1.0 } else { -1.0 });
        sign / m * (-(m * PI).powi(2) * time).exp() * (m * PI * y).sin()
    };
    y + 2.0 / PI * (1..200).map(term).sum::<f64>()
}

/// Checks Couette and Poiseuille flow between plates.
fn viscous(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let report = run_mpm(&load_case("mpm/couette")?)?;
    let mut chart =
        LineChart::new("Couette flow, 40 cells across", "height over gap", "velocity over that of the plate");
    let table = [
        (0.05, [0.017629, 0.113844, 0.429195]),
        (0.1, [0.088344, 0.262756, 0.576059]),
        (0.5, [0.246763, 0.495422, 0.746763]),
    ];
    for (time, exact) in table {
        let frame = report.frames.iter().find(|frame| (frame.time - time).abs() < 1e-9);
        let frame = frame.ok_or_else(|| format!("no frame at {time} s"))?;
        for (height, exact) in [0.25, 0.5, 0.75].into_iter().zip(exact) {
            let name = format!("Couette, t = {time} H²/ν, y = {height} H: velocity over that of the plate");
            outcome.assert_close(name, exact, 0.02, at_height(frame, height), "the sheet's 2 %");
        }
        chart.series.push(Series::new(format!("t = {time} H²/ν"), profile(frame), Style::Markers));
        if time == 0.5 {
            let name = format!(
                "Couette, t = {time} H²/ν, row of points under the plate: velocity over that of the plate"
            );
            outcome.assert_close(
                name,
                couette(TOP_ROW_HEIGHT, time),
                0.02,
                top_row_velocity(frame),
                "the sheet's 2 %",
            );
        }
        let line = (0..=100).map(|i| f64::from(i) / 100.0).map(|y| (y, couette(y, time))).collect();
        let label = if time < 0.06 { "closed form" } else { "" };
        chart.series.push(Series::new(label, line, Style::Dashed));
    }
    outcome.svg("Velocity of the points while the upper plate draws the liquid along.", &chart)?;
    poiseuille(&mut outcome)?;
    Ok(outcome)
}

/// Checks the velocity profile of Poiseuille flow.
fn poiseuille(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut case = load_case("mpm/couette")?;
    case.boundaries[1].velocity = None;
    // u = g y (H - y) / (2 ν), 1 m/s in the middle.
    case.gravity = vec![8.0, 0.0];
    case.stages[0].duration = 1.0;
    let report = run_mpm(&case)?;
    let exact = |y: f64| 4.0 * y * (1.0 - y);
    for height in [0.25, 0.5, 0.75] {
        outcome.assert_close(
            format!("Poiseuille, y = {height} H: velocity (m/s)"),
            exact(height),
            0.02,
            at_height(&report.snapshot, height),
            "the sheet's 2 %",
        );
    }
    let drift = report
        .snapshot
        .positions
        .iter()
        .zip(initial_positions(&report.snapshot))
        .map(|(x, s)| (x[1] - s[1]).abs());
    outcome.assert_below(
        "Poiseuille: largest move across the flow over the gap",
        "none",
        drift.max_or_nan(),
        1e-3,
        "a twenty-fifth of a cell, while the liquid in the middle has gone around the domain twelve times",
    );
    let line = (0..=100).map(|i| f64::from(i) / 100.0).map(|y| (y, exact(y))).collect();
    outcome.svg(
        "Steady flow under gravity between resting plates.",
        &LineChart {
            series: vec![
                Series::new("points", profile(&report.snapshot), Style::Markers),
                Series::new("closed form", line, Style::Dashed),
            ],
            ..LineChart::new("Poiseuille flow, 40 cells across", "height over gap", "velocity (m/s)")
        },
    )
}

/// Width of the column (m).
const WIDTH: f64 = 0.146;

/// Checks the front of a dam break against experiments.
fn dam_break(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut case = load_case("mpm/dam-break")?;
    if quick {
        set_mpm_option(&mut case, "cell_size", 2.0 * 0.0045625);
    }
    let report = run_mpm(&case)?;
    let unit = (WIDTH / (2.0 * GRAVITY)).sqrt();
    let front: Vec<(f64, f64)> =
        measure_series(&report, "front").iter().map(|(t, x)| (t / unit, x / WIDTH)).collect();
    let between = |points: &[(f64, f64)]| -> Vec<(f64, f64)> {
        points.iter().copied().filter(|(_, z)| *z > 1.5 && *z < 3.0).collect()
    };
    let found = regression_slope(&between(&front));
    let table = reference_table("mpm/dam-break/front.csv")?;
    let mut chart = LineChart {
        series: vec![Series::new("MPM", front.clone(), Style::Line)],
        ..LineChart::new("Front of the surge", "t √(2g/a)", "x / a")
    };
    for (name, column) in [("Martin & Moyce", "martin-moyce"), ("Koshizuka & Oka", "koshizuka-oka")] {
        let measured = reference_curve(&table, "time", column)?;
        let exact = regression_slope(&between(&measured));
        outcome.assert_close(
            format!("speed of the front, dZ/dT for 1.5 < Z < 3, against {name}"),
            exact,
            0.15,
            found,
            "the sheet's 15 %; slopes by least squares, so that the time at which the gate opened does not count",
        );
        chart.series.push(Series::new(name, measured, Style::Markers));
    }
    let ahead = front.iter().map(|(t, z)| z - 1.0 - 2.0 * t).fold(f64::NEG_INFINITY, f64::max);
    outcome.assert_below(
        "largest lead of the front over Ritter's, over the width of the column",
        "none: x/a - 1 = 2 T is a bound",
        ahead,
        0.0,
        "the sheet: never above",
    );
    chart.series.push(Series::new("Ritter's bound", vec![(0.0, 1.0), (1.5, 4.0)], Style::Dashed));
    outcome.assert_close(
        "mass at the end over that at the start",
        1.0,
        1e-12,
        report.end.mass / report.start.mass,
        "exact",
    );
    energy(&mut outcome, &report)?;
    outcome.svg("The front against both experiments and the bound of shallow water.", &chart)?;
    let cloud = PointCloud::from_snapshot(&report.snapshot, "velocity", [0, 1]).ok_or("no velocities")?;
    outcome.png("The surge just before the far wall.", &cloud)?;
    Ok(outcome)
}

/// Checks that the sum of kinetic and potential energy does not grow.
fn energy(outcome: &mut BenchmarkOutcome, report: &RunReport) -> Result<(), String> {
    let column = |name: &str| measure_series(report, name);
    let (kinetic, potential) = (column("kinetic_energy"), column("potential_energy"));
    let total: Vec<(f64, f64)> = kinetic.iter().zip(&potential).map(|(k, p)| (k.0, k.1 + p.1)).collect();
    let first = total.first().map_or(f64::NAN, |p| p.1);
    let (mut smallest, mut rise) = (f64::INFINITY, 0f64);
    for (_, e) in &total {
        rise = rise.max(e - smallest);
        smallest = smallest.min(*e);
    }
    outcome.assert_below(
        "largest rise of kinetic and potential energy over that at the start",
        "none",
        rise / first,
        0.02,
        "the sheet's 2 %",
    );
    let parts = |points: &[(f64, f64)]| points.iter().map(|(t, e)| (*t, e / first)).collect::<Vec<_>>();
    outcome.svg(
        "Energy over that at the start.",
        &LineChart {
            series: vec![
                Series::new("kinetic", parts(&kinetic), Style::Line),
                Series::new("potential", parts(&potential), Style::Line),
                Series::new("sum", parts(&total), Style::Line),
            ],
            ..LineChart::new("Energy", "time (s)", "energy over that at the start")
        },
    )
}
