//! Depth-integrated SPH through case files: what it refuses, threads, restarts, balance of mass.

use colluvium_case::{Case, Method, Solver};
use colluvium_depth_sph::DepthSph;
use serde_json::{Value, json};

/// A column of sand behind a wall, 2 m long and 1 m high, on a rough floor.
fn column() -> Value {
    json!({
        "title": "column", "space": "plane-strain",
        "domain": { "min": [0, 0], "max": [10, 2] }, "gravity": [0, -9.81],
        "materials": { "sand": {
            "model": "mohr-coulomb", "density": 1600, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 30
        } },
        "bodies": [{ "name": "column", "material": "sand", "shape": { "kind": "box", "min": [0, 0], "max": [2, 1] } }],
        "boundaries": [{ "side": "x-min", "wall": { "kind": "smooth" } }, { "side": "y-min", "wall": { "kind": "rough" } }],
        "stages": [{ "name": "release", "duration": 3 }],
        "methods": { "depth-sph": { "spacing": 0.05 } }
    })
}

/// A heap of grains and water on a plane of three dimensions, with columns of pore pressure.
fn heap() -> Value {
    json!({
        "title": "heap", "space": "3d",
        "domain": { "min": [0, 0, 0], "max": [20, 10, 5] }, "gravity": [3, 0, -9.3],
        "materials": { "debris": {
            "model": "mohr-coulomb", "density": 1990, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 30
        } },
        "bodies": [{ "name": "heap", "material": "debris", "velocity": { "kind": "uniform", "value": [1, 0.2, 0] },
            "shape": { "kind": "box", "min": [1, 3], "max": [5, 7] } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }, { "side": "z-min", "wall": { "kind": "rough" } }],
        "stages": [{ "name": "release", "duration": 1 }],
        "methods": { "depth-sph": { "spacing": 0.5, "phases": "two", "mixture": {
                "grain_density": 2650, "porosity": 0.4, "drag": { "law": "anderson", "settling_velocity": 0.05 } },
            "column": { "cells": 8, "consolidation": 0.05, "excess_ratio": 0.8 } } }
    })
}

fn fix(mut value: Value) -> Value {
    value["bodies"][0]["shape"] = json!({ "kind": "box", "min": [1, 3, 0], "max": [5, 7, 1.5] });
    value
}

fn build(value: &Value) -> Box<dyn Solver> {
    let case = Case::from_json(&value.to_string()).unwrap();
    let mut solver = DepthSph.build(&case).unwrap();
    solver.begin_stage(0, 0.0).unwrap();
    solver
}

fn advance(solver: &mut dyn Solver, steps: usize) {
    for _ in 0..steps {
        let dt = solver.limit().dt;
        solver.step(dt).unwrap();
    }
}

fn refused(value: &Value) -> String {
    match Case::from_json(&value.to_string()) {
        Ok(case) => DepthSph.plan(&case).unwrap_err().to_string(),
        Err(errors) => errors.to_string(),
    }
}

#[test]
fn a_column_of_sand_spreads_and_stops_without_losing_mass() {
    let mut solver = build(&column());
    let before = solver.budget();
    assert!((before.mass - 3200.0).abs() < 1e-9, "{}", before.mass);
    while solver.time() < 3.0 {
        let dt = solver.limit().dt;
        solver.step(dt).unwrap();
    }
    let after = solver.budget();
    assert_eq!(after.mass, before.mass);
    assert!(after.kinetic < 1e-9, "it has stopped: {} J", after.kinetic);
    let snapshot = solver.snapshot();
    let front = snapshot.positions.iter().map(|x| x[0]).fold(0.0, f64::max);
    // Depth-averaged sand of 30° spreads by about two heights over tan φ.
    assert!((3.0..5.0).contains(&front), "{front}");
    let slope = |pair: &[(f64, f64)]| (pair[0].1 - pair[1].1) / (pair[1].0 - pair[0].0);
    let depth = snapshot.scalars("depth").unwrap();
    let mut surface: Vec<(f64, f64)> =
        snapshot.positions.iter().zip(depth).map(|(x, h)| (x[0], *h)).collect();
    surface.sort_by(|a, b| a.0.total_cmp(&b.0));
    let inner = &surface[3..surface.len() - 4];
    let steepest = inner.windows(2).map(slope).fold(0.0, f64::max);
    assert!(steepest < 32f64.to_radians().tan(), "no deposit is steeper than its friction: {steepest}");
}

#[test]
fn the_result_is_the_same_on_any_number_of_threads() {
    for value in [column(), fix(heap())] {
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut solver = build(&value);
                advance(solver.as_mut(), 30);
                solver.snapshot().hash()
            })
        };
        assert_eq!(run(1), run(3));
    }
}

