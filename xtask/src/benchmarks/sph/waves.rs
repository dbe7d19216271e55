//! Waves, damping and the stability of the step (sheet: sph §5.3, V-15, V-16, V-18, V-19).

use std::f64::consts::PI;
use std::ops::Range;
use std::path::Path;

use colluvium::case::{Case, Solver};
use colluvium::plots::{LineChart, Series, Style};
use colluvium::sph::setup::rates_only::unchecked_energy_history;

use crate::analysis::MaxOrNan;
use crate::benchmarks::{Benchmark, BenchmarkOutcome, set_method_option, vectors};

/// Benchmark of waves in bars and strips, and of the stability limit of the time step.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "sph/waves",
    title: "Waves in bars and strips, stability limit, SPH",
    source: "sheet: sph §5.3, V-15, V-16, V-18, V-19; §3.4",
    short_seconds: Some(1),
    full_seconds: 1,
    run,
};

/// Reads the case `validation/sph/<file>`.
pub(super) fn load(file: &str) -> Result<Case, String> {
    let path = crate::root().join(Path::new("validation/sph")).join(file);
    crate::benchmarks::recorder::record_file(&path);
    Case::from_file(&path).map_err(|errors| format!("{}: {errors}", path.display()))
}

/// Builds the SPH solver of a case and begins its first stage.
pub(super) fn start(case: &Case) -> Result<Box<dyn Solver>, String> {
    let method = colluvium::method("sph").ok_or("no method sph")?;
    let mut solver = method.build(case).map_err(|error| error.to_string())?;
    solver.begin_stage(0, 0.0).map_err(|error| error.to_string())?;
    Ok(solver)
}

/// Makes the largest stable step, and returns it (s).
pub(super) fn advance(solver: &mut dyn Solver) -> Result<f64, String> {
    let dt = solver.limit().dt;
    solver.step(dt).map_err(|error| error.to_string())?;
    Ok(dt)
}

/// Checks waves in a bar and a strip, damping, and the limit of the time step.
fn run(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    check_bar(&mut outcome)?;
    strip(&mut outcome)?;
    damping(&mut outcome)?;
    limit(&mut outcome)?;
    Ok(outcome)
}

/// Checks the motion of a bar against d'Alembert's solution (V-15). Half a sine of amplitude 0.1 on 0.2 m splits in two; one half reaches
/// 0.6 m from its centre at 0.1 m after 5 ms and the free end after 9 ms, the other follows from the mirror with the opposite sign.
fn check_bar(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let case = load("waves/case.json")?;
    let mut solver = start(&case)?;
    let (mut passing, mut end) = (Vec::new(), Vec::new());
    while solver.time() < 0.0125 {
        let snapshot = solver.snapshot();
        let v = vectors(&snapshot, "velocity");
        passing.push((snapshot.time, 0.5 * (v[59][0] + v[60][0])));
        end.push((snapshot.time, v.last().map_or(f64::NAN, |v| v[0])));
        advance(&mut *solver)?;
    }
    let exact = |time: f64, place: f64| {
        let hump = |x: f64| if x.abs() < 0.1 { 0.05 * (PI * (x + 0.1) / 0.2).sin() } else { 0.0 };
        hump(place - 0.1 - 100.0 * time) - hump(place + 0.1 - 100.0 * time)
    };
    // The middle of the positive half wave.
    let positive = passing.iter().filter(|(t, v)| *v > 0.02 && *t < 6.5e-3);
    let (weight, sum) = positive.fold((0.0, 0.0), |(w, s), (t, v)| (w + v, s + v * t));
    let reason = "V-15: 2 % with 100 particles";
    outcome.assert_close("V-15, speed of the wave (m/s)", 100.0, 0.02, 0.5 / (sum / weight), reason);
    let largest = end.iter().map(|(_, v)| *v).max_or_nan();
    let reason = "V-15: the 2 % of its speed; the outermost particle stands half a spacing inside";
    outcome.assert_close(
        "V-15, velocity of the free end over that of the wave",
        2.0,
        0.02,
        largest / 0.05,
        reason,
    );
    let mut chart = LineChart::new("Velocity in an elastic bar", "time (s)", "velocity (m/s)");
    let closed = passing.iter().map(|(t, _)| (*t, exact(*t, 0.6))).collect();
    chart.series.push(Series::new("at 0.6 m, d'Alembert", closed, Style::Dashed));
    chart.series.push(Series::new("at 0.6 m", passing, Style::Line));
    chart.series.push(Series::new("free end", end, Style::Line));
    outcome.svg("V-15: a pulse passes, doubles at the free end and comes back.", &chart)
}

