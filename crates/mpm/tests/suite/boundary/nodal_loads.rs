//! Loads on nodes.

use colluvium_case::Method;
use colluvium_mpm::Mpm;
use colluvium_testkit::{
    advance_to, assert_same_after_restart, read_case, solve, stresses, vectors, with_keys,
};
use serde_json::{Value, json};

use crate::boundary::elastic_block;

#[test]
fn a_load_on_nodes_is_exact_up_to_the_side() {
    // The points of the last cell, which would carry it, have the stress of all others: of a bar, and of triangles.
    let bar = |space: &str, min: Value, max: Value, value: Value, options: Value| {
        read_case(&json!({
            "title": "bar", "space": space, "domain": { "min": min, "max": max }, "gravity": vec![0; min.as_array().unwrap().len()],
            "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": min, "max": max } }],
            "boundaries": [{ "side": "x-min", "wall": { "kind": "smooth" } }],
            "loads": [{ "kind": "traction", "body": "b", "side": "x-max", "value": value, "applied_to": "nodes", "ramp": 0.1 }],
            "stages": [{ "name": "s", "duration": 10, "damping": 0.5,
                         "equilibrium": { "unbalanced_force": 1e-5, "kinetic_energy": 1e-8 } }],
            "methods": { "mpm": options }
        }))
    };
    let linear = || json!({ "cell_size": 0.1, "shape": "linear" });
    for case in [
        bar("1d", json!([0]), json!([1]), json!([-100]), linear()),
        bar("1d", json!([0]), json!([1]), json!([-100]), json!({ "cell_size": 0.1, "shape": "quadratic" })),
        bar("plane-strain", json!([0, 0]), json!([1, 0.3]), json!([-100, 0]), linear()),
        bar(
            "plane-strain",
            json!([0, 0]),
            json!([1, 0.3]),
            json!([-100, 0]),
            with_keys(linear(), &json!({ "mesh": { "kind": "box" } })),
        ),
    ] {
        let report = solve(&Mpm, &case);
        assert!(report.snapshot.time < 10.0, "at rest");
        // Points in the middle of parts of cells do not integrate splines exactly.
        let slack = if case.methods["mpm"]["shape"] == "quadratic" { 5e-3 } else { 1e-3 };
        for (x, stress) in report.snapshot.positions.iter().zip(stresses(&report.snapshot)) {
            assert!((stress[0] / -100.0 - 1.0).abs() < slack, "{} at {x:?}: {}", stress[0], case.to_json());
        }
    }
}

#[test]
fn saturated_ground_under_open_water_stays_at_rest() {
    // Grains as heavy as water, so that the skeleton has no effective stress; water stands 1 m above the ground and beside it, with the
    // pressure of that depth on skeleton and fluid together and on the fluid.
    let load = |kind: &str, side: &str, value: Value, profile: Value| {
        json!({ "kind": kind, "body": "b", "side": side,
        "value": value, "profile": profile, "applied_to": "nodes" })
    };
    let deep = json!({ "axis": "y", "shares": [[0, 2], [2, 0]] });
    let level = json!({ "axis": "x", "shares": [[0, 1], [1, 1]] });
    let ground = |options: Value| {
        elastic_block().with(json!({
            "domain": { "min": [0, 0], "max": [1.2, 1.2] }, "gravity": [0, -10],
            "materials": { "m": { "model": "linear-elastic", "density": 600, "youngs_modulus": 1e6, "poissons_ratio": 0.3 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 1] },
                         "pore_fluid": { "porosity": 0.4, "permeability": 1e-3, "bulk_modulus": 1e8,
                                         "pressure": { "kind": "hydrostatic", "surface": 2 } } }],
            "boundaries": [{ "side": "x-min", "wall": { "kind": "smooth" } }, { "side": "y-min", "wall": { "kind": "smooth" } }],
            "loads": [
                load("traction", "x-max", json!([-1e4, 0]), deep.clone()), load("pore-pressure", "x-max", json!(1e4), deep.clone()),
                load("traction", "y-max", json!([0, -1e4]), level.clone()), load("pore-pressure", "y-max", json!(1e4), level.clone())
            ],
            "stages": [{ "name": "s", "duration": 0.01 }],
            "methods": { "mpm": options }
        })).build()
    };
    for options in [
        json!({ "cell_size": 0.2, "shape": "linear" }),
        json!({ "cell_size": 0.2, "shape": "linear", "points_per_cell": 3, "mesh": { "kind": "box" } }),
    ] {
        let report = solve(&Mpm, &ground(options.clone()));
        let largest = |name: &str| {
            let speeds = vectors(&report.snapshot, name).into_iter().map(|v| v[0].hypot(v[1]));
            speeds.fold(0.0, f64::max)
        };
        // Without the loads, or with one of them missing, centimetres a second.
        let speeds = ["velocity", "liquid_velocity"].map(largest);
        assert!(speeds.iter().all(|speed| *speed < 1e-9), "{options}: {speeds:?}");
    }
}

