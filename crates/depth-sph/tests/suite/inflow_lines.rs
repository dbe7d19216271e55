//! Inflow of depth-integrated SPH across lines in plan: with columns of pore pressure, and over a bed that varies along the line.

use std::path::Path;

use colluvium_case::{Case, Method};
use colluvium_depth_sph::DepthSph;
use colluvium_depth_sph::bed::Bed;
use colluvium_depth_sph::config::settings::FlowSettings;
use colluvium_depth_sph::flow::{Flow, PlanBoundaries};
use colluvium_depth_sph::inflow::{Inflow, InflowState};
use colluvium_depth_sph::points::phase_nodes::NewNode;
use colluvium_testkit::{
    advance_exactly_to, hash_after, read_case, scalar_output, start_solver, write_ascii_grid,
};
use serde_json::{Value, json};

use crate::inflow::{bore, channel, integrators, mixture, still_plan};

const GRAVITY: f64 = 9.81;

/// Still water of a plan as grains and fluid, with columns of pore pressure that are drained at the start or not.
fn still_columns(phases: &str, drained: bool) -> Value {
    let mut value = still_plan();
    value["materials"]["water"]["density"] = json!(1600);
    let own = value["methods"]["depth-sph"].as_object_mut().unwrap();
    own.insert("phases".to_owned(), json!(phases));
    own.insert("mixture".to_owned(), mixture(0.4));
    own.insert("column".to_owned(), json!({ "cells": 8, "consolidation": 0, "excess_ratio": 0.6 }));
    if drained {
        let of_bed = json!([{ "shape": { "kind": "box", "min": [6, 0], "max": [24, 1.5] }, "drainage": { "kind": "hydrostatic" } }]);
        own.insert("regions".to_owned(), of_bed);
        own["column"]["consolidation"] = json!(0.5);
    }
    value
}

/// Inflow across a line onto a wet bed has columns with its own excess ratio, which load and unload with its depth like those of the body;
/// the columns and the volume of the body are not changed by it.
#[test]
fn an_inflow_across_a_line_into_a_wet_bed_brings_its_columns() {
    for phases in ["one", "two"] {
        let mut solver = start_solver(&DepthSph, &read_case(&still_columns(phases, false)));
        let pond = scalar_output(solver.as_ref(), "flow_volume");
        let first = scalar_output(solver.as_ref(), "mean_liquefaction");
        assert!(
            (first - 0.6).abs() < 1e-9,
            "{phases}: the rows behind the line are not of the flow: {first}"
        );
        advance_exactly_to(solver.as_mut(), 2.4);
        let entered = scalar_output(solver.as_ref(), "volume_entered");
        assert!((entered - 1.8).abs() <= 0.5 * 1.5 * 0.1 + 1e-9, "{phases}: {entered}");
        let flow = scalar_output(solver.as_ref(), "flow_volume");
        assert!((flow - pond - entered).abs() < 1e-9, "{phases}: {flow} {entered}");
        let [depth, speed, front] = bore(solver.as_ref(), 4.5, 10.0);
        assert!((depth / 1.144_364 - 1.0).abs() < 0.02, "{phases}: {depth}");
        assert!((speed / 0.436_924 - 1.0).abs() < 0.03, "{phases}: {speed}");
        assert!(((front - 4.0) / (2.4 * 3.463) - 1.0).abs() < 0.03, "{phases}: {front}");
        let snapshot = solver.snapshot();
        let [ratio, depths] = ["liquefaction", "depth"].map(|name| snapshot.scalars(name).unwrap());
        let grains = |i: &usize| ratio[*i].is_finite();
        // The contact of the inflow moves with the speed behind the bore.
        let contact = 4.0 + 2.4 * 0.436_924;
        for i in (0..depths.len()).filter(grains) {
            let x = snapshot.positions[i][0];
            if (4.1..contact - 0.2).contains(&x) {
                assert!((ratio[i] - 0.6).abs() < 0.02, "{phases}: at {x} m, what flows in: {}", ratio[i]);
            }
            // Without drainage `ψ` grows as the depth does (V14), whose initial values are sums over the lattice.
            if (contact + 0.5..10.0).contains(&x) {
                let exact = (0.6 + depths[i] - 1.0) / depths[i];
                assert!(
                    (ratio[i] - exact).abs() < 0.02,
                    "{phases}: at {x} m, what was there: {} {exact}",
                    ratio[i]
                );
            }
        }
    }
}

