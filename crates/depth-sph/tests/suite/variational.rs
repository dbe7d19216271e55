//! Variational pressure forces, derived from an energy (sheet: depth-sph §3.4, row 52).

use colluvium_case::Method;
use colluvium_depth_sph::DepthSph;
use colluvium_depth_sph::analytical_solutions::ritter;
use colluvium_depth_sph::bed::Bed;
use colluvium_depth_sph::config::choices::PressureForceForm;
use colluvium_depth_sph::config::settings::FlowSettings;
use colluvium_depth_sph::flow::{Flow, PlanBoundaries};
use colluvium_depth_sph::points::phase_nodes::NewNode;
use colluvium_testkit::read_case;
use serde_json::json;

use crate::flow_runs::advance_flow_to;

fn settings<const D: usize>(momentum: PressureForceForm, viscosity: f64) -> FlowSettings<D> {
    let mut settings = FlowSettings::single_phase(1000.0);
    settings.numerics.momentum = momentum;
    settings.numerics.viscosity = (viscosity, 0.0);
    settings
}

fn node(x: f64, volume: f64, spacing: f64) -> NewNode<1> {
    NewNode { body: 0, position: [x], velocity: [0.0], volume, length: 1.5 * spacing, scale: 1.5 }
}

#[test]
fn variational_forces_conserve_momentum_to_round_off() {
    let mut nodes = Vec::new();
    for i in 0..30 {
        for j in 0..20 {
            let [x, y] = [
                0.1 * f64::from(i) + 0.003 * f64::from(j % 7),
                0.1 * f64::from(j) + 0.004 * f64::from(i % 5),
            ];
            let depth = 0.3 + 0.2 * x + 0.1 * (3.0 * y).sin();
            let (position, volume) = ([x, y], 0.01 * depth);
            nodes.push(NewNode { body: 0, position, velocity: [0.0; 2], volume, length: 0.13, scale: 1.69 });
        }
    }
    let mut flow = Flow::new(
        settings::<2>(PressureForceForm::Variational, 1.0),
        Bed::Flat(0.0),
        PlanBoundaries::default(),
        &[nodes],
    )
    .unwrap();
    advance_flow_to(&mut flow, 0.3);
    let nodes = &flow.nodes.sets[0].nodes;
    let size: f64 =
        (0..nodes.len()).map(|i| nodes.volume[i] * nodes.velocity[i][0].hypot(nodes.velocity[i][1])).sum();
    assert!(size > 0.1, "it flows: {size}");
    for c in 0..2 {
        let sum: f64 = (0..nodes.len()).map(|i| nodes.volume[i] * nodes.velocity[i][c]).sum();
        assert!(sum.abs() < 1e-12 * size, "{sum} of {size}");
    }
}

/// Largest change of the energy of sloshing without friction over three periods, over its largest kinetic energy.
fn energy_lost(momentum: PressureForceForm) -> f64 {
    let (half, spacing) = (5.0, 0.1);
    let ends = PlanBoundaries { walls: [[Some(-half), Some(half)]], ..PlanBoundaries::default() };
    let nodes = (0..100).map(|k| {
        let x = -half + spacing * (f64::from(k) + 0.5);
        let depth = 1.0 + 0.1 * (std::f64::consts::PI * (x + half) / (2.0 * half)).cos();
        node(x, depth * spacing, spacing)
    });
    let mut flow = Flow::new(settings::<1>(momentum, 0.0), Bed::Flat(0.0), ends, &[nodes.collect()]).unwrap();
    let first = flow.totals(0).potential;
    let (mut largest_kinetic, mut off) = (0.0f64, 0.0f64);
    while flow.clock.time < 3.0 * 4.0 * half / 9.81f64.sqrt() {
        flow.advance(0.005).unwrap();
        let totals = flow.totals(0);
        largest_kinetic = largest_kinetic.max(totals.kinetic);
        off = off.max((totals.kinetic + totals.potential - first).abs());
    }
    off / largest_kinetic
}

