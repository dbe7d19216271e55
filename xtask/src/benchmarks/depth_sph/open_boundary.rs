//! Waves that leave through the end of a channel (sheet: depth-sph §3.9, §5.5, V27).

use colluvium::depth_sph::bed::Bed;
use colluvium::depth_sph::config::settings::FlowSettings;
use colluvium::depth_sph::flow::{Flow, PlanBoundaries};
use colluvium::depth_sph::points::phase_nodes::NewNode;
use colluvium::plots::{Series, Style};

use crate::benchmarks::depth_sph::common_cases::{chart, step_flow_until};
use crate::benchmarks::{Benchmark, BenchmarkOutcome};

/// Benchmark of waves that leave a channel through an open end.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "depth-sph/open-end",
    title: "Waves that leave through an open end, depth-integrated",
    source: "sheet: depth-sph §5.5, V27, and §0 for the channel",
    short_seconds: Some(4),
    full_seconds: 10,
    run,
};

/// Gravitational acceleration (m/s²).
const GRAVITY: f64 = 9.81;
/// Length of the channel (m).
const LENGTH: f64 = 40.0;
/// Times (s) at which the incoming and the reflected wave are evaluated. The hump is then at 31 m, and would be at 30.6 m after reflection.
const TIMES: [f64; 2] = [2.0, 7.8];

/// Checks the share of a wave that an open end of a channel reflects, in water at rest and in a rapid stream.
fn run(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let spacing = if quick { 0.05 } else { 0.025 };
    let mut shown =
        chart("What has come back after 7.8 s, over the height that arrived", "depth less that at rest");
    let (wall, _) = reflected_wave(channel(1e-3, 0.0, spacing, [true; 2])?)?;
    outcome.assert_within(
        "V27, wall: share that comes back",
        "all",
        wall,
        (0.95, 1.05),
        "V27: 95 % at least",
    );
    for (height, name) in [(1e-3, "hump"), (-1e-3, "trough")] {
        let mut flow = channel(height, 0.0, spacing, [true, false])?;
        flow.open_end(LENGTH, 1.0, spacing).map_err(|failure| failure.to_string())?;
        let (open, profile) = reflected_wave(flow)?;
        let label = format!("V27, open end, {name}: share that comes back");
        outcome.assert_below(label, "0", open, 0.02, "V27: 2 %");
        shown.series.push(Series::new(name, profile, Style::Line));
    }
    // Froude number 1.6, with nothing behind the hump, so that its tail stays away from the window.
    let mut flow = channel(1e-3, 5.0, spacing, [false; 2])?;
    flow.open_end(LENGTH, 1.0, spacing).map_err(|failure| failure.to_string())?;
    step_flow_until(&mut flow, 2.2)?;
    let nodes = &flow.nodes.sets[0].nodes;
    let inside = nodes.position.iter().zip(&nodes.velocity).filter(|(x, _)| (30.0..39.0).contains(&x[0]));
    let off = inside.map(|(_, v)| (v[0] - 5.0).abs()).fold(0.0, f64::max) / (1e-3 * GRAVITY.sqrt());
    outcome.assert_below(
        "V27, rapid stream: largest speed that is not its own, over that of the hump",
        "0",
        off,
        0.02,
        "V27: no reflection; 2 % as of the hump at rest",
    );
    outcome.svg("V27: flow that remains in the channel, between 12 and 38 m.", &shown)?;
    Ok(outcome)
}

/// Channel with water 1 m deep and a hump 2 m wide of `height` (m) at 25 m that moves to the right on a stream of `speed` (m/s), with or
/// without walls at its ends.
fn channel(height: f64, speed: f64, spacing: f64, walls: [bool; 2]) -> Result<Flow<1>, String> {
    let celerity = |depth: f64| (GRAVITY * depth).sqrt();
    let count = (LENGTH / spacing).round() as usize;
    let nodes = (0..count).map(|k| {
        let x = spacing * (k as f64 + 0.5);
        let depth = 1.0 + height * (-(x - 25.0).powi(2)).exp();
        NewNode {
            body: 0,
            position: [x],
            velocity: [speed + 2.0 * (celerity(depth) - celerity(1.0))],
            volume: depth * spacing,
            length: 1.5 * spacing,
            scale: 1.5,
        }
    });
    let [low, high] = walls;
    let ends =
        PlanBoundaries { walls: [[low.then_some(0.0), high.then_some(LENGTH)]], ..PlanBoundaries::default() };
    let mut settings = FlowSettings::single_phase(1000.0);
    settings.numerics.viscosity = (0.0, 0.0);
    Flow::new(settings, Bed::Flat(0.0), ends, &[nodes.collect()]).map_err(|failure| failure.to_string())
}

/// Reflected height over the incoming height, and its profile between 12 and 38 m relative to the incoming height.
fn reflected_wave(mut flow: Flow<1>) -> Result<(f64, Vec<(f64, f64)>), String> {
    // Sums over this lattice have an error of 0.4 %.
    let nodes = &flow.nodes.sets[0].nodes;
    let far = nodes.position.iter().position(|x| (x[0] - 7.5).abs() < 0.1).ok_or("no node at 7.5 m")?;
    let still = nodes.depth[far];
    let profile = |flow: &Flow<1>| {
        let nodes = &flow.nodes.sets[0].nodes;
        let all = nodes.position.iter().zip(&nodes.depth).map(|(x, depth)| (x[0], depth - still));
        let mut inside: Vec<(f64, f64)> = all.filter(|(x, _)| (12.0..38.0).contains(x)).collect();
        inside.sort_by(|a, b| a.0.total_cmp(&b.0));
        inside
    };
    let largest = |profile: &[(f64, f64)]| profile.iter().map(|(_, off)| off.abs()).fold(0.0, f64::max);
    step_flow_until(&mut flow, TIMES[0])?;
    let arriving = largest(&profile(&flow));
    step_flow_until(&mut flow, TIMES[1])?;
    let left: Vec<(f64, f64)> = profile(&flow).into_iter().map(|(x, off)| (x, off / arriving)).collect();
    Ok((largest(&left), left))
}
