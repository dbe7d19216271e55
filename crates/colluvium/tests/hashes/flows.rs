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

/// Adds them.
pub fn add(runs: &mut Runs) {
    let mixture = json!({ "grain_density": 2650, "porosity": 0.4, "drag": { "law": "anderson", "settling_velocity": 0.05 } });
    let column = json!({ "cells": 8, "consolidation": 0.05, "excess_ratio": 0.8 });
    let earth = json!({ "internal_friction_angle": 30, "basal_friction_angle": 20 });
    for space in ["plane-strain", "3d"] {
        let mut run = |name: &str, more: Value, options: Value| {
            let options = json!({ "methods": { "depth-sph": options } });
            runs.insert(format!("depth-sph {space} {name}"), merged(merged(heap(space), &more), &options));
        };
        run("one phase", json!({}), json!({}));
        for kind in ["rate-basic", "rate-difference", "rate-volume", "normalised"] {
            run(kind, json!({}), json!({ "continuity": kind }));
        }
        for kind in ["runge-kutta2", "runge-kutta4"] {
            run(kind, json!({}), json!({ "integration": kind }));
        }
        for kind in ["symmetric", "product", "node"] {
            run(&format!("momentum {kind}"), json!({}), json!({ "momentum": kind }));
            run(
                &format!("two phases momentum {kind}"),
                json!({}),
                json!({ "momentum": kind, "phases": "two", "mixture": mixture, "column": column }),
            );
        }
        run("columns", json!({}), json!({ "mixture": mixture, "column": column }));
        run("earth pressure", json!({}), json!({ "earth_pressure": earth }));
        let both = json!({ "phases": "two", "mixture": mixture, "column": column, "earth_pressure": earth, "xsph": 0.1 });
        run("two phases earth pressure", json!({}), both);
        let ergun = json!({ "grain_density": 2650, "porosity": 0.4, "drag": { "law": "ergun", "diameter": 0.02, "viscosity": 1e-3 },
            "fluid_resistance": { "law": "turbulent", "turbulence": 500 } });
        let basal = json!({ "model": "voellmy", "friction_angle": 15, "turbulence": 500 });
        run(
            "two phases Ergun and Voellmy",
            json!({}),
            json!({ "phases": "two", "mixture": ergun, "basal": basal }),
        );
        run("surface gradient", json!({}), json!({ "surface_gradient": true }));
        let heap = heap(space)["bodies"][0].clone();
        let mut water = heap.clone();
        water["name"] = json!("water");
        let up = if space == "3d" { 2 } else { 1 };
        water["shape"]["min"][up] = json!(1.5);
        water["shape"]["max"][up] = json!(2);
        run(
            "layers",
            json!({ "bodies": [heap, water] }),
            json!({ "phases": "layers", "mixture": { "grain_density": 1990, "upper": ["water"], "interface_friction": 0.1 } }),
        );
    }
    let mut run = |name: &str, space: &str, options: Value, more: Value| {
        let options = json!({ "methods": { "depth-sph": options } });
        runs.insert(format!("depth-sph {space} {name}"), merged(merged(heap(space), &more), &options));
    };
    let level = json!({ "gravity": [0, -9.81] });
    let end = json!({ "gravity": [0, -9.81], "boundaries": [
        { "side": "x-min", "wall": { "kind": "absorbing" } }, { "side": "y-min", "wall": { "kind": "smooth" } }] });
    run(
        "open end",
        "plane-strain",
        json!({}),
        merged(
            end,
            &json!({ "bodies": [{ "name": "heap", "material": "debris",
        "shape": { "kind": "box", "min": [0, 0], "max": [5, 1.5] } }] }),
        ),
    );
    let still = json!({ "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }] });
    let from_end = json!({ "inflows": [{ "side": "x-max", "discharge": [[0, 2], [9, 2]] }] });
    run("inflow at an end", "plane-strain", from_end, merged(level, &still));
    let line = json!({ "inflows": [{ "from": [8, 2], "to": [8, 6], "discharge": [[0, 9], [9, 9]], "froude": 1.5 }] });
    run("inflow across a line", "3d", line, json!({ "gravity": [0, 0, -9.81] }));
}
