//! Block that slides down an incline, or sticks (sheet: snow-mpm V15).

use colluvium::case::description::Wall;
use serde_json::json;

use super::{case_with_options, run_snow_case};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, vectors};

/// Benchmark of a block on an incline with Coulomb friction at the nodes.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "snow-mpm/incline",
    title: "Block on an incline: Coulomb friction at the nodes",
    source: "sheet: snow-mpm V15, closed form",
    short_seconds: Some(6),
    full_seconds: 12,
    run: benchmark,
};

/// Mean displacement (m) along the incline with a coefficient of friction.
fn mean_displacement(friction: f64, options: &serde_json::Value) -> Result<f64, String> {
    let mut case = case_with_options("incline", options)?;
    case.boundaries[0].wall = Wall::Frictional { friction_coefficient: friction, bilateral: false };
    let displacement = vectors(&run_snow_case(&case)?.snapshot, "displacement");
    Ok(displacement.iter().map(|u| u[0]).sum::<f64>() / displacement.len() as f64)
}

/// Checks the displacement of a block on an incline: it slides with a friction coefficient of 0.3, and sticks with 0.7.
fn benchmark(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    // g (sin 30° - μ cos 30°) t² / 2 after 1.1 s.
    let exact = 0.5 * 9.81 * (0.5 - 0.3 * 0.75f64.sqrt()) * 1.21;
    for (name, options) in
        [("APIC", json!({})), ("FLIP 0.999", json!({ "transfer": "flip", "flip_ratio": 0.999 }))]
            .into_iter()
            .take(if quick { 1 } else { 2 })
    {
        let slid = mean_displacement(0.3, &options)?;
        outcome.assert_close(
            format!("V15 {name}, friction 0.3: way after 1.1 s (m)"),
            exact,
            0.005,
            slid,
            "the sheet's criterion",
        );
        let stayed = mean_displacement(0.7, &options)?.abs();
        outcome.assert_below(
            format!("V15 {name}, friction 0.7: way after 1.1 s (m)"),
            "0",
            stayed,
            1e-3,
            "the sheet's criterion",
        );
    }
    Ok(outcome)
}
