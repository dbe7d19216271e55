//! Oscillating elastic bar (sheet: mpm; Bardenhagen 2002).

use std::f64::consts::PI;

use colluvium::case::RunReport;
use colluvium::plots::{LineChart, Series, Style};

use crate::analysis::MaxOrNan;
use crate::benchmarks::{
    Benchmark, BenchmarkOutcome, load_case, measure_series, reference_curve, reference_table, run_mpm,
    set_mpm_option,
};

/// Benchmark of an oscillating elastic bar: frequency, energy and order of convergence.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "mpm/bar",
    title: "Oscillating elastic bar: frequency, energy, order",
    source: "Bardenhagen 2002; sheet: mpm A-06, A-07",
    short_seconds: Some(7),
    full_seconds: 7,
    run: benchmark,
};

/// Length of the bar (m).
const LENGTH: f64 = 25.0;
/// Wave speed of the bar (m/s).
const SPEED: f64 = 10.0;

/// Checks period, energy and damping of a vibrating bar.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    vibration(&mut outcome)?;
    single_point(&mut outcome)?;
    consistent(&mut outcome)?;
    check_rayleigh_damping(&mut outcome)?;
    Ok(outcome)
}

/// Checks the frequency of the first mode with two points in a cell. The grid represents `(5 + 3 cos βh)/8` of the mass of the mode. With
/// lumped mass the points respond by that much less, with the consistent one more.
fn consistent(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let (beta, cell) = (PI / (2.0 * LENGTH), LENGTH / 13.0);
    let wave = (beta * cell).cos();
    let (stiffness, mass_factor) = (2.0 * (SPEED / cell).powi(2) * (1.0 - wave), (5.0 + 3.0 * wave) / 8.0);
    for (mass, exact) in
        [("lumped", (stiffness * mass_factor).sqrt()), ("consistent", (stiffness / mass_factor).sqrt())]
    {
        let mut case = load_case("mpm/bar")?;
        set_mpm_option(&mut case, "points_per_cell", 2);
        set_mpm_option(&mut case, "stress_update", "usl");
        set_mpm_option(&mut case, "mass", mass);
        set_mpm_option(&mut case, "courant", 0.02);
        case.bodies[0].velocity = colluvium::case::description::Velocity::Sine {
            amplitude: vec![1e-4],
            wave_vector: vec![beta],
            phase: 0.0,
        };
        case.stages[0].duration = 42.0;
        let report = run_mpm(&case)?;
        let name = format!("{mass} mass, 13 cells of two points: frequency (rad/s)");
        let reason = "0.02 % of that of the discrete equations; 0.6283 in the continuum";
        outcome.assert_close(name, exact, 2e-4, frequency(&measure_series(&report, "momentum.x")), reason);
    }
    Ok(())
}

/// Checks the decay of the first mode under Rayleigh damping: `e^{-ζt}(cos ω_d t - (ζ/ω_d) sin ω_d t)` with `ζ = λ α_R/2`, where `λ =
/// cos²(βh/2)` is the share of the mode on the grid.
fn check_rayleigh_damping(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let (beta, cell, damping) = (PI / (2.0 * LENGTH), LENGTH / 13.0, 0.2);
    let mut case = load_case("mpm/bar")?;
    set_mpm_option(&mut case, "courant", 0.01);
    case.bodies[0].velocity = colluvium::case::description::Velocity::Sine {
        amplitude: vec![1e-4],
        wave_vector: vec![beta],
        phase: 0.0,
    };
    case.stages[0].duration = 20.0;
    case.stages[0].rayleigh_damping = damping;
    let report = run_mpm(&case)?;
    let decay = 0.5 * damping * (0.5 * beta * cell).cos().powi(2);
    let own = SPEED / cell * (beta * cell).sin();
    let omega = (own * own - decay * decay).sqrt();
    let momentum = measure_series(&report, "momentum.x");
    let error = momentum.iter().map(|(t, p)| {
        let exact = (-decay * t).exp() * ((omega * t).cos() - decay / omega * (omega * t).sin());
        (p / momentum[0].1 - exact).abs()
    });
    outcome.assert_below(
        "Rayleigh damping of 0.2/s: largest error of the velocity over 20 s, over the first",
        "0",
        error.max_or_nan(),
        3e-3,
        "closed form of the damped oscillator; the step and the other modes of the start",
    );
    Ok(())
}

