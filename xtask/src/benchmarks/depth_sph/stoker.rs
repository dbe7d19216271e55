//! Dam break on a wet bed, and the bore reflected by a wall (sheet: depth-sph §5.3, V6; §5.5, V29).

use colluvium::case::Case;
use colluvium::depth_sph::analytical_solutions::Stoker;
use colluvium::depth_sph::bed::Bed;
use colluvium::depth_sph::config::settings::FlowSettings;
use colluvium::depth_sph::flow::{Flow, PlanBoundaries};
use colluvium::plots::{Series, Style};
use serde_json::json;

use crate::benchmarks::depth_sph::common_cases::{
    NodeProfile, chart, closed_form_series, layer, load, start, step_flow_until, step_until,
};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, set_method_option};

/// Benchmark of a dam break on a wet bed and of the reflected bore.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "depth-sph/wet-bed",
    title: "Dam break on a wet bed and reflected bore, depth-integrated",
    source: "Stoker 1957; sheet: depth-sph §5.3, V6; §5.5, V29",
    short_seconds: Some(4),
    full_seconds: 45,
    run,
};

/// Gravitational acceleration (m/s²).
const GRAVITY: f64 = 9.81;

/// Checks the dam break on a wet bed against Stoker's solution, and the bore that a wall reflects.
fn run(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    // The other pairs of the sheet, 10 m over 5 m and over 1 m, are these at ten times the length.
    let pairs: &[(f64, f64)] = if quick { &[(1.0, 0.5)] } else { &[(1.0, 0.5), (1.0, 0.1), (10.0, 0.1)] };
    for &(left, right) in pairs {
        let exact = Stoker::new(GRAVITY, left, right);
        judge(&mut outcome, left, right, "equal spacing", &equally_spaced_profile(left, right)?, &exact)?;
        judge(&mut outcome, left, right, "equal volumes", &equal_volume_profile(left, right)?, &exact)?;
    }
    reflect(&mut outcome, quick)?;
    Ok(outcome)
}

/// Half of the length of the basin over the larger depth.
const HALF_LENGTH: f64 = 5.0;
/// Time of the comparison, over the square root of the larger depth over gravity. No wave has reached a wall then.
const TIME: f64 = 3.132_092;

/// Time at which the profiles of a dam break with the larger depth `left` (m) are compared (s).
fn end(left: f64) -> f64 {
    TIME * (left / GRAVITY).sqrt()
}

/// Number of nodes on half of the basin. A wave over a shallow bed has few nodes.
fn nodes(left: f64, right: f64) -> f64 {
    if left > 20.0 * right { 1000.0 } else { 250.0 }
}

/// Case with the depths `left` and `right` (m); its lengths are proportional to the left depth.
fn case(left: f64, right: f64) -> Result<Case, String> {
    let mut case = load("wet-bed")?;
    let half = HALF_LENGTH * left;
    case.domain.min[0] = -half;
    case.domain.max[0] = half;
    case.domain.max[1] = 1.5 * left;
    for (body, [low, high, depth]) in case.bodies.iter_mut().zip([[-half, 0.0, left], [0.0, half, right]]) {
        let shape = json!({ "kind": "box", "min": [low, 0], "max": [high, depth] });
        body.shape = serde_json::from_value(shape).map_err(|error| error.to_string())?;
    }
    set_method_option(&mut case, "depth-sph", "spacing", half / nodes(left, right));
    Ok(case)
}

/// Profile from nodes at equal distances, of unequal volume.
fn equally_spaced_profile(left: f64, right: f64) -> Result<NodeProfile, String> {
    let mut solver = start(&case(left, right)?)?;
    step_until(&mut *solver, end(left))?;
    Ok(NodeProfile::from_snapshot(&solver.snapshot(), 0, &[-HALF_LENGTH * left, HALF_LENGTH * left]))
}