#[test]
fn inflow_of_columns_is_bit_identical_on_any_threads_and_after_a_restart() {
    for phases in ["one", "two"] {
        let value = still_columns(phases, true);
        let run =
            |threads: usize, restart: Option<usize>| hash_after(&DepthSph, &value, threads, 60, restart);
        let whole = run(1, None);
        assert_eq!(run(3, None), whole, "{phases}");
        assert_eq!(run(1, Some(25)), whole, "{phases}");
    }
}

/// Dry channel, of little friction, into which grains and fluid flow across a line with columns of an excess ratio.
fn dry_columns(phases: &str, ratio: f64, integrator: &Value) -> Value {
    let mut value = channel();
    value["materials"]["water"]["density"] = json!(1600);
    value["materials"]["water"]["friction_angle"] = json!(0.5);
    value["boundaries"][2]["wall"]["kind"] = json!("rough");
    let own = value["methods"]["depth-sph"].as_object_mut().unwrap();
    own.insert("phases".to_owned(), json!(phases));
    own.insert("mixture".to_owned(), mixture(0.4));
    own.insert("column".to_owned(), json!({ "cells": 8, "consolidation": 0, "excess_ratio": ratio }));
    own.extend(integrator.as_object().unwrap().clone());
    value
}

/// An inflow across a line onto a dry bed keeps depth, speed, excess ratio of pore pressure and volume, with all integrators and with
/// integrated heights.
#[test]
fn an_inflow_across_a_line_onto_a_dry_bed_keeps_its_columns() {
    let rates = json!({ "continuity": "rate-difference" });
    let cases = |phases| integrators().into_iter().chain([rates.clone()]).map(move |all| (phases, all));
    for (phases, integrator) in cases("one").chain(cases("two")) {
        for ratio in [0.0, 0.8] {
            let about = format!("{phases} {integrator} {ratio}");
            let mut solver = start_solver(&DepthSph, &read_case(&dry_columns(phases, ratio, &integrator)));
            let pond = scalar_output(solver.as_ref(), "flow_volume");
            advance_exactly_to(solver.as_mut(), 1.5);
            let entered = scalar_output(solver.as_ref(), "volume_entered");
            let depth = (1.0 / (2.0 * GRAVITY.sqrt())).powf(2.0 / 3.0);
            assert!((entered - 6.0).abs() <= 0.5 * depth * 1.1 + 1e-9, "{about}: {entered}");
            let flow = scalar_output(solver.as_ref(), "flow_volume");
            assert!((flow - pond - entered).abs() < 1e-9, "{about}: {flow} {entered}");
            let (found, velocity) = solver.gauge(&[4.8, 2.0]).unwrap();
            assert!((found / depth - 1.0).abs() < 0.03, "{about}: {found} m for {depth} m");
            assert!((velocity[0] * depth - 1.0).abs() < 0.03, "{about}: {velocity:?}");
            let snapshot = solver.snapshot();
            let liquefaction = snapshot.scalars("liquefaction").unwrap();
            let near = |i: &usize| (3.8..5.0).contains(&snapshot.positions[*i][0]);
            for i in (0..liquefaction.len()).filter(near).filter(|i| liquefaction[*i].is_finite()) {
                assert!((liquefaction[i] - ratio).abs() < 0.03, "{about}: {}", liquefaction[i]);
            }
        }
    }
}

