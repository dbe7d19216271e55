//! Inflow of depth-integrated SPH into two layers.

use colluvium_case::Solver;
use colluvium_depth_sph::DepthSph;
use colluvium_testkit::{advance_exactly_to, hash_after, read_case, refusal, scalar_output, start_solver};
use serde_json::{Value, json};

use crate::inflow::{self, channel, integrators};

const GRAVITY: f64 = 9.81;
/// Discharges per width of the lower and the upper layer (m²/s), and their Froude number.
const FLUXES: [f64; 2] = [1.0, 0.5];
const FROUDE: f64 = 2.0;

/// Turns a channel of water into one of mud below water, with a pond of each.
fn layered(mut value: Value) -> Value {
    let up = if value["space"] == "3d" { 2 } else { 1 };
    value["materials"]["mud"] = value["materials"]["water"].clone();
    value["materials"]["mud"]["density"] = json!(2000);
    let mut water = value["bodies"][0].clone();
    water["name"] = json!("water");
    water["shape"]["min"][up] = json!(0.2);
    water["shape"]["max"][up] = json!(0.4);
    value["bodies"][0]["material"] = json!("mud");
    value["bodies"].as_array_mut().unwrap().push(water);
    let own = value["methods"]["depth-sph"].as_object_mut().unwrap();
    own.insert("phases".to_owned(), json!("layers"));
    own.insert("mixture".to_owned(), json!({ "grain_density": 2000, "upper": ["water"] }));
    value
}

/// Dry plan into which both layers flow across one line.
fn plan() -> Value {
    let mut value = layered(channel());
    let line = |layer: &str, flux: f64| json!({ "from": [4, 0], "to": [4, 4], "discharge": [[0, 4.0 * flux], [9, 4.0 * flux]], "froude": FROUDE, "layer": layer });
    value["methods"]["depth-sph"]["inflows"] = json!([line("lower", FLUXES[0]), line("upper", FLUXES[1])]);
    value
}

/// Dry profile into which both layers flow through its end.
fn profile() -> Value {
    let end = |layer: &str, flux: f64| json!({ "side": "x-min", "discharge": [[0, flux], [9, flux]], "froude": FROUDE, "layer": layer });
    let inflows = json!([end("lower", FLUXES[0]), end("upper", FLUXES[1])]);
    let mut value = layered(inflow::profile(&inflows));
    value["domain"]["min"] = json!([4, 0]);
    value
}

/// Volume of a layer at `x` >= 4 m, and the means of its heights (m) and speeds (m/s) in the first metre and a half.
fn found(solver: &dyn Solver, layer: usize) -> [f64; 3] {
    let snapshot = solver.snapshot();
    let [height, phase, volume] = ["height", "phase", "volume"].map(|name| snapshot.scalars(name).unwrap());
    let velocity = snapshot.vectors("velocity").unwrap();
    let (mut count, mut sums) = (0.0, [0.0; 3]);
    for (i, x) in snapshot.positions.iter().enumerate().filter(|(i, _)| phase[*i] == layer as f64) {
        sums[0] += if x[0] >= 4.0 { volume[i] } else { 0.0 };
        if (4.2..5.5).contains(&x[0]) {
            count += 1.0;
            sums = [sums[0], sums[1] + height[i], sums[2] + velocity[i][0]];
        }
    }
    [sums[0], sums[1] / count, sums[2] / count]
}

/// Faster than all waves each layer keeps the depth and speed of its own Froude number, and its own volume, by all integrators.
#[test]
fn both_layers_flow_in_each_with_its_own_depth_and_speed() {
    integrators().iter().for_each(both_layers_flow_in);
}