#[test]
fn variational_forces_conserve_the_energy_of_a_slosh_better_than_symmetric_ones() {
    let [variational, plain] =
        [PressureForceForm::Variational, PressureForceForm::Symmetric].map(energy_lost);
    println!("energy: {variational} and {plain}");
    // 0.5 and 2.3 % were found.
    assert!(variational < 0.5 * plain, "{variational} and {plain}");
}

#[test]
fn a_lake_on_a_level_bed_stays_at_rest() {
    let ends = PlanBoundaries { walls: [[Some(-5.0), Some(5.0)]], ..PlanBoundaries::default() };
    let nodes = (0..100).map(|k| node(-5.0 + 0.1 * (f64::from(k) + 0.5), 0.1, 0.1));
    let mut flow = Flow::new(
        settings::<1>(PressureForceForm::Variational, 1.0),
        Bed::Flat(0.0),
        ends,
        &[nodes.collect()],
    )
    .unwrap();
    advance_flow_to(&mut flow, 10.0);
    let fastest = flow.nodes.sets[0].nodes.velocity.iter().map(|v| v[0].abs()).fold(0.0, f64::max);
    assert!(fastest < 1e-10 * 9.81f64.sqrt(), "V12: {fastest}");
}

#[test]
fn dam_break_on_a_dry_bed_follows_ritter() {
    let ends = PlanBoundaries { walls: [[Some(-20.0), None]], ..PlanBoundaries::default() };
    let nodes = (0..400).map(|k| node(-20.0 + 0.05 * (f64::from(k) + 0.5), 0.5, 0.05));
    let mut flow = Flow::new(
        settings::<1>(PressureForceForm::Variational, 1.0),
        Bed::Flat(0.0),
        ends,
        &[nodes.collect()],
    )
    .unwrap();
    advance_flow_to(&mut flow, 1.0);
    let nodes = &flow.nodes.sets[0].nodes;
    let near = nodes.position.iter().zip(&nodes.partial_thickness).filter(|(x, _)| x[0] < 10.0);
    let errors: Vec<f64> = near.map(|(x, h)| (h - ritter(9.81, 10.0, x[0], 1.0).0).abs() / 10.0).collect();
    let error = errors.iter().sum::<f64>() / errors.len() as f64;
    println!("ritter {error}");
    assert!(error < 0.006, "V5: {error}");
    // Heights and smoothing lengths are consistent.
    for i in 0..nodes.len() {
        let (shortest, longest) = (0.5 * nodes.first_length[i], 50.0 * nodes.first_length[i]);
        let kept = nodes.length[i] * nodes.partial_thickness[i] / (nodes.scale[i] * nodes.volume[i]);
        assert!(
            nodes.length[i] == shortest || nodes.length[i] == longest || (kept - 1.0).abs() < 1e-9,
            "node {i}: {kept}"
        );
    }
}

#[test]
fn unsupported_combinations_with_variational_momentum_are_refused_by_path() {
    let case = json!({
        "title": "slosh", "space": "plane-strain", "domain": { "min": [0, 0], "max": [10, 2] }, "gravity": [0, -9.81],
        "materials": { "water": {
            "model": "mohr-coulomb", "density": 1000, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 30
        } },
        "bodies": [{ "name": "pond", "material": "water", "shape": { "kind": "box", "min": [0, 0], "max": [10, 1] } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }],
        "stages": [{ "name": "wave", "duration": 3 }],
        "methods": { "depth-sph": { "spacing": 0.1, "momentum": "variational" } }
    });
    let plan = |case: &serde_json::Value| DepthSph.plan(&read_case(case)).map(|_| ());
    plan(&case).unwrap();
    let mut other = case;
    other["methods"]["depth-sph"]["continuity"] = json!("rate-volume");
    let refused = plan(&other).unwrap_err().to_string();
    assert!(refused.starts_with("methods.depth-sph.momentum: `variational`"), "{refused}");
}
