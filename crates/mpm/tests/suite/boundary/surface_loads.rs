//! Loads on the surface of a body, carried by its points.

use colluvium_case::{Case, Solver};
use colluvium_mpm::Mpm;
use colluvium_testkit::{advance_to, solve, start_solver, stresses, with_keys};
use serde_json::{Value, json};

use crate::boundary::elastic_block;

/// Force on the whole body in the next step (N).
fn force(solver: &mut dyn Solver) -> [f64; 2] {
    let (before, dt) = (solver.totals().momentum, solver.limit().dt);
    solver.step(dt).unwrap();
    let after = solver.totals().momentum;
    [(after[0] - before[0]) / dt, (after[1] - before[1]) / dt]
}

#[test]
fn a_pressure_rotates_with_the_surface_and_a_traction_does_not() {
    // A quarter turn in a second.
    let rate = std::f64::consts::FRAC_PI_2;
    let spin = json!({ "kind": "linear", "value": [0, 0], "origin": [0.5, 0.5], "gradient": [[0, -rate], [rate, 0]] });
    let body = json!([{ "name": "b", "material": "m", "velocity": spin,
                        "shape": { "kind": "box", "min": [0.35, 0.35], "max": [0.65, 0.65] } }]);
    let loads = [
        (json!({ "kind": "pressure", "body": "b", "side": "x-max", "value": 10 }), [0.0, -3.0]),
        (json!({ "kind": "traction", "body": "b", "side": "x-max", "value": [-10, 0] }), [-3.0, 0.0]),
    ];
    for scheme in ["usf", "usl", "musl"] {
        for (load, exact) in &loads {
            let options = json!({ "cell_size": 0.05, "stress_update": scheme });
            let case = elastic_block()
                .with(json!({ "bodies": body, "loads": [load], "methods": { "mpm": options } }))
                .build();
            let mut solver = start_solver(&Mpm, &case);
            let start = force(&mut *solver);
            assert!((start[0] + 3.0).abs() < 0.02 && start[1].abs() < 0.02, "{start:?}");
            advance_to(&mut *solver, 1.0);
            let end = force(&mut *solver);
            assert!((end[0].hypot(end[1]) - 3.0).abs() < 0.05, "{scheme}: {end:?}");
            // Next to a free surface the lumped mass of a node does not lie at the node, and the rotation rate of its points
            // is lower: the surface lags behind by up to a fifth.
            assert!(
                (0..2).all(|c| (end[c] - exact[c]).abs() < 1.1),
                "{scheme}: {end:?} instead of {exact:?}"
            );
        }
    }
}

#[test]
fn each_load_of_a_body_grows_over_its_own_ramp() {
    let load = |side: &str, value: Value, ramp: f64| json!({ "kind": "traction", "body": "b", "side": side, "value": value, "ramp": ramp });
    let case = elastic_block()
        .with(json!({
            "loads": [load("x-max", json!([10, 0]), 0.1), load("y-max", json!([0, 20]), 0.4)],
            "stages": [{ "name": "s", "duration": 0.2 }]
        }))
        .build();
    let momentum = solve(&Mpm, &case).end.momentum;
    // 3 N and 6 N at full load: 3 × (0.2 - 0.05) and 6 × 0.2² / (2 × 0.4), but for the last part of the step.
    assert!(
        (momentum[0] / 0.45 - 1.0).abs() < 0.02 && (momentum[1] / 0.3 - 1.0).abs() < 0.02,
        "{momentum:?}"
    );
}

/// Resultants of the forces on the whole body in the next step: force (N) and moment about the origin (N m).
fn resultants(case: &Case) -> [f64; 3] {
    let mut solver = start_solver(&Mpm, case);
    let (before, dt) = (solver.totals(), solver.limit().dt);
    solver.step(dt).unwrap();
    let after = solver.totals();
    let force = |c: usize| (after.momentum[c] - before.momentum[c]) / dt;
    [force(0), force(1), (after.angular_momentum[2] - before.angular_momentum[2]) / dt]
}