#[test]
fn a_restored_run_goes_on_to_the_last_bit() {
    for value in [column(), fix(heap())] {
        let mut whole = build(&value);
        advance(whole.as_mut(), 20);
        let bytes = whole.saved().unwrap();
        let mut again = build(&value);
        again.restore(&mut &bytes[..]).unwrap();
        again.begin_stage(0, 0.0).unwrap();
        assert_eq!(again.snapshot().hash(), whole.snapshot().hash());
        advance(whole.as_mut(), 105);
        advance(again.as_mut(), 105);
        assert_eq!(again.snapshot().hash(), whole.snapshot().hash());
        assert!(again.restore(&mut &bytes[..bytes.len() - 9]).is_err());
    }
}

#[test]
fn two_phases_keep_their_masses_and_stay_together() {
    let mut solver = build(&fix(heap()));
    let before = solver.budget();
    assert!((before.mass / (24.0 * 1990.0) - 1.0).abs() < 1e-12, "{}", before.mass);
    advance(solver.as_mut(), 60);
    let after = solver.budget();
    assert_eq!(after.mass, before.mass);
    let liquid = after.liquid.unwrap();
    assert!((liquid.mass / 9600.0 - 1.0).abs() < 1e-12, "{}", liquid.mass);
    // Drag of this strength leaves a slip of a few per cent.
    let solid = (after.momentum[0] - liquid.momentum[0]) / (after.mass - liquid.mass);
    let fluid = liquid.momentum[0] / liquid.mass;
    assert!((fluid / solid - 1.0).abs() < 0.1, "{fluid} {solid}");
}

#[test]
fn what_it_cannot_honour_is_refused_by_path() {
    let change = |change: &dyn Fn(&mut Value)| {
        let mut value = column();
        change(&mut value);
        refused(&value)
    };
    let starts = |text: String, start: &str| assert!(text.starts_with(start), "{text}");
    starts(change(&|v| v["space"] = json!("axisymmetric")), "space: ");
    starts(change(&|v| v["gravity"] = json!([0, 9.81])), "gravity[1]: ");
    starts(change(&|v| v["boundaries"] = json!([])), "boundaries: there is no bed");
    starts(change(&|v| v["methods"] = json!({})), "methods.depth-sph: is missing");
    starts(
        change(&|v| v["methods"]["depth-sph"]["spacing"] = json!(-1)),
        "methods.depth-sph.spacing: -1 must be positive",
    );
    starts(change(&|v| v["bodies"][0]["shape"]["min"] = json!([0, 0.5])), "bodies[0].shape: there is a gap");
    let model =
        json!({ "model": "linear-elastic", "density": 1600, "youngs_modulus": 1e7, "poissons_ratio": 0.3 });
    starts(change(&|v| v["materials"]["sand"] = model.clone()), "materials.sand.model: ");
    starts(change(&|v| v["methods"]["depth-sph"]["phases"] = json!("two")), "methods.depth-sph.mixture: ");
    for (turbulence, problem) in
        [(json!(500), ""), (json!("none"), ""), (json!("much"), "neither a number nor")]
    {
        let mut value = column();
        value["methods"]["depth-sph"]["basal"] =
            json!({ "model": "voellmy", "friction_angle": 22, "turbulence": turbulence });
        match DepthSph.plan(&Case::from_json(&value.to_string()).unwrap()) {
            Ok(_) => assert!(problem.is_empty(), "{turbulence}"),
            Err(error) => assert!(!problem.is_empty() && error.to_string().contains(problem), "{error}"),
        }
    }
    starts(change(&|v| v["methods"]["depth-sph"]["frame"] = json!("nonsense")), "methods.depth-sph.frame");
}

#[test]
fn a_stage_that_balances_stress_is_passed_over_with_a_warning() {
    let mut value = column();
    value["stages"] = json!([
        { "name": "rest", "duration": 1, "equilibrium": {} },
        { "name": "release", "duration": 1 }
    ]);
    let case = Case::from_json(&value.to_string()).unwrap();
    let plan = DepthSph.plan(&case).unwrap();
    assert!(plan.warnings.iter().any(|warning| warning.starts_with("stages[0]: ")), "{:?}", plan.warnings);
    let mut solver = build(&value);
    let before = solver.snapshot().positions;
    advance(solver.as_mut(), 3);
    assert_eq!(solver.snapshot().positions, before);
    assert_eq!(solver.equilibrium().map(|e| e.kinetic_ratio), Some(0.0));
}
