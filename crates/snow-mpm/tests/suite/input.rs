//! What is refused and what is warned of (sheet: snow-mpm §7).

use colluvium_case::{Case, Method};
use colluvium_snow_mpm::SnowMpm;
use serde_json::{Value, json};

use crate::common::{ball, begun, block, refused};

#[test]
fn options_out_of_range_are_refused_by_name() {
    for (options, words) in [
        (json!({ "cell_size": 0 }), "methods.snow-mpm.cell_size: 0 must be finite and positive (m)"),
        (json!({ "cell_size": 0.07 }), "methods.snow-mpm.cell_size: along axis 0 the domain is 2 m wide"),
        (json!({ "points_per_cell": 0 }), "methods.snow-mpm.points_per_cell: 0 is not in 1..=20"),
        (
            json!({ "courant_elastic": 1.2 }),
            "methods.snow-mpm.courant_elastic: 1.2 is not in 0..=1 (0 excluded)",
        ),
        (
            json!({ "courant_velocity": 0 }),
            "methods.snow-mpm.courant_velocity: 0 is not in 0..=1 (0 excluded)",
        ),
        (
            json!({ "transfer": "flip", "flip_ratio": 1.1 }),
            "methods.snow-mpm.flip_ratio: 1.1 is not in 0..=1",
        ),
        (
            json!({ "flip_ratio": 1, "blend_time": 1 }),
            "methods.snow-mpm.blend_time: stands in place of flip_ratio",
        ),
        (json!({ "shape": "linear" }), "methods.snow-mpm.transfer: apic needs cubic or quadratic functions"),
        (json!({ "time_step": 1 }), "methods.snow-mpm.time_step: 1 s is larger than the critical step"),
        (json!({ "courant": 1 }), "methods.snow-mpm.courant: unknown key"),
    ] {
        let error = refused(&block(&json!({ "kind": "rest" }), &options));
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn what_the_method_does_not_have_is_refused_with_a_cure() {
    let change = |pointer: &str, value: Value| {
        let mut case = ball(&json!({}));
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        case.pointer_mut(parent).unwrap()[key] = value;
        refused(&case)
    };
    for (error, words) in [
        (change("/boundaries/0/wall", json!({ "kind": "absorbing" })), "use mpm"),
        (change("/domain/periodic", json!(["x"])), "smooth walls"),
        (
            change(
                "/patches",
                json!([{ "name": "p", "region": { "kind": "box", "min": [0, 0], "max": [1, 0.1] } }]),
            ),
            "boundary with a velocity",
        ),
        (change("/bodies/0/shape/centre", json!([0.95, 0.24])), "beyond the domain"),
        (change("/methods", json!({})), "cell_size"),
    ] {
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn warnings_name_what_is_doubtful() {
    for (options, words) in [
        (json!({ "transfer": "flip", "flip_ratio": 0.9 }), "flip_ratio: 0.9 damps"),
        (json!({ "flip_ratio": 0.99 }), "no effect"),
        (json!({ "points_per_cell": 1 }), "under-sample"),
        (json!({ "courant_elastic": 0.9 }), "courant_elastic: 0.9 is above 0.5"),
        (json!({ "shape": "linear", "transfer": "flip" }), "refining the grid makes it worse"),
        (json!({ "cell_size": 0.2 }), "2.00 cells across"),
    ] {
        let case = Case::from_json(&block(&json!({ "kind": "rest" }), &options).to_string()).unwrap();
        let warnings = SnowMpm.plan(&case).unwrap().warnings;
        assert!(warnings.iter().any(|warning| warning.contains(words)), "{words}: {warnings:?}");
    }
    let case = Case::from_json(&ball(&json!({})).to_string()).unwrap();
    assert_eq!(SnowMpm.plan(&case).unwrap().warnings, Vec::<String>::new());
}

#[test]
fn a_point_that_leaves_ends_the_run_unless_its_body_lets_it() {
    let mut value = block(&json!({ "kind": "uniform", "value": [20, 0] }), &json!({}));
    let mut solver = begun(&value);
    let error = loop {
        let dt = solver.limit().dt;
        if let Err(error) = solver.step(dt) {
            break error.to_string();
        }
    };
    assert!(error.contains("it left the domain: enlarge the domain"), "{error}");
    value["bodies"][0]["drop_outside"] = json!(true);
    let mut solver = begun(&value);
    let mass = solver.totals().mass;
    while solver.time() < 0.05 {
        let dt = solver.limit().dt;
        solver.step(dt).unwrap();
    }
    assert!(solver.totals().mass < 0.7 * mass && solver.points() > 0);
    let lost = crate::common::reading(&*solver, "energy_numerical");
    assert!(lost.abs() < 1e-6 * mass * 200.0, "{lost} J");
}