#[test]
fn loads_on_nodes_survive_a_restart_and_need_a_side_on_a_grid_line() {
    let load = json!({ "kind": "traction", "body": "b", "side": "x-max", "value": [-100, 20], "applied_to": "nodes", "ramp": 0.3,
                       "profile": { "axis": "y", "shares": [[0.35, 1], [0.65, 0.2]] } });
    let held = json!([{ "side": "x-min", "position": 0.35, "wall": { "kind": "rough" } }]);
    let sound = elastic_block().with(json!({ "loads": [load], "boundaries": held })).build();
    assert_same_after_restart(&Mpm, &sound, |solver| {
        let end = if solver.time() < 0.1 { 0.1 } else { 0.2 };
        advance_to(solver, end);
    });
    let refused = |options: Value, max: f64| {
        let body = json!([{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.35, 0.35], "max": [max, 0.65] } }]);
        let case = elastic_block()
            .with(json!({ "loads": [load], "bodies": body, "methods": { "mpm": options } }))
            .build();
        Mpm.build(&case).err().map(|error| error.to_string()).unwrap_or_default()
    };
    assert_eq!(refused(json!({ "cell_size": 0.05 }), 0.65), "");
    for (options, max, words) in [
        (json!({ "cell_size": 0.05 }), 0.625, "12.500000 cells"),
        (json!({ "cell_size": 0.05, "shape": "cubic" }), 0.65, "only on the sides of the domain"),
        (json!({ "cell_size": 0.05, "shape": "cpdi" }), 0.65, "cpdi"),
    ] {
        let problem = refused(options, max);
        assert!(problem.starts_with("loads[0].applied_to") && problem.contains(words), "{problem}");
    }
}

#[test]
fn loads_on_nodes_are_the_same_on_any_thread() {
    let load = json!({ "kind": "traction", "body": "b", "side": "x-max", "value": [-100, 20], "applied_to": "nodes", "ramp": 0.05,
                       "profile": { "axis": "y", "shares": [[0.35, 1], [0.65, 0.2]] } });
    let held = json!([{ "side": "x-min", "position": 0.35, "wall": { "kind": "rough" } }]);
    for options in [
        json!({ "cell_size": 0.0125 }),
        json!({ "cell_size": 0.0125, "stress_update": "usl", "shape": "cpgimp" }),
        json!({ "cell_size": 0.0125, "shape": "linear", "mesh": { "kind": "box" } }),
    ] {
        for fluid in
            [Value::Null, json!({ "porosity": 0.4, "intrinsic_permeability": 1e-8, "bulk_modulus": 1e6 })]
        {
            let mut body = json!({ "name": "b", "material": "m",
                                   "shape": { "kind": "box", "min": [0.35, 0.35], "max": [0.65, 0.65] } });
            if !fluid.is_null() {
                body["pore_fluid"] = fluid;
            }
            let case = elastic_block().with(json!({ "loads": [load], "boundaries": held, "bodies": [body],
                                    "stages": [{ "name": "s", "duration": 0.008 }], "methods": { "mpm": options } })).build();
            let hash = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let report = pool.install(|| solve(&Mpm, &case));
                let budget =
                    [report.end.momentum[0], report.end.kinetic, report.end.elastic].map(f64::to_bits);
                (report.snapshot.hash(), budget)
            };
            let [one, two] = [1, 2].map(hash);
            assert!(f64::from_bits(one.1[0]) < 0.0, "it is pushed");
            assert_eq!(one, two, "{options}");
        }
    }
}
