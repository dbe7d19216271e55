//! Bad input is refused with its path (sheet: dem §7).

use colluvium_case::{Case, Method};
use colluvium_dem::Dem;
use colluvium_testkit::read_case;
use serde_json::{Value, json};

use crate::single_grains::{Scene, floor, linear};

fn refusal(change: impl Fn(&mut Value)) -> String {
    let mut scene = Scene::new(linear(1e6, 0.1, 0.5, 0.5)).disk([0.0, 0.6], 0.5, [0.0; 2], 0.0).disk(
        [1.2, 0.6],
        0.5,
        [0.0; 2],
        0.0,
    );
    scene.boundaries = floor(&json!({ "kind": "rough" }));
    let mut value = scene.json();
    assert!(Dem.build(&read_case(&value)).is_ok());
    change(&mut value);
    let built = Case::from_json(&value.to_string()).map_err(|errors| errors.to_string());
    match built.and_then(|case| Dem.build(&case).map(|_| ()).map_err(|error| error.to_string())) {
        Err(problem) => problem,
        Ok(()) => panic!("is not refused"),
    }
}

/// Hertz law with one number changed.
fn hertz(key: &str, value: f64) -> Value {
    let mut law = json!({ "law": "hertz", "youngs_modulus": 1e7, "poissons_ratio": 0.3, "restitution": 0.5 });
    law[key] = json!(value);
    law
}

/// Bond with one number changed.
fn bond(key: &str, value: f64) -> Value {
    let mut bond = json!({ "normal_stiffness": 1e6, "shear_stiffness": 1e6, "gap": 0.5 });
    bond[key] = json!(value);
    bond
}

/// Grading curve.
fn beta(min: f64, max: f64, a: f64) -> Value {
    json!({ "distribution": "cumulative-beta", "min": min, "max": max, "a": a, "b": 4 })
}

/// Further invalid input: laws, sizes, bonds, stages.
fn numbers() -> Vec<(&'static str, Value, &'static str)> {
    vec![
        ("/pairs/0/normal", hertz("poissons_ratio", 0.6), "methods.dem.pairs[0].normal.poissons_ratio"),
        ("/pairs/0/normal", hertz("poissons_ratio", -1.0), "methods.dem.pairs[0].normal.poissons_ratio"),
        ("/pairs/0/normal", hertz("youngs_modulus", 0.0), "methods.dem.pairs[0].normal.youngs_modulus"),
        ("/pairs/0/normal", hertz("restitution", 1.2), "methods.dem.pairs[0].normal.restitution"),
        ("/pairs/0/normal", hertz("restitution", 0.001), "methods.dem.pairs[0].normal.restitution"),
        ("/pairs/0/normal", hertz("restitution", 0.0), "methods.dem.pairs[0].normal.restitution"),
        ("/pairs/0/bond", bond("radius_factor", 0.0), "methods.dem.pairs[0].bond.radius_factor"),
        ("/pairs/0/bond", bond("tensile_strength", -1.0), "methods.dem.pairs[0].bond.tensile_strength"),
        ("/pairs/0/bond", bond("scatter", 1.5), "methods.dem.pairs[0].bond.scatter"),
        // The grains are 0.2 m apart.
        ("/pairs/0/bond", bond("gap", 0.1), "methods.dem.pairs"),
        (
            "/pairs/0/adhesion",
            json!({ "kind": "capillary", "surface_tension": 0.07, "contact_angle": 90, "volume_ratio": 0.01 }),
            "methods.dem.pairs[0].adhesion.contact_angle",
        ),
        ("/grains/grain/diameter", beta(0.0, 1.0, 4.0), "methods.dem.grains.grain.diameter.min"),
        ("/grains/grain/diameter", beta(1.0, 0.5, 4.0), "methods.dem.grains.grain.diameter.max"),
        ("/grains/grain/diameter", beta(0.5, 1.0, 0.0), "methods.dem.grains.grain.diameter.a"),
        (
            "/grains/grain/fill",
            json!({ "kind": "random", "solid_fraction": 1.2 }),
            "methods.dem.grains.grain.fill.solid_fraction",
        ),
        ("/step_fraction", json!(0.2), "methods.dem.step_fraction"),
        ("/time_step", json!(0), "methods.dem.time_step"),
        ("/initial_overlap", json!(0.5), "methods.dem.initial_overlap"),
        ("/bodies/grain 0/spin", json!([1, 0, 0]), "methods.dem.bodies.grain 0.spin"),
        (
            "/stages",
            json!({ "all": { "cell": { "xx": { "stress": -1 } } } }),
            "methods.dem.stages.all.cell.xx",
        ),
        ("/stages", json!({ "all": { "cell": { "zz": { "rate": 0 } } } }), "methods.dem.stages.all.cell.zz"),
        ("/stages", json!({ "all": { "gravity": [0] } }), "methods.dem.stages.all.gravity"),
        ("/stages", json!({ "all": { "agitation": -1 } }), "methods.dem.stages.all.agitation"),
    ]
}

