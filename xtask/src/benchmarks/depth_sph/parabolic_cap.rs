//! Parabolic caps: similarity solutions along a line and in plan (sheet: depth-sph §5.3, V8, V9).

use colluvium::case::Case;
use colluvium::depth_sph::analytical_solutions::ParabolicCap;
use colluvium::depth_sph::bed::{Bed, incline};
use colluvium::depth_sph::config::settings::FlowSettings;
use colluvium::depth_sph::flow::{Flow, PlanBoundaries};
use colluvium::depth_sph::points::phase_nodes::NewNode;
use colluvium::plots::{Series, Style};
use serde_json::json;

use crate::benchmarks::depth_sph::common_cases::{
    NodeProfile, chart, closed_form_series, load, start, step_flow_until, step_until,
};
use crate::benchmarks::{Benchmark, BenchmarkOutcome, scalars};

/// Benchmark of parabolic caps of sand that slide and spread.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "depth-sph/cap",
    title: "Parabolic caps that slide and spread, depth-integrated",
    source: "Savage and Hutter 1989; sheet: depth-sph §5.3, V8, V9",
    short_seconds: Some(6),
    full_seconds: 12,
    run,
};

/// Initial speed of the cap, so that all of it moves down (m/s).
const SPEED: f64 = 2.0;

/// Checks parabolic caps of sand that slide and spread, along a line and in plan.
fn run(_quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    line(&mut outcome)?;
    plan(&mut outcome)?;
    check_steep_plane(&mut outcome)?;
    Ok(outcome)
}

/// Case of the parabolic cap (V8), which is a polygon of many sides.
fn cap() -> Result<Case, String> {
    let mut case = load("cap")?;
    let count = 200;
    let arc = (0..=count).map(|k| {
        let xi = 1.0 - 2.0 * f64::from(k) / f64::from(count);
        [10.0 * xi, 2.0 * (1.0 - xi * xi)]
    });
    let points: Vec<[f64; 2]> = arc.collect();
    let shape = json!({ "kind": "polygon", "vertices": points });
    case.bodies[0].shape = serde_json::from_value(shape).map_err(|error| error.to_string())?;
    Ok(case)
}

/// Checks the length and the velocity of a cap along a line against the similarity solution.
fn line(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let slope = 35f64.to_radians();
    let gravity = 9.81 * slope.cos();
    let acceleration = gravity * (slope.tan() - 25f64.to_radians().tan());
    let exact = ParabolicCap { half_length: 10.0, area: 80.0 / 3.0, gravity, coefficient: 1.0 };
    let mut solver = start(&cap()?)?;
    let mut shown = chart("Cap on an incline of 35° over 25° of friction", "depth (m)");
    for time in [1.0, 2.0, 3.0, 5.0] {
        step_until(&mut *solver, time)?;
        let snapshot = solver.snapshot();
        let volume = scalars(&snapshot, "volume");
        let whole: f64 = volume.iter().sum();
        let moment = |power: i32, about: f64| {
            let each = snapshot.positions.iter().zip(&volume);
            each.map(|(x, m)| m * (x[0] - about).powi(power)).sum::<f64>() / whole
        };
        let middle = moment(1, 0.0);
        let half = (5.0 * moment(2, middle)).sqrt();
        let (length, _) = exact.half_length(time);
        let place = SPEED * time + 0.5 * acceleration * time * time;
        let name = |what: &str| format!("V8, {time} s: {what}");
        outcome.assert_close(
            name("half of the length (m)"),
            length,
            0.01,
            half,
            "V8: 1 %; by the second moment",
        );
        let reason = "V8: 1 % of the half-length";
        let off = (middle - place).abs() / length;
        outcome.assert_below(
            name("place of the middle, error over half of the length"),
            "0",
            off,
            0.01,
            reason,
        );
        let profile = NodeProfile::from_snapshot(&snapshot, 0, &[]);
        let highest = profile.heights(place - length, place + length);
        let highest = highest.iter().map(|(_, h)| *h).fold(0.0, f64::max);
        outcome.assert_close(name("largest depth (m)"), exact.depth(length, 0.0), 0.01, highest, "V8: 1 %");
        let depth = |x: f64| exact.depth(length, x - place);
        let error = profile.errors(place - length, place + length, |x| (depth(x), 0.0)).0;
        let reason = "V8: 1 % of the largest depth";
        outcome.assert_below(
            name("mean error of the profile"),
            "0",
            error / exact.depth(length, 0.0),
            0.01,
            reason,
        );
        let (low, high) = (place - 1.1 * length, place + 1.1 * length);
        shown.series.push(closed_form_series(String::new(), low, high, depth));
        shown.series.push(Series::new(format!("{time} s"), profile.heights(low, high), Style::Line));
    }
    outcome.svg("V8: depth along the bed, and the similarity solution (broken).", &shown)
}

