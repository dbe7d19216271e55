//! Waves that leave through an open end (sheet: depth-sph §5.5, V27).

use colluvium_case::{Case, Method};
use colluvium_depth_sph::DepthSph;
use colluvium_depth_sph::bed::Bed;
use colluvium_depth_sph::flow::{Ends, Flow};
use colluvium_depth_sph::nodes::Node;
use colluvium_depth_sph::settings::Settings;
use serde_json::{Value, json};

use crate::common::run;

const SPACING: f64 = 0.05;

/// A channel of 40 m, 1 m deep, with a hump 2 m wide of `height` (m) at 25 m that runs to the right on a stream of `speed` (m/s);
/// smoothing lengths of `ratio` spacings.
fn channel(height: f64, speed: f64, ratio: f64, walls: [Option<f64>; 2]) -> Flow<1> {
    let celerity = |depth: f64| (9.81 * depth).sqrt();
    let nodes = (0..800).map(|k| {
        let x = SPACING * (f64::from(k) + 0.5);
        let depth = 1.0 + height * (-(x - 25.0f64).powi(2)).exp();
        Node {
            body: 0,
            position: [x],
            velocity: [speed + 2.0 * (celerity(depth) - celerity(1.0))],
            volume: depth * SPACING,
            length: ratio * SPACING,
            scale: ratio,
        }
    });
    let ends = Ends { walls: [walls], ..Ends::default() };
    let mut settings = Settings::plain(1000.0);
    settings.numerics.viscosity = (0.0, 0.0);
    Flow::new(settings, Bed::Flat(0.0), ends, &[nodes.collect()]).unwrap()
}

/// Largest difference of the depth from `still` (m) between 12 and 38 m.
fn amplitude(flow: &Flow<1>, still: f64) -> f64 {
    let nodes = &flow.sets[0].nodes;
    let inside = nodes.position.iter().zip(&nodes.depth).filter(|(x, _)| (12.0..38.0).contains(&x[0]));
    inside.map(|(_, depth)| (depth - still).abs()).fold(0.0, f64::max)
}

/// What comes back over what arrives: the hump is at 31 m after 2 s, and back at 30.6 m after 7.8 s.
fn reflected(mut flow: Flow<1>) -> f64 {
    // Sums over this lattice are 0.4 % off.
    let still = flow.sets[0].nodes.depth[150];
    run(&mut flow, 2.0);
    let arriving = amplitude(&flow, still);
    run(&mut flow, 7.8);
    amplitude(&flow, still) / arriving
}

#[test]
fn a_hump_leaves_through_an_open_end_and_comes_back_from_a_wall() {
    let back = reflected(channel(1e-3, 0.0, 1.5, [Some(0.0), Some(40.0)]));
    assert!(back > 0.95, "a wall sends back {back} (V27: 95 %)");
    // V27 asks for 2 %; 0.4 and 0.7 % were found, and 4.1 % with the state at the end itself in place of that two supports before it.
    for height in [1e-3, -1e-3] {
        let mut flow = channel(height, 0.0, 1.5, [Some(0.0), None]);
        flow.open(40.0, 1.0, SPACING).unwrap();
        let back = reflected(flow);
        assert!(back < 0.02, "an open end sends back {back}");
    }
}

#[test]
fn a_rapid_stream_leaves_without_a_wave() {
    // Froude number 1.6; nothing is behind it, so that its tail stays away from the window.
    let mut flow = channel(1e-3, 5.0, 1.5, [None, None]);
    flow.open(40.0, 1.0, SPACING).unwrap();
    let before = flow.sets[0].nodes.total_volume() - flow.beyond();
    run(&mut flow, 2.2);
    let nodes = &flow.sets[0].nodes;
    let inside = nodes.position.iter().zip(&nodes.velocity).filter(|(x, _)| (30.0..39.0).contains(&x[0]));
    let off = inside.map(|(_, v)| (v[0] - 5.0).abs()).fold(0.0, f64::max);
    assert!(off < 2e-4, "{off}");
    let after = flow.sets[0].nodes.total_volume() - flow.beyond();
    let [passed, _] = flow.opens[0].state.passed;
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

/// Readings of the volume and what has left of a case, `steps` on.
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
    let readings = solver.readings();
    let reading = |name: &str| readings.iter().find(|(own, _, _)| own == name).unwrap().2;
    (vec![reading("flow_volume"), reading("volume_left")], solver.snapshot().hash())
}

#[test]
fn a_case_has_an_absorbing_side_and_keeps_its_balance() {
    let side = json!({ "side": "x-max", "wall": { "kind": "absorbing" } });
    let case = Case::from_json(&pond(&side).to_string()).unwrap();
    let (found, hash) = volumes(&case, None);
    assert!((found[0] + found[1] - 10.1).abs() < 1e-9, "{found:?}");
    assert!((found[1] - 0.05).abs() < 0.02, "half of the hump has left, to a node: {found:?}");
    assert_eq!(volumes(&case, Some(533)).1, hash, "a restored run goes on to the last bit");
    let refused = |value: &Value| {
        let case = Case::from_json(&value.to_string()).unwrap();
        DepthSph.plan(&case).map(|_| ()).unwrap_err().to_string()
    };
    let mut pressed = pond(&side);
    pressed["methods"]["depth-sph"]["column"] = json!({ "consolidation": 0.1 });
    pressed["methods"]["depth-sph"]["mixture"] = json!({ "grain_density": 2600 });
    assert!(refused(&pressed).starts_with("boundaries[2].wall: "), "{}", refused(&pressed));
    let mut walled = pond(&side);
    walled["boundaries"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "side": "x-max", "name": "gate", "position": 8, "wall": { "kind": "smooth" } }));
    assert!(refused(&walled).starts_with("boundaries[2].wall: stands at a side"), "{}", refused(&walled));
}
