//! Waves that leave through an open end (sheet: depth-sph §5.5, V27).

use colluvium_case::{Case, Method};
use colluvium_depth_sph::DepthSph;
use colluvium_depth_sph::bed::Bed;
use colluvium_depth_sph::config::choices::Phases;
use colluvium_depth_sph::config::settings::{Consolidation, FlowSettings, Mixture, PoreColumn};
use colluvium_depth_sph::flow::{Flow, Opening, PlanBoundaries};
use colluvium_depth_sph::laws::interphase_drag::{InterphaseDrag, MixtureDensities};
use colluvium_depth_sph::laws::pore_pressure_column::{LowerBound, PressureProfile};
use colluvium_depth_sph::points::phase_nodes::NewNode;
use colluvium_testkit::{hash_after, read_case, refusal};
use serde_json::{Value, json};

use crate::flow_runs::advance_flow_to;

const SPACING: f64 = 0.05;

/// Channel of 40 m, 1 m deep, with a hump 2 m wide of `height` (m) at 25 m that runs to the right on a stream of `speed` (m/s);
/// smoothing lengths of `ratio` spacings.
fn channel(height: f64, speed: f64, ratio: f64, walls: [Option<f64>; 2]) -> Flow<1> {
    let celerity = |depth: f64| (9.81 * depth).sqrt();
    let nodes = (0..800).map(|k| {
        let x = SPACING * (f64::from(k) + 0.5);
        let depth = 1.0 + height * (-(x - 25.0f64).powi(2)).exp();
        NewNode {
            body: 0,
            position: [x],
            velocity: [speed + 2.0 * (celerity(depth) - celerity(1.0))],
            volume: depth * SPACING,
            length: ratio * SPACING,
            scale: ratio,
        }
    });
    let ends = PlanBoundaries { walls: [walls], ..PlanBoundaries::default() };
    let mut settings = FlowSettings::single_phase(1000.0);
    settings.numerics.viscosity = (0.0, 0.0);
    Flow::new(settings, Bed::Flat(0.0), ends, &[nodes.collect()]).unwrap()
}

/// Largest difference of the depth from `still` (m) between 12 and 38 m.
fn amplitude(flow: &Flow<1>, still: f64) -> f64 {
    let nodes = &flow.nodes.sets[0].nodes;
    let inside = nodes.position.iter().zip(&nodes.depth).filter(|(x, _)| (12.0..38.0).contains(&x[0]));
    inside.map(|(_, depth)| (depth - still).abs()).fold(0.0, f64::max)
}

/// Reflected over arriving amplitude: the hump is at 31 m after 2 s, and back at 30.6 m after 7.8 s.
fn reflected(mut flow: Flow<1>) -> f64 {
    // Sums over this lattice are 0.4 % off.
    let still = flow.nodes.sets[0].nodes.depth[150];
    advance_flow_to(&mut flow, 2.0);
    let arriving = amplitude(&flow, still);
    advance_flow_to(&mut flow, 7.8);
    amplitude(&flow, still) / arriving
}

#[test]
fn a_hump_leaves_through_an_open_end_and_is_reflected_by_a_wall() {
    let back = reflected(channel(1e-3, 0.0, 1.5, [Some(0.0), Some(40.0)]));
    assert!(back > 0.95, "a wall sends back {back} (V27: 95 %)");
    // V27 demands 2 %; 0.4 and 0.7 % were found, and 4.1 % with the state at the end itself in place of that two supports before it.
    for height in [1e-3, -1e-3] {
        let mut flow = channel(height, 0.0, 1.5, [Some(0.0), None]);
        flow.open_end(40.0, 1.0, SPACING).unwrap();
        let back = reflected(flow);
        assert!(back < 0.02, "an open end sends back {back}");
    }
}