/// Nodes of a parabolic cap of this radius and depth (m).
fn heap(radius: f64, depth: f64, spacing: f64) -> Vec<NewNode<2>> {
    let mut nodes = Vec::new();
    let count = (radius / spacing) as i32 + 1;
    for i in -count..count {
        for j in -count..count {
            let x = [spacing * (f64::from(i) + 0.5), spacing * (f64::from(j) + 0.5)];
            let height = depth * (1.0 - (x[0] * x[0] + x[1] * x[1]) / (radius * radius));
            if height > 0.0 {
                let volume = height * spacing * spacing;
                let (length, scale) = (1.3 * spacing, 1.3 * 1.3);
                nodes.push(NewNode { body: 0, position: x, velocity: [0.0; 2], volume, length, scale });
            }
        }
    }
    let volume = std::f64::consts::FRAC_PI_2 * radius * radius * depth;
    let sum: f64 = nodes.iter().map(|node: &NewNode<2>| node.volume).sum();
    nodes.iter_mut().for_each(|node| node.volume *= volume / sum);
    nodes
}

/// Checks a cap on a plane of 35° without friction, in plan and vertical depths. It equals that on a level plane under `g cos θ` (V9).
fn check_steep_plane(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let angle = 35f64.to_radians();
    let (sin, cos) = angle.sin_cos();
    let mut nodes = heap(10.0, 2.0, 0.4);
    nodes.iter_mut().for_each(|node| node.position[0] *= cos);
    let mut flow = Flow::new(
        FlowSettings::single_phase(1000.0),
        incline([-sin / cos, 0.0]),
        PlanBoundaries::default(),
        &[nodes],
    )
    .map_err(|failure| failure.to_string())?;
    let first = central_moments(&flow);
    for (time, exact) in [(1.0, 11.8), (2.0, 16.029_972), (4.0, 26.978_510)] {
        let time = time / cos.sqrt();
        step_flow_until(&mut flow, time)?;
        let now = central_moments(&flow);
        let reason = "2 %: the metric is blended between that of level surfaces and that of sheets";
        for (axis, name) in ["along the slope", "across it"].into_iter().enumerate() {
            let found = (now[axis] / first[axis]).sqrt();
            outcome.assert_close(
                format!("35°, {time:.2} s: growth {name}"),
                exact / 10.0,
                0.02,
                found,
                reason,
            );
        }
    }
    Ok(())
}

/// Second moments of the volume about its centre, over the volume: xx, yy (m²).
fn central_moments(flow: &Flow<2>) -> [f64; 2] {
    let nodes = &flow.nodes.sets[0].nodes;
    let whole = nodes.total_volume();
    let mean = |of: &dyn Fn(&[f64; 2]) -> f64| {
        nodes.position.iter().zip(&nodes.volume).map(|(x, m)| m * of(x)).sum::<f64>() / whole
    };
    [0, 1].map(|axis| {
        let middle = mean(&|x| x[axis]);
        mean(&|x| (x[axis] - middle).powi(2))
    })
}

/// Checks a cap on a level plane, in plan (V9).
fn plan(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let radius = 10.0;
    let nodes = heap(radius, 2.0, 0.4);
    let mut flow =
        Flow::new(FlowSettings::single_phase(1000.0), Bed::Flat(0.0), PlanBoundaries::default(), &[nodes])
            .map_err(|failure| failure.to_string())?;
    let first = second_moments(&flow);
    let mut shown = chart("Cap on a level plane: depth over the distance from its middle", "depth (m)");
    let table = [(1.0, 11.8, 1.436_369), (2.0, 16.029_972, 0.778_331), (4.0, 26.978_510, 0.274_786)];
    for (time, exact, highest) in table {
        step_flow_until(&mut flow, time)?;
        let [xx, yy, xy] = second_moments(&flow);
        let name = |what: &str| format!("V9, {time} s: {what}");
        let reason = "V9: 0.5 %; from the second moment, whose first value is that of the lattice";
        let found = radius * ((xx + yy) / (first[0] + first[1])).sqrt();
        outcome.assert_close(name("radius (m)"), exact, 0.005, found, reason);
        let top = flow.nodes.sets[0].nodes.partial_thickness.iter().copied().fold(0.0, f64::max);
        outcome.assert_close(name("largest depth (m)"), highest, 0.02, top, "V9: 2 %");
        let uneven = ((xx - yy).powi(2) + 4.0 * xy * xy).sqrt() / (xx + yy);
        outcome.assert_below(name("anisotropy of the second moments"), "0", uneven, 0.005, "V9: 0.5 %");
        let nodes = &flow.nodes.sets[0].nodes;
        let found = nodes.position.iter().zip(&nodes.partial_thickness).step_by(7);
        let found = found.map(|(x, h)| (x[0].hypot(x[1]), *h)).collect();
        shown.series.push(Series::new(format!("{time} s"), found, Style::Markers));
        let cap = |r: f64| highest * (1.0 - (r / exact).powi(2));
        shown.series.push(closed_form_series(String::new(), 0.0, exact, cap));
    }
    outcome.svg("V9: every seventh node, and the similarity solution (broken).", &shown)
}

/// Second moments of the volume over the volume: xx, yy, xy (m²).
fn second_moments(flow: &Flow<2>) -> [f64; 3] {
    let nodes = &flow.nodes.sets[0].nodes;
    let whole = nodes.total_volume();
    let mut sum = [0.0; 3];
    for (x, m) in nodes.position.iter().zip(&nodes.volume) {
        sum[0] += m / whole * x[0] * x[0];
        sum[1] += m / whole * x[1] * x[1];
        sum[2] += m / whole * x[0] * x[1];
    }
    sum
}