fn both_layers_flow_in(integrator: &Value) {
    for (mut value, width, spacing) in [(plan(), 4.0, 0.25), (profile(), 1.0, 0.1)] {
        let own = value["methods"]["depth-sph"].as_object_mut().unwrap();
        own.extend(integrator.as_object().unwrap().clone());
        let mut solver = start_solver(&DepthSph, &read_case(&value));
        let before = [0, 1].map(|layer| found(solver.as_ref(), layer)[0]);
        let pond = scalar_output(solver.as_ref(), "flow_volume");
        advance_exactly_to(solver.as_mut(), 2.0);
        for layer in 0..2 {
            let flux = FLUXES[layer];
            let depth = (flux / (FROUDE * GRAVITY.sqrt())).powf(2.0 / 3.0);
            let [volume, height, speed] = found(solver.as_ref(), layer);
            println!(
                "{integrator}, width {width} m, layer {layer}: {height} of {depth} m, {speed} of {} m/s",
                flux / depth
            );
            assert!((height / depth - 1.0).abs() < 0.03, "layer {layer}: {height} m for {depth} m");
            assert!((speed * depth / flux - 1.0).abs() < 0.03, "layer {layer}: {speed} m/s");
            let own = volume - before[layer];
            let row = depth * width * spacing;
            assert!((own - 2.0 * flux * width).abs() < 1.1 * row, "layer {layer}: {own} m³, to a row");
        }
        let [flow, entered] =
            ["flow_volume", "volume_entered"].map(|name| scalar_output(solver.as_ref(), name));
        assert!((flow - pond - entered).abs() < 1e-9, "{flow} {pond} {entered}");
    }
}

/// Mud flows in below still water: for the water its end is an open side, both volumes are kept, and after the end of the inflow
/// the mud stays.
#[test]
fn mud_flows_in_below_still_water() {
    let mut value = profile();
    value["domain"] = json!({ "min": [4, 0], "max": [24, 3] });
    value["bodies"][0]["shape"] = json!({ "kind": "box", "min": [22, 0], "max": [23, 0.2] });
    value["bodies"][1]["shape"] = json!({ "kind": "polygon", "vertices": [[4, 0], [22, 0], [22, 0.2], [23, 0.2], [23, 0], [24, 0], [24, 1], [4, 1]] });
    value["boundaries"]
        .as_array_mut()
        .unwrap()
        .push(json!({ "side": "x-max", "wall": { "kind": "smooth" } }));
    let options = &mut value["methods"]["depth-sph"];
    options["mixture"]["interface_friction"] = json!(0.05);
    options["smoothing"] = json!(2);
    options["inflows"] = json!([
        { "side": "x-min", "discharge": [[0, 0], [1, 0.2], [3, 0.2], [4, 0]], "froude": 0.7, "layer": "lower" } ]);
    let mut solver = start_solver(&DepthSph, &read_case(&value));
    let before = [0, 1].map(|layer| found(solver.as_ref(), layer)[0]);
    advance_exactly_to(solver.as_mut(), 8.0);
    let after = [0, 1].map(|layer| found(solver.as_ref(), layer)[0]);
    let [entered, left] = ["volume_entered", "volume_left"].map(|name| scalar_output(solver.as_ref(), name));
    println!("mud {:?} water {:?} entered {entered} left {left}", after[0] - before[0], after[1] - before[1]);
    assert!((entered - 0.6).abs() < 0.05, "0.6 m² of mud, to a node: {entered}");
    assert!((after[0] - before[0] - entered).abs() < 1e-9, "mud {before:?} {after:?}");
    assert!((before[1] - after[1] - left).abs() < 1e-9, "water {before:?} {after:?} {left}");
}

#[test]
fn inflow_of_layers_is_bit_identical_on_any_threads_and_after_a_restart() {
    for value in [plan(), profile()] {
        let run =
            |threads: usize, restart: Option<usize>| hash_after(&DepthSph, &value, threads, 60, restart);
        let whole = run(1, None);
        assert_eq!(run(3, None), whole);
        assert_eq!(run(1, Some(25)), whole);
    }
}

#[test]
fn invalid_inflows_of_layers_are_refused_by_path() {
    let mut unsaid = plan();
    unsaid["methods"]["depth-sph"]["inflows"][1].as_object_mut().unwrap().remove("layer");
    let mut one = channel();
    one["methods"]["depth-sph"]["inflows"][0]["layer"] = json!("lower");
    let mut twice = profile();
    twice["methods"]["depth-sph"]["inflows"][1]["layer"] = json!("lower");
    for (value, start) in [
        (unsaid, "[1].layer: is missing"),
        (one, "[0].layer: applies only to two layers"),
        (twice, "[1].side: has another inflow"),
    ] {
        let error = refusal(&DepthSph, &value);
        assert!(error.starts_with(&format!("methods.depth-sph.inflows{start}")), "{error}");
    }
}
