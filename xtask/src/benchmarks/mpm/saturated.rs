//! Skeleton and water: drag, weight, undrained compression, critical step; and absorbing boundaries (sheet: mpm,
//!

use colluvium::case::{Case, RunReport, Snapshot};
use colluvium::plots::{LineChart, Series, Style};

use crate::analysis::MaxOrNan;
use crate::benchmarks::{
    Benchmark, BenchmarkOutcome, load_case, patched_case, run_mpm, scalars, set_mpm_option, stresses, vectors,
};

/// Benchmark of drag, undrained compression and critical time step of skeleton and water.
pub const PHASES: Benchmark = Benchmark {
    id: "mpm/phases",
    title: "Drag, undrained compression and critical step of skeleton and water",
    source: "sheet: mpm A-21, A-23, A-36, closed forms and eigenvalues",
    short_seconds: Some(2),
    full_seconds: 2,
    run: check_drag_compression_and_critical_step,
};

/// Benchmark of a saturated column under sudden gravity.
pub const GRAVITY: Benchmark = Benchmark {
    id: "mpm/saturated-column",
    title: "Saturated column under gravity",
    source: "sheet: mpm A-22, closed form",
    short_seconds: Some(4),
    full_seconds: 4,
    run: column,
};

/// Benchmark of the reflection of waves by absorbing, free and fixed ends of a bar.
pub const ABSORBING: Benchmark = Benchmark {
    id: "mpm/absorbing",
    title: "What ends of a bar send back",
    source: "Lysmer & Kuhlemeyer 1969; sheet: mpm A-18, closed form",
    short_seconds: Some(2),
    full_seconds: 2,
    run: absorbing,
};

/// Checks drag, undrained compression and the critical time step of saturated soil.
fn check_drag_compression_and_critical_step(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    drag(&mut outcome)?;
    check_undrained(&mut outcome)?;
    steps(&mut outcome)?;
    Ok(outcome)
}

/// Rate of decay of the relative velocity by drag in the case, `n ρ g / ((1-n) ρ_S k)` (1/s).
const RATE: f64 = 0.4 * 1990.0 * 9.81 / (1590.0 * 1e-3);

/// Checks the decay of the relative velocity by drag, and the onset of seepage.
fn drag(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let held = load_case("mpm/drag")?;
    free_drag(outcome, &held)?;
    let report = run_mpm(&held)?;
    let speed = |frame: &Snapshot| -vectors(frame, "liquid_velocity").first().map_or(f64::NAN, |v| v[0]);
    let flux = |time: f64| 1e-3 * (1.0 - (-0.4 * 9.81 * time / 1e-3f64).exp());
    let found: Vec<(f64, f64)> = report.frames.iter().map(|f| (1e3 * f.time, 0.4 * speed(f))).collect();
    let worst = report.frames.iter().map(|f| (0.4 * speed(f) - flux(f.time)).abs() / 1e-3).max_or_nan();
    outcome.assert_below(
        "A-21: largest error of the flux while seepage sets in, over the steady one",
        "k i (1 - exp(-n g t / k))",
        worst,
        0.05,
        "explicit drag is of first order in a Δt: half a step of it is 0.03",
    );
    let (name, steady) = ("A-21: steady flux under a gradient of 1 (m/s)", 0.4 * speed(&report.snapshot));
    outcome.assert_close(name, 1e-3, 1e-3, steady, "the sheet's 0.1 %");
    let exact = (0..=100).map(|i| 2e-5 * f64::from(i)).map(|t| (1e3 * t, flux(t))).collect();
    let chart = LineChart {
        series: vec![
            Series::new("closed form", exact, Style::Dashed),
            Series::new("points", found, Style::Markers),
        ],
        ..LineChart::new("Onset of seepage", "time (ms)", "flux (m/s)")
    };
    outcome.svg("Water begins to seep through a held skeleton.", &chart)
}

