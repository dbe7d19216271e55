//! Energy on rough terrain: frictionless thin layers down rough slopes and steps (sheet: depth-sph §0, energy on rough terrain).

use std::sync::Arc;

use colluvium::depth_sph::bed::test_terrain::{RoughSlope, step_profile};
use colluvium::depth_sph::bed::{Bed, TerrainBed};
use colluvium::depth_sph::config::choices::Metric;
use colluvium::depth_sph::config::settings::{BedZone, FlowSettings};
use colluvium::depth_sph::flow::{Flow, PlanBoundaries};
use colluvium::depth_sph::points::phase_nodes::NewNode;
use colluvium::points::Raster;
use serde_json::json;

use crate::benchmarks::depth_sph::common_cases::{basal_law, step_flow_until, step_with_limit};
use crate::benchmarks::{Benchmark, BenchmarkOutcome};

/// Benchmark of the energy of flows over rough terrain.
pub const BENCHMARK: Benchmark = Benchmark {
    id: "depth-sph/rough-terrain",
    title: "Energy of flows over rough terrain",
    source: "energy of what slides without friction; sheet: depth-sph §0, test terrain",
    short_seconds: Some(20),
    full_seconds: 60,
    run,
};

/// Gravitational acceleration (m/s²).
const GRAVITY: f64 = 9.81;
/// Seed of the waves of the rough slope.
const SEED: u64 = 20_261_128;

/// Checks the energy that frictionless layers keep on rough slopes and over steps.
fn run(quick: bool) -> Result<BenchmarkOutcome, String> {
    let mut outcome = BenchmarkOutcome::default();
    let spacing = if quick { 5.0 } else { 2.5 };
    let rough = |lengths: [f64; 2], rms: f64| {
        let slope = RoughSlope::new(30f64.to_radians().tan(), 80.0, lengths, rms, SEED);
        slope.raster([0.0, 0.0], [700.0, 200.0], 5.0)
    };
    let steps =
        |angle: f64| Raster::from_function([101, 41], [0.0; 2], [5.0; 2], step_profile(150.0, 20.0, angle));
    for (name, raster) in [
        ("30° slope, rms slope 0.1", rough([40.0, 200.0], 0.1)),
        ("30° slope, rms slope 0.2", rough([20.0, 200.0], 0.2)),
        ("step of 20 m at 45°", steps(45.0)),
        ("step of 20 m at 60°", steps(60.0)),
    ] {
        slide(&mut outcome, name, &raster, spacing)?;
    }
    order(&mut outcome, &rough([20.0, 200.0], 0.2))?;
    check_frictional_layer(&mut outcome, &rough([20.0, 200.0], 0.2), spacing)?;
    lake(&mut outcome)?;
    Ok(outcome)
}

/// Bed of a raster with one averaging pass over its levels, the default.
fn bed(raster: &Raster) -> Result<Bed<2>, String> {
    let ground = TerrainBed::new(TerrainBed::smoothed(raster, 1)).map_err(|error| error.to_string())?;
    Ok(Bed::Surface(Arc::new(ground)))
}

/// Nodes of a layer of `depth` (m) over a rectangle.
fn layer(low: [f64; 2], high: [f64; 2], spacing: f64, depth: impl Fn([f64; 2]) -> f64) -> Vec<NewNode<2>> {
    let counts = [0, 1].map(|c| ((high[c] - low[c]) / spacing).round() as usize);
    let place = |k: usize| {
        let [i, j] = [k % counts[0], k / counts[0]];
        [low[0] + spacing * (i as f64 + 0.5), low[1] + spacing * (j as f64 + 0.5)]
    };
    let node = |position: [f64; 2]| NewNode {
        body: 0,
        position,
        velocity: [0.0; 2],
        volume: depth(position) * spacing * spacing,
        length: 1.3 * spacing,
        scale: 1.69,
    };
    (0..counts[0] * counts[1]).map(place).filter(|x| depth(*x) > 0.0).map(node).collect()
}

/// Checks the energy of a frictionless layer of 0.05 m until its first node is near the end of the terrain.
fn slide(outcome: &mut BenchmarkOutcome, name: &str, raster: &Raster, spacing: f64) -> Result<(), String> {
    let end = raster.last_node_position()[0] - 30.0;
    let bed = bed(raster)?;
    let nodes = layer([20.0, 80.0], [60.0, 120.0], spacing, |_| 0.05);
    let mut flow = Flow::new(FlowSettings::single_phase(1000.0), bed, PlanBoundaries::default(), &[nodes])
        .map_err(|f| f.to_string())?;
    let mut origins: Vec<(u64, f64)> = Vec::new();
    for (id, x) in flow.nodes.sets[0].nodes.id.iter().zip(&flow.nodes.sets[0].nodes.position) {
        origins.push((*id, flow.bed_below(x).level));
    }
    origins.sort_by_key(|one| one.0);
    let (mut worst, mut largest) = (1.0f64, 0.0f64);
    loop {
        let next = flow.clock.time + 0.5;
        step_flow_until(&mut flow, next)?;
        let nodes = &flow.nodes.sets[0].nodes;
        if nodes.position.iter().any(|x| x[0] > end) || flow.records.removed_nodes > 0 {
            break;
        }
        let ratio = |i: usize| {
            let here = flow.bed_below(&nodes.position[i]);
            let first = origins[origins.binary_search_by_key(&nodes.id[i], |one| one.0).unwrap_or(0)].1;
            0.5 * here.speed(&nodes.velocity[i]).powi(2) / (GRAVITY * (first - here.level).max(20.0))
        };
        let fallen = (0..nodes.len()).all(|i| nodes.position[i][0] > 100.0);
        if !fallen {
            continue;
        }
        let ratios: Vec<f64> = (0..nodes.len()).map(ratio).collect();
        let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
        if (mean - 1.0).abs() > (worst - 1.0).abs() {
            worst = mean;
        }
        largest = ratios.into_iter().fold(largest, f64::max);
    }
    let reason = "sheet: depth-sph §0, test terrain: 0.3 % for the mean, 3 % for any node";
    outcome.assert_close(
        format!("{name}: v²/2 over g ΔZ, mean of the nodes when it is worst"),
        1.0,
        0.003,
        worst,
        reason,
    );
    outcome.assert_below(format!("{name}: v²/2 over g ΔZ, largest of any node"), "1", largest, 1.03, reason);
    account(outcome, name, &flow)
}