/// Heap of grains and fluid on a slope and an inflow across a line below it, with pore pressure and earth pressure.
fn heap(integrator: &Value) -> Value {
    let mut value = json!({
        "title": "heap", "space": "3d", "gravity": [3, 0, -9.3], "domain": { "min": [0, 0, 0], "max": [20, 10, 5] },
        "materials": { "debris": {
            "model": "mohr-coulomb", "density": 1990, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 20
        } },
        "bodies": [{ "name": "heap", "material": "debris", "shape": { "kind": "box", "min": [1, 3, 0], "max": [5, 7, 1.5] } }],
        "boundaries": [{ "side": "x-min", "wall": { "kind": "smooth" } }, { "side": "z-min", "wall": { "kind": "rough" } }],
        "stages": [{ "name": "release", "duration": 0.5 }],
        "methods": { "depth-sph": {
            "spacing": 0.5, "phases": "two", "momentum": "symmetric",
            "mixture": { "grain_density": 2650, "porosity": 0.4, "drag": { "law": "anderson", "settling_velocity": 0.05 } },
            "column": { "cells": 8, "consolidation": 0.05, "excess_ratio": 0.8 },
            "earth_pressure": { "basal_friction_angle": 20, "internal_friction_angle": 30 },
            "inflows": [{ "from": [8, 2], "to": [8, 6], "discharge": [[0, 9], [9, 9]], "froude": 1.5 }]
        } }
    });
    let own = value["methods"]["depth-sph"].as_object_mut().unwrap();
    own.extend(integrator.as_object().unwrap().clone());
    value
}

#[test]
fn a_heap_behind_an_inflow_conserves_mass_and_is_bit_identical_after_a_restart() {
    for integrator in integrators() {
        let value = heap(&integrator);
        let mut solver = start_solver(&DepthSph, &read_case(&value));
        let first = scalar_output(solver.as_ref(), "flow_volume");
        advance_exactly_to(solver.as_mut(), 0.5);
        let [flow, entered] =
            ["flow_volume", "volume_entered"].map(|name| scalar_output(solver.as_ref(), name));
        assert!(entered > 3.0 && (flow - first - entered).abs() < 1e-9, "{integrator}: {flow} {entered}");
        let speed = scalar_output(solver.as_ref(), "largest_speed");
        assert!(speed < 10.0, "{integrator}: {speed}");
        let run =
            |threads: usize, restart: Option<usize>| hash_after(&DepthSph, &value, threads, 20, restart);
        let whole = run(1, None);
        assert_eq!(run(3, None), whole, "{integrator}");
        assert_eq!(run(1, Some(7)), whole, "{integrator}");
    }
}

/// Nodes that approach a line at 1 km/s end the run: the inflow against them would be hundreds of times too deep.
#[test]
fn an_inflow_that_would_be_far_too_deep_ends_the_run() {
    let node = |k: usize| NewNode {
        body: 0,
        position: [0.25 + 0.5 * (k / 4) as f64, 0.25 + 0.5 * (k % 4) as f64],
        velocity: [-1e3, 0.0],
        volume: 0.25,
        length: 0.6,
        scale: 1.44,
    };
    let nodes = (0..16).map(node).collect();
    let mut flow =
        Flow::new(FlowSettings::single_phase(1000.0), Bed::Flat(0.0), PlanBoundaries::default(), &[nodes])
            .unwrap();
    let mut inflow = Inflow {
        start: [0.0, 0.0],
        end: [0.0, 2.0],
        hydrograph: vec![[0.0, 4.0], [9.0, 4.0]],
        froude: 1.0,
        depth: 0.0,
        gravity: GRAVITY,
        spacing: 0.5,
        ratio: 1.2,
        row_extent: 2.0,
        body: 0,
        porosity: None,
        layer: None,
        channel: None,
        state: InflowState::default(),
    };
    inflow.depth = inflow.max_section().depth;
    flow.boundary.inflows.push(inflow);
    let failure = flow.advance(1e-3).unwrap_err();
    assert!(failure.reason.to_string().contains("m deep") && failure.position == [0.0, 0.0], "{failure}");
}

/// Channel with sides of 1 : 4, which falls by 2 % along x, with its case beside the raster: 6 m³/s flow in across it.
fn triangle(folder: &Path, across: &str) -> Value {
    let bed = |x: f64, y: f64| 5.0 - 0.02 * x + 0.25 * (y - 8.0).abs();
    write_ascii_grid(&folder.join("bed.asc"), [-2.0, 0.0], [45, 33], 0.5, bed);
    let mut value = channel();
    value["domain"] = json!({ "min": [-2, 0, 0], "max": [20, 16, 12] });
    value["boundaries"] = json!([]);
    value["obstacles"] = json!([{ "name": "bed", "wall": { "kind": "smooth" }, "shape": { "kind": "raster", "file": "bed.asc" } }]);
    // The pond of a case is away from the flow.
    value["bodies"][0]["shape"] = json!({ "kind": "box", "min": [18, 1, 4], "max": [19, 2, 6.6] });
    value["methods"]["depth-sph"]["spacing"] = json!(0.2);
    value["methods"]["depth-sph"]["inflows"] = json!([
        { "from": [2, 2], "to": [2, 14], "discharge": [[0, 6], [9, 6]], "froude": 1.5, "across": across } ]);
    value
}