#[test]
fn a_rapid_stream_leaves_without_a_wave() {
    // Froude number 1.6; there is no water behind it, so that its tail stays away from the window.
    let mut flow = channel(1e-3, 5.0, 1.5, [None, None]);
    flow.open_end(40.0, 1.0, SPACING).unwrap();
    let before = flow.nodes.sets[0].nodes.total_volume() - flow.far_field_volume();
    advance_flow_to(&mut flow, 2.2);
    let nodes = &flow.nodes.sets[0].nodes;
    let inside = nodes.position.iter().zip(&nodes.velocity).filter(|(x, _)| (30.0..39.0).contains(&x[0]));
    let off = inside.map(|(_, v)| (v[0] - 5.0).abs()).fold(0.0, f64::max);
    assert!(off < 2e-4, "{off}");
    let after = flow.nodes.sets[0].nodes.total_volume() - flow.far_field_volume();
    let [passed, _] = flow.boundary.open_sides[0].state.outflow;
    assert!((before - after - passed).abs() < 1e-10 * before, "{before} {after} {passed}");
    assert!((passed - 11.0).abs() < 0.2, "5 m/s for 2.2 s, to a node: {passed}");
}

fn pond(side: &Value) -> Value {
    json!({
        "title": "pond", "space": "plane-strain", "domain": { "min": [0, 0], "max": [10, 2] }, "gravity": [0, -9.81],
        "materials": { "water": {
            "model": "mohr-coulomb", "density": 1000, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 30
        } },
        "bodies": [{ "name": "pond", "material": "water", "shape": { "kind": "polygon",
            "vertices": [[0, 0], [10, 0], [10, 1], [6, 1], [5, 1.1], [4, 1], [0, 1]] } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }, { "side": "x-min", "wall": { "kind": "smooth" } }, side],
        "stages": [{ "name": "wave", "duration": 3 }],
        "methods": { "depth-sph": { "spacing": 0.02 } }
    })
}

/// Volume and outflow readings of a case after 900 steps, and the hash of its state; a restart before step `stop` where there is one.
fn volumes(case: &Case, stop: Option<usize>) -> (Vec<f64>, u64) {
    let start = || {
        let mut solver = DepthSph.build(case).unwrap();
        solver.begin_stage(0, 0.0).unwrap();
        solver
    };
    let mut solver = start();
    for step in 0..900 {
        if stop == Some(step) {
            let mut bytes = Vec::new();
            solver.save(&mut bytes).unwrap();
            solver = start();
            solver.restore(&mut bytes.as_slice()).unwrap();
        }
        let dt = solver.limit().dt;
        solver.step(dt).unwrap();
    }
    let readings = solver.scalar_outputs();
    let reading = |name: &str| readings.iter().find(|(own, _, _)| own == name).unwrap().2;
    (vec![reading("flow_volume"), reading("volume_left")], solver.snapshot().hash())
}

#[test]
fn a_case_has_an_absorbing_side_and_keeps_its_balance() {
    let side = json!({ "side": "x-max", "wall": { "kind": "absorbing" } });
    let case = read_case(&pond(&side));
    let (found, hash) = volumes(&case, None);
    assert!((found[0] + found[1] - 10.1).abs() < 1e-9, "{found:?}");
    assert!((found[1] - 0.05).abs() < 0.02, "half of the hump has left, to a node: {found:?}");
    assert_eq!(volumes(&case, Some(533)).1, hash, "a restored run goes on to the last bit");
    let mut walled = pond(&side);
    walled["boundaries"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "side": "x-max", "name": "gate", "position": 8, "wall": { "kind": "smooth" } }));
    assert!(
        refusal(&DepthSph, &walled).starts_with("boundaries[2].wall: the side has another wall"),
        "{}",
        refusal(&DepthSph, &walled)
    );
}

/// Channel of 40 m with two sets of nodes of these depths (m), each with a wave of `rise` times a hump 2 m wide at 25 m, which moves
/// outward at `speed` times its rise over its depth (m/s). Waves decay in a `layer` (m) before the end.
fn two_sets(settings: FlowSettings<1>, depths: [f64; 2], rise: [f64; 2], speed: f64, layer: f64) -> Flow<1> {
    let set = |number: usize| -> Vec<NewNode<1>> {
        let node = |k: i32| {
            let x = SPACING * (f64::from(k) + 0.5);
            let hump = rise[number] * (-(x - 25.0f64).powi(2)).exp();
            NewNode {
                body: 0,
                position: [x],
                velocity: [speed * hump / depths[number]],
                volume: (depths[number] + hump) * SPACING,
                // Sums over nodes of two sets are equal everywhere.
                length: 2.0 * SPACING,
                scale: 2.0,
            }
        };
        (0..800).map(node).collect()
    };
    let ends = PlanBoundaries { walls: [[Some(0.0), None]], ..PlanBoundaries::default() };
    let mut flow = Flow::new(settings, Bed::Flat(0.0), ends, &[set(0), set(1)]).unwrap();
    let end = Opening {
        axis: 0,
        coordinate: 40.0,
        outward: 1.0,
        spacing: SPACING,
        span: (0.0, 0.0),
        periodic: false,
        inlets: Vec::new(),
        absorbing_length: layer,
    };
    flow.open_sides(&[end]).unwrap();
    flow
}