#[test]
fn invalid_options_are_refused_with_their_path() {
    let dem = "/methods/dem";
    let cases: Vec<(&str, Value, &str)> = vec![
        ("/grains/grain/density", json!(-1), "methods.dem.grains.grain.density"),
        ("/pairs/0/normal/stiffness", json!(0), "methods.dem.pairs[0].normal.stiffness"),
        ("/pairs/0/normal/restitution", json!(0.5), "methods.dem.pairs[0].normal.damping_ratio"),
        ("/pairs/0/normal/damping_ratio", json!(-0.1), "methods.dem.pairs[0].normal.damping_ratio"),
        ("/pairs/0/normal/damping_ratio", json!(50), "methods.dem.pairs[0].normal.damping_ratio"),
        ("/pairs/0/tangential/damping_ratio", json!(50), "methods.dem.pairs[0].tangential.damping_ratio"),
        ("/pairs/0/tangential/stiffness_ratio", json!(4), "methods.dem.pairs[0].tangential.stiffness_ratio"),
        ("/pairs/0/friction/coefficient", json!(-0.2), "methods.dem.pairs[0].friction.coefficient"),
        ("/pairs/0/friction/at_rest", json!(0.2), "methods.dem.pairs[0].friction.at_rest"),
        ("/pairs/0/rolling", json!({ "friction": -1 }), "methods.dem.pairs[0].rolling.friction"),
        ("/pairs/0/twisting", json!({ "friction": 1 }), "methods.dem.pairs[0].twisting"),
        (
            "/pairs/0/adhesion",
            json!({ "kind": "jkr", "work_of_adhesion": 1 }),
            "methods.dem.pairs[0].adhesion.kind",
        ),
        ("/pairs/0/between", json!(["grain", "flor"]), "methods.dem.pairs[0].between[1]"),
        ("/pairs", json!([]), "methods.dem.pairs"),
        ("/skin", json!(0), "methods.dem.skin"),
        ("/time_step", json!(1.0), "methods.dem.time_step"),
        ("/stages", json!({ "al": {} }), "methods.dem.stages.al"),
        ("/bodies/nobody", json!({}), "methods.dem.bodies.nobody"),
        ("/clumps", json!([]), "methods.dem.clumps"),
    ];
    for (pointer, value, path) in cases.into_iter().chain(numbers()) {
        let problem = refusal(|case| {
            let (parent, key) = pointer.rsplit_once('/').unwrap();
            case.pointer_mut(&format!("{dem}{parent}")).unwrap()[key] = value.clone();
        });
        assert!(problem.contains(&format!("{path}:")), "{pointer}: {problem}");
    }
}

/// Grains without attraction carry no tension, and grains of any kind no pressure near their stiffness.
#[test]
fn unattainable_controlled_stresses_are_refused_with_their_path() {
    let cell = |entry: Value| {
        json!({
            "title": "cell", "space": "plane-strain", "gravity": [0, 0],
            "domain": { "min": [0, 0], "max": [20, 20], "periodic": ["x", "y"] },
            "materials": { "disk": { "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 } },
            "bodies": [{ "name": "b", "material": "disk", "shape": { "kind": "box", "min": [0, 0], "max": [20, 20] } }],
            "stages": [{ "name": "all", "duration": 1 }],
            "methods": { "dem": {
                "grains": { "disk": { "density": 1, "diameter": { "distribution": "equal", "value": 1 },
                    "fill": { "kind": "lattice", "packing": "square" } } },
                "pairs": [{ "between": ["disk", "disk"], "normal": { "law": "linear", "stiffness": 1000 } }],
                "stages": { "all": { "cell": { "yy": entry } } }
            } }
        })
    };
    let problem = |value: Value| {
        let case = read_case(&value);
        Dem.build(&case).map(|_| ()).map_err(|error| error.to_string())
    };
    let start = "methods.dem.stages.all.cell.yy.";
    let refused = |entry: Value| problem(cell(entry)).unwrap_err();
    assert!(refused(json!({ "stress": 0 })).starts_with(&format!("{start}stress: 0 must be negative")));
    assert!(
        refused(json!({ "stress": -160 }))
            .starts_with(&format!("{start}stress: 1.6000e2 Pa causes overlaps"))
    );
    let swing = |mean: f64| json!({ "cyclic-stress": { "mean": mean, "amplitude": 2, "period": 1 } });
    assert!(refused(swing(-1.0)).starts_with(&format!("{start}cyclic-stress: 1 must be negative")));
    assert_eq!(problem(cell(swing(-3.0))), Ok(()));
    assert_eq!(problem(cell(json!({ "stress": -140 }))), Ok(()));
    let mut bonded = cell(json!({ "stress": 1 }));
    bonded["methods"]["dem"]["pairs"][0]["bond"] = json!({ "normal_stiffness": 1e3, "shear_stiffness": 1e3 });
    assert_eq!(problem(bonded), Ok(()));
}

#[test]
fn grains_that_start_in_a_wall_are_refused_with_their_position() {
    let problem = refusal(|case| {
        case["methods"]["dem"]["initial_overlap"] = json!(0.01);
        case["bodies"][0]["shape"]["centre"] = json!([0.0, 0.48]);
    });
    assert!(problem.starts_with("bodies[0].shape: grain 0 ") && problem.contains("a wall"), "{problem}");
}

#[test]
fn clumps_are_refused_by_key_and_rolling_resistance_is_suggested() {
    for path in ["clumps", "grains.grain.clump"] {
        let problem = refusal(|value| match path {
            "clumps" => value["methods"]["dem"]["clumps"] = json!([]),
            _ => value["methods"]["dem"]["grains"]["grain"]["clump"] = json!({ "spheres": 2 }),
        });
        assert!(
            problem.starts_with(&format!("methods.dem.{path}: dem has disks and spheres, but no clumps")),
            "{problem}"
        );
        assert!(problem.contains("`rolling`"), "{problem}");
    }
}
