//! Inflow of depth-integrated SPH across a line, by a hydrograph.

use colluvium_case::{Case, Method, Solver};
use colluvium_depth_sph::DepthSph;
use serde_json::{Value, json};

const GRAVITY: f64 = 9.81;

/// A smooth level channel, 4 m wide, into which 4 m³/s flow at twice the celerity.
fn channel() -> Value {
    json!({
        "title": "channel", "space": "3d", "gravity": [0, 0, -GRAVITY],
        "domain": { "min": [0, 0, 0], "max": [60, 4, 5] },
        "materials": { "water": {
            "model": "mohr-coulomb", "density": 1000, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 30
        } },
        "bodies": [{ "name": "pond", "material": "water", "shape": { "kind": "box", "min": [58, 1, 0], "max": [59, 3, 0.2] } }],
        "boundaries": [
            { "side": "y-min", "wall": { "kind": "smooth" } }, { "side": "y-max", "wall": { "kind": "smooth" } },
            { "side": "z-min", "wall": { "kind": "smooth" } }
        ],
        "stages": [{ "name": "flow", "duration": 6 }],
        "methods": { "depth-sph": { "spacing": 0.25, "inflows": [
            { "from": [4, 0], "to": [4, 4], "discharge": [[0, 4], [4, 4]], "froude": 2 } ] } }
    })
}

fn build(value: &Value) -> Box<dyn Solver> {
    let mut solver = DepthSph.build(&Case::from_json(&value.to_string()).unwrap()).unwrap();
    solver.begin_stage(0, 0.0).unwrap();
    solver
}

fn until(solver: &mut dyn Solver, time: f64) {
    while solver.time() < time - 1e-12 {
        solver.step(time - solver.time()).unwrap();
    }
}

fn reading(solver: &dyn Solver, name: &str) -> f64 {
    solver.readings().iter().find(|(reading, ..)| reading == name).unwrap().2
}

/// Behind the front a stream above its celerity keeps the depth and speed that it enters with.
#[test]
fn a_stream_keeps_the_depth_and_speed_that_it_enters_with() {
    let mut solver = build(&channel());
    let (depth, speed) = ((1.0 / (2.0 * GRAVITY.sqrt())).powf(2.0 / 3.0), 1.0);
    let speed = speed / depth;
    let pond = reading(solver.as_ref(), "flow_volume");
    until(solver.as_mut(), 3.0);
    // The tail of the front's fan goes with the speed less the celerity, half of it here.
    let (found, velocity) = solver.gauge(&[5.5, 2.0]).unwrap();
    assert!((found / depth - 1.0).abs() < 0.02, "depth {found} for {depth}");
    assert!(
        (velocity[0] / speed - 1.0).abs() < 0.02 && velocity[1].abs() < 0.02 * speed,
        "{velocity:?} for {speed}"
    );
    let row = depth * 4.0 * 0.25;
    for time in [3.0, 6.0] {
        until(solver.as_mut(), time);
        let (entered, exact) = (reading(solver.as_ref(), "volume_entered"), 4.0 * time.min(4.0));
        assert!((entered - exact).abs() <= 0.5 * row + 1e-9, "{entered} m³ of {exact} m³");
        let flow = reading(solver.as_ref(), "flow_volume");
        assert!((flow - pond - entered).abs() < 1e-9 * flow, "{flow} {pond} {entered}");
    }
}

#[test]
fn a_stream_goes_on_after_a_restart_to_the_last_bit_on_any_threads() {
    let run = |threads: usize, restart: bool| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut solver = build(&channel());
            (0..70).for_each(|_| {
                solver.step(1.0).unwrap();
            });
            if restart {
                let bytes = solver.saved().unwrap();
                solver = build(&channel());
                solver.restore(&mut &bytes[..]).unwrap();
                solver.begin_stage(0, 0.0).unwrap();
            }
            (0..120).for_each(|_| {
                solver.step(1.0).unwrap();
            });
            solver.snapshot().hash()
        })
    };
    let whole = run(1, false);
    assert_eq!(run(3, false), whole);
    assert_eq!(run(1, true), whole);
}

#[test]
fn hydrographs_and_lines_that_are_none_are_refused_by_path() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("flood.csv"), "time,discharge\n0,1\n10,three\n").unwrap();
    let refused = |changes: Value| {
        let mut value = channel();
        let inflow = value["methods"]["depth-sph"]["inflows"][0].as_object_mut().unwrap();
        inflow.extend(changes.as_object().unwrap().clone());
        inflow.retain(|_, value| !value.is_null());
        let case = Case::from_value(&value, folder.path()).unwrap();
        DepthSph.plan(&case).map(|_| ()).unwrap_err().to_string()
    };
    for (changes, start) in [
        (json!({ "discharge": [[0, 1], [0, 2]] }), "discharge: times must increase"),
        (json!({ "discharge": [[0, 1], [1, -2]] }), "discharge: -2 m³/s at 1 s"),
        (json!({ "discharge": [[0, 0], [1, 0]] }), "discharge: must begin at zero or later and flow"),
        (json!({ "hydrograph": "flood.csv" }), "discharge: give either"),
        (json!({ "discharge": null, "hydrograph": "flood.csv" }), "hydrograph: /"),
        (json!({ "froude": 0 }), "froude: 0 must be"),
        (json!({ "to": [4, 0] }), "to: is where"),
        (json!({ "to": null }), "to: is missing"),
        (json!({ "side": "x-min" }), "side: is an end of a profile"),
    ] {
        let error = refused(changes);
        assert!(error.starts_with(&format!("methods.depth-sph.inflows[0].{start}")), "{error}");
    }
    let mut value = channel();
    value["methods"]["depth-sph"]["column"] = json!({ "consolidation": 0.1 });
    value["methods"]["depth-sph"]["mixture"] =
        json!({ "grain_density": 1500, "porosity": 0.5, "fluid_density": 500 });
    let error =
        DepthSph.plan(&Case::from_json(&value.to_string()).unwrap()).map(|_| ()).unwrap_err().to_string();
    assert!(error.starts_with("methods.depth-sph.inflows: are of a flow of one phase"), "{error}");
}

