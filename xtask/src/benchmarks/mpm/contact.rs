//! Contact between bodies (sheet: mpm ).

use colluvium::case::{Case, RunReport, Snapshot};
use colluvium::plots::{LineChart, PointCloud, Series, Style};

use crate::analysis::regression_slope;
use crate::benchmarks::{Benchmark, BenchmarkOutcome, load_case, run_mpm, set_mpm_option, stresses, vectors};

/// Benchmark of contact: bodies that collide, slide, stick, roll and separate.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "mpm/contact",
    title: "Bodies that meet, slide, stick, roll and part",
    source: "sheet: mpm A-13, A-14, A-15, A-31, closed forms; Bardenhagen et al. 2000, 2001",
    short_seconds: Some(28),
    full_seconds: 28,
    run: benchmark,
};

/// Checks contact of bars, of a block on a base and on an incline, and of a disk.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    check_bars(&mut outcome, "A-13 bars", &run_mpm(&load_case("mpm/contact-bars")?)?)?;
    block(&mut outcome)?;
    incline(&mut outcome)?;
    disk(&mut outcome)?;
    Ok(outcome)
}

/// Sets a key of the first contact of the case.
pub(super) fn contact(case: &mut Case, key: &str, value: impl Into<serde_json::Value>) {
    if let Some(mpm) = case.methods.get_mut("mpm") {
        mpm["contacts"][0][key] = value.into();
    }
}

/// Mean of a component of a field over a body, whose points all have the same mass.
pub(super) fn mean(snapshot: &Snapshot, field: &str, body: u32, component: usize) -> f64 {
    let values = vectors(snapshot, field);
    let of_body = values.iter().zip(&snapshot.bodies).filter(|(_, b)| **b == body);
    let (sum, count) = of_body.fold((0.0, 0.0), |(sum, count), (v, _)| (sum + v[component], count + 1.0));
    sum / count
}

/// Mean of a component of a field over a body, over time and relative to `start`.
pub(super) fn history(report: &RunReport, field: &str, body: u32, start: f64) -> Vec<(f64, f64)> {
    let frames = report.frames.iter().filter(|frame| frame.time >= start - 1e-9);
    frames.map(|frame| (frame.time - start, mean(frame, field, body, 0))).collect()
}

/// Mean displacement along x of a body over time.
fn mean_displacement(report: &RunReport, body: u32) -> Vec<(f64, f64)> {
    report.frames.iter().map(|frame| (frame.time, mean(frame, "displacement", body, 0))).collect()
}

/// Mean stress along the bars (Pa) of the points initially between two positions (m); the interface is at 2 m.
fn mean_bar_stress(snapshot: &Snapshot, from: f64, to: f64) -> f64 {
    let moved = vectors(snapshot, "displacement");
    let start = snapshot.positions.iter().zip(moved).map(|(x, u)| x[0] - u[0]);
    let within = start.zip(stresses(snapshot)).filter(|(x, _)| *x > from && *x < to);
    let (sum, count) = within.fold((0.0, 0.0), |(sum, count), (_, s)| (sum + s[0], count + 1.0));
    sum / count
}

/// Checks two equal bars that collide: 1 m long, 1000 kg/m³, 10 m/s wave speed, ±0.1 m/s.
pub(super) fn check_bars(
    outcome: &mut BenchmarkOutcome,
    name: &str,
    report: &RunReport,
) -> Result<(), String> {
    let speeds: Vec<(f64, f64)> = history(report, "velocity", 0, 0.0);
    // Part of the left bar near its end, without the points next to the interface.
    let near = |snapshot: &Snapshot| mean_bar_stress(snapshot, 1.8, 1.95);
    let pressed = report.frames.iter().filter(|frame| (0.08..0.12).contains(&frame.time));
    let (sum, count) = pressed.fold((0.0, 0.0), |(sum, count), frame| (sum + near(frame), count + 1.0));
    let title = format!("{name}: stress behind the front, mean 0.08 to 0.12 s (Pa)");
    outcome.assert_close(title, -1000.0, 0.03, sum / count, "the sheet's 3 %");
    // The mean speed falls linearly until separation, and is constant from then on.
    let last = speeds.last().map_or(f64::NAN, |(_, v)| *v);
    let part = speeds.iter().find(|(_, v)| *v < 0.98 * last).map_or(f64::NAN, |(t, _)| *t);
    let reason = "the sheet's 5 %; they part when the mean speed has reached 98 % of what it ends with";
    outcome.assert_close(format!("{name}: time when they part (s)"), 0.2, 0.05, part, reason);
    let kept = report.end.kinetic / report.start.kinetic;
    let title = format!("{name}: kinetic energy after over before");
    outcome.assert_within(title, "at least 0.97", kept, (0.97, 1.0001), "the sheet's bound");
    tension_after_separation(outcome, name, report, part);
    let momentum = report.end.momentum[0].abs() / (0.1 * 0.5 * report.start.mass);
    outcome.assert_below(format!("{name}: momentum over that of one bar"), "0", momentum, 1e-12, "round-off");
    let chart = LineChart {
        series: vec![
            Series::new("closed form", vec![(0.0, 0.1), (0.2, -0.1), (0.4, -0.1)], Style::Dashed),
            Series::new("contact", speeds, Style::Line),
        ],
        ..LineChart::new(name, "time (s)", "mean velocity of the left bar (m/s)")
    };
    outcome.svg(
        "Mean speed of the left bar: the impact lasts while the wave runs to the free end and back.",
        &chart,
    )
}

