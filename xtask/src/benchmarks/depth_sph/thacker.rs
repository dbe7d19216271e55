//! Water that oscillates in a parabolic basin (sheet: depth-sph §5.3, V10, V11).

use std::f64::consts::{PI, TAU};

use colluvium::depth_sph::bed::paraboloid;
use colluvium::depth_sph::config::choices::DepthFrame;
use colluvium::depth_sph::config::settings::{BedZone, FlowSettings};
use colluvium::depth_sph::flow::{Flow, PlanBoundaries};
use colluvium::depth_sph::kernel::Kernel;
use colluvium::depth_sph::points::phase_nodes::NewNode;
use colluvium::plots::{LineChart, Series, Style};
use serde_json::json;

use crate::benchmarks::depth_sph::common_cases::{basal_law, line_node, step_flow_until};
use crate::benchmarks::{Benchmark, BenchmarkOutcome};

/// Benchmark of water that oscillates in a parabolic canal and in a parabolic bowl.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "depth-sph/basin",
    title: "Water that swings in a parabolic canal and bowl, depth-integrated",
    source: "Thacker 1981; sheet: depth-sph §5.3, V10, V11",
    short_seconds: Some(6),
    full_seconds: 30,
    run,
};

/// Gravitational acceleration (m/s²).
const GRAVITY: f64 = 9.81;

/// Checks oscillations in parabolic basins against closed forms, with and without resistance.
fn run(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let mut chart = LineChart::new("Middle of the water in a canal", "time (s)", "x (m)");
    check_frictionless(&mut outcome, &mut chart)?;
    check_linear_resistance(&mut outcome, &mut chart)?;
    check_frictional(&mut outcome, &mut chart)?;
    outcome.svg(
        "V10: water in a parabolic canal, free, damped in proportion to its speed, and with a little friction; closed forms broken.",
        &chart,
    )?;
    check_rotating_surface(&mut outcome, quick)?;
    check_axisymmetric_oscillation(&mut outcome, quick)?;
    Ok(outcome)
}

/// Flow in the canal of V10. It is 100 m from the middle to the shore of the still water and 10 m deep; the water is displaced by 20 m.
fn canal(friction: f64) -> Result<Flow<1>, String> {
    let spacing = 0.5;
    let nodes: Vec<NewNode<1>> = (0..400)
        .map(|k| {
            let x = -100.0 + spacing * (f64::from(k) + 0.5);
            line_node(x + 20.0, 0.0, 10.0 * (1.0 - x * x / 1e4) * spacing, spacing)
        })
        .collect();
    let mut settings = FlowSettings::<1>::single_phase(1000.0);
    settings.frame = DepthFrame::SmallSlope;
    if friction > 0.0 {
        let angle = friction.atan().to_degrees();
        settings.zones =
            vec![BedZone::unbounded(basal_law(json!({ "model": "coulomb", "friction_angle": angle }))?)];
    }
    Flow::new(settings, paraboloid(1e-3, [0.0]), PlanBoundaries::default(), &[nodes])
        .map_err(|failure| failure.to_string())
}

/// Centre of the water (m).
fn water_centre<const D: usize>(flow: &Flow<D>) -> [f64; D] {
    let nodes = &flow.nodes.sets[0].nodes;
    let whole = nodes.total_volume();
    let sum = |c: usize| nodes.position.iter().zip(&nodes.volume).map(|(x, m)| m / whole * x[c]).sum();
    std::array::from_fn(sum)
}