/// Checks that the energy balance of a flow closes.
fn account(outcome: &mut BenchmarkOutcome, name: &str, flow: &Flow<2>) -> Result<(), String> {
    let account = flow.energy_balance_summary();
    let off = account.error.abs() / account.exchanged_energy;
    let reason = "sheet: depth-sph §0, test terrain: 1e-4 of the exchanged energy";
    outcome.assert_below(format!("{name}: error of the account of energy"), "0", off, 1e-4, reason);
    Ok(())
}

/// Checks the order of convergence of the position of a single node, with steps that are halved.
fn order(outcome: &mut BenchmarkOutcome, raster: &Raster) -> Result<(), String> {
    let place = |dt: f64| -> Result<[f64; 2], String> {
        let mut settings = FlowSettings::<2>::single_phase(1000.0);
        (settings.numerics.variable_length, settings.numerics.viscosity) = (false, (0.0, 0.0));
        let node = NewNode {
            body: 0,
            position: [40.0, 100.0],
            velocity: [0.0; 2],
            volume: 1.0,
            length: 20.0,
            scale: 1.69,
        };
        let mut flow = Flow::new(settings, bed(raster)?, PlanBoundaries::default(), &[vec![node]])
            .map_err(|f| f.to_string())?;
        while flow.clock.time < 10.0 - 1e-9 {
            flow.advance(dt).map_err(|failure| failure.to_string())?;
        }
        Ok(flow.nodes.sets[0].nodes.position[0])
    };
    let exact = place(0.1 / 128.0)?;
    let mut errors = Vec::new();
    for dt in [0.1, 0.05, 0.025, 0.0125] {
        let found = place(dt)?;
        errors.push((found[0] - exact[0]).hypot(found[1] - exact[1]));
    }
    let order = (errors[1] / errors[3]).log2() / 2.0;
    outcome.assert_close(
        "order in time of the place of a node alone",
        2.0,
        0.075,
        order,
        "sheet: depth-sph §0: 2 ± 0.15",
    );
    Ok(())
}

/// Checks the energy balance of a layer with friction.
fn check_frictional_layer(
    outcome: &mut BenchmarkOutcome,
    raster: &Raster,
    spacing: f64,
) -> Result<(), String> {
    let mut settings = FlowSettings::<2>::single_phase(1000.0);
    let spec = json!({ "model": "voellmy", "friction_angle": 12, "turbulence": 2000 });
    settings.zones = vec![BedZone::unbounded(basal_law(spec)?)];
    let nodes = layer([20.0, 80.0], [60.0, 120.0], spacing, |_| 0.5);
    let mut flow =
        Flow::new(settings, bed(raster)?, PlanBoundaries::default(), &[nodes]).map_err(|f| f.to_string())?;
    step_flow_until(&mut flow, 12.0)?;
    let account = flow.energy_balance_summary();
    let off = account.error.abs() / account.exchanged_energy;
    let reason = "shown: with friction, which is split off at first order in time";
    outcome.info("rms slope 0.2 with friction: error of the account of energy", "0", off, reason);
    let lost = flow.records.energy_balance.friction / account.exchanged_energy;
    outcome.info("rms slope 0.2 with friction: share that friction takes", "", lost, "shown");
    Ok(())
}

/// Checks that a lake in a rough bowl comes to rest at least as well as with unmodified gradients.
fn lake(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let waves = RoughSlope::new(0.0, -200.0, [20.0, 100.0], 0.2, SEED);
    let level = |x: f64, y: f64| 0.004 * (x * x + y * y) + waves.level(x, y);
    let raster = Raster::from_function([61, 61], [-150.0; 2], [5.0; 2], level);
    let mut found = Vec::new();
    for metric in [Metric::Vertical, Metric::Blended, Metric::Normal] {
        let bed = bed(&raster)?;
        let depth = |x: [f64; 2]| bed.bed_point(&x).map_or(0.0, |bed| 30.0 - bed.level);
        let nodes = layer([-140.0; 2], [140.0; 2], 4.0, depth);
        let mut settings = FlowSettings::<2>::single_phase(1000.0);
        settings.metric = metric;
        let mut flow = Flow::new(settings, bed.clone(), PlanBoundaries::default(), &[nodes])
            .map_err(|f| f.to_string())?;
        step_with_limit(&mut flow, 0.1, 10.0)?;
        let nodes = &flow.nodes.sets[0].nodes;
        let square = |i: usize| flow.bed_below(&nodes.position[i]).speed(&nodes.velocity[i]).powi(2);
        let mean = (0..nodes.len()).map(square).sum::<f64>() / nodes.len() as f64;
        found.push(mean.sqrt());
    }
    let reason = "the default is no faster than gradients as they are, by a tenth for scatter";
    outcome.assert_below(
        "lake on a rough bowl after 10 s: speed (m/s, root mean square)",
        "0",
        found[1],
        1.1 * found[0],
        reason,
    );
    outcome.info("the same with metric vertical", "0", found[0], "shown");
    outcome.info("the same with metric normal", "0", found[2], "shown");
    Ok(())
}
