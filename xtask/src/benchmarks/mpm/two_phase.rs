//! Saturated columns: consolidation and the two P-waves (sheet: mpm ).

use std::f64::consts::PI;

use colluvium::case::{Case, RunReport, Snapshot};
use colluvium::plots::{LineChart, Series, Style};

use crate::analysis::MaxOrNan;
use crate::benchmarks::{
    Benchmark, BenchmarkOutcome, load_case, reference_curve, reference_table, run_mpm, scalars,
    set_mpm_option, stresses, vectors,
};

/// Benchmark of the one-dimensional consolidation of a saturated column.
pub const CONSOLIDATION: Benchmark = Benchmark {
    id: "mpm/consolidation",
    title: "One-dimensional consolidation of a saturated column",
    source: "Terzaghi 1923; sheet: mpm A-19, closed form",
    short_seconds: Some(15),
    full_seconds: 22,
    run: consolidation,
};

/// Benchmark of the fast and the slow P-wave in a saturated column.
pub const WAVES: Benchmark = Benchmark {
    id: "mpm/two-waves",
    title: "Fast and slow P-wave in a saturated column",
    source: "Anura3D scientific manual 2021 and others; sheet: mpm A-20, Laplace solution",
    short_seconds: Some(1),
    full_seconds: 1,
    run: waves,
};

/// Load on the column (Pa).
pub(super) const LOAD: f64 = 1e4;
/// Constrained modulus of the skeleton (Pa).
pub(super) const SKELETON: f64 = 1e7;
/// Bulk modulus of the water over the porosity (Pa).
pub(super) const WATER: f64 = 2.15e9 / 0.4;
/// Coefficient of consolidation `k / (ρ_L g (1/E_c + n/K_L))` (m²/s).
pub(super) const CONSOLIDATION_RATE: f64 = 1e-3 / (9810.0 * (1.0 / SKELETON + 1.0 / WATER));

/// Checks consolidation of a saturated column against the series of Terzaghi.
fn consolidation(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let factors = [0.02, 0.05, 0.1, 0.2, 0.5, 1.0];
    let factors = if quick { &factors[..5] } else { &factors[..] };
    let start = LOAD * WATER / (SKELETON + WATER);
    let mut isochrones = LineChart::new(
        "Isochrones, 40 cells",
        "depth below the drained top (m)",
        "pore pressure over that at the start",
    );
    let table = reference_table("mpm/consolidation/isochrones.csv")?;
    let whole = run_consolidation(&load_case("mpm/consolidation")?, *factors.last().unwrap_or(&0.5))?;
    let mut surface = Vec::new();
    for frame in &whole.frames {
        let factor = CONSOLIDATION_RATE * frame.time;
        let down = vectors(frame, "displacement").iter().map(|u| -u[0]).max_or_nan();
        surface.push((factor, 1e3 * down));
        let Some(nominal) = factors.iter().find(|f| (factor - **f).abs() < 1e-9) else { continue };
        let points = profile(frame, start);
        let law = |z: f64| isochrone(z, factor);
        judge_pressures(&mut outcome, &format!("T = {nominal}"), &points, &law, degree(factor));
        let exact = reference_curve(&table, "depth", &format!("T={nominal}"))?;
        let label = if *nominal == factors[0] { "closed form" } else { "" };
        isochrones.series.push(Series::new(label, exact, Style::Dashed));
        isochrones.series.push(Series::new(format!("T = {nominal}"), points, Style::Markers));
    }
    check_cell_averages(&mut outcome, start)?;
    let settlement = surface_settlement(&mut outcome, &whole, surface);
    damped_consolidation(&mut outcome, start)?;
    let liquid = |budget: colluvium::case::Budget| budget.liquid.map_or(f64::NAN, |liquid| liquid.mass);
    outcome.info(
        "liquid mass at the end over that at the start",
        "below 1: points follow the skeleton, and water leaves",
        liquid(whole.end) / liquid(whole.start),
        "the sheet requires the drift of the liquid mass and gives no bound",
    );
    outcome.svg("Pore pressure of the points against Terzaghi's isochrones.", &isochrones)?;
    outcome.svg("Settlement beyond the undrained one, with which the run starts.", &settlement)?;
    Ok(outcome)
}