/// Checks that no tension acts between the bars after the time `part` (s) of their separation.
fn tension_after_separation(outcome: &mut BenchmarkOutcome, name: &str, report: &RunReport, part: f64) {
    for (body, bar, outwards) in [(0, "left", 1.0), (1, "right", -1.0)] {
        // No other force acts on a bar: a tensile contact force changes its mean speed.
        let speeds = history(report, "velocity", body, part);
        let tensions = speeds
            .windows(2)
            .map(|pair| outwards * 1000.0 * (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0));
        let title = format!("{name}: largest tension at the end of the {bar} one after they part (Pa)");
        outcome.assert_below(title, "none", tensions.fold(f64::NAN, f64::max), 1e-6, "round-off");
        let within = if body == 0 { (1.95, 2.0) } else { (2.0, 2.05) };
        let parted = report.frames.iter().filter(|frame| frame.time >= part);
        outcome.info(
            format!("{name}: largest tension within the {bar} one next to its end after they part (Pa)"),
            "none",
            parted.map(|frame| mean_bar_stress(frame, within.0, within.1)).fold(f64::NAN, f64::max),
            "not judged: a step wave rings in a free bar without damping (A-08)",
        );
    }
}

/// Removes the prescribed normal of the first contact of the case.
fn forget_normal(case: &mut Case) {
    contact(case, "normal", serde_json::Value::Null);
}

/// Checks a block that slides to rest, with 1 m/s, a friction coefficient of 0.4 and 10 m/s².
fn block(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut chart = LineChart::new("Block sliding to rest", "time (s)", "mean velocity (m/s)");
    chart.series.push(Series::new("closed form", vec![(0.0, 1.0), (0.25, 0.0), (0.5, 0.0)], Style::Dashed));
    for shape in ["linear", "ugimp", "quadratic"] {
        let mut case = load_case("mpm/contact-block")?;
        set_mpm_option(&mut case, "shape", shape);
        let report = run_mpm(&case)?;
        let speeds = history(&report, "velocity", 1, 0.0);
        let sliding: Vec<(f64, f64)> = speeds.iter().copied().filter(|(t, _)| *t < 0.22).collect();
        let stop = 1.0 / -regression_slope(&sliding);
        let reason = "the sheet's 2 %";
        outcome.assert_close(
            format!("A-31 block, {shape}: time to rest by its deceleration (s)"),
            0.25,
            0.02,
            stop,
            reason,
        );
        let displacement = mean(&report.snapshot, "displacement", 1, 0);
        outcome.assert_close(
            format!("A-31 block, {shape}: way to rest (m)"),
            0.125,
            0.02,
            displacement,
            reason,
        );
        chart.series.push(Series::new(shape, speeds, Style::Line));
        forget_normal(&mut case);
        let report = run_mpm(&case)?;
        outcome.info(
            format!("A-31 block, {shape}, normals from the bodies: way to rest (m)"),
            "0.125",
            mean(&report.snapshot, "displacement", 1, 0),
            "not judged: the sheet gives the normal; corners tilt the others, and undamped contact by gaps bounces",
        );
    }
    for friction in ["impulse", "acceleration"] {
        plane(outcome, &mut chart, friction)?;
    }
    outcome.svg("A block on a flat base: Coulomb's law takes its speed in a straight line.", &chart)
}