/// V28: water that flows into still water of a channel, slower than its waves, rises as the invariant has it, and a bore runs ahead.
#[test]
fn an_inflow_into_still_water_sends_a_bore_ahead() {
    let value = json!({
        "title": "channel", "space": "plane-strain", "gravity": [0, -GRAVITY],
        "domain": { "min": [0, 0], "max": [40, 3] },
        "materials": { "water": {
            "model": "mohr-coulomb", "density": 1000, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 30
        } },
        "bodies": [{ "name": "still", "material": "water", "shape": { "kind": "box", "min": [0, 0], "max": [40, 1] } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }, { "side": "x-max", "wall": { "kind": "smooth" } }],
        "stages": [{ "name": "flow", "duration": 6 }],
        "methods": { "depth-sph": { "spacing": 0.05, "smoothing": 2, "inflows": [
            { "side": "x-min", "discharge": [[0, 0.5], [9, 0.5]] } ] } }
    });
    let mut solver = build(&value);
    until(solver.as_mut(), 6.0);
    let entered = reading(solver.as_ref(), "volume_entered");
    assert!((entered - 3.0).abs() < 0.06, "0.5 m²/s for 6 s, to a node: {entered}");
    let flow = reading(solver.as_ref(), "flow_volume");
    assert!((flow - 40.0 - entered).abs() < 1e-9, "{flow} {entered}");
    let snapshot = solver.snapshot();
    let depth = snapshot.scalars("depth").unwrap();
    let velocity = snapshot.vectors("velocity").unwrap();
    let (mut count, mut means) = (0.0, [0.0; 2]);
    let mut bore = 0.0f64;
    for (i, x) in snapshot.positions.iter().enumerate() {
        if (2.0..15.0).contains(&x[0]) {
            count += 1.0;
            means = [means[0] + depth[i], means[1] + velocity[i][0]];
        }
        if depth[i] > 1.0 + 0.5 * 0.144_364 {
            bore = bore.max(x[0]);
        }
    }
    let [depth, speed] = means.map(|sum| sum / count);
    assert!((depth / 1.144_364 - 1.0).abs() < 0.02, "{depth}");
    assert!((speed / 0.436_924 - 1.0).abs() < 0.02, "{speed}");
    assert!((bore / (6.0 * 3.463) - 1.0).abs() < 0.02, "{bore}");
}

/// An inflow onto a dry bed has the depth and speed of its Froude number.
#[test]
fn an_inflow_onto_a_dry_profile_has_its_froude_number() {
    let value = json!({
        "title": "channel", "space": "plane-strain", "gravity": [0, -GRAVITY],
        "domain": { "min": [0, 0], "max": [60, 3] },
        "materials": { "water": {
            "model": "mohr-coulomb", "density": 1000, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 30
        } },
        "bodies": [{ "name": "pond", "material": "water", "shape": { "kind": "box", "min": [58, 0], "max": [59, 0.2] } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }],
        "stages": [{ "name": "flow", "duration": 4 }],
        "methods": { "depth-sph": { "spacing": 0.1, "inflows": [
            { "side": "x-min", "discharge": [[0, 1], [9, 1]], "froude": 2 } ] } }
    });
    let mut solver = build(&value);
    until(solver.as_mut(), 4.0);
    let depth = (1.0 / (2.0 * GRAVITY.sqrt())).powf(2.0 / 3.0);
    let snapshot = solver.snapshot();
    let (found, velocity) = (snapshot.scalars("depth").unwrap(), snapshot.vectors("velocity").unwrap());
    let inside: Vec<usize> =
        (0..found.len()).filter(|i| (1.0..4.0).contains(&snapshot.positions[*i][0])).collect();
    assert!(inside.len() > 20, "{}", inside.len());
    for i in inside {
        assert!((found[i] / depth - 1.0).abs() < 0.03, "{} for {depth}", found[i]);
        assert!((velocity[i][0] * depth - 1.0).abs() < 0.03, "{} for {}", velocity[i][0], 1.0 / depth);
    }
    let entered = reading(solver.as_ref(), "volume_entered");
    assert!((entered - 4.0).abs() < 0.1, "{entered}");
}