/// Profile from nodes of equal volume, at unequal distances.
fn equal_volume_profile(left: f64, right: f64) -> Result<NodeProfile, String> {
    let half = HALF_LENGTH * left;
    let ends = PlanBoundaries { walls: [[Some(-half), Some(half)]], ..PlanBoundaries::default() };
    // As many nodes as at equal distances, where the deeper side leaves enough for the shallow one.
    let count = (100.0 * left / right).clamp(250.0, 2000.0).round();
    let spacing = half / count;
    let mut nodes = layer(-half, 0.0, spacing, left);
    nodes.extend(layer(0.0, half, spacing * left / right, right));
    let mut flow = Flow::new(FlowSettings::single_phase(1000.0), Bed::Flat(0.0), ends, &[nodes])
        .map_err(|failure| failure.to_string())?;
    step_flow_until(&mut flow, end(left))?;
    Ok(NodeProfile::of_set(&flow.nodes.sets[0], &[-half, half]))
}

/// Checks the profiles of one dam break on a wet bed against Stoker's solution (V6).
fn judge(
    outcome: &mut BenchmarkOutcome,
    left: f64,
    right: f64,
    nodes: &str,
    profile: &NodeProfile,
    exact: &Stoker,
) -> Result<(), String> {
    let name = |what: &str| format!("V6, {left} m over {right} m, {nodes}: {what}");
    let (time, half) = (end(left), HALF_LENGTH * left);
    let tail = (exact.velocity - (GRAVITY * exact.depth).sqrt()) * time;
    let front = exact.bore_speed * time;
    // The middle of the region between the waves.
    let width = front - tail;
    let (depth, velocity) = profile.mean(tail + 0.2 * width, front - 0.2 * width);
    outcome.assert_close(name("depth between the waves (m)"), exact.depth, 0.015, depth, "V6: 1.5 %");
    outcome.assert_close(
        name("velocity between the waves (m/s)"),
        exact.velocity,
        0.015,
        velocity,
        "V6: 1.5 %",
    );
    let bore = profile.downcrossing(0.5 * (exact.depth + right), 0.5 * (tail + front), half);
    outcome.assert_close(name("place of the bore (m)"), front, 0.01, bore, "V6: 1 % of its travel");
    let error = profile.errors(-half, half, |x| exact.state_at(x, time));
    let reason = "V6: 1.5 % of the larger depth";
    outcome.assert_below(name("mean error of depth over the larger one"), "0", error.0 / left, 0.015, reason);
    if nodes == "equal spacing" {
        let mut chart = chart(&format!("{left} m of water over {right} m after {time:.3} s"), "depth (m)");
        chart.series.push(closed_form_series("Stoker", -half, half, |x| exact.state_at(x, time).0));
        chart.series.push(Series::new("nodes", profile.heights(-half, half), Style::Line));
        outcome.svg("V6: depth by sums over the nodes, and the closed form of Stoker.", &chart)?;
    }
    Ok(())
}

/// Checks the state behind the bore that the wall reflects (V29).
fn reflect(outcome: &mut BenchmarkOutcome, quick: bool) -> Result<(), String> {
    for right in [0.5, 0.1].into_iter().take(if quick { 1 } else { 2 }) {
        let exact = Stoker::new(GRAVITY, 1.0, right);
        let (depth, speed) = exact.reflected();
        let level = 0.5 * (depth + exact.depth);
        let mut solver = start(&case(1.0, right)?)?;
        let arrival = HALF_LENGTH / exact.bore_speed;
        // Two evaluations, before the water that follows changes it.
        let mut places = Vec::new();
        let mut found = (f64::NAN, f64::NAN);
        for distance in [0.1, 0.2] {
            step_until(&mut *solver, arrival + distance * HALF_LENGTH / -speed)?;
            let profile = NodeProfile::from_snapshot(&solver.snapshot(), 0, &[-HALF_LENGTH, HALF_LENGTH]);
            found = profile.mean(0.85 * HALF_LENGTH, HALF_LENGTH);
            places.push((
                solver.time(),
                -profile.mirrored().downcrossing(level, -HALF_LENGTH, -0.5 * HALF_LENGTH),
            ));
        }
        let name = |what: &str| format!("V29, 1 m over {right} m: {what}");
        outcome.assert_close(name("depth behind the reflected bore (m)"), depth, 0.02, found.0, "V29: 2 %");
        let still = (found.1 / exact.velocity).abs();
        outcome.assert_below(name("velocity there over that before"), "0", still, 0.02, "V29: 2 %");
        let found = crate::analysis::regression_slope(&places);
        outcome.assert_close(name("speed of the reflected bore (m/s)"), speed, 0.02, found, "V29: 2 %");
    }
    Ok(())
}