/// Checks the relative velocity of a mixture without other forces.
fn free_drag(outcome: &mut BenchmarkOutcome, held: &Case) -> Result<(), String> {
    let intrinsic = 1e-3 * 1e-3 / 9810.0;
    let body = serde_json::json!({ "kind": "box", "min": [0.3], "max": [0.7] });
    let fluid = serde_json::json!({ "porosity": 0.4, "intrinsic_permeability": intrinsic, "bulk_modulus": 2.15e9,
                                    "velocity": { "kind": "uniform", "value": [0.02] } });
    let dt: f64 = 1e-5;
    let free = patched_case(
        held,
        &[
            ("/gravity", serde_json::json!([0])),
            ("/boundaries", serde_json::json!([])),
            ("/bodies/0/shape", body),
            ("/bodies/0/pore_fluid", fluid),
            ("/stages/0/duration", serde_json::json!(1e-3)),
            ("/methods/mpm/time_step", serde_json::json!(dt)),
        ],
    )?;
    let report = run_mpm(&free)?;
    let end = &report.snapshot;
    let between = vectors(end, "liquid_velocity")[0][0] - vectors(end, "velocity")[0][0];
    let steps = (1e-3 / dt).round() as i32;
    outcome.assert_close(
        "A-21: relative velocity after 100 steps over that at the start",
        (1.0 - RATE * dt).powi(steps),
        1e-9,
        between / 0.02,
        "the sheet has it exact; the remainder is 0.7 %, so round-off of the whole is 1e-14",
    );
    let lost = (report.end.momentum[0] - report.start.momentum[0]).abs() / report.start.momentum[0];
    outcome.assert_below("A-21: momentum lost over that at the start", "0", lost, 1e-12, "round-off");
    Ok(())
}

/// Checks the pore pressure of undrained compression.
fn check_undrained(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let two = load_case("mpm/undrained")?;
    let mut one = two.clone();
    one.bodies[0].pore_fluid = None;
    one.bodies[0].material = "soil".into();
    let strain = -1e-3 * 1e-5;
    let (skeleton, water) = (1e7, 2.15e9 / 0.4);
    for (name, case) in [("two phases", two), ("material undrained", one)] {
        let report = run_mpm(&case)?;
        let pressure = scalars(&report.snapshot, "pore_pressure")[0];
        outcome.assert_close(
            format!("A-23, {name}: pore pressure (Pa)"),
            -water * strain,
            1e-6,
            pressure,
            "the sheet's 1e-6",
        );
        let mut total = stresses(&report.snapshot)[0][0];
        if case.bodies[0].pore_fluid.is_some() {
            total -= pressure;
        }
        outcome.assert_close(
            format!("A-23, {name}: total vertical stress (Pa)"),
            (skeleton + water) * strain,
            1e-6,
            total,
            "the sheet's 1e-6",
        );
    }
    Ok(())
}