/// Checks the block on a frictional plane, with friction applied to impulses or to accelerations (§3.7).
fn plane(outcome: &mut BenchmarkOutcome, chart: &mut LineChart, friction: &str) -> Result<(), String> {
    let mut case = load_case("mpm/contact-block")?;
    case.bodies.remove(0);
    let floor = serde_json::json!({
        "side": "y-min", "position": 0.4, "wall": { "kind": "frictional", "friction_coefficient": 0.4 }
    });
    case.boundaries[0] = serde_json::from_value(floor).map_err(|error| error.to_string())?;
    if let Some(mpm) = case.methods.get_mut("mpm") {
        mpm["contacts"] = serde_json::json!([]);
        mpm["wall_friction"] = friction.into();
    }
    let report = run_mpm(&case)?;
    let speeds = history(&report, "velocity", 0, 0.0);
    let sliding: Vec<(f64, f64)> = speeds.iter().copied().filter(|(t, _)| *t < 0.22).collect();
    let name = |what: &str| format!("A-31 block on a plane, friction by {friction}: {what}");
    let reason = "the sheet's 2 %";
    outcome.assert_close(
        name("time to rest by its deceleration (s)"),
        0.25,
        0.02,
        1.0 / -regression_slope(&sliding),
        reason,
    );
    let displacement = mean(&report.snapshot, "displacement", 0, 0);
    outcome.assert_close(name("way to rest (m)"), 0.125, 0.02, displacement, reason);
    chart.series.push(Series::new(format!("plane, by {friction}"), speeds, Style::Line));
    Ok(())
}

/// Checks the acceleration of a block on an incline.
fn incline(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let mut chart =
        LineChart::new("Block on an incline of 30°", "time (s)", "mean velocity along the incline (m/s)");
    let weight = 9.81 * 0.5;
    for (friction, adhesion, given, exact) in [
        (0.0, 0.0, true, 4.9050),
        (0.2, 0.0, true, 3.2059),
        (0.4, 0.0, true, 1.5067),
        (0.5, 0.0, true, 0.6571),
        (0.7, 0.0, true, 0.0),
        (0.2, 500.0, true, 2.5392),
        (0.2, 0.0, false, 3.2059),
        (0.5, 0.0, false, 0.6571),
        (0.7, 0.0, false, 0.0),
    ] {
        let mut case = load_case("mpm/contact-incline")?;
        contact(&mut case, "friction_coefficient", friction);
        contact(&mut case, "adhesion", adhesion);
        if !given {
            forget_normal(&mut case);
        }
        // The sheet's prototype damps vertical motion with this factor: a bouncing block does not stick.
        case.stages[1].damping = 0.1;
        case.stages[1].damping_axes = Some(vec![1]);
        let report = run_mpm(&case)?;
        let start = report.snapshot.time - 1.0;
        let speeds = history(&report, "velocity", 1, start);
        let mut label = format!("μ = {friction}");
        if adhesion > 0.0 {
            label += &format!(", a = {adhesion} Pa");
        }
        if !given {
            label += ", normals from the bodies";
        }
        if exact > 0.0 {
            outcome.assert_within(
                format!("A-14 incline, {label}: acceleration (m/s²)"),
                &format!("{exact}"),
                regression_slope(&speeds),
                (exact - 0.03 * weight, exact + 0.03 * weight),
                "the sheet's 3 % of g sin θ",
            );
        } else {
            let drift = mean(&report.snapshot, "displacement", 1, 0);
            let reason = "the sheet's 5 mm; local damping 0.1 of the vertical motion, as in its prototype";
            outcome.assert_within(
                format!("A-14 incline, {label}: drift in 1 s (m)"),
                "0",
                drift,
                (-5e-3, 5e-3),
                reason,
            );
        }
        chart.series.push(Series::new(label, speeds, Style::Line));
    }
    outcome.svg("Velocity of the block for five coefficients of friction, with adhesion, and with normals from the bodies.", &chart)
}

/// Checks the acceleration of a disk on an incline.
fn disk(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let (sine, cosine) = (0.5, 0.75f64.sqrt());
    let mut chart = LineChart::new("Disk on an incline of 30°", "time (s)", "way (m)");
    for (friction, what) in [(0.4, "rolls"), (0.1, "slips")] {
        let mut case = load_case("mpm/contact-disk")?;
        contact(&mut case, "friction_coefficient", friction);
        let report = run_mpm(&case)?;
        let rate = if friction > 0.3 { sine / 3.0 } else { 0.5 * (sine - friction * cosine) };
        let exact = rate * 9.81;
        let displacement = mean(&report.snapshot, "displacement", 1, 0);
        let name = format!("A-15 disk, μ = {friction}, {what}: way in 1 s (m)");
        outcome.assert_close(name, exact, 0.05, displacement, "the sheet's 5 %");
        chart.series.push(Series::new(format!("μ = {friction}"), mean_displacement(&report, 1), Style::Line));
        let parabola = (0..=20).map(|k| 0.05 * f64::from(k)).map(|t| (t, exact * t * t)).collect();
        chart.series.push(Series::new(format!("closed form, it {what}"), parabola, Style::Dashed));
        if friction > 0.3 {
            let cloud =
                PointCloud::from_snapshot(&report.snapshot, "velocity", [0, 1]).ok_or("no velocity")?;
            outcome.png("The disk that rolls, after 1 s.", &cloud)?;
        }
    }
    outcome
        .svg("The way of the disk along the incline: it rolls with friction 0.4 and slips with 0.1.", &chart)
}