/// Checks V10 (i): the period and the amplitude without friction.
fn check_frictionless(outcome: &mut BenchmarkOutcome, chart: &mut LineChart) -> Result<(), String> {
    let omega = (2.0 * GRAVITY * 10.0).sqrt() / 100.0;
    let period = TAU / omega;
    let mut flow = canal(0.0)?;
    let (mut found, mut crossing) = (vec![(0.0, 20.0)], f64::NAN);
    for k in 1..=200 {
        step_flow_until(&mut flow, period * f64::from(k) / 200.0)?;
        let (before, now) = (found[found.len() - 1], (flow.clock.time, water_centre(&flow)[0]));
        if before.1 < 0.0 && now.1 >= 0.0 {
            crossing = before.0 - before.1 * (now.0 - before.0) / (now.1 - before.1);
        }
        found.push(now);
    }
    let reason = "V10: 1 % of the amplitude in a period";
    for (time, exact) in [(5.0, 15.292_242), (10.0, 3.385_268), (40.0, 15.547_317)] {
        let after = found.partition_point(|(t, _)| *t < time);
        let (a, b) = (found[after - 1], found[after]);
        let place = a.1 + (b.1 - a.1) * (time - a.0) / (b.0 - a.0);
        let name = format!("V10, free: middle after {time} s (m)");
        outcome.assert_within(name, &format!("{exact}"), place, (exact - 0.2, exact + 0.2), reason);
    }
    outcome.assert_close("V10, free: amplitude after a period (m)", 20.0, 0.01, found[200].1, reason);
    let reason = "V10: phase 0.5 %";
    outcome.assert_close(
        "V10, free: second passage of the middle (s)",
        0.75 * period,
        0.005,
        crossing,
        reason,
    );
    let exact = found.iter().map(|(t, _)| (*t, 20.0 * (omega * t).cos())).collect();
    chart.series.push(Series::new("free, Thacker", exact, Style::Dashed));
    chart.series.push(Series::new("free", found, Style::Line));
    Ok(())
}

/// Checks oscillations with a resistance of 0.05/s times the velocity (V10 (ii)). No basal law has it; it is integrated exactly after each
/// step.
fn check_linear_resistance(outcome: &mut BenchmarkOutcome, chart: &mut LineChart) -> Result<(), String> {
    /// Resistance over velocity (1/s).
    const RATE: f64 = 0.05;
    let mut flow = canal(0.0)?;
    let mut found = vec![(0.0, 20.0)];
    for (end, exact) in [(5.0, 15.658_145), (10.0, 5.754_165), (20.0, -10.415_289), (40.0, 4.351_248)] {
        while flow.clock.time < end * (1.0 - 1e-12) {
            let dt = flow.limit().dt.min(end - flow.clock.time);
            flow.advance(dt).map_err(|failure| failure.to_string())?;
            let left = (-RATE * dt).exp();
            flow.nodes.sets[0].nodes.velocity.iter_mut().for_each(|v| v[0] *= left);
            found.push((flow.clock.time, water_centre(&flow)[0]));
        }
        let place = found[found.len() - 1].1;
        let name = format!("V10, damped: middle after {end} s (m)");
        outcome.assert_within(
            name,
            &format!("{exact}"),
            place,
            (exact - 0.2, exact + 0.2),
            "V10: 1 % of the amplitude",
        );
    }
    let square = 2.0 * GRAVITY * 10.0 / 1e4;
    let omega = (square - 0.25 * RATE * RATE).sqrt();
    let closed = |t: f64| {
        20.0 * (-0.5 * RATE * t).exp() * ((omega * t).cos() + 0.5 * RATE / omega * (omega * t).sin())
    };
    let exact = found.iter().map(|(t, _)| (*t, closed(*t))).collect();
    chart.series.push(Series::new("damped, closed form", exact, Style::Dashed));
    chart.series.push(Series::new("damped", found, Style::Line));
    Ok(())
}

/// Checks that friction reduces the amplitude by 5 m in each half period (V10 (iii)).
fn check_frictional(outcome: &mut BenchmarkOutcome, chart: &mut LineChart) -> Result<(), String> {
    let omega = (2.0 * GRAVITY * 10.0).sqrt() / 100.0;
    let mut flow = canal(0.005)?;
    let mut found = vec![(0.0, 20.0)];
    while flow.clock.time < 110.0 {
        let end = flow.clock.time + 0.5;
        step_flow_until(&mut flow, end)?;
        found.push((flow.clock.time, water_centre(&flow)[0]));
    }
    for (number, exact) in [-15.0, 10.0, -5.0, 0.0].into_iter().enumerate() {
        let time = PI / omega * (number + 1) as f64;
        let near = found.iter().filter(|(t, _)| (t - time).abs() < 0.25 * PI / omega);
        let sign = if number % 2 == 0 { -1.0 } else { 1.0 };
        let turn = near.map(|(_, x)| sign * x).fold(f64::MIN, f64::max) * sign;
        let name = format!("V10, friction: turning point {} (m)", number + 1);
        let reason = if number < 3 { "V10: 1 % of the first amplitude" } else { "V10: |X| < 0.3 m" };
        let width = if number < 3 { 0.2 } else { 0.3 };
        outcome.assert_within(name, &format!("{exact}"), turn, (exact - width, exact + width), reason);
    }
    let fastest = flow.nodes.sets[0].nodes.velocity.iter().map(|v| v[0].abs()).fold(0.0, f64::max);
    outcome.assert_below(
        "V10, friction: largest speed at rest (m/s)",
        "0",
        fastest,
        0.0,
        "V10: exactly zero",
    );
    chart.series.push(Series::new("friction", found, Style::Line));
    Ok(())
}

