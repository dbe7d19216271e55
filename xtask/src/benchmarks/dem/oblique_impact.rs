//! Oblique impacts on a wall (sheet: dem §5, B7).

use std::f64::consts::PI;

use colluvium::case::Solver;
use colluvium::plots::{LineChart, Series, Style};
use serde_json::json;

use crate::analysis::max_or_nan;
use crate::benchmarks::dem::case_builders::{disk_solver, load, method_options, sphere_solver, step};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, vectors};

/// Benchmark of oblique impacts of disks and spheres on a wall.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "dem/oblique",
    title: "Oblique impacts on a wall, disks and spheres",
    source: "sheet: dem §5, B7",
    short_seconds: Some(2),
    full_seconds: 2,
    run,
};

/// Number of steps in the time π/ω₀; the sheet requires at least 400.
const STEPS: f64 = 1000.0;

/// Impact of a grain with a normal speed of one.
#[derive(Clone, Copy)]
struct Impact {
    sphere: bool,
    friction: f64,
    /// Tangential over normal stiffness.
    stiffness_ratio: f64,
    restitution: f64,
    /// Tangent of the angle of impact: tangential over normal speed before the impact.
    angle: f64,
}

/// Table of the sheet: the impact, and the velocity along the wall and spin times radius after it.
const TABLE: [(Impact, f64, f64); 10] = [
    (row(false, 0.3, 1.0 / 3.0, 1.0, 0.5), 0.1667, -0.6667),
    (row(false, 0.3, 1.0 / 3.0, 1.0, 1.5), 0.9, -1.2),
    (row(false, 0.5, 0.5, 1.0, 1.0), 0.3745, -1.2510),
    (row(false, 0.5, 0.5, 1.0, 2.0), 1.0, -2.0),
    (row(false, 0.3, 1.0 / 3.0, 0.5, 1.0), 0.6191, -0.7619),
    (row(false, 0.5, 0.5, 0.5, 1.0), 0.41, -1.1799),
    (row(false, 0.5, 0.5, 0.5, 3.0), 2.2782, -1.4436),
    (row(true, 0.3, 2.0 / 7.0, 1.0, 1.0), 0.4286, -1.4286),
    (row(true, 0.5, 0.5, 1.0, 1.0), 0.5008, -1.2479),
    (row(true, 0.5, 0.5, 0.5, 2.0), 1.2988, -1.7529),
];

/// Row of the sheet: shape, friction coefficient, ratio of tangential to normal stiffness, restitution, angle.
const fn row(sphere: bool, friction: f64, stiffness_ratio: f64, restitution: f64, angle: f64) -> Impact {
    Impact { sphere, friction, stiffness_ratio, restitution, angle }
}

/// Checks velocity and spin after oblique impacts against the sheet's table.
fn run(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let reason = "B7: 0.005";
    for (impact, along, spin) in TABLE {
        let (v, w) = rebound(impact)?;
        let name = format!(
            "B7, {}, μ {}, k_t/k_n {:.3}, ε {}, ψ {}",
            if impact.sphere { "sphere" } else { "disk" },
            impact.friction,
            impact.stiffness_ratio,
            impact.restitution,
            impact.angle
        );
        outcome.assert_within(
            format!("{name}: velocity"),
            &format!("{along}"),
            v,
            (along - 5e-3, along + 5e-3),
            reason,
        );
        outcome.assert_within(
            format!("{name}: spin times radius"),
            &format!("{spin}"),
            w,
            (spin - 5e-3, spin + 5e-3),
            reason,
        );
    }
    // The note under the table: a rigid body would have ψ - μ (1 + ε) = 4.55.
    let (v, _) = rebound(row(false, 0.3, 1.0 / 3.0, 0.5, 5.0))?;
    let name = "B7, disk, μ 0.3, ε 0.5, ψ 5, gross sliding: velocity";
    outcome.assert_within(name, "4.558", v, (4.553, 4.563), reason);
    for (sphere, across, q) in [(false, 1.0 / 3.0, 0.5), (true, 2.0 / 7.0, 0.4)] {
        check_half_period(&mut outcome, sphere, across, q)?;
    }
    Ok(outcome)
}

/// Checks stiffnesses with which the contact lasts half a period of both springs. The contact then sticks and rebounds elastically, or
/// slips.
fn check_half_period(
    outcome: &mut BenchmarkOutcome,
    sphere: bool,
    across: f64,
    q: f64,
) -> Result<(), String> {
    let friction = 0.3;
    let body = if sphere { "sphere" } else { "disk" };
    let (mut exact, mut found, mut worst) = (Vec::new(), Vec::new(), 0.0f64);
    for k in 1..=12 {
        let angle = 0.25 * f64::from(k);
        let (v, w) = rebound(row(sphere, friction, across, 1.0, angle))?;
        let closed = if angle < friction / across {
            (angle * (1.0 - 2.0 * q / (1.0 + q)), -angle * 2.0 / (1.0 + q))
        } else {
            (angle - 2.0 * friction, -2.0 * friction / q)
        };
        worst = max_or_nan(worst, max_or_nan((v - closed.0).abs(), (w - closed.1).abs()));
        exact.push((angle, closed.0 + closed.1));
        found.push((angle, v + w));
    }
    outcome.assert_below(
        format!("B7, {body}, matched stiffness: largest error over twelve angles"),
        "0",
        worst,
        5e-3,
        "B7: 0.005",
    );
    let mut picture = LineChart::new(
        format!("Velocity of the surface after an oblique impact, {body}"),
        "tangential over normal velocity before",
        "velocity of the surface over normal velocity",
    );
    picture.series.push(Series::new("closed form", exact, Style::Dashed));
    picture.series.push(Series::new("DEM", found, Style::Markers));
    outcome.svg("B7: a contact that sticks turns the velocity of the surface back; one that slips takes off 2μ(1 + 1/q).", &picture)
}

/// Velocity along the wall and spin times radius after the impact.
fn rebound(impact: Impact) -> Result<(f64, f64), String> {
    let mut value = load(if impact.sphere { "wall-sphere" } else { "wall" })?;
    let dt = PI / 1e3 / STEPS;
    let height = 0.5 + 3.3 * dt;
    value["boundaries"][0]["wall"] = json!({ "kind": "frictional", "friction_coefficient": impact.friction });
    value["bodies"][0]["shape"]["centre"][1] = json!(height);
    value["bodies"][0]["velocity"]["value"][0] = json!(impact.angle);
    let options = method_options(&mut value);
    options["time_step"] = json!(dt);
    options["pairs"][0]["normal"] =
        json!({ "law": "linear", "stiffness": 1e6, "restitution": impact.restitution });
    options["pairs"][0]["tangential"] = json!({ "stiffness_ratio": impact.stiffness_ratio });
    if !impact.sphere {
        return velocity_after_contact(&mut disk_solver(&value)?, dt);
    }
    velocity_after_contact(&mut sphere_solver(&value)?, dt)
}

/// Velocity along the wall and spin times radius after the contact.
fn velocity_after_contact(solver: &mut impl Solver, dt: f64) -> Result<(f64, f64), String> {
    for _ in 0..(1.2 * STEPS) as usize {
        step(solver, dt)?;
    }
    let snapshot = solver.snapshot();
    let spin = match snapshot.scalars("spin") {
        Some(spin) => spin[0],
        None => vectors(&snapshot, "spin")[0][2],
    };
    Ok((vectors(&snapshot, "velocity")[0][0], 0.5 * spin))
}