/// Checks the reported critical time step of a saturated element against its exact limit.
fn steps(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let table = [
        (0.4, 2650.0, 1e7, 2.15e9, 1e-3, 0.1, 5.368209e-5, 5.095711e-5),
        (0.4, 2650.0, 1e7, 2.15e9, 1e-5, 0.1, 4.067833e-6, 4.049846e-6),
        (0.4, 2650.0, 1e7, 2.15e9, 1e-7, 0.1, 4.072349e-8, 4.072347e-8),
        (0.4, 2650.0, 5e9, 2.0e9, 1e-2, 0.05, 2.230461e-5, 2.224362e-5),
        (0.4, 2650.0, 5e9, 2.0e9, 1e-5, 0.05, 4.039088e-6, 3.944958e-6),
        (0.3, 2700.0, 1e8, 3e9, 1e-4, 0.01, 4.190370e-6, 4.070237e-6),
        (0.4, 2650.0, 1e7, 2.15e9, 1e3, 0.1, 5.447948e-5, 5.447947e-5),
    ];
    let base = load_case("mpm/saturated-column")?;
    let method = colluvium::method("mpm").ok_or("no method mpm")?;
    for (n, grains, modulus, bulk, k, length, exact, formula) in table {
        let case = patched_case(
            &base,
            &[
                ("/materials/skeleton/density", serde_json::json!((1.0 - n) * grains)),
                ("/materials/skeleton/youngs_modulus", serde_json::json!(modulus)),
                ("/bodies/0/pore_fluid/porosity", serde_json::json!(n)),
                ("/bodies/0/pore_fluid/bulk_modulus", serde_json::json!(bulk)),
                ("/bodies/0/pore_fluid/permeability", serde_json::json!(k)),
                ("/methods/mpm/cell_size", serde_json::json!(length)),
                ("/methods/mpm/courant", serde_json::json!(1.0)),
            ],
        )?;
        let step = method.plan(&case).map_err(|error| error.to_string())?.time_step.dt;
        let name = format!("A-36: E_c = {modulus:.0e} Pa, k = {k:.0e} m/s, L = {length} m");
        outcome.assert_close(
            format!("{name}: critical step (s)"),
            formula,
            1e-6,
            step,
            "the sheet's seven digits",
        );
        outcome.assert_within(
            format!("{name}: critical step over the exact limit of one element"),
            "0.95 to 1: never above, at most 5 % below",
            step / exact,
            (0.949, 1.0),
            "the sheet: always below the limit, at most 5 % conservative",
        );
    }
    Ok(())
}

/// Depths below the initial surface of the points at the start (m).
fn initial_depths(frame: &Snapshot) -> Vec<f64> {
    let u = vectors(frame, "displacement");
    frame.positions.iter().zip(u).map(|(x, u)| 1.0 - x[0] + u[0]).collect()
}

/// Checks a saturated column under sudden gravity: stresses during consolidation, and rest from equilibrium.
fn column(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let report = run_mpm(&load_case("mpm/saturated-column")?)?;
    let (water, grains) = (9810.0, 0.6 * 1650.0 * 9.81);
    let errors = |frame: &Snapshot| {
        let worst = |values: &[f64], base: f64| {
            let pairs =
                initial_depths(frame).into_iter().zip(values).map(|(z, v)| (v - base * z).abs() / base);
            pairs.max_or_nan()
        };
        let skeleton: Vec<f64> = stresses(frame).iter().map(|s| -s[0]).collect();
        (worst(&scalars(frame, "pore_pressure"), water), worst(&skeleton, grains))
    };
    let at = |time: f64| {
        let frame = report.frames.iter().find(|frame| (frame.time - time).abs() < 1e-9);
        frame.map_or((f64::NAN, f64::NAN), &errors)
    };
    for (time, prototype) in [(0.5, 0.23), (1.0, 0.065)] {
        let name = format!("A-22: largest error of pore pressure at {time} s over the value at the base");
        let reason = "consolidation is under way; the sheet judges at 2 s";
        outcome.info(name, &format!("{prototype} (sheet's prototype)"), at(time).0, reason);
    }
    let (pressure, skeleton) = at(2.0);
    let prototype = "0.006 (sheet's prototype)";
    let name = |what: &str| format!("A-22: largest error of {what} at 2 s over the value at the base");
    outcome.assert_below(name("pore pressure"), prototype, pressure, 0.01, "the sheet's 1 %");
    outcome.assert_below(name("effective stress"), prototype, skeleton, 0.01, "the sheet's 1 %");
    column_in_equilibrium(&mut outcome)?;
    let line = |base: f64| vec![(0.0, 0.0), (1.0, 1e-3 * base)];
    let mut chart = LineChart::new("Pore pressure, 20 cells", "depth (m)", "pore pressure (kPa)");
    for time in [0.05, 0.2, 0.5, 1.0, 2.0] {
        if let Some(frame) = report.frames.iter().find(|frame| (frame.time - time).abs() < 1e-9) {
            let pressure = scalars(frame, "pore_pressure").into_iter().map(|p| 1e-3 * p);
            let points = initial_depths(frame).into_iter().zip(pressure).collect();
            chart.series.push(Series::new(format!("t = {time} s"), points, Style::Line));
        }
    }
    chart.series.push(Series::new("at rest", line(water), Style::Dashed));
    outcome.svg("The water carries all of the weight at first, and then its own.", &chart)?;
    Ok(outcome)
}

