//! Rigid bodies moved by forces: a block on a frictional base, a footing on clay.

use colluvium::case::RunReport;
use colluvium::plots::{LineChart, Series, Style};

use super::contact::mean;
use crate::analysis::regression_slope;
use crate::benchmarks::{Benchmark, BenchmarkOutcome, load_case, measure_series, run_mpm, set_mpm_option};

/// Benchmark of rigid bodies that forces move.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "mpm/rigid-block",
    title: "Rigid bodies that forces move",
    source: "closed form F / m - μ g; a footing under a force against the one under a velocity",
    short_seconds: Some(25),
    full_seconds: 25,
    run: benchmark,
};

/// Mass of the block (kg).
const MASS: f64 = 750.0;
/// Applied force (N).
const APPLIED_FORCE: f64 = 6000.0;
/// Coefficient of friction.
const FRICTION: f64 = 0.4;
/// Gravitational acceleration (m/s²).
const GRAVITY: f64 = 10.0;
/// Time at which the applied force begins (s).
const SETTLING_TIME: f64 = 0.3;

/// Undrained strength of the clay (Pa).
const STRENGTH: f64 = 1e4;
/// Half width of the footing (m).
const HALF_WIDTH: f64 = 1.0;
/// Speed of the driven footing (m/s).
const SPEED: f64 = 0.01;

/// Checks rigid bodies that forces move: a block on a frictional base, and a footing.
fn benchmark(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    block(&mut outcome)?;
    footing(&mut outcome)?;
    Ok(outcome)
}

/// Part of a column of measures from `start` (s) on, with times relative to `start`.
fn column_since(report: &RunReport, column: &str, start: f64) -> Vec<(f64, f64)> {
    let rows = measure_series(report, column).into_iter().filter(|row| row.0 >= start);
    rows.map(|row| (row.0 - start, row.1)).collect()
}

/// Checks the acceleration and the momentum of a pushed block.
fn block(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let exact = APPLIED_FORCE / MASS - FRICTION * GRAVITY;
    let mut chart = LineChart::new(
        "Rigid block pushed over a frictional base",
        "time since the push begins (s)",
        "velocity (m/s)",
    );
    chart.series.push(Series::new("F/m - μ g", vec![(0.0, 0.0), (0.5, 0.5 * exact)], Style::Dashed));
    for shape in ["linear", "ugimp", "quadratic"] {
        let mut case = load_case("mpm/rigid-block")?;
        set_mpm_option(&mut case, "shape", shape);
        let report = run_mpm(&case)?;
        let speeds = column_since(&report, "block.velocity.x", SETTLING_TIME);
        outcome.assert_close(
            format!("{shape}: acceleration (m/s²)"),
            exact,
            0.02,
            regression_slope(&speeds),
            "the 2 % of sheet: mpm A-31, friction between two bodies that deform",
        );
        let [rubbed, borne] = ["x", "y"].map(|axis| {
            regression_slope(&column_since(&report, &format!("reaction.impulse.{axis}"), SETTLING_TIME + 0.1))
        });
        outcome.assert_close(
            format!("{shape}: friction over normal force"),
            FRICTION,
            0.002,
            -rubbed / borne,
            "the law of contact at each node; the rest is the mean over the rows of the table",
        );
        let late = column_since(&report, "block.velocity.x", SETTLING_TIME + 0.1);
        let impulse = column_since(&report, "reaction.impulse.x", SETTLING_TIME + 0.1);
        if let ([first, .., last], [begun, .., taken]) = (&late[..], &impulse[..]) {
            let open = MASS * (last.1 - first.1) - APPLIED_FORCE * (last.0 - first.0) - (taken.1 - begun.1);
            outcome.assert_below(
                format!("{shape}: momentum less impulses over the impulse of the push"),
                "0",
                open.abs() / (APPLIED_FORCE * (last.0 - first.0)),
                1e-9,
                "round-off",
            );
        }
        chart.series.push(Series::new(shape, speeds, Style::Line));
    }
    outcome.svg("A rigid block, 750 kg, on an elastic base: 6 kN push it, friction 0.4 holds it.", &chart)
}

/// Settlement (m) and load over strength and width, for each frame.
fn settling(report: &RunReport) -> Vec<(f64, f64)> {
    let impulse = measure_series(report, "reaction.impulse.y");
    let load = |time: f64| {
        let near: Vec<(f64, f64)> =
            impulse.iter().copied().filter(|row| (row.0 - time).abs() < 0.06).collect();
        regression_slope(&near) / (HALF_WIDTH * STRENGTH)
    };
    let frames = report.frames.iter().filter(|frame| frame.time > 0.2);
    frames.map(|frame| (-mean(frame, "displacement", 1, 1), load(frame.time))).collect()
}

/// Settlement under a load, by linear interpolation.
fn settlement_at_load(curve: &[(f64, f64)], load: f64) -> f64 {
    let part = curve.windows(2).find(|pair| pair[0].1 <= load && load < pair[1].1);
    part.map_or(f64::NAN, |pair| {
        let share = (load - pair[0].1) / (pair[1].1 - pair[0].1);
        pair[0].0 + share * (pair[1].0 - pair[0].0)
    })
}

/// Checks that a footing pressed by a force settles as one that is driven at a velocity.
fn footing(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let pressed = load_case("mpm/rigid-footing")?;
    let mut driven = pressed.clone();
    let motion = &mut driven.stages[0].motions[0];
    motion.velocity = vec![Some(0.0), Some(-SPEED)];
    motion.force.clear();
    motion.ramp = 0.3;
    let report = run_mpm(&pressed)?;
    let [by_force, by_velocity] = [settling(&report), settling(&run_mpm(&driven)?)];
    for load in [1.0, 2.0, 3.0] {
        outcome.assert_close(
            format!("footing: settlement under {load} c_u (m)"),
            settlement_at_load(&by_velocity, load),
            0.03,
            settlement_at_load(&by_force, load),
            "both are slow, not at rest: loads are means over 0.1 s, in which the force grows by 3 % of its end",
        );
    }
    let end = measure_series(&report, "reaction.impulse.y");
    let late: Vec<(f64, f64)> = end.into_iter().filter(|row| row.0 > 2.8).collect();
    let mean_force = 4.0 * STRENGTH * (2.9 / 3.0);
    outcome.assert_close(
        "footing: reaction over the force, mean of the last 0.2 s",
        1.0,
        0.01,
        regression_slope(&late) / mean_force,
        "the remainder is the footing's own acceleration",
    );
    outcome.svg(
        "A rigid footing on clay settles under a force as it does where it is pressed with a velocity.",
        &LineChart {
            series: vec![
                Series::new("by a velocity", by_velocity, Style::Dashed),
                Series::new("by a force", by_force, Style::Line),
            ],
            ..LineChart::new("Rigid footing on Tresca clay", "settlement (m)", "load / (width × c_u)")
        },
    )
}