/// Flow in a bowl, 10 m from the middle to the shore of the still water and 1 m deep, with a depth and a velocity at each position.
fn bowl(quick: bool, state: impl Fn([f64; 2]) -> (f64, [f64; 2])) -> Result<Flow<2>, String> {
    let spacing = if quick { 0.3 } else { 0.25 };
    let mut nodes = Vec::new();
    let count = (14.0 / spacing) as i32;
    for i in -count..count {
        for j in -count..count {
            let position = [spacing * (f64::from(i) + 0.5), spacing * (f64::from(j) + 0.5)];
            let (height, velocity) = state(position);
            if height > 0.0 {
                let volume = height * spacing * spacing;
                nodes.push(NewNode {
                    body: 0,
                    position,
                    velocity,
                    volume,
                    length: 1.3 * spacing,
                    scale: 1.69,
                });
            }
        }
    }
    let mut settings = FlowSettings::<2>::single_phase(1000.0);
    settings.frame = DepthFrame::SmallSlope;
    Flow::new(settings, paraboloid(0.01, [0.0; 2]), PlanBoundaries::default(), &[nodes])
        .map_err(|failure| failure.to_string())
}

/// Depth at a position, by the SPH sum over the nodes (m).
fn depth(flow: &Flow<2>, x: [f64; 2]) -> f64 {
    let nodes = &flow.nodes.sets[0].nodes;
    let each = nodes.position.iter().zip(&nodes.volume).zip(&nodes.length);
    let near =
        each.map(|((y, m), l)| (m, (x[0] - y[0]).hypot(x[1] - y[1]), l)).filter(|(_, r, l)| r < &(2.0 * *l));
    near.map(|(m, r, l)| m * Kernel::CubicSpline.value::<2>(r, *l)).sum()
}

/// Mean difference of the depth from `exact` at 500 positions within `radius` (m) of `centre` (m).
fn error(flow: &Flow<2>, centre: [f64; 2], radius: f64, exact: impl Fn([f64; 2]) -> f64) -> f64 {
    let golden = PI * (3.0 - 5f64.sqrt());
    let at = |k: i32| {
        let (r, angle) = (radius * ((f64::from(k) + 0.5) / 500.0).sqrt(), golden * f64::from(k));
        let x = [centre[0] + r * angle.cos(), centre[1] + r * angle.sin()];
        (depth(flow, x) - exact(x)).abs()
    };
    (0..500).map(at).sum::<f64>() / 500.0
}