/// Checks the settlement of the uppermost point over the time factor, and draws it. `surface` is in mm.
fn surface_settlement(
    outcome: &mut BenchmarkOutcome,
    whole: &RunReport,
    surface: Vec<(f64, f64)>,
) -> LineChart {
    // The uppermost point lies a quarter of a cell below the surface, and the part above it settles too.
    let last = whole.frames.last().map_or(f64::NAN, |frame| CONSOLIDATION_RATE * frame.time);
    let settled = |factor: f64| {
        let u = degree(factor);
        1e3 * LOAD / SKELETON * (u + (1.0 - u) * SKELETON / (SKELETON + WATER)) - undrained_settlement()
    };
    let found = surface.last().map_or(f64::NAN, |p| p.1) / settled(last);
    let name = "settlement of the uppermost point over the closed form of the surface, at the end";
    let reason = "as the degree of consolidation: the sheet's 0.02";
    outcome.assert_within(name, "1", found, (0.98, 1.02), reason);
    let exact = (0..=200).map(|i| f64::from(i) / 200.0 * last).map(|f| (f, settled(f))).collect();
    LineChart {
        series: vec![
            Series::new("closed form", exact, Style::Dashed),
            Series::new("uppermost point", surface, Style::Line),
        ],
        ..LineChart::new("Settlement", "time factor", "settlement (mm)")
    }
}

/// Checks the degree of consolidation with local damping.
fn damped_consolidation(outcome: &mut BenchmarkOutcome, start: f64) -> Result<(), String> {
    let mut damped = load_case("mpm/consolidation")?;
    damped.stages[0].damping = 0.7;
    let report = run_consolidation(&damped, 0.5)?;
    let pressures = report.frames.last().map(|frame| scalars(frame, "pore_pressure")).unwrap_or_default();
    outcome.info(
        "with local damping of 0.7: degree of consolidation at T = 0.5",
        "0.41 (sheet's prototype), 0.764 without",
        1.0 - pressures.iter().sum::<f64>() / (start * pressures.len() as f64),
        "what damping does to a slow process; the sheet gives no bound",
    );
    Ok(())
}

/// Undrained settlement (mm), from which the displacements of the run are measured.
fn undrained_settlement() -> f64 {
    1e3 * LOAD / (SKELETON + WATER)
}

/// Runs the column up to a time factor, with a frame at each hundredth of it.
pub(super) fn run_consolidation(case: &Case, factor: f64) -> Result<RunReport, String> {
    let mut case = case.clone();
    case.stages[0].duration = factor / CONSOLIDATION_RATE;
    case.output.frames = Some(0.01 / CONSOLIDATION_RATE);
    run_mpm(&case)
}

/// Terzaghi's pressure over that at the start, at depth `z` (m) of a column of 1 m.
fn isochrone(z: f64, factor: f64) -> f64 {
    modes().map(|a| 2.0 / a * (a * z).sin() * (-a * a * factor).exp()).sum()
}

/// Degree of consolidation at a time factor.
fn degree(factor: f64) -> f64 {
    1.0 - modes().map(|a| 2.0 / (a * a) * (-a * a * factor).exp()).sum::<f64>()
}

/// Depth (m) and pressure over that at the `start` of the points of a column of 1 m.
fn profile(frame: &Snapshot, start: f64) -> Vec<(f64, f64)> {
    let pressures = scalars(frame, "pore_pressure").into_iter().map(|p| p / start);
    initial_positions(frame).iter().map(|x| 1.0 - x).zip(pressures).collect()
}

/// Checks pore pressures over that at the start, and the degree of consolidation from them, against a closed form.
pub(super) fn judge_pressures(
    outcome: &mut BenchmarkOutcome,
    label: &str,
    points: &[(f64, f64)],
    isochrone: &dyn Fn(f64) -> f64,
    degree: f64,
) {
    let count = points.len() as f64;
    let square = points.iter().map(|(z, p)| (p - isochrone(*z)).powi(2)).sum::<f64>();
    outcome.assert_below(
        format!("{label}: RMS error of pressure over that at the start"),
        "0.017, 0.008, 0.007, 0.005, 0.003, 0.001 at T = 0.02, 0.05, 0.1, 0.2, 0.5, 1 (sheet's prototype)",
        (square / count).sqrt(),
        0.03,
        "the sheet's bound",
    );
    outcome.assert_within(
        format!("{label}: degree of consolidation from pressures"),
        &format!("{degree:.6}"),
        1.0 - points.iter().map(|point| point.1).sum::<f64>() / count,
        (degree - 0.02, degree + 0.02),
        "the sheet's bound",
    );
}