/// Checks that a column that starts in equilibrium remains at rest.
fn column_in_equilibrium(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let still = patched_case(
        &load_case("mpm/saturated-column")?,
        &[
            ("/bodies/0/stress", serde_json::json!({ "kind": "k0", "surface": 1.0, "coefficient": 0.0 })),
            ("/bodies/0/pore_fluid/pressure", serde_json::json!({ "kind": "hydrostatic", "surface": 1.0 })),
            ("/stages/0/duration", serde_json::json!(1.0)),
        ],
    )?;
    let rest = run_mpm(&still)?;
    let speed = ["velocity", "liquid_velocity"]
        .map(|field| vectors(&rest.snapshot, field).iter().map(|v| v[0].abs()).max_or_nan());
    outcome.assert_below(
        format!("A-22: largest speed after {} steps from the state of balance (m/s)", rest.snapshot.step),
        "below 1e-6 m/s after 10 000 steps",
        speed[0].max(speed[1]),
        1e-6,
        "the sheet's bound",
    );
    Ok(())
}

/// Stress of the load (Pa).
const STRESS: f64 = 1e-3;
/// Position at which the stress is measured (m).
const STATION: f64 = 15.0;

/// Checks the reflection of waves by an absorbing end of a bar.
fn absorbing(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let base = load_case("mpm/absorbing")?;
    let mut chart = LineChart::new("Stress at 15 m, the end at 20 m", "time (s)", "compression over load");
    let wall = |kind: serde_json::Value| ("/boundaries/0/wall", kind);
    let dashpot = |a: f64| patched_case(&base, &[wall_of(a)]);
    let cases = [
        ("dashpot a = 1", dashpot(1.0)?, 0.0),
        ("free end", patched_case(&base, &[("/boundaries", serde_json::json!([]))])?, -1.0),
        ("fixed end", patched_case(&base, &[wall(serde_json::json!({ "kind": "rough" }))])?, 1.0),
        ("dashpot a = 0.5", dashpot(0.5)?, -1.0 / 3.0),
        ("dashpot a = 3", dashpot(3.0)?, 0.5),
    ];
    for (name, case, exact) in cases {
        let report = run_mpm(&case)?;
        let history = history(&report);
        // The front returns to the station at 2.5 s, with its ramp of 0.4 s behind it.
        let after: Vec<f64> = history.iter().filter(|p| p.0 > 3.0).map(|p| p.1 - 1.0).collect();
        let mean = after.iter().sum::<f64>() / after.len() as f64;
        outcome.assert_within(
            format!("A-18, {name}: reflected over arriving stress"),
            &format!("{exact:.4}: (a - 1)/(a + 1)"),
            mean,
            (exact - 0.02, exact + 0.02),
            "the sheet's 2 %",
        );
        if exact == 0.0 {
            let all = history.iter().filter(|p| p.0 > 2.4).map(|p| (p.1 - 1.0).abs()).max_or_nan();
            outcome.assert_below(
                "A-18, dashpot a = 1: largest deviation behind the front",
                "0",
                all,
                0.02,
                "the sheet's 2 %",
            );
        }
        chart.series.push(Series::new(name, history, Style::Line));
    }
    outcome.svg("The wave passes at 1.5 s; what the end sends back follows at 2.5 s.", &chart)?;
    shear(&mut outcome)?;
    undrained_wave(&mut outcome)?;
    Ok(outcome)
}

