//! Restored solvers continue with equal bits where sums use neighbour lists, which are older than the positions of the nodes.

use colluvium_depth_sph::DepthSph;
use colluvium_testkit::{read_case, resume_solver, set_value, start_solver, take_steps};
use serde_json::{Value, json};

/// Steps before a restart: the first step, steps between two sorts by cell, and the step of a sort.
const RESTARTS: [usize; 5] = [1, 7, 19, 20, 33];
/// Steps of a run: lists are built again several times.
const STEPS: usize = 47;

/// Block that moves towards a wall, in a profile or in plan, with a drive along a side wall in plan.
fn block(is_plan: bool) -> Value {
    let wall = |side: &str, kind: &str| json!({ "side": side, "wall": { "kind": kind } });
    let mut value = json!({
        "title": "block", "space": "plane-strain", "gravity": [1, -9.81],
        "domain": { "min": [0, 0], "max": [6, 3] },
        "materials": { "soil": {
            "model": "mohr-coulomb", "density": 1990, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 15
        } },
        "bodies": [{ "name": "block", "material": "soil", "shape": { "kind": "box", "min": [0, 0], "max": [3, 1] },
            "velocity": { "kind": "uniform", "value": [1.5, 0] } }],
        "boundaries": [wall("x-min", "smooth"), wall("x-max", "smooth"), wall("y-min", "rough")],
        "stages": [{ "name": "release", "duration": 9 }],
        "methods": { "depth-sph": { "spacing": 0.1 } }
    });
    if is_plan {
        value["space"] = json!("3d");
        value["gravity"] = json!([1, 0.5, -9.81]);
        value["domain"] = json!({ "min": [0, 0, 0], "max": [6, 4, 3] });
        value["bodies"][0]["shape"] = json!({ "kind": "box", "min": [0, 0.5, 0], "max": [3, 3, 1] });
        value["bodies"][0]["velocity"]["value"] = json!([1.5, 0.3, 0]);
        value["boundaries"] =
            json!([wall("x-min", "smooth"), wall("y-max", "smooth"), wall("z-min", "rough")]);
        value["methods"]["depth-sph"]["spacing"] = json!(0.25);
    }
    value
}

/// Block with options of the method.
fn with_options(mut value: Value, options: &Value) -> Value {
    let own = value["methods"]["depth-sph"].as_object_mut().unwrap();
    own.extend(options.as_object().unwrap().clone());
    value
}

/// Block of two layers, of which the upper one is shorter.
fn layered(mut value: Value) -> Value {
    let up = if value["space"] == "3d" { 2 } else { 1 };
    value["materials"]["sea"] = value["materials"]["soil"].clone();
    value["materials"]["sea"]["density"] = json!(1000);
    let mut sea = value["bodies"][0].clone();
    (sea["name"], sea["material"]) = (json!("sea"), json!("sea"));
    sea["shape"]["min"][up] = json!(0.4);
    sea["shape"]["max"][0] = json!(2.5);
    value["bodies"][0]["shape"]["max"][up] = json!(0.4);
    value["bodies"].as_array_mut().unwrap().push(sea);
    with_options(
        value,
        &json!({ "phases": "layers", "mixture": { "grain_density": 1990, "upper": ["sea"] } }),
    )
}

/// Asserts that restarts after different numbers of steps do not change the bits of a run, nor its complete state at the end.
#[track_caller]
fn assert_restarts(name: &str, value: &Value) {
    let case = read_case(value);
    let mut whole = start_solver(&DepthSph, &case);
    let mut restored = Vec::new();
    for step in 0..STEPS {
        if RESTARTS.contains(&step) {
            restored.push((step, resume_solver(&DepthSph, &case, &whole.checkpoint_bytes().unwrap())));
        }
        whole.step(1.0).unwrap();
    }
    let mut differing = Vec::new();
    for (first, mut solver) in restored {
        take_steps(&mut *solver, STEPS - first, 1.0);
        let equal_bits = solver.snapshot().hash() == whole.snapshot().hash();
        if !(equal_bits && solver.checkpoint_bytes().unwrap() == whole.checkpoint_bytes().unwrap()) {
            differing.push((first, equal_bits));
        }
    }
    assert!(differing.is_empty(), "{name} in {}: restarts after {differing:?} steps", value["space"]);
}

/// Asserts the same in a profile and in plan, between walls and with a periodic boundary.
#[track_caller]
fn assert_restarts_everywhere(name: &str, change: impl Fn(Value) -> Value) {
    for is_plan in [false, true] {
        let walled = change(block(is_plan));
        assert_restarts(name, &walled);
        let mut periodic = walled;
        set_value(&mut periodic, "/domain/periodic", &json!(["x"]));
        let walls = periodic["boundaries"].as_array_mut().unwrap();
        walls.retain(|wall| !wall["side"].as_str().unwrap().starts_with('x'));
        assert_restarts(&format!("{name}, periodic"), &periodic);
    }
}

/// Asserts the same for options of the method.
#[track_caller]
fn assert_restarts_with(options: &Value) {
    assert_restarts_everywhere(&options.to_string(), |value| with_options(value, options));
}

#[test]
fn smoothed_velocities_are_equal_after_a_restart() {
    assert_restarts_with(&json!({ "xsph": 0.1 }));
    assert_restarts_with(&json!({ "xsph": 0.3, "momentum": "variational" }));
}

#[test]
fn earth_pressures_are_equal_after_a_restart() {
    assert_restarts_with(
        &json!({ "earth_pressure": { "basal_friction_angle": 15, "internal_friction_angle": 30 } }),
    );
}

#[test]
fn depths_by_rates_and_by_normalised_sums_are_equal_after_a_restart() {
    for continuity in ["normalised", "rate-basic", "rate-difference", "rate-volume"] {
        assert_restarts_with(&json!({ "continuity": continuity }));
    }
}

#[test]
fn stages_of_runge_kutta_schemes_are_equal_after_a_restart() {
    for integration in ["runge-kutta2", "runge-kutta4"] {
        assert_restarts_with(&json!({ "integration": integration, "continuity": "rate-difference" }));
    }
}

#[test]
fn two_layers_are_equal_after_a_restart() {
    assert_restarts_everywhere("layers", layered);
    let smoothed = |value| with_options(layered(value), &json!({ "xsph": 0.1 }));
    assert_restarts_everywhere("layers and xsph", smoothed);
}

#[test]
fn two_phases_are_equal_after_a_restart() {
    let mixture = json!({ "grain_density": 2650, "porosity": 0.4, "drag": { "law": "anderson", "settling_velocity": 0.05 } });
    assert_restarts_with(&json!({ "phases": "two", "xsph": 0.1, "mixture": mixture,
        "column": { "cells": 6, "consolidation": 0.05, "excess_ratio": 0.8 } }));
}