fn of_two(phases: Phases) -> FlowSettings<1> {
    let mut settings = FlowSettings::single_phase(1000.0);
    settings.phases = phases;
    let densities = MixtureDensities { grain: 2000.0, fluid: 1000.0, gravity: 9.81 };
    settings.material = Mixture { densities, porosity: 0.4, is_saturated: phases == Phases::Two };
    settings.numerics.viscosity = (0.0, 0.0);
    settings
}

/// Largest difference of the height of a set from `still` (m) between 12 and 38 m.
fn amplitude_of(flow: &Flow<1>, set: usize, still: f64) -> f64 {
    let nodes = &flow.nodes.sets[set].nodes;
    let inside =
        nodes.position.iter().zip(&nodes.partial_thickness).filter(|(x, _)| (12.0..38.0).contains(&x[0]));
    inside.map(|(_, height)| (height - still).abs()).fold(0.0, f64::max)
}

/// Volume of a set within the channel and its volume that has passed the end (m²).
fn balance(flow: &Flow<1>, set: usize) -> f64 {
    let nodes = &flow.nodes.sets[set].nodes;
    let inside = nodes.position.iter().zip(&nodes.volume).filter(|(x, _)| x[0] <= 40.0);
    let passed: f64 = flow.boundary.open_sides.iter().map(|end| end.state.outflow[set]).sum();
    inside.map(|(_, volume)| volume).sum::<f64>() + passed
}

/// Grains and fluid under excess pore pressure, whose waves are those of water: a wave leaves as in water, and the columns of the nodes
/// beyond the end are those of the channel.
#[test]
fn a_wave_of_grains_and_fluid_leaves_with_their_columns() {
    let mut settings = of_two(Phases::Two);
    settings.drag = InterphaseDrag::Darcy { permeability: 1e-4 };
    settings.column = Some(PoreColumn {
        cells: 8,
        weight: 1.0,
        profile: PressureProfile::FiniteDifference,
        consolidation: Consolidation::Coefficient(0.02),
        lower_bound: LowerBound::NoSuction,
        excess_ratio: 0.5,
        stiffness: 1e6,
        dilatancy: None,
    });
    let celerity = 9.81f64.sqrt();
    let mut flow = two_sets(settings, [0.6, 0.4], [6e-4, 4e-4], celerity, 0.0);
    let backs = come_back(&mut flow, [0.6, 0.4], [2.0, 7.8]);
    for (set, back) in backs.into_iter().enumerate() {
        // 0.8 % was found.
        assert!(back < 0.02, "of set {set} {back} comes back");
    }
    // All columns drain alike, those beyond the end too, as far as they have neighbours.
    let nodes = &flow.nodes.sets[0].nodes;
    let ratio = |i: usize| flow.nodes.pore_columns.base_head(i) / nodes.depth[i];
    let middle = nodes.position.iter().position(|x| (x[0] - 20.0).abs() < SPACING).unwrap();
    let mut beyond = 0;
    for (i, x) in nodes.position.iter().enumerate().filter(|(_, x)| (30.0..40.3).contains(&x[0])) {
        beyond += usize::from(x[0] > 40.0);
        assert!((ratio(i) / ratio(middle) - 1.0).abs() < 0.01, "at {} m: {}", x[0], ratio(i));
    }
    assert!(beyond > 3 && ratio(middle) < 0.49, "{beyond} {}", ratio(middle));
}

/// Ratios of the amplitudes of both sets over their `still` heights (m) at the second time (s) to those at the first; volumes are kept.
fn come_back(flow: &mut Flow<1>, still: [f64; 2], times: [f64; 2]) -> [f64; 2] {
    let volumes = [balance(flow, 0), balance(flow, 1)];
    let found = times.map(|time| {
        advance_flow_to(flow, time);
        for set in 0..2 {
            assert!((balance(flow, set) / volumes[set] - 1.0).abs() < 1e-12, "set {set}");
        }
        [0, 1].map(|set| amplitude_of(flow, set, still[set]))
    });
    [0, 1].map(|set| found[1][set] / found[0][set])
}