/// Path and value of an absorbing boundary with the dimensionless dashpot coefficient `a`.
fn wall_of(a: f64) -> (&'static str, serde_json::Value) {
    ("/boundaries/0/wall", serde_json::json!({ "kind": "absorbing", "normal": a }))
}

/// Stress at the station over that of the load, over time (s).
fn history(report: &RunReport) -> Vec<(f64, f64)> {
    let at = |frame: &Snapshot| {
        let near: Vec<f64> = frame
            .positions
            .iter()
            .zip(stresses(frame))
            .filter(|(x, _)| (x[0] - STATION).abs() < 0.05)
            .map(|(_, s)| -s[0] / STRESS)
            .collect();
        near.iter().sum::<f64>() / near.len() as f64
    };
    report.frames.iter().map(|frame| (frame.time, at(frame))).collect()
}

/// Checks the absorption of a shear wave at the end of a layer that is periodic sideways.
fn shear(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let report = run_mpm(&load_case("mpm/shear-wave")?)?;
    // The shear wave (10 m/s) passes at 5 m from 0.5 to 0.9 s; its reflection from the end from 1.5 to 1.9 s.
    let at = |frame: &Snapshot| {
        let near: Vec<f64> = frame
            .positions
            .iter()
            .zip(stresses(frame))
            .filter(|(x, _)| (x[1] - 5.0).abs() < 0.1)
            .map(|(_, s)| -s[3] / STRESS)
            .collect();
        near.iter().sum::<f64>() / near.len() as f64
    };
    let mean = |from: f64, to: f64| {
        let within: Vec<f64> =
            report.frames.iter().filter(|f| f.time > from && f.time < to).map(&at).collect();
        within.iter().sum::<f64>() / within.len() as f64
    };
    outcome.assert_within(
        "A-18, shear wave, dashpot b = 1: reflected over arriving stress",
        "0",
        mean(2.0, 2.4) - mean(1.0, 1.4),
        (-0.02, 0.02),
        "the sheet's 2 %",
    );
    Ok(())
}

/// Checks the absorption of the undrained wave in the soil of A-20.
fn undrained_wave(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut case = load_case("mpm/two-waves")?;
    set_mpm_option(&mut case, "cell_size", 0.01);
    for (name, conductivity) in [("1e-5", 1e-5), ("1e-2", 1e-2)] {
        let permeability = conductivity * 1e-3 / 9810.0;
        let case = patched_case(
            &case,
            &[
                ("/domain/min", serde_json::json!([-0.5])),
                (
                    "/boundaries",
                    serde_json::json!([{ "side": "x-min", "position": 0, "wall": { "kind": "absorbing" } }]),
                ),
                ("/bodies/0/pore_fluid/intrinsic_permeability", serde_json::json!(permeability)),
                ("/stages/0/duration", serde_json::json!(1.5e-3)),
                ("/output/frames", serde_json::json!(1e-5)),
            ],
        )?;
        let report = run_mpm(&case)?;
        let total = |frame: &Snapshot| {
            let pressure = scalars(frame, "pore_pressure");
            let near: Vec<f64> = frame
                .positions
                .iter()
                .zip(stresses(frame))
                .zip(pressure)
                .filter(|((x, _), _)| (x[0] - 1.0).abs() < 0.02)
                .map(|((_, s), p)| (p - s[0]) / 1000.0)
                .collect();
            near.iter().sum::<f64>() / near.len() as f64
        };
        // The reflection from the end arrives at 1.31e-3 s.
        let after: Vec<f64> = report.frames.iter().filter(|f| f.time > 1.4e-3).map(total).collect();
        outcome.info(
            format!("two phases, k = {name} m/s: total stress sent back over that which arrived"),
            "0; a fixed end sends back 1, a free one -1",
            after.iter().sum::<f64>() / after.len() as f64 - 1.0,
            "the sheet gives the dashpots of both phases and no bound: the liquid's is that of water alone",
        );
    }
    Ok(())
}
