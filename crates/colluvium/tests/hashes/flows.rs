//! Runs of depth-integrated flow.

use serde_json::{Value, json};

use crate::{Runs, merged};

/// A heap of grains and water that slides down a tilted plane, or a dam that breaks along a line.
fn heap(space: &str) -> Value {
    let (max, low, high) = if space == "3d" {
        (json!([20, 10, 5]), json!([1, 3, 0]), json!([5, 7, 1.5]))
    } else {
        (json!([20, 5]), json!([1, 0]), json!([5, 1.5]))
    };
    let (gravity, bed) =
        if space == "3d" { (json!([3, 0, -9.3]), "z-min") } else { (json!([3, -9.3]), "y-min") };
    let spacing = if space == "3d" { 0.5 } else { 0.05 };
    json!({
        "title": "heap", "space": space, "domain": { "min": vec![0; low.as_array().map_or(2, Vec::len)], "max": max }, "gravity": gravity,
        "materials": { "debris": {
            "model": "mohr-coulomb", "density": 1990, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 20
        } },
        "bodies": [{ "name": "heap", "material": "debris", "shape": { "kind": "box", "min": low, "max": high } }],
        "boundaries": [{ "side": "x-min", "wall": { "kind": "smooth" } }, { "side": bed, "wall": { "kind": "rough" } }],
        "stages": [{ "name": "release", "duration": 1 }],
        "methods": { "depth-sph": { "spacing": spacing } }
    })
}

/// Grains and fluid that drag couples.
fn mixture() -> Value {
    json!({ "grain_density": 2650, "porosity": 0.4, "drag": { "law": "anderson", "settling_velocity": 0.05 } })
}

/// Options and bodies of a heap below water.
fn layers(space: &str) -> (Value, Value) {
    let heap = heap(space)["bodies"][0].clone();
    let mut water = heap.clone();
    water["name"] = json!("water");
    let up = if space == "3d" { 2 } else { 1 };
    water["shape"]["min"][up] = json!(1.5);
    water["shape"]["max"][up] = json!(2);
    let mixture = json!({ "grain_density": 1990, "upper": ["water"], "interface_friction": 0.1 });
    (json!({ "phases": "layers", "mixture": mixture }), json!({ "bodies": [heap, water] }))
}

/// Adds them.
pub fn add(runs: &mut Runs) {
    for space in ["plane-strain", "3d"] {
        numerics(runs, space);
        phases(runs, space);
    }
    ends(runs);
    ends_of_layers(runs);
}

fn put(runs: &mut Runs, space: &str, name: &str, options: &Value, more: &Value) {
    let options = json!({ "methods": { "depth-sph": options } });
    runs.insert(format!("depth-sph {space} {name}"), merged(merged(heap(space), more), &options));
}

fn numerics(runs: &mut Runs, space: &str) {
    let mut run = |name: &str, options: Value| put(runs, space, name, &options, &json!({}));
    run("one phase", json!({}));
    for kind in ["rate-basic", "rate-difference", "rate-volume", "normalised"] {
        run(kind, json!({ "continuity": kind }));
    }
    for kind in ["runge-kutta2", "runge-kutta4"] {
        run(kind, json!({ "integration": kind }));
    }
    for kind in ["symmetric", "product", "node", "variational"] {
        run(&format!("momentum {kind}"), json!({ "momentum": kind }));
    }
    run("surface gradient", json!({ "surface_gradient": true }));
}

fn phases(runs: &mut Runs, space: &str) {
    let (mixture, column) = (mixture(), json!({ "cells": 8, "consolidation": 0.05, "excess_ratio": 0.8 }));
    let earth = json!({ "internal_friction_angle": 30, "basal_friction_angle": 20 });
    let mut run = |name: &str, options: Value| put(runs, space, name, &options, &json!({}));
    for kind in ["symmetric", "product", "node"] {
        let options = json!({ "momentum": kind, "phases": "two", "mixture": mixture, "column": column });
        run(&format!("two phases momentum {kind}"), options);
    }
    run("columns", json!({ "mixture": mixture, "column": column }));
    run("earth pressure", json!({ "earth_pressure": earth }));
    let both = json!({ "phases": "two", "mixture": mixture, "column": column, "earth_pressure": earth, "xsph": 0.1 });
    run("two phases earth pressure", both);
    let ergun = json!({ "grain_density": 2650, "porosity": 0.4, "drag": { "law": "ergun", "diameter": 0.02, "viscosity": 1e-3 },
        "fluid_resistance": { "law": "turbulent", "turbulence": 500 } });
    let basal = json!({ "model": "voellmy", "friction_angle": 15, "turbulence": 500 });
    run("two phases Ergun and Voellmy", json!({ "phases": "two", "mixture": ergun, "basal": basal }));
    let (options, bodies) = layers(space);
    put(runs, space, "layers", &options, &bodies);
}