/// Waves of the surface and of the interface of two layers leave: their speeds and shapes have the closed forms of V18 of two layers.
#[test]
fn waves_of_two_layers_leave_through_an_open_end() {
    let (depths, ratio): ([f64; 2], f64) = ([0.6, 0.4], 0.5);
    let spread = ((depths[0] - depths[1]).powi(2) + 4.0 * ratio * depths[0] * depths[1]).sqrt();
    for (sign, times) in [(1.0, [2.0, 7.8]), (-1.0, [6.0, 24.0])] {
        let square = 0.5 * 9.81 * (depths[0] + depths[1] + sign * spread);
        let shape = [ratio * 9.81 * depths[0], square - 9.81 * depths[0]];
        let size = 1e-3 / shape[0].abs().max(shape[1].abs());
        for layer in [0.0, 8.0] {
            let rise = shape.map(|x| size * x);
            let mut flow = two_sets(of_two(Phases::Layers), depths, rise, square.sqrt(), layer);
            for (set, back) in come_back(&mut flow, depths, times).into_iter().enumerate() {
                println!("wave {sign}, layer {layer} m: of set {set} {back} comes back");
                // 0.7 and 1.1 % were found of waves of the surface and of the interface, 0.6 and 1.0 % with a layer.
                assert!(back < 0.02, "wave {sign}, layer {layer} m: of set {set} {back} comes back");
            }
        }
    }
}

/// A run with columns or with two layers keeps its balance, and continues after a restart to the last bit on any number of threads.
#[test]
fn open_ends_of_two_phases_keep_the_balance_and_are_bit_identical() {
    let side = json!({ "side": "x-max", "wall": { "kind": "absorbing" } });
    let mut pressed = pond(&side);
    pressed["methods"]["depth-sph"]["spacing"] = json!(0.05);
    pressed["materials"]["water"]["density"] = json!(1960);
    let mut layered = pressed.clone();
    pressed["methods"]["depth-sph"].as_object_mut().unwrap().extend(
        json!({ "column": { "cells": 8, "consolidation": 0.1, "excess_ratio": 0.7 },
            "mixture": { "grain_density": 2600, "porosity": 0.4 } })
        .as_object()
        .unwrap()
        .clone(),
    );
    layered["materials"]["water"]["density"] = json!(2000);
    layered["materials"]["sea"] = layered["materials"]["water"].clone();
    layered["materials"]["sea"]["density"] = json!(1000);
    let mut sea = layered["bodies"][0].clone();
    sea["name"] = json!("sea");
    sea["material"] = json!("sea");
    sea["shape"] = json!({ "kind": "box", "min": [0, 0.4], "max": [10, 1] });
    layered["bodies"][0]["shape"] =
        json!({ "kind": "polygon", "vertices": [[0, 0], [10, 0], [10, 0.4], [0, 0.4]] });
    layered["bodies"].as_array_mut().unwrap().push(sea);
    layered["bodies"][0]["velocity"] = json!({ "kind": "uniform", "value": [0.2, 0] });
    layered["methods"]["depth-sph"].as_object_mut().unwrap().extend(
        json!({ "phases": "layers", "mixture": { "grain_density": 2000, "upper": ["sea"] } })
            .as_object()
            .unwrap()
            .clone(),
    );
    for value in [pressed, layered] {
        let case = read_case(&value);
        let before = DepthSph.plan(&case).unwrap().volumes.iter().sum::<f64>();
        let (found, _) = volumes(&case, None);
        let inside = if value["methods"]["depth-sph"]["phases"] == "layers" { 10.0 } else { 10.1 };
        assert!((found[0] + found[1] - inside).abs() < 1e-9, "{found:?} of {before}");
        assert!(found[1].abs() > 0.01, "{found:?}");
        let whole = hash_after(&DepthSph, &value, 1, 200, None);
        assert_eq!(hash_after(&DepthSph, &value, 3, 200, None), whole, "threads");
        assert_eq!(hash_after(&DepthSph, &value, 1, 200, Some(90)), whole, "a restart");
    }
}
