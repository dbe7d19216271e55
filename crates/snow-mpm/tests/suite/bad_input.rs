//! Refusals and warnings (sheet: snow-mpm §7).

use colluvium_case::Method;
use colluvium_snow_mpm::SnowMpm;
use colluvium_testkit::{read_case, refusal, scalar_output, start_solver};
use serde_json::{Value, json};

use crate::bodies::{ball, block};

#[test]
fn options_out_of_range_are_refused_by_name() {
    for (options, words) in [
        (json!({ "cell_size": 0 }), "methods.snow-mpm.cell_size: 0 must be finite and positive (m)"),
        (json!({ "cell_size": 0.07 }), "methods.snow-mpm.cell_size: along x the domain is 2 m wide"),
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
        (json!({ "flip_ratio": 1, "blend_time": 1 }), "methods.snow-mpm.blend_time: replaces flip_ratio"),
        (json!({ "shape": "linear" }), "methods.snow-mpm.transfer: apic needs cubic or quadratic functions"),
        (json!({ "time_step": 1 }), "methods.snow-mpm.time_step: 1 s is larger than the critical step"),
        (json!({ "courant": 1 }), "methods.snow-mpm.courant: unknown key"),
    ] {
        let error = refusal(&SnowMpm, &block(&json!({ "kind": "rest" }), &options));
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn unsupported_features_are_refused_with_an_alternative() {
    let change = |pointer: &str, value: Value| {
        let mut case = ball(&json!({}));
        let (parent, key) = pointer.rsplit_once('/').unwrap();
        case.pointer_mut(parent).unwrap()[key] = value;
        refusal(&SnowMpm, &case)
    };
    for (error, words) in [
        (change("/boundaries/0/wall", json!({ "kind": "absorbing" })), "use mpm"),
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
fn invariants_of_the_plane_are_refused_in_space() {
    let mut case = ball(&json!({}));
    case["materials"]["snow"]["invariants"] = json!("plane");
    assert!(SnowMpm.plan(&read_case(&case)).is_ok());
    case["space"] = json!("3d");
    (case["domain"], case["gravity"]) =
        (json!({ "min": [-1, 0, -1], "max": [1, 0.6, 1] }), json!([0, -9.81, 0]));
    case["bodies"][0]["shape"]["centre"] = json!([0, 0.24, 0]);
    case["bodies"][0]["velocity"]["value"] = json!([0, -5, 0]);
    assert!(
        refusal(&SnowMpm, &case).starts_with("materials.snow: its law has no strain normal to the plane"),
        "{}",
        refusal(&SnowMpm, &case)
    );
}

#[test]
fn doubtful_options_cause_warnings_that_name_them() {
    for (options, words) in [
        (json!({ "transfer": "flip", "flip_ratio": 0.9 }), "flip_ratio: 0.9 damps"),
        (json!({ "flip_ratio": 0.99 }), "no effect"),
        (json!({ "points_per_cell": 1 }), "under-sample"),
        (json!({ "courant_elastic": 0.9 }), "courant_elastic: 0.9 is above 0.5"),
        (json!({ "shape": "linear", "transfer": "flip" }), "refining the grid makes it worse"),
        (
            json!({ "cell_size": 0.25 }),
            "its smallest thickness is 1.60 cells; shape functions extend across it",
        ),
    ] {
        let case = read_case(&block(&json!({ "kind": "rest" }), &options));
        let warnings = SnowMpm.plan(&case).unwrap().warnings;
        assert!(warnings.iter().any(|warning| warning.text.contains(words)), "{words}: {warnings:?}");
    }
    for (ratio, words) in [(0.46, "0.46 is above 0.45"), (-0.1, "-0.1 is negative")] {
        let mut case = block(&json!({ "kind": "rest" }), &json!({}));
        case["materials"]["m"]["poissons_ratio"] = json!(ratio);
        let warnings = SnowMpm.plan(&read_case(&case)).unwrap().warnings;
        let expected = format!("materials.m.poissons_ratio: {words}");
        assert!(warnings.len() == 1 && warnings[0].text.starts_with(&expected), "{warnings:?}");
    }
    let case = read_case(&ball(&json!({})));
    assert_eq!(SnowMpm.plan(&case).unwrap().warnings, Vec::<colluvium_case::Warning>::new());
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
        "removal_shapes": [{ "name": "saw", "stage": "saw", "bodies": ["weak"], "velocity": [-speed, 0],
            "shape": { "kind": "box", "min": [length, -0.1], "max": [length + 1.0, 0.2] } }],
        "stages": [{ "name": "settle", "duration": 0.01 }, { "name": "saw", "duration": 0.01 }],
        "methods": { "snow-mpm": { "cell_size": 0.025 } }
    })
}

#[test]
fn a_saw_test_that_measures_something_else_is_refused() {
    let warnings = |case: &Value| SnowMpm.plan(&read_case(case)).unwrap().warnings;
    assert_eq!(warnings(&saw_test(2.0, 0.1, 1.0)), Vec::<colluvium_case::Warning>::new());
    let thin = warnings(&saw_test(2.0, 0.05, 1.0));
    assert!(
        thin.len() == 1 && thin[0].text.starts_with("bodies[0].shape: its smallest thickness is 2.00 cells"),
        "{thin:?}"
    );
    let with = |pointer: &str, value: Value| {
        let mut case = saw_test(2.0, 0.1, 1.0);
        *case.pointer_mut(pointer).unwrap() = value;
        refusal(&SnowMpm, &case)
    };
    // Shear waves run with 67.9 m/s in the slab, which weighs 1054 Pa with the layer.
    let slanted = |x: f64, y: f64, height: f64| {
        let (low, high) = (x + 0.2 * y, x + 0.2 * (y + height));
        json!({ "kind": "polygon", "vertices": [[low, y], [1.9 + low, y], [1.9 + high, y + height], [high, y + height]] })
    };
    let mut parallelogram = saw_test(2.0, 0.1, 1.0);
    parallelogram["bodies"][0]["shape"] = slanted(0.0, 0.0, 0.1);
    parallelogram["bodies"][1]["shape"] = slanted(0.0, 0.1, 0.4);
    for (error, words) in [
        (
            refusal(&SnowMpm, &saw_test(2.0, 0.1, 3.5)),
            "removal_shapes[0].velocity: 3.5 m/s is above a twentieth",
        ),
        (
            refusal(&SnowMpm, &saw_test(2.0, 0.1, 3.5)),
            "in the slab (67.9 m/s), so that the crack depends on the speed of the cut: saw with 3.39 m/s",
        ),
        (
            refusal(&SnowMpm, &saw_test(1.9, 0.1, 1.0)),
            "removal_shapes[0]: the cut column is 1.9000 m long, less than five times the thickness of its slab (0.4000 m)",
        ),
        (refusal(&SnowMpm, &saw_test(1.9, 0.1, 1.0)), "make it 2.0000 m long or longer"),
        (refusal(&SnowMpm, &parallelogram), "removal_shapes[0]: the cut column is 1.9"),
        (
            refusal(&SnowMpm, &saw_test(2.0, 0.025, 1.0)),
            "bodies[0].shape: the weak layer is 0.025 m thick, less than two cells",
        ),
        (
            with("/materials/weak/compressive_strength", json!(1000)),
            "materials.weak.compressive_strength: a layer of 1000 Pa yields at rest under its slab (pressure 1079 Pa, shear stress 0 Pa)",
        ),
        (
            with("/gravity", json!([9.4, -2.8])),
            "yields at rest under its slab (pressure 308 Pa, shear stress 1034 Pa)",
        ),
    ] {
        assert!(error.contains(words), "{words}: {error}");
    }
}

#[test]
fn cuts_that_deviate_from_a_saw_test_cause_a_warning() {
    let warnings = |length, speed| {
        let mut case = saw_test(length, 0.1, speed);
        case["materials"]["weak"]["hardening"] = json!({ "kind": "slab" });
        SnowMpm.plan(&read_case(&case)).unwrap().warnings
    };
    assert_eq!(warnings(2.0, 1.0), Vec::<colluvium_case::Warning>::new());
    for (found, words) in [
        (warnings(2.0, 3.5), "removal_shapes[0].velocity: 3.5 m/s is above a twentieth"),
        (
            warnings(1.9, 1.0),
            "removal_shapes[0]: the cut material is 1.9 m long, less than five times the thickness of the remaining material (0.400 m)",
        ),
    ] {
        assert!(found.len() == 1 && found[0].text.starts_with(words), "{words}: {found:?}");
    }
    let mut at_once = saw_test(2.0, 0.1, 1.0);
    at_once["removal_shapes"][0]["stage"] = json!("settle");
    let warnings_found = SnowMpm.plan(&read_case(&at_once)).unwrap().warnings;
    assert!(
        warnings_found.len() == 1
            && warnings_found[0].text.starts_with("removal_shapes[0]: begins with the run"),
        "{warnings_found:?}"
    );
    let mut all = saw_test(2.0, 0.1, 1.0);
    all["removal_shapes"][0].as_object_mut().unwrap().remove("bodies");
    let warnings_found = SnowMpm.plan(&read_case(&all)).unwrap().warnings;
    assert!(
        warnings_found.len() == 1
            && warnings_found[0].text.starts_with("removal_shapes[0]: removes all bodies"),
        "{warnings_found:?}"
    );
    // A body below the layer, or on a small part of it, is no slab.
    let mut case = saw_test(2.0, 0.1, 1.0);
    case["gravity"] = json!([0, 9.81]);
    assert!(SnowMpm.plan(&read_case(&case)).is_ok());
    case["gravity"] = json!([0, -9.81]);
    let load = json!({ "name": "load", "material": "slab", "shape": { "kind": "box", "min": [0.5, 0.5], "max": [0.7, 0.6] } });
    case["bodies"].as_array_mut().unwrap().push(load);
    assert!(SnowMpm.plan(&read_case(&case)).is_ok());
}

/// Warning of a saw test on cells of 50 mm as the saw begins, with a layer of this strength (Pa) under 1079 Pa.
fn begins(settle: &Value, strength: f64) -> Result<Option<String>, String> {
    let mut value = saw_test(2.0, 0.1, 1.0);
    value["domain"] = json!({ "min": [-0.1, 0], "max": [2.4, 0.6] });
    value["methods"]["snow-mpm"]["cell_size"] = json!(0.05);
    value["materials"]["weak"]["compressive_strength"] = json!(strength);
    value["stages"] = json!([settle, { "name": "saw", "duration": 0.01 }]);
    let case = read_case(&value);
    let mut solver = start_solver(&SnowMpm, &read_case(&value));
    let duration = settle["duration"].as_f64().unwrap();
    colluvium_testkit::advance_to(&mut *solver, duration);
    solver.end_stage(&case.stages[0]).unwrap();
    solver.begin_stage(1, duration).unwrap();
    let dt = solver.limit().dt;
    solver.step(dt).map_err(|error| error.to_string())?;
    Ok(solver.warning().map(|warning| warning.text))
}

#[test]
fn a_layer_that_yields_before_the_saw_ends_the_run() {
    let settles = json!({ "name": "settle", "duration": 0.2, "damping": 0.5, "gravity_ramp": 0.14 });
    assert_eq!(begins(&settles, 2500.0), Ok(None));
    // Its weight still comes, and nothing damps it.
    let hasty = json!({ "name": "settle", "duration": 0.03, "gravity_ramp": 0.03 });
    let warning = begins(&hasty, 2500.0).unwrap().unwrap();
    assert!(warning.starts_with("the first cut began with points as fast as"), "{warning}");
    // Next to the bed, in two cells, some points carry more than the mean.
    let warning = begins(&settles, 1500.0).unwrap().unwrap();
    assert!(
        warning.starts_with("at the end of stage \"settle\"") && warning.contains("of the 320 points"),
        "{warning}"
    );
    // A weight that comes at once presses twice as much.
    let error = begins(&json!({ "name": "drop", "duration": 0.02 }), 1300.0).unwrap_err();
    assert!(
        error.contains("points of the weak layer \"weak\" have collapsed at rest, before the first cut"),
        "{error}"
    );
    assert!(error.contains("t = 0.02") && error.contains("gravity_ramp"), "{error}");
}

#[test]
fn layers_on_a_slope_are_measured_along_its_normal_and_their_friction_is_checked() {
    let mut case = saw_test(2.0, 0.1, 1.0);
    (case["removal_shapes"], case["boundaries"]) = (json!([]), json!([]));
    case["domain"] = json!({ "min": [-1, -2], "max": [3, 1] });
    case["obstacles"] = json!([{ "name": "track", "wall": { "kind": "frictional", "friction_coefficient": 2.5 },
        "shape": { "kind": "profile", "start": [-0.5, 0.5], "pieces": [{ "to": [2.5, -1] }] },
        "regions": [{ "shape": { "kind": "box", "min": [0], "max": [1] }, "wall": { "kind": "smooth" } },
            { "shape": { "kind": "box", "min": [1], "max": [2] }, "wall": { "kind": "frictional", "friction_coefficient": 3 } }] }]);
    let layer = |from: f64, to: f64| json!({ "kind": "arc-layer", "on": "track", "start": 0.5, "end": 2.5, "from": from, "to": to });
    (case["bodies"][0]["shape"], case["bodies"][1]["shape"]) = (layer(0.0, 0.075), layer(0.08, 0.4));
    let warnings = SnowMpm.plan(&read_case(&case)).unwrap().warnings;
    for words in [
        "bodies[0].shape: its smallest thickness is 3.00 cells",
        "bodies[0].shape.from: the weak layer lies 0.00 cells above the ground",
        "obstacles[0].wall.friction_coefficient: 2.5 is more",
        "obstacles[0].regions[1].wall.friction_coefficient: 3 is more",
    ] {
        assert!(warnings.iter().any(|warning| warning.text.starts_with(words)), "{words}: {warnings:?}");
    }
    (case["bodies"][0]["shape"], case["bodies"][1]["shape"]) = (layer(0.0, 0.025), layer(0.03, 0.4));
    assert!(
        refusal(&SnowMpm, &case).starts_with("bodies[0].shape: the weak layer is"),
        "{}",
        refusal(&SnowMpm, &case)
    );
}

#[test]
fn measure_lengths_incompatible_with_the_cell_size_cause_a_warning() {
    let warnings = |link: f64, bin: f64| {
        let mut case = saw_test(2.0, 0.1, 1.0);
        case["measures"] = json!({
            "pieces": { "kind": "fragments", "link": link },
            "crack": { "kind": "crack-tip", "body": "weak", "field": "collapsed", "direction": [-1, 0], "from": [2, 0], "bin": bin } });
        SnowMpm.plan(&read_case(&case)).unwrap().warnings
    };
    assert_eq!(warnings(0.03, 0.025), Vec::<colluvium_case::Warning>::new());
    let found = warnings(0.02, 0.01);
    assert!(found.len() == 2 && found[0].text.starts_with("measures.crack.bin: 0.01 m"), "{found:?}");
    assert!(found[1].text.starts_with("measures.pieces.link: 0.02 m is 0.80 cells"), "{found:?}");
}

#[test]
fn a_point_leaving_the_domain_ends_the_run_unless_remove_outside_is_set() {
    let mut value = block(&json!({ "kind": "uniform", "value": [20, 0] }), &json!({}));
    let mut solver = start_solver(&SnowMpm, &read_case(&value));
    let error = loop {
        let dt = solver.limit().dt;
        if let Err(error) = solver.step(dt) {
            break error.to_string();
        }
    };
    assert!(error.contains("it left the domain: enlarge the domain"), "{error}");
    value["bodies"][0]["remove_outside"] = json!(true);
    let mut solver = start_solver(&SnowMpm, &read_case(&value));
    let mass = solver.totals().mass;
    while solver.time() < 0.05 {
        let dt = solver.limit().dt;
        solver.step(dt).unwrap();
    }
    assert!(solver.totals().mass < 0.7 * mass && solver.point_count() > 0);
    let lost = scalar_output(&*solver, "energy_numerical");
    assert!(lost.abs() < 1e-6 * mass * 200.0, "{lost} J");
}