fn ends(runs: &mut Runs) {
    let mut run =
        |space: &str, name: &str, options: Value, more: Value| put(runs, space, name, &options, &more);
    let end = json!({ "gravity": [0, -9.81], "boundaries": [
        { "side": "x-min", "wall": { "kind": "absorbing" } }, { "side": "y-min", "wall": { "kind": "smooth" } }],
        "bodies": [{ "name": "heap", "material": "debris", "shape": { "kind": "box", "min": [0, 0], "max": [5, 1.5] } }] });
    run("plane-strain", "open end", json!({}), end);
    let side = json!({ "gravity": [0, 0, -9.81], "boundaries": [
        { "side": "x-min", "wall": { "kind": "absorbing" } }, { "side": "z-min", "wall": { "kind": "smooth" } }],
        "bodies": [{ "name": "heap", "material": "debris", "shape": { "kind": "box", "min": [0, 0, 0], "max": [5, 10, 1.5] } }] });
    run("3d", "open side", json!({}), side.clone());
    run("3d", "open side and a layer", json!({ "absorbing_layer": 4 }), side);
    run("3d", "cells turned", json!({ "search": "turned" }), json!({}));
    let still =
        json!({ "gravity": [0, -9.81], "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }] });
    let from_end = json!({ "inflows": [{ "side": "x-max", "discharge": [[0, 2], [9, 2]] }] });
    run("plane-strain", "inflow at an end", from_end.clone(), still.clone());
    let two = json!({ "phases": "two", "mixture": mixture() });
    run("plane-strain", "inflow of two phases at an end", merged(from_end, &two), still);
    let line = json!({ "inflows": [{ "from": [8, 2], "to": [8, 6], "discharge": [[0, 9], [9, 9]], "froude": 1.5 }] });
    let level = json!({ "gravity": [0, 0, -9.81] });
    run("3d", "inflow across a line", line.clone(), level.clone());
    run("3d", "inflow of two phases across a line", merged(line, &two), level);
}

fn ends_of_layers(runs: &mut Runs) {
    let inflows = |place: Value| {
        let of = |layer: &str, flux: f64| {
            merged(
                place.clone(),
                &json!({ "discharge": [[0, flux], [9, flux]], "froude": 1.5, "layer": layer }),
            )
        };
        json!({ "inflows": [of("lower", 4.0), of("upper", 2.0)] })
    };
    let mut run = |space: &str, name: &str, own: Value, more: Value| {
        let (options, bodies) = layers(space);
        put(runs, space, name, &merged(options, &own), &merged(bodies, &more));
    };
    let still =
        json!({ "gravity": [0, -9.81], "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }] });
    run("plane-strain", "inflow of layers at an end", inflows(json!({ "side": "x-max" })), still);
    let level = json!({ "gravity": [0, 0, -9.81] });
    run("3d", "inflow of layers across a line", inflows(json!({ "from": [8, 2], "to": [8, 6] })), level);
    let end = json!({ "gravity": [0, -9.81], "boundaries": [
        { "side": "x-min", "wall": { "kind": "absorbing" } }, { "side": "y-min", "wall": { "kind": "smooth" } }] });
    let (_, mut bodies) = layers("plane-strain");
    for body in bodies["bodies"].as_array_mut().expect("bodies") {
        body["shape"]["min"][0] = json!(0);
    }
    run(
        "plane-strain",
        "open end of layers and a layer",
        json!({ "absorbing_layer": 2 }),
        merged(end, &bodies),
    );
}
