//! Factors of safety of slopes in undrained clays, by MPM and SPH: two clays, and a weak layer (sheet: sph §3.5).

use colluvium::case::Case;
use serde_json::json;

use super::draw_failure;
use crate::analysis::undrained_slope::LayeredClaySlope;
use crate::benchmarks::{Benchmark, BenchmarkOutcome, load_case, patched_case, run_in_memory};

/// Benchmark of the factor of safety of a slope of undrained clay on equal and on stronger clay.
pub const LAYERS: Benchmark = Benchmark {
    id: "compare/slope-layers",
    title: "Factor of safety of an undrained slope on equal and stronger clay, MPM and SPH",
    source: "Griffiths & Lane 1999, example 4; Taylor 1937; slip circles as upper bounds",
    short_seconds: None,
    full_seconds: 1200,
    run: layers,
};

/// Benchmark of the factor of safety of a slope of undrained clay over a weak layer.
pub const WEAK_LAYER: Benchmark = Benchmark {
    id: "compare/slope-weak-layer",
    title: "Factor of safety of an undrained slope over a weak layer, MPM and SPH",
    source: "least upper bound of sliding blocks and of slip circles",
    short_seconds: None,
    full_seconds: 240,
    run: run_weak_base,
};

/// Undrained strength of the slope (Pa).
const STRENGTH: f64 = 50e3;

/// Distances of the ends of the searched range below and above the least upper bound. They exceed the tolerance. Trials far from the bound
/// would only take time.
const SEARCH_RANGE: [f64; 2] = [0.13, 0.07];

/// Slope of 2:1 with clays below its toe, which are given by their tops (m) and strengths (Pa).
fn clays(below: &[(f64, f64)], base: f64) -> LayeredClaySlope {
    let clays = [&[(f64::INFINITY, STRENGTH)], below].concat();
    LayeredClaySlope { height: 10.0, cotangent: 2.0, unit_weight: 2038.736 * 9.81, layers: clays, base }
}

/// Checks the factors of safety of both methods against the least upper bound.
fn judge(outcome: &mut BenchmarkOutcome, name: &str, case: &Case, bound: f64) -> Result<(), String> {
    for method in ["mpm", "sph"] {
        let report = run_in_memory(method, case)?;
        let found = report.safety.get("safety").ok_or("no factor of safety")?;
        outcome.assert_within(
            format!("{name}, {method}: factor of safety"),
            &format!("{bound:.3}, least upper bound"),
            found.factor().unwrap_or(f64::NAN),
            (bound - 0.05, bound + 0.05),
            "± 0.05 on 20 cells over the height",
        );
        outcome.assert_within(
            format!("{name}, {method}: largest factor with which it stands"),
            "at most the least upper bound",
            found.stable_factor,
            (0.0, bound),
            "limit analysis: with that strength it falls",
        );
        outcome.assert_within(
            format!("{name}, {method}: least factor with which it fails"),
            "from 0.05 below the least upper bound to as much above",
            found.failing_factor,
            (bound - 0.05, bound + 0.05),
            "± 0.05 on 20 cells over the height",
        );
        draw_failure(outcome, &format!("{name}, {method}"), &report)?;
    }
    Ok(())
}

/// Checks factors of safety of a clay slope on equal and on stronger clay against upper bounds of slip circles.
fn layers(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let base = load_case("compare/slope-layers")?;
    // One clay, and one below that the slip circle does not enter. Weaker clays slip below the toe, without a published factor.
    for ratio in [1.0, 2.0] {
        let strength = ratio * STRENGTH;
        let bound = clays(&[(0.0, strength)], -10.0).min_circle_safety_factor();
        let case = patched_case(
            &base,
            &[
                ("/materials/lower/undrained_strength", json!(strength)),
                ("/measures/safety/range", json!([bound - SEARCH_RANGE[0], bound + SEARCH_RANGE[1]])),
            ],
        )?;
        judge(&mut outcome, &format!("lower over upper strength {ratio}"), &case, bound)?;
        if ratio == 2.0 {
            let reason = "not judged: the least circle has less, and is an upper bound";
            outcome.info(
                "lower over upper strength 2: bound of circles",
                "2.1 by finite elements",
                bound,
                reason,
            );
        }
    }
    Ok(outcome)
}

/// Checks the factor of safety of a clay slope over a weak layer against the upper bound of sliding blocks.
fn run_weak_base(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let clays = clays(&[(0.0, 0.2 * STRENGTH), (-1.0, STRENGTH)], -5.0);
    // Along the base of the layer: the weight of the layer drives the slip too.
    let (circles, blocks) = (clays.min_circle_safety_factor(), clays.min_block_safety_factor(-1.0));
    outcome.assert_within(
        "upper bound of sliding blocks over that of circles",
        "below 1: the slip follows the layer",
        blocks / circles,
        (0.0, 1.0),
        "limit analysis",
    );
    judge(&mut outcome, "weak layer", &load_case("compare/slope-weak-layer")?, blocks.min(circles))?;
    Ok(outcome)
}
