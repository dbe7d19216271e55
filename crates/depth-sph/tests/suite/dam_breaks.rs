//! Dam breaks against their closed forms, in few nodes.

use colluvium_constitutive::basal::BasalSpec;
use colluvium_depth_sph::analytical_solutions::{Stoker, ritter};
use colluvium_depth_sph::bed::Bed;
use colluvium_depth_sph::config::choices::{Phases, ThicknessEquation};
use colluvium_depth_sph::config::settings::{BedZone, FlowSettings, Mixture};
use colluvium_depth_sph::flow::{Flow, PlanBoundaries};
use colluvium_depth_sph::laws::interphase_drag::{InterphaseDrag, MixtureDensities};
use colluvium_depth_sph::points::phase_nodes::NewNode;

use crate::flow_runs::advance_flow_to;

/// Nodes of depth `depth` every `spacing` from `from` to `to`.
fn layer(from: f64, to: f64, spacing: f64, depth: f64) -> Vec<NewNode<1>> {
    let count = ((to - from) / spacing).round() as usize;
    (0..count)
        .map(|k| NewNode {
            body: 0,
            position: [from + spacing * (k as f64 + 0.5)],
            velocity: [0.0],
            volume: depth * spacing,
            length: 1.5 * spacing,
            scale: 1.5,
        })
        .collect()
}

#[test]
fn dam_break_on_a_dry_bed_follows_ritter() {
    let ends = PlanBoundaries { walls: [[Some(-20.0), None]], ..PlanBoundaries::default() };
    let nodes = layer(-20.0, 0.0, 0.05, 10.0);
    let mut flow = Flow::new(FlowSettings::single_phase(1000.0), Bed::Flat(0.0), ends, &[nodes]).unwrap();
    let volume = flow.nodes.sets[0].nodes.total_volume();
    advance_flow_to(&mut flow, 1.0);
    let nodes = &flow.nodes.sets[0].nodes;
    assert_eq!(nodes.total_volume(), volume);
    let (mut error, mut count) = (0.0, 0);
    for (x, h) in nodes.position.iter().zip(&nodes.partial_thickness) {
        if x[0] < 10.0 {
            error += (h - ritter(9.81, 10.0, x[0], 1.0).0).abs() / 10.0;
            count += 1;
        }
    }
    error /= f64::from(count);
    println!("ritter {error}");
    assert!(error < 0.006, "{error}");
}

/// Mean error of the depth one second after a dam break of 1 m of water over 0.5 m, and the mean velocity between the
/// waves over the exact one.
fn bore(continuity: ThicknessEquation) -> (f64, f64) {
    let exact = Stoker::new(9.81, 1.0, 0.5);
    let ends = PlanBoundaries { walls: [[Some(-5.0), Some(5.0)]], ..PlanBoundaries::default() };
    let mut nodes = layer(-5.0, 0.0, 0.02, 1.0);
    nodes.extend(layer(0.0, 5.0, 0.02, 0.5));
    let mut settings = FlowSettings::single_phase(1000.0);
    settings.numerics.continuity = continuity;
    let mut flow = Flow::new(settings, Bed::Flat(0.0), ends, &[nodes]).unwrap();
    advance_flow_to(&mut flow, 1.0);
    let nodes = &flow.nodes.sets[0].nodes;
    let mut error = 0.0;
    for (x, h) in nodes.position.iter().zip(&nodes.partial_thickness) {
        error += (h - exact.state_at(x[0], 1.0).0).abs();
    }
    error /= nodes.len() as f64;
    let between: Vec<usize> =
        (0..nodes.len()).filter(|&i| (-1.4..2.6).contains(&nodes.position[i][0])).collect();
    let mean = between.iter().map(|&i| nodes.velocity[i][0]).sum::<f64>() / between.len() as f64;
    println!("stoker {continuity:?} {error} {}", mean / exact.velocity);
    (error, mean / exact.velocity)
}

#[test]
fn dam_break_on_a_wet_bed_follows_stoker() {
    let (error, velocity) = bore(ThicknessEquation::Summation);
    assert!(error < 0.015, "{error}");
    assert!((velocity - 1.0).abs() < 0.015, "{velocity}");
}

#[test]
fn each_rate_of_height_carries_the_bore_of_stoker() {
    for continuity in
        [ThicknessEquation::RateBasic, ThicknessEquation::RateDifference, ThicknessEquation::RateVolume]
    {
        let (error, velocity) = bore(continuity);
        assert!(error < 0.015, "{continuity:?}: {error}");
        assert!((velocity - 1.0).abs() < 0.015, "{continuity:?}: {velocity}");
    }
}

/// Water that leaves its grains: the grains rest by their friction, and the water that has left flows as water does.
#[test]
fn fluid_flows_out_of_grains_at_rest_with_conserved_volumes() {
    let mut settings = FlowSettings::single_phase(1000.0);
    settings.phases = Phases::Two;
    let densities = MixtureDensities { grain: 2600.0, fluid: 1000.0, gravity: 9.81 };
    settings.material = Mixture { densities, porosity: 0.4, is_saturated: true };
    settings.drag = InterphaseDrag::Anderson { settling_velocity: 2.0.into(), exponent: 1.0 };
    let spec = serde_json::json!({ "model": "coulomb", "friction_angle": 50 });
    let spec: BasalSpec = serde_json::from_value(spec).unwrap();
    settings.zones = vec![BedZone::unbounded(Some(spec.build().unwrap()))];
    let ends = PlanBoundaries { walls: [[Some(0.0), None]], ..PlanBoundaries::default() };
    let sets = [layer(0.0, 5.0, 0.05, 0.3), layer(0.0, 5.0, 0.05, 1.0)];
    let mut flow = Flow::new(settings, Bed::Flat(0.0), ends, &sets).unwrap();
    let volumes = [0, 1].map(|set| flow.nodes.sets[set].nodes.total_volume());
    advance_flow_to(&mut flow, 2.0);
    let front = |set: usize| flow.nodes.sets[set].nodes.position.iter().map(|x| x[0]).fold(0.0, f64::max);
    let [grains, water] = [front(0), front(1)];
    assert!(water > grains + 3.0, "the water is ahead: {grains} {water}");
    assert_eq!([0, 1].map(|set| flow.nodes.sets[set].nodes.total_volume()), volumes);
    let nodes = &flow.nodes.sets[1].nodes;
    let last = (0..nodes.len()).find(|i| nodes.position[*i][0] == water).unwrap();
    let [own, all] = [nodes.partial_thickness[last], nodes.depth[last]];
    assert!(all < 1.1 * own, "water alone: {own} m of {all} m");
    assert!(
        flow.nodes.sets[0]
            .nodes
            .depth
            .iter()
            .chain(&nodes.depth)
            .all(|depth| depth.is_finite() && *depth > 0.0)
    );
}