/// Checks the period and the energy of a bar in its first mode on 13, 26 and 52 cells.
fn vibration(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let beta = PI / (2.0 * LENGTH);
    let omega = beta * SPEED;
    let amplitude = 0.1 / (beta * LENGTH);
    let mut chart = LineChart::new("Velocity of the centre of mass", "time (s)", "velocity (m/s)");
    let mut errors = Vec::new();
    for cells in [13usize, 26, 52] {
        let mut case = load_case("mpm/bar")?;
        let cell = LENGTH / cells as f64;
        set_mpm_option(&mut case, "cell_size", cell);
        let report = run_mpm(&case)?;
        let mass = report.start.mass;
        let velocity: Vec<(f64, f64)> =
            measure_series(&report, "momentum.x").into_iter().map(|(t, p)| (t, p / mass)).collect();
        let error = velocity.iter().map(|(t, v)| (v - amplitude * (omega * t).cos()).abs()).max_or_nan();
        errors.push(error / amplitude);
        let discrete = SPEED / cell * (beta * cell).sin();
        let name = format!("{cells} cells: frequency (rad/s)");
        let reason = "the sheet's 0.05 % of the frequency of the discrete equations, (c/h) sin(βh)";
        outcome.assert_close(name, discrete, 5e-4, frequency(&velocity), reason);
        if cells == 13 {
            energy_band(outcome, &report);
            let exact = reference_curve(&reference_table("mpm/bar/first-mode.csv")?, "time", "velocity")?;
            chart.series.push(Series::new("closed form", exact, Style::Dashed));
        }
        let late = velocity.iter().filter(|p| p.0 > 60.0).copied().collect();
        chart.series.push(Series::new(format!("{cells} cells"), late, Style::Line));
    }
    let name = "13 cells: largest velocity error over the amplitude";
    let bound = "0.17 of the amplitude: the phase error of the discrete frequency after 100 s";
    outcome.assert_below(name, "0.160 (sheet's prototype)", errors[0], 0.17, bound);
    for (pair, name) in errors.windows(2).zip(["13 to 26 cells", "26 to 52 cells"]) {
        let (name, order) = (format!("order of convergence, {name}"), (pair[0] / pair[1]).log2());
        outcome.assert_within(name, "2", order, (1.8, 2.2), "asymptotic order 2, within 10 %");
    }
    outcome.svg(
        "First mode after 60 s: the error is a phase error and falls with the square of the cell size.",
        &chart,
    )
}

/// Checks the range of the energy over that at the start.
fn energy_band(outcome: &mut BenchmarkOutcome, report: &RunReport) {
    let energy: Vec<f64> = measure_series(report, "kinetic_energy")
        .into_iter()
        .zip(measure_series(report, "elastic_energy"))
        .map(|(k, e)| (k.1 + e.1) / (report.start.kinetic + report.start.elastic))
        .collect();
    let (low, high) = energy.iter().fold((f64::MAX, f64::MIN), |(a, b), e| (a.min(*e), b.max(*e)));
    for (which, value) in [("least", low), ("largest", high)] {
        let name = format!("13 cells: {which} energy over the first");
        outcome.assert_within(name, "0.99 to 1.01", value, (0.99, 1.01), "the sheet's band");
    }
}

/// Frequency from the first and the last zero of a signal.
fn frequency(signal: &[(f64, f64)]) -> f64 {
    let zero = |w: &[(f64, f64)]| {
        let ((t0, v0), (t1, v1)) = (w[0], w[1]);
        (v0 * v1 < 0.0).then(|| t0 + (t1 - t0) * v0 / (v0 - v1))
    };
    let zeros: Vec<f64> = signal.windows(2).filter_map(zero).collect();
    match (zeros.first(), zeros.last()) {
        (Some(first), Some(last)) if last > first => PI * (zeros.len() - 1) as f64 / (last - first),
        _ => f64::NAN,
    }
}