/// Checks total stress and pore pressure as averages over cells (§2.16).
fn check_cell_averages(outcome: &mut BenchmarkOutcome, start: f64) -> Result<(), String> {
    /// Time factor at which integration by cells is compared.
    const NOMINAL: f64 = 0.1;
    let mut case = load_case("mpm/consolidation")?;
    set_mpm_option(&mut case, "integration", "mixed");
    let report = run_consolidation(&case, NOMINAL)?;
    let frame = report.frames.last().ok_or("no frame")?;
    let factor = CONSOLIDATION_RATE * frame.time;
    let law = |z: f64| isochrone(z, factor);
    let label = format!("integration by cells, T = {NOMINAL}");
    judge_pressures(outcome, &label, &profile(frame, start), &law, degree(factor));
    Ok(())
}

/// Wave numbers of Terzaghi's series over the height.
pub(super) fn modes() -> impl Iterator<Item = f64> {
    (0..200).map(|m| PI / 2.0 * f64::from(2 * m + 1))
}

/// Initial positions of the points (m).
fn initial_positions(snapshot: &Snapshot) -> Vec<f64> {
    let displacement = vectors(snapshot, "displacement");
    snapshot.positions.iter().zip(displacement).map(|(x, u)| x[0] - u[0]).collect()
}

/// Traction on the end of the column (Pa).
const TRACTION: f64 = 1000.0;
/// Duration of the increase of the traction (s).
const RAMP: f64 = 5e-5;
/// Speed of the fast compression wave without drag (m/s).
const FAST_WAVE_SPEED: f64 = 2297.728;
/// Speed of the slow compression wave without drag (m/s).
const SLOW_WAVE_SPEED: f64 = 1144.720;

/// Hydraulic conductivities (m/s) with their labels, and the skeleton stress over the load at 7e-4 s in the sheet.
const CONDUCTIVITIES: [(&str, f64, f64); 5] = [
    ("1e3", 1e3, 1.0),
    ("0.1", 0.1, 0.99448),
    ("1e-2", 1e-2, 0.94860),
    ("1e-3", 1e-3, 0.70262),
    ("1e-5", 1e-5, 0.47619),
];

/// Mean of values (Pa) over the load, of the points about 0.5 m below the loaded end.
fn mean_over_load(frame: &Snapshot, values: &[f64]) -> f64 {
    let near: Vec<f64> = initial_positions(frame)
        .iter()
        .zip(values)
        .filter(|(x, _)| (*x - 1.5).abs() < 0.004)
        .map(|(_, v)| *v)
        .collect();
    near.iter().sum::<f64>() / near.len() as f64 / TRACTION
}

