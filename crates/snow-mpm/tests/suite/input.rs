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

/// A column of 2 m with a weak layer of `layer` (m) under a slab of 0.4 m, that a saw of this speed (m/s) cuts.
fn saw_test(length: f64, layer: f64, speed: f64) -> Value {
    json!({
        "title": "saw", "space": "plane-strain", "domain": { "min": [-0.1, 0], "max": [2.4, 0.6] }, "gravity": [0, -9.81],
        "materials": {
            "slab": { "model": "linear-elastic", "strain_measure": "hencky", "density": 250, "youngs_modulus": 3e6, "poissons_ratio": 0.3 },
            "weak": { "model": "cohesive-cam-clay", "density": 100, "youngs_modulus": 1e6, "poissons_ratio": 0.3,
                "critical_state_slope": 1.2, "cohesion_ratio": 0.3, "compressive_strength": 3000, "hardening_factor": 0.02,
                "hardening": { "kind": "weak-layer", "softening_factor": 20 } } },
        "bodies": [
            { "name": "weak", "material": "weak", "shape": { "kind": "box", "min": [0, 0], "max": [length, layer] } },
            { "name": "slab", "material": "slab", "shape": { "kind": "box", "min": [0, layer], "max": [length, layer + 0.4] } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } }],
        "cuts": [{ "name": "saw", "bodies": ["weak"], "velocity": [-speed, 0],
            "shape": { "kind": "box", "min": [length, -0.1], "max": [length + 1.0, 0.2] } }],
        "stages": [{ "name": "saw", "duration": 0.01 }],
        "methods": { "snow-mpm": { "cell_size": 0.025 } }
    })
}

#[test]
fn a_saw_test_that_measures_something_else_is_warned_of() {
    let warnings = |length, layer, speed| {
        let case = Case::from_json(&saw_test(length, layer, speed).to_string()).unwrap();
        SnowMpm.plan(&case).unwrap().warnings
    };
    assert_eq!(warnings(2.0, 0.1, 1.0), Vec::<String>::new());
    // Shear waves run with 67.9 m/s in the slab.
    for (found, words) in [
        (warnings(2.0, 0.1, 3.5), "cuts[0].velocity: 3.5 m/s is above a twentieth"),
        (warnings(1.9, 0.1, 1.0), "cuts[0]: what it cuts is 1.9 m long, less than five times the 0.400 m"),
        (warnings(2.0, 0.05, 1.0), "bodies[0].shape: 2.00 cells across"),
    ] {
        assert!(found.len() == 1 && found[0].starts_with(words), "{words}: {found:?}");
    }
    let error = refused(&saw_test(2.0, 0.025, 1.0));
    assert!(error.starts_with("bodies[0].shape: a weak layer of 0.025 m is less than two cells"), "{error}");
}

#[test]
fn layers_along_a_track_are_as_thin_as_they_lie_and_its_friction_is_looked_at() {
    let mut case = saw_test(2.0, 0.1, 1.0);
    (case["cuts"], case["boundaries"]) = (json!([]), json!([]));
    case["domain"] = json!({ "min": [-1, -2], "max": [3, 1] });
    case["obstacles"] = json!([{ "name": "track", "wall": { "kind": "frictional", "friction_coefficient": 2.5 },
        "shape": { "kind": "profile", "start": [-0.5, 0.5], "pieces": [{ "to": [2.5, -1] }] } }]);
    let layer = |from: f64, to: f64| json!({ "kind": "arc-layer", "on": "track", "start": 0.5, "end": 2.5, "from": from, "to": to });
    (case["bodies"][0]["shape"], case["bodies"][1]["shape"]) = (layer(0.0, 0.075), layer(0.08, 0.4));
    let warnings = SnowMpm.plan(&Case::from_json(&case.to_string()).unwrap()).unwrap().warnings;
    for words in ["bodies[0].shape: 3.00 cells across", "obstacles[0].wall.friction_coefficient: 2.5 is more"]
    {
        assert!(warnings.iter().any(|warning| warning.starts_with(words)), "{words}: {warnings:?}");
    }
    (case["bodies"][0]["shape"], case["bodies"][1]["shape"]) = (layer(0.0, 0.025), layer(0.03, 0.4));
    assert!(refused(&case).starts_with("bodies[0].shape: a weak layer"), "{}", refused(&case));
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