/// Checks the motion of one point in one cell by three stress updates, and its energy.
fn single_point(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let omega = 2.0 * PI;
    let mut chart = LineChart::new("One point in one cell", "time (s)", "energy over initial energy");
    for scheme in ["musl", "usl", "usf"] {
        let mut case = load_case("mpm/bar")?;
        case.title = format!("one point, {scheme}");
        case.domain.max = vec![1.0];
        let shape = serde_json::json!({ "kind": "box", "min": [0.0], "max": [1.0] });
        case.bodies[0].shape = serde_json::from_value(shape).map_err(|error| error.to_string())?;
        let velocity = serde_json::json!({ "kind": "uniform", "value": [0.1] });
        case.bodies[0].velocity = serde_json::from_value(velocity).map_err(|error| error.to_string())?;
        let material = serde_json::json!({
            "model": "linear-elastic", "density": 1.0, "youngs_modulus": omega * omega, "poissons_ratio": 0.0
        });
        case.materials
            .insert("bar".into(), serde_json::from_value(material).map_err(|error| error.to_string())?);
        case.stages[0].duration = 10.0;
        case.output.measures = Some(0.01);
        case.output.frames = Some(0.01);
        set_mpm_option(&mut case, "cell_size", 1.0);
        set_mpm_option(&mut case, "time_step", 1e-3);
        set_mpm_option(&mut case, "stress_update", scheme);
        let report = run_mpm(&case)?;
        if scheme == "musl" {
            check_single_point(outcome, &report);
        }
        let energy = (report.end.kinetic + report.end.elastic) / report.start.kinetic;
        let name = format!("single point, {scheme}: energy at 10 s");
        if scheme == "usl" {
            let exact = (-omega * omega * 1e-3 * 10.0f64).exp();
            outcome.assert_close(name, exact, 5e-3, energy, "the sheet's 0.5 % around exp(-ω² Δt t)");
        } else {
            outcome.assert_close(name, 1.0, 1e-4, energy, "the sheet's 10⁻⁴");
        }
        let total = measure_series(&report, "kinetic_energy")
            .into_iter()
            .zip(measure_series(&report, "elastic_energy"))
            .map(|(k, e)| (k.0, (k.1 + e.1) / report.start.kinetic))
            .collect();
        chart.series.push(Series::new(scheme, total, Style::Line));
    }
    let decay = reference_curve(&reference_table("mpm/bar/energy-usl.csv")?, "time", "energy")?;
    chart.series.push(Series::new("exp(-ω² Δt t)", decay, Style::Dashed));
    outcome.svg("Updating stress last from the solved velocities loses energy; the other two do not.", &chart)
}

/// Checks the position of the single point against two problems: The first has a closed form; the second is integrated here.
fn check_single_point(outcome: &mut BenchmarkOutcome, report: &RunReport) {
    let omega = 2.0 * PI;
    let largest = |exact: &dyn Fn(f64) -> f64| {
        let error = |frame: &colluvium::case::Snapshot| (frame.positions[0][0] - exact(frame.time)).abs();
        report.frames.iter().map(error).max_or_nan()
    };
    outcome.info(
        "single point, musl: largest error of position, volume kept (m)",
        "5e-5 (prototype 1.3e-5)",
        largest(&|t| 0.5 * (0.1 / omega * (omega * t).sin()).exp()),
        "known deviation, not judged: the sheet's problem keeps the volume of the point, ours lets it follow the \
         deformation, which is another oscillator",
    );
    outcome.assert_below(
        "single point, musl: largest error of position, volume that follows (m)",
        "5e-5",
        largest(&|t| 0.5 * stretching_point(omega, 0.1, t).exp()),
        5e-5,
        "the sheet's bound, for the equations that the method solves: u'' = -ω² u eᵘ, x = x₀ eᵘ",
    );
}

/// Solution `u(t)` of `u'' = -ω² u eᵘ` from zero with the velocity `speed`. It is the logarithmic strain of a point whose volume follows
/// its strain. Fourth-order Runge–Kutta; its error here is below 1e-12.
fn stretching_point(omega: f64, speed: f64, time: f64) -> f64 {
    let steps = (time / 1e-3).ceil().max(1.0);
    let dt = time / steps;
    let rate = |[u, v]: [f64; 2]| [v, -omega * omega * u * u.exp()];
    let add = |y: [f64; 2], k: [f64; 2], s: f64| [y[0] + s * k[0], y[1] + s * k[1]];
    let mut y = [0.0, speed];
    for _ in 0..steps as u64 {
        let a = rate(y);
        let b = rate(add(y, a, 0.5 * dt));
        let c = rate(add(y, b, 0.5 * dt));
        let d = rate(add(y, c, dt));
        for i in 0..2 {
            y[i] += dt / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]);
        }
    }
    y[0]
}