/// Checks arrival times and amplitudes of the two compression waves of saturated soil.
fn waves(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let table = reference_table("mpm/two-waves/reference.csv")?;
    let mut chart =
        LineChart::new("Pore pressure at 0.5 m, 400 cells", "time (ms)", "pore pressure over load");
    for (name, conductivity, skeleton) in CONDUCTIVITIES {
        let mut case = load_case("mpm/two-waves")?;
        if let Some(fluid) = &mut case.bodies[0].pore_fluid {
            fluid.intrinsic_permeability = Some(conductivity * 1e-3 / 9810.0);
        }
        let report = run_mpm(&case)?;
        let pressure: Vec<(f64, f64)> =
            report.frames.iter().map(|f| (f.time, mean_over_load(f, &scalars(f, "pore_pressure")))).collect();
        let exact = reference_curve(&table, "time", &format!("k={name}"))?;
        let value = |time: f64| exact.iter().find(|p| (p.0 - time).abs() < 1e-9).map_or(f64::NAN, |p| p.1);
        if conductivity > 1.0 {
            check_arrival_times(&mut outcome, &pressure, value(3.5e-4));
        }
        pressures_behind_waves(&mut outcome, name, &pressure, value);
        let late: Vec<f64> = report
            .frames
            .iter()
            .filter(|frame| frame.time > 6.5e-4)
            .map(|frame| mean_over_load(frame, &stresses(frame).iter().map(|s| -s[0]).collect::<Vec<f64>>()))
            .collect();
        outcome.info(
            format!("k = {name} m/s: effective stress over load, mean from 6.5e-4 s to 7e-4 s"),
            &format!("{skeleton} at 7e-4 s"),
            late.iter().sum::<f64>() / late.len() as f64,
            "shown: the sheet gives bounds for the pressure",
        );
        let milli = |points: &[(f64, f64)]| points.iter().map(|(t, p)| (1e3 * t, *p)).collect::<Vec<_>>();
        chart.series.push(Series::new(format!("k = {name} m/s"), milli(&pressure), Style::Line));
        let label = if conductivity > 1.0 { "Laplace solution" } else { "" };
        chart.series.push(Series::new(label, milli(&exact), Style::Markers));
    }
    outcome.svg(
        "The first wave carries water and skeleton alike; the second one lets the water out, at once or, with a low \
         conductivity, by diffusion.",
        &chart,
    )?;
    Ok(outcome)
}

/// Checks the mean pressures over the load behind both waves against `value`, the reference over time (s).
fn pressures_behind_waves(
    outcome: &mut BenchmarkOutcome,
    name: &str,
    pressure: &[(f64, f64)],
    value: impl Fn(f64) -> f64,
) {
    // Simpson's rule over the sheet's values; behind the second wave they give a parabola.
    let first = (value(3e-4) + 4.0 * value(3.5e-4) + value(4e-4)) / 6.0;
    let second = parabola_mean([5.0, 6.0, 7.0], [5e-4, 6e-4, 7e-4].map(value), 5.5, 7.0);
    for (what, from, to, exact) in [("first wave", 3e-4, 4e-4, first), ("second wave", 5.5e-4, 7e-4, second)]
    {
        let within: Vec<f64> = pressure.iter().filter(|p| p.0 >= from && p.0 <= to).map(|p| p.1).collect();
        outcome.assert_within(
            format!("k = {name} m/s: mean pressure over load behind the {what}"),
            &format!("{exact:.5}"),
            within.iter().sum::<f64>() / within.len() as f64,
            (exact - 0.03, exact + 0.03),
            "the sheet's bound",
        );
    }
}

/// Checks the times at which the pressure passes half of its plateau, less half of the load ramp.
fn check_arrival_times(outcome: &mut BenchmarkOutcome, pressure: &[(f64, f64)], plateau: f64) {
    let crossing = |rising: bool| {
        let passed = |w: &[(f64, f64)]| {
            let ((t0, p0), (t1, p1)) = (w[0], w[1]);
            let (a, b) = (p0 - 0.5 * plateau, p1 - 0.5 * plateau);
            (a * b <= 0.0 && (b > a) == rising).then(|| t0 + (t1 - t0) * a / (a - b) - 0.5 * RAMP)
        };
        pressure.windows(2).find_map(passed).unwrap_or(f64::NAN)
    };
    for (name, speed, rising) in [("fast", FAST_WAVE_SPEED, true), ("slow", SLOW_WAVE_SPEED, false)] {
        outcome.assert_close(
            format!("arrival of the {name} wave at 0.5 m (s)"),
            0.5 / speed,
            0.02,
            crossing(rising),
            "the sheet's 2 %",
        );
    }
}

/// Mean between `from` and `to` of the parabola through three points.
fn parabola_mean(x: [f64; 3], y: [f64; 3], from: f64, to: f64) -> f64 {
    let at = |t: f64| -> f64 {
        let weight =
            |i: usize| -> f64 { (0..3).filter(|j| *j != i).map(|j| (t - x[j]) / (x[i] - x[j])).product() };
        (0..3).map(|i| y[i] * weight(i)).sum()
    };
    (at(from) + 4.0 * at(0.5 * (from + to)) + at(to)) / 6.0
}