/// Inflow across a channel has one level, is zero where the bed is higher, and has all of the discharge.
#[test]
fn an_inflow_across_a_channel_has_one_level() {
    let folder = tempfile::tempdir().unwrap();
    // `Q² b = Fr² g A³` of a triangle of level `s`: `A = 4 s²`, `b = 8 s`.
    let level = (8.0f64 * 36.0 / (1.5 * 1.5 * GRAVITY * 64.0)).powf(0.2);
    let speed = 6.0 / (4.0 * level * level);
    let value = triangle(folder.path(), "level");
    let case = Case::from_value(&value, folder.path()).unwrap();
    let mut solver = DepthSph.build(&case).unwrap();
    solver.begin_stage(0, 0.0).unwrap();
    let pond = scalar_output(solver.as_ref(), "flow_volume");
    advance_exactly_to(solver.as_mut(), 2.0);
    let entered = scalar_output(solver.as_ref(), "volume_entered");
    let row = 4.0 * level * level * 0.2;
    assert!((entered - 12.0).abs() <= 0.5 * row + 1e-9, "{entered}");
    let flow = scalar_output(solver.as_ref(), "flow_volume");
    let left = scalar_output(solver.as_ref(), "volume_left");
    assert!((flow + left - pond - entered).abs() < 1e-9, "{flow} {left} {entered}");
    // Kernels reach half a metre, over the bend of the bed and towards the edge of the water.
    for off in [-1.2, -0.6, 0.0, 0.6, 1.2f64] {
        let (depth, velocity) = solver.gauge(&[2.1, 8.0 + off]).unwrap();
        let surface = depth + 0.25 * off.abs();
        assert!((surface / level - 1.0).abs() < 0.1, "at {off} m: {surface} m for {level} m");
        assert!((velocity[0] / speed - 1.0).abs() < 0.1, "at {off} m: {velocity:?} for {speed} m/s");
    }
    let snapshot = solver.snapshot();
    let widest = 4.0 * level + 0.2;
    assert!(snapshot.positions.iter().all(|x| x[0] > 2.0 || (x[1] - 8.0).abs() < widest));
    let warned = |value: &Value| {
        let plan = DepthSph.plan(&Case::from_value(value, folder.path()).unwrap()).unwrap();
        plan.warnings.iter().any(|warning| warning.text.contains("inflows[0]: the bed rises by"))
    };
    let mut upward = value.clone();
    upward["methods"]["depth-sph"]["inflows"][0]["from"] = json!([2, 14]);
    upward["methods"]["depth-sph"]["inflows"][0]["to"] = json!([2, 2]);
    upward["obstacles"][0]["shape"]["file"] = json!("steep.asc");
    write_ascii_grid(&folder.path().join("steep.asc"), [-2.0, 0.0], [45, 33], 0.5, |x, y| {
        8.0 - 0.1 * x + 0.25 * (y - 8.0).abs()
    });
    upward["domain"]["max"][2] = json!(16);
    upward["bodies"][0]["shape"]["max"][2] = json!(8.4);
    assert!(warned(&upward) && !warned(&value));
    let other = Case::from_value(&triangle(folder.path(), "even"), folder.path()).unwrap();
    let mut even = DepthSph.build(&other).unwrap();
    even.begin_stage(0, 0.0).unwrap();
    even.step(1.0).unwrap();
    assert!(even.snapshot().positions.iter().any(|x| (x[1] - 8.0).abs() > 5.0), "all of the line, without");
}

#[test]
fn a_level_inflow_is_bit_identical_on_any_threads_and_after_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let mut value = triangle(folder.path(), "level");
    let file = folder.path().join("bed.asc");
    value["obstacles"][0]["shape"]["file"] = json!(file.to_str().unwrap());
    let run = |threads: usize, restart: Option<usize>| hash_after(&DepthSph, &value, threads, 60, restart);
    let whole = run(1, None);
    assert_eq!(run(3, None), whole);
    assert_eq!(run(1, Some(25)), whole);
}