#[test]
fn a_load_that_varies_along_its_side_has_the_resultants_of_its_profile() {
    let load = |kind: &str, value: Value, axis: &str, side: &str, shares: Value| {
        json!({ "kind": kind, "body": "b",
        "side": side, "value": value, "profile": { "axis": axis, "shares": shares } })
    };
    // Water of 0.2 m beside a block of 0.3 m that stands at y = 0.35 m, 2 kPa at its foot; its load goes through the
    // lowest third. And a strip of 1 kPa between 0.4 and 0.5 m on its top, pulled along as well.
    let water = json!([[0.35, 1], [0.55, 0]]);
    let strip = json!([[0.4, 0], [0.4, 1], [0.5, 1], [0.5, 0]]);
    let table = [
        (
            load("pressure", json!(2e3), "y", "x-max", water.clone()),
            [-200.0, 0.0, 200.0 * (0.35 + 0.2 / 3.0)],
        ),
        (load("traction", json!([-2e3, 0]), "y", "x-max", water), [-200.0, 0.0, 200.0 * (0.35 + 0.2 / 3.0)]),
        (
            load("traction", json!([50, -1e3]), "x", "y-max", strip),
            [5.0, -100.0, -100.0 * 0.45 - 5.0 * (0.65 - 0.0125)],
        ),
    ];
    let grids = [
        json!({ "cell_size": 0.05 }),
        json!({ "cell_size": 0.05, "shape": "quadratic" }),
        json!({ "cell_size": 0.05, "shape": "linear", "mesh": { "kind": "box" } }),
    ];
    let on_nodes = table.iter().filter(|(load, _)| load["kind"] == "traction");
    let on_nodes =
        on_nodes.map(|(load, exact)| (with_keys(load.clone(), &json!({ "applied_to": "nodes" })), *exact));
    for (load, exact) in table.iter().cloned().chain(on_nodes) {
        for options in
            grids.iter().filter(|options| load.get("applied_to").is_none() || options["shape"] != "quadratic")
        {
            let found = resultants(
                &elastic_block().with(json!({ "loads": [load], "methods": { "mpm": options } })).build(),
            );
            for c in 0..2 {
                assert!((found[c] - exact[c]).abs() < 1e-9, "{options}: {found:?} for {exact:?}");
            }
            // The lumped mass of a node at the surface does not lie at the node, and the points of triangles next to a
            // facet do not lie around its middle.
            let slack = if options.get("mesh").is_some() { 0.05 } else { 0.02 };
            assert!((found[2] / exact[2] - 1.0).abs() < slack, "{options}: {found:?} for {exact:?}");
        }
    }
}

#[test]
fn a_linearly_varying_pressure_causes_the_stress_of_a_beam() {
    // Between a smooth wall and a pressure from 1 kPa below to 3 kPa above, with a Poisson's ratio of zero: each fibre
    // has the stress of the pressure on its end, as in a beam in bending.
    let report = elastic_block().with(json!({
        "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0 } },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0.2], "max": [0.4, 0.8] } }],
        "boundaries": [{ "side": "x-min", "wall": { "kind": "smooth" } }],
        "loads": [{ "kind": "pressure", "body": "b", "side": "x-max", "value": 1e3, "ramp": 0.05,
                    "profile": { "axis": "y", "shares": [[0.2, 1], [0.8, 3]] } }],
        "stages": [{ "name": "s", "duration": 1.0, "damping": 0.3 }]
    })).solve(&Mpm);
    for (x, s) in report.snapshot.positions.iter().zip(stresses(&report.snapshot)) {
        let exact = -1e3 * (1.0 + 2.0 * (x[1] - 0.2) / 0.6);
        // A load is smeared over the outermost cells.
        if x[0] < 0.3 && (0.25..0.75).contains(&x[1]) {
            assert!((s[0] - exact).abs() < 60.0, "{} for {exact} at {x:?}", s[0]);
        }
    }
}