/// Checks that the surface of water in a bowl remains plane and rotates (V11).
fn check_rotating_surface(outcome: &mut BenchmarkOutcome, quick: bool) -> Result<(), String> {
    let (omega, away) = ((2.0 * GRAVITY).sqrt() / 10.0, 2.0);
    let still = move |x: [f64; 2], centre: [f64; 2]| {
        (1.0 - ((x[0] - centre[0]).powi(2) + (x[1] - centre[1]).powi(2)) / 100.0).max(0.0)
    };
    let mut flow = bowl(quick, |x| (still(x, [away, 0.0]), [0.0, away * omega]))?;
    let period = TAU / omega;
    let (mut angle, mut turned, mut path) = (0.0f64, 0.0f64, Vec::new());
    for k in 1..=40 {
        step_flow_until(&mut flow, period * f64::from(k) / 40.0)?;
        let [x, y] = water_centre(&flow);
        let now = y.atan2(x);
        turned += (now - angle + PI).rem_euclid(TAU) - PI;
        angle = now;
        path.push((x, y));
    }
    let reason = "V11: period 1 %";
    outcome.assert_close("V11, plane surface: turns in a period", 1.0, 0.01, turned / TAU, reason);
    let [x, y] = water_centre(&flow);
    let found = error(&flow, [away, 0.0], 10.0, |x| still(x, [away, 0.0]));
    outcome.assert_below(
        "V11, plane surface: mean error of depth after a period (m)",
        "0",
        found,
        0.02,
        "V11: 2 %",
    );
    let reason = "not judged: the sheet requires period and depth";
    outcome.info("V11, plane surface: distance of the middle from the axis (m)", "2", x.hypot(y), reason);
    let circle =
        (0..=90).map(|k| TAU * f64::from(k) / 90.0).map(|a| (away * a.cos(), away * a.sin())).collect();
    let chart = LineChart {
        series: vec![
            Series::new("Thacker", circle, Style::Dashed),
            Series::new("nodes, 40 times in a period", path, Style::Markers),
        ],
        ..LineChart::new("Middle of the water in a bowl", "x (m)", "y (m)")
    };
    outcome.svg("V11: the middle of water with a plane surface goes round in a circle.", &chart)
}

/// Checks the axisymmetric oscillation of water in a bowl (V11).
fn check_axisymmetric_oscillation(outcome: &mut BenchmarkOutcome, quick: bool) -> Result<(), String> {
    let (omega, a) = ((8.0 * GRAVITY).sqrt() / 10.0, 0.25f64);
    let root = (1.0 - a * a).sqrt();
    let height = move |x: [f64; 2], t: f64| {
        let q = 1.0 - a * (omega * t).cos();
        (root / q - (x[0] * x[0] + x[1] * x[1]) / 100.0 * (1.0 - a * a) / (q * q)).max(0.0)
    };
    let mut flow = bowl(quick, |x| (height(x, 0.0), [0.0; 2]))?;
    let period = TAU / omega;
    let (mut found, mut low) = (vec![(0.0, depth(&flow, [0.0; 2]))], (0.0, f64::INFINITY));
    for k in 1..=40 {
        step_flow_until(&mut flow, period * f64::from(k) / 40.0)?;
        let now = (flow.clock.time, depth(&flow, [0.0; 2]));
        if now.1 < low.1 {
            low = now;
        }
        found.push(now);
    }
    let reason = "V11: 2 % of the still depth";
    for (k, exact) in [(10, 0.968_246), (20, 0.774_597), (40, 1.290_994)] {
        let name = format!("V11, round surface: depth in the middle after {}/4 of a period (m)", k / 10);
        outcome.assert_within(name, &format!("{exact}"), found[k].1, (exact - 0.02, exact + 0.02), reason);
    }
    let exact = |x: [f64; 2]| height(x, period);
    let mean = error(&flow, [0.0; 2], 8.801_117, exact);
    outcome.assert_below(
        "V11, round surface: mean error of depth after a period (m)",
        "0",
        mean,
        0.02,
        "V11: 2 %",
    );
    // The lowest level lies at half of the period; a parabola through its neighbours.
    let at = found.iter().position(|now| now.0 == low.0).unwrap_or(1).clamp(1, found.len() - 2);
    let (a, b, c) = (found[at - 1].1, found[at].1, found[at + 1].1);
    let time = found[at].0 + period / 40.0 * 0.5 * (a - c) / (a - 2.0 * b + c);
    outcome.assert_close(
        "V11, round surface: twice the time to the lowest level (s)",
        period,
        0.01,
        2.0 * time,
        "V11: 1 %",
    );
    let exact = (0..=100).map(|k| period * f64::from(k) / 100.0).map(|t| (t, height([0.0; 2], t))).collect();
    let chart = LineChart {
        series: vec![
            Series::new("Thacker", exact, Style::Dashed),
            Series::new("nodes", found, Style::Markers),
        ],
        ..LineChart::new("Depth in the middle of a bowl", "time (s)", "depth (m)")
    };
    outcome.svg("V11: water with a round surface rises and falls in the middle.", &chart)
}
