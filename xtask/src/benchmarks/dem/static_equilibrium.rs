//! Grains at rest on each other: a stack and a pile of three (sheet: dem §5, B5 and B9).

use colluvium::case::Solver;
use serde_json::json;

use crate::analysis::max_or_nan;
use crate::benchmarks::dem::case_builders::{disk_solver, load, method_options, step};
use crate::benchmarks::{Benchmark, BenchmarkOutcome};

/// Benchmark of grains at rest: a stack of disks and a pile of three.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "dem/rest",
    title: "A stack of disks, linear and after Hertz; a pile of three, DEM",
    source: "sheet: dem §5, B5, B9",
    short_seconds: Some(4),
    full_seconds: 4,
    run,
};

/// Gravitational acceleration (m/s²).
const GRAVITY: f64 = 9.81;
/// Number of disks of the stack.
const COUNT: u32 = 10;

/// Checks the overlaps of a stack of disks and the contact forces of a pile of three.
fn run(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    stack(&mut outcome, "linear", None, &|i| f64::from(i) * GRAVITY / 1e6)?;
    // E* of like grains; effective radii r/2, and r at the floor.
    let modulus = 1e8 / (2.0 * (1.0 - 0.09));
    let hertz = json!({ "law": "hertz", "youngs_modulus": 1e8, "poissons_ratio": 0.3, "damping_ratio": 0.4 });
    stack(&mut outcome, "Hertz", Some(hertz), &|i| {
        let radius: f64 = if i == COUNT { 0.5 } else { 0.25 };
        (3.0 * f64::from(i) * GRAVITY / (4.0 * modulus * radius.sqrt())).powf(2.0 / 3.0)
    })?;
    pile(&mut outcome)?;
    Ok(outcome)
}

/// Checks the overlaps of a stack of disks, which follow from the weight above (B5).
fn stack(
    outcome: &mut BenchmarkOutcome,
    name: &str,
    law: Option<serde_json::Value>,
    overlap: &dyn Fn(u32) -> f64,
) -> Result<(), String> {
    let mut value = load("stack")?;
    if let Some(law) = law {
        method_options(&mut value)["pairs"][0]["normal"] = law;
    }
    let mut solver = disk_solver(&value)?;
    for _ in 0..60_000 {
        let dt = solver.limit().dt;
        step(&mut solver, dt)?;
    }
    let heights: Vec<f64> = solver.snapshot().positions.iter().map(|x| x[1]).collect();
    let total: f64 = (1..=COUNT).map(overlap).sum();
    let reason = "B5: 1e-6";
    let top = heights[heights.len() - 1];
    outcome.assert_close(
        format!("B5, {name}: settlement of the top disk (m)"),
        total,
        1e-6,
        9.5 - top,
        reason,
    );
    let mut worst = 0.0f64;
    for (below, pair) in heights.windows(2).enumerate() {
        let exact = overlap(COUNT - 1 - below as u32);
        worst = max_or_nan(worst, ((1.0 - (pair[1] - pair[0])) / exact - 1.0).abs());
    }
    outcome.assert_below(
        format!("B5, {name}: largest relative error of an overlap"),
        "0",
        worst,
        1e-6,
        reason,
    );
    let floor = solver.reaction("floor").map_or(f64::NAN, |reaction| -reaction.force[1]);
    outcome.assert_close(
        format!("B5, {name}: force on the floor (N)"),
        GRAVITY * f64::from(COUNT),
        1e-6,
        floor,
        reason,
    );
    Ok(())
}

/// Checks that the pile is stable above both thresholds and collapses below one of them (B9).
fn pile(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let (grain, wall) = (2.0 - 3f64.sqrt(), (2.0 - 3f64.sqrt()) / 3.0);
    let reason = "B9: stands at 1.03 of both thresholds and falls at 0.97 of either; 1.366 m at the start";
    for (name, of_grain, of_wall, stands) in [
        ("1.03 of both", 1.03, 1.03, true),
        ("0.97 between grains", 0.97, 2.0, false),
        ("0.97 at the floor", 2.0, 0.97, false),
    ] {
        let mut value = load("pile")?;
        value["boundaries"][0]["wall"]["friction_coefficient"] = json!(of_wall * wall);
        method_options(&mut value)["pairs"][0]["friction"]["coefficient"] = json!(of_grain * grain);
        let mut solver = disk_solver(&value)?;
        while solver.time() < 9.0 {
            let dt = solver.limit().dt;
            step(&mut solver, dt)?;
        }
        let height = solver.snapshot().positions[2][1];
        let (claim, range) = if stands { ("stands", (1.36, 1.37)) } else { ("falls", (0.0, 1.0)) };
        outcome.assert_within(
            format!("B9, friction {name}: height of the third (m)"),
            claim,
            height,
            range,
            reason,
        );
    }
    Ok(())
}