/// Checks the frequency of the first mode of a strip (V-16).
fn strip(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut solver = start(&load("waves/strip.json")?)?;
    let exact = PI * (1.2e6f64 / 1000.0).sqrt();
    let amplitude = |solver: &dyn Solver| {
        let snapshot = solver.snapshot();
        let v = vectors(&snapshot, "velocity");
        snapshot.positions.iter().zip(v).map(|(x, v)| v[0] * (PI * x[0]).sin()).sum::<f64>()
    };
    let (mut zeros, mut before) = (Vec::new(), (0.0, amplitude(&*solver)));
    while zeros.len() < 3 {
        advance(&mut *solver)?;
        let now = (solver.time(), amplitude(&*solver));
        if before.1 * now.1 < 0.0 {
            zeros.push(before.0 + (now.0 - before.0) * before.1 / (before.1 - now.1));
        }
        before = now;
    }
    let found = 2.0 * PI / (zeros[2] - zeros[0]);
    outcome.assert_close(
        "V-16, circular frequency (1/s)",
        exact,
        0.015,
        found,
        "V-16: 1.5 % with 50 particles",
    );
    Ok(())
}

/// Checks the decay of the velocity by damping, `v = v₀ e^(-c_d t)` (V-18).
fn damping(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut case = load("waves/lattice.json")?;
    set_method_option(&mut case, "sph", "damping", 0.05);
    set_method_option(&mut case, "sph", "integration", "position-verlet");
    let body = serde_json::json!({ "kind": "uniform", "value": [0.5, 0.0] });
    case.bodies[0].velocity = serde_json::from_value(body).map_err(|error| error.to_string())?;
    let mut solver = start(&case)?;
    for _ in 0..100 {
        advance(&mut *solver)?;
    }
    let rate = 0.05 * (1.2e6f64 / 1000.0).sqrt() / 0.12;
    let found = vectors(&solver.snapshot(), "velocity")[0][0] / (0.5 * (-rate * solver.time()).exp());
    outcome.assert_close(
        "V-18, velocity under damping over the closed form",
        1.0,
        1e-12,
        found,
        "V-18: 1e-12",
    );
    Ok(())
}

/// Checks that waves grow with steps of 2.0 but not of 1.7 times the spacing over the wave speed; the limit is 1.867 (V-19).
fn limit(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let growth = |courant: f64| -> Result<f64, String> {
        let case = load("waves/lattice.json")?;
        let dt = courant * 0.12 / (1.2e6f64 / 1000.0).sqrt();
        // Exactly this step: a run never takes longer than a stable step.
        let course = unchecked_energy_history(&case, dt, 2000).map_err(|error| error.to_string())?;
        let maximum = |steps: Range<usize>| steps.map(|step| course[step]).fold(0.0, f64::max);
        Ok(if course.len() == 2001 { maximum(1001..2001) / maximum(1..1001) } else { f64::INFINITY })
    };
    let reason = "V-19: no growth over 2000 steps; the largest kinetic energy of the second thousand over that of the first";
    outcome.assert_below("V-19, c dt / h = 1.7", "no growth", growth(1.7)?, 1.05, reason);
    let reason = "V-19: growth; the closed limit is 1.867";
    outcome.assert_within("V-19, c dt / h = 2.0", "growth", growth(2.0)?, (1e3, f64::INFINITY), reason);
    Ok(())
}
