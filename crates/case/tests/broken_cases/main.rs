//! Invalid case files: each gives an error with path and description.

mod error_kinds;
mod mutations;
mod non_finite_numbers;

use colluvium_case::Case;
use colluvium_testkit::set_value;
use serde_json::{Value, json};

/// Mistakes, one a row: JSON pointer into the valid case, value set there (null removes the key), path and words of the error.
const MISTAKES: &str = include_str!("mistakes.json");

fn sound() -> Value {
    json!({
        "title": "sound", "space": "plane-strain",
        "domain": { "min": [0, 0], "max": [1, 1] }, "gravity": [0, -9.81],
        "materials": { "sand": {
            "model": "mohr-coulomb", "density": 1600, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 30
        } },
        "bodies": [
            { "name": "a", "material": "sand", "shape": { "kind": "box", "min": [0, 0], "max": [0.4, 0.4] } },
            { "name": "b", "material": "sand", "shape": { "kind": "ball", "centre": [0.7, 0.7], "radius": 0.1 } }
        ],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "frictional", "friction_coefficient": 0.5 } }],
        "loads": [{ "kind": "traction", "body": "a", "side": "y-max", "value": [0, -100] }],
        "stages": [{ "name": "settle", "duration": 1, "damping": 0.7, "equilibrium": {} }, { "name": "go", "duration": 1 }],
        "measures": {
            "front": { "kind": "front", "side": "x-max" },
            "eye": { "kind": "probe", "position": [0.2, 0.2], "radius": 0.1, "fields": ["stress"] }
        },
        "output": { "frames": 0.1 },
        "methods": { "mpm": { "cell_size": 0.1 } }
    })
}

/// Valid case with the value at a JSON pointer replaced (or removed, for null).
fn sound_with(pointer: &str, value: &Value) -> Value {
    let mut case = sound();
    let parent = pointer.rsplit_once('/').expect("a pointer").0;
    assert!(case.pointer(parent).is_some(), "{pointer} leads nowhere");
    set_value(&mut case, pointer, value);
    case
}

#[test]
fn the_valid_case_round_trips() {
    let case = Case::from_json(&sound().to_string()).unwrap();
    assert_eq!(Case::from_json(&case.to_json()).unwrap(), case);
    assert_eq!(case.fingerprint(), Case::from_json(&case.to_json()).unwrap().fingerprint());
}

#[test]
fn every_mistake_is_reported_at_its_path() {
    let rows: Vec<(String, Value, String, String)> =
        serde_json::from_str(MISTAKES).expect("the file is valid");
    for (pointer, value, path, words) in rows {
        let errors = Case::from_json(&sound_with(&pointer, &value).to_string()).expect_err(&pointer);
        let found = errors.0.iter().any(|error| error.path == path && error.problem().contains(&words));
        assert!(found, "{pointer}: expected `{path}: …{words}…`, found\n{errors}");
        assert!(errors.to_string().lines().all(|line| line.contains(": ")));
    }
}

#[test]
fn walls_removed_by_a_stage_remain_removed_after_the_last_stage() {
    let case =
        Case::from_json(&sound_with("/stages/1/remove_boundaries", &json!(["y-min"])).to_string()).unwrap();
    let active = |stage| case.active_boundaries(stage).len();
    assert_eq!([active(0), active(1), active(2), active(usize::MAX)], [1, 0, 0, 0]);
}

#[test]
fn a_stage_motion_of_an_obstacle_is_refused_with_its_key() {
    let mut value = sound();
    value["obstacles"] = json!([
        { "name": "ground", "shape": { "kind": "plane", "point": [0, 0], "normal": [0, 1] }, "wall": { "kind": "rough" } }
    ]);
    value["stages"][0]["motions"] = json!([{ "target": "ground", "velocity": [0, 0] }]);
    let errors = Case::from_json(&value.to_string()).unwrap_err();
    assert_eq!(errors.0[0].path, "stages[0].motions[0].target", "{errors}");
    assert!(errors.0[0].problem().contains("give its motion in obstacles[0].motion"), "{errors}");
}

#[test]
fn errors_of_json_syntax_have_line_and_column() {
    for (text, place, words) in [
        ("", "line 1, column 0", "EOF"),
        ("{ \"title\": ", "line 1", "EOF"),
        ("{ \"title\": 'x' }", "line 1, column", "expected value"),
        ("{\n  \"title\": \"a\",\n  \"title\": \"b\"\n}", "line 4", "\"title\" appears twice"),
        ("{ \"gravity\": [0, 1e999] }", "line 1", "out of range"),
        ("[1, 2]", "case file", "not of type object"),
        ("null", "case file", "not of type object"),
    ] {
        let errors = Case::from_json(text).unwrap_err();
        let first = errors.first();
        assert!(first.path.contains(place) && first.problem().contains(words), "{text}: {errors}");
    }
    let deep = "[".repeat(5000);
    assert!(Case::from_json(&deep).is_err());
}

#[test]
fn several_mistakes_are_all_reported() {
    let mut case = sound_with("/materials/sand/friction_angle", &json!(95));
    case["stages"][0]["damping"] = json!(2);
    case["bodies"][0]["material"] = json!("clay");
    let errors = Case::from_json(&case.to_string()).unwrap_err();
    assert_eq!(errors.0.len(), 3, "{errors}");
}

#[test]
fn errors_in_dimensions_do_not_hide_other_errors() {
    let mut case = sound_with("/domain/max", &json!([1]));
    case["domain"]["min"] = json!([2, 0]);
    case["gravity"] = json!([0, 0, -9.81]);
    case["stages"][0]["damping"] = json!(2);
    case["bodies"][0]["material"] = json!("clay");
    case["bodies"][1]["shape"]["radius"] = json!(-1);
    case["measures"]["eye"]["radius"] = json!(0);
    case["measures"]["eye"]["position"] = json!([0.2, 9]);
    let errors = Case::from_json(&case.to_string()).unwrap_err();
    let paths: Vec<&str> = errors.0.iter().map(|error| error.path.as_str()).collect();
    let expected = [
        "domain.max",
        "gravity",
        "domain.max[0]",
        "bodies[0].material",
        "bodies[1].shape.radius",
        "stages[0].damping",
        "measures.eye.radius",
    ];
    assert_eq!(paths, expected, "{errors}");
}

#[test]
fn plane_strain_cones_are_refused_outside_plane_strain() {
    let mut case = sound();
    case["materials"]["sand"]["model"] = json!("drucker-prager");
    case["materials"]["sand"]["matching"] = json!("plane-strain");
    assert!(Case::from_json(&case.to_string()).is_ok());
    case["space"] = json!("axisymmetric");
    let errors = Case::from_json(&case.to_string()).unwrap_err();
    assert_eq!(errors.first().path, "materials.sand.matching");
    for matching in ["plane-strain", "plane-strain-associated"] {
        let column = json!({
            "title": "column", "space": "1d", "domain": { "min": [0], "max": [1] }, "gravity": [-9.81],
            "materials": { "sand": {
                "model": "drucker-prager", "matching": matching, "density": 1600, "youngs_modulus": 1e7,
                "poissons_ratio": 0.3, "friction_angle": 30, "dilatancy_angle": 30
            } },
            "bodies": [{ "name": "a", "material": "sand", "shape": { "kind": "box", "min": [0], "max": [1] } }],
            "stages": [{ "name": "go", "duration": 1 }]
        });
        let errors = Case::from_json(&column.to_string()).unwrap_err();
        assert_eq!(errors.first().path, "materials.sand.matching");
    }
}

#[test]
fn the_axis_of_symmetry_is_smooth() {
    let wall = |side: &str, position: f64, kind: &str| {
        let mut case = sound();
        case["space"] = json!("axisymmetric");
        case["boundaries"] = json!([{ "side": side, "position": position, "wall": { "kind": kind } }]);
        if kind == "frictional" {
            case["boundaries"][0]["wall"]["friction_coefficient"] = json!(0.3);
        }
        Case::from_json(&case.to_string())
    };
    for kind in ["rough", "frictional"] {
        let errors = wall("x-min", 0.0, kind).unwrap_err();
        assert_eq!(
            (errors.0.len(), errors.first().path.as_str()),
            (1, "boundaries[0].wall.kind"),
            "{errors}"
        );
        assert!(wall("x-min", 0.5, kind).is_ok(), "a wall beside the axis");
        assert!(wall("x-max", 1.0, kind).is_ok());
    }
    assert!(wall("x-min", 0.0, "smooth").is_ok());
}

/// Case with a rigid body and a patch, and a motion in its first stage.
fn driven(motion: &Value) -> Result<Case, colluvium_case::CaseErrors> {
    let mut case = sound();
    case["loads"] = json!([]);
    case["bodies"][0]["rigid"] = json!(true);
    case["patches"] =
        json!([{ "name": "p", "region": { "kind": "ball", "centre": [0.5, 0.5], "radius": 0.1 } }]);
    case["stages"][0]["motions"] = json!([motion]);
    Case::from_json(&case.to_string())
}

#[test]
fn motions_of_rigid_bodies_and_patches_are_accepted() {
    for motion in [
        json!({ "target": "a", "velocity": [0, -1], "ramp": 0.5 }),
        json!({ "target": "p", "velocity": [null, -1] }),
        json!({ "target": "a", "velocity": [0, null], "force": [0, -1], "turns": true, "moment": [2] }),
    ] {
        assert!(driven(&motion).is_ok(), "{motion}");
    }
}

#[test]
fn invalid_motions_are_refused_by_path() {
    let table = [
        (json!({ "target": "a", "velocity": [0] }), "stages[0].motions[0].velocity", "has 1 entries"),
        (
            json!({ "target": "a", "velocity": [0, null], "force": [1, 2] }),
            "stages[0].motions[0].force[0]",
            "whose velocity is prescribed",
        ),
        (
            json!({ "target": "p", "velocity": [null, 1], "force": [1, 0] }),
            "stages[0].motions[0].force",
            "has no mass",
        ),
        (
            json!({ "target": "a", "velocity": [null, 1], "force": [1] }),
            "stages[0].motions[0].force",
            "1 entries",
        ),
        (
            json!({ "target": "a", "velocity": [null, 1], "moment": [1] }),
            "stages[0].motions[0].moment",
            "keeps its orientation",
        ),
        (
            json!({ "target": "a", "velocity": [null, 1], "turns": true, "moment": [0, 0, 1] }),
            "stages[0].motions[0].moment",
            "one in the plane",
        ),
        (
            json!({ "target": "p", "velocity": [0, 1], "ramp": -1 }),
            "stages[0].motions[0].ramp",
            "must not be negative",
        ),
        (
            json!({ "target": "q", "velocity": [0, 1] }),
            "stages[0].motions[0].target",
            "is not the name of a rigid body or of a patch",
        ),
    ];
    for (motion, path, words) in table {
        let errors = driven(&motion).unwrap_err();
        assert!(errors.0[0].path == path && errors.0[0].problem().contains(words), "{errors}");
    }
}

#[test]
fn pore_fluids_out_of_range_are_refused_by_name() {
    let sound = json!({ "porosity": 0.4, "permeability": 1e-3 });
    let refused = |change: &dyn Fn(&mut Value), path: &str, words: &str| {
        let mut case = self::sound();
        case["bodies"][0]["pore_fluid"] = sound.clone();
        assert!(Case::from_json(&case.to_string()).is_ok());
        change(&mut case);
        let text = Case::from_json(&case.to_string()).unwrap_err().to_string();
        assert!(text.contains(path) && text.contains(words), "{path}, {words}: {text}");
    };
    let keys = [
        ("porosity", json!(0.0), "between 0 and 1"),
        ("porosity", json!(1.0), "between 0 and 1"),
        ("permeability", json!(-1e-3), "positive"),
        ("permeability", Value::Null, "either"),
        ("density", json!(0), "positive"),
        ("bulk_modulus", json!(-1), "positive"),
        ("viscosity", json!(0), "positive"),
        ("cavitation_strength", json!(-1), "negative"),
    ];
    for (key, value, words) in keys {
        let path = format!("bodies[0].pore_fluid.{key}");
        refused(&|case| case["bodies"][0]["pore_fluid"][key] = value.clone(), &path, words);
    }
    let weightless = |case: &mut Value| case["gravity"] = json!([0, 0]);
    refused(&weightless, "bodies[0].pore_fluid.permeability", "depends on gravity");
    let undrained = |case: &mut Value| {
        let skeleton = case["materials"]["sand"].clone();
        case["materials"]["sand"] =
            json!({ "model": "undrained", "fluid_bulk_modulus": 1e9, "porosity": 0.4, "skeleton": skeleton });
    };
    refused(&undrained, "bodies[0].material", "already contains its pore water");
    let dry = |case: &mut Value| {
        case["bodies"][0].as_object_mut().unwrap().remove("pore_fluid");
        case["boundaries"][0]["drained"] = json!(true);
    };
    refused(&dry, "boundaries[0].drained", "no body");
}

#[test]
fn motions_and_loads_of_removed_bodies_are_refused() {
    let mut case = sound();
    case["bodies"][1]["rigid"] = json!(true);
    case["loads"][0]["stage"] = json!("go");
    case["stages"] = json!([
        { "name": "settle", "duration": 1, "remove_bodies": ["a", "b"] },
        { "name": "go", "duration": 1, "motions": [{ "target": "b", "velocity": [0, 0] }] }
    ]);
    let found = Case::from_json(&case.to_string()).unwrap_err().to_string();
    let lines: Vec<&str> = found.lines().collect();
    assert_eq!(
        lines,
        [
            "loads[0].stage: the body \"a\" is removed by then",
            "stages[1].motions[0].target: the body \"b\" is removed by then"
        ]
    );
    // Names are valid until the bodies are removed.
    case["stages"][0]["remove_bodies"] = json!([]);
    case["stages"][1]["remove_bodies"] = json!(["a"]);
    case["loads"][0]["stage"] = json!("settle");
    Case::from_json(&case.to_string()).unwrap();
}

#[test]
fn a_case_is_the_same_from_any_working_directory() {
    let folder = tempfile::tempdir().unwrap();
    let mut case = sound();
    case["methods"]["mpm"]["mesh"] = json!({ "kind": "file", "file": "a.msh" });
    let file = folder.path().join("case.json");
    std::fs::write(&file, case.to_string()).unwrap();
    std::fs::write(folder.path().join("a.msh"), "one mesh").unwrap();
    let read = Case::from_file(&file).unwrap();
    let mesh = |case: &Case| case.methods["mpm"]["mesh"]["file"].as_str().unwrap().to_owned();
    assert_eq!(mesh(&read), folder.path().join("a.msh").to_str().unwrap());
    // The copy of the case in another folder.
    let copy = folder.path().join("out/case.json");
    std::fs::create_dir(folder.path().join("out")).unwrap();
    std::fs::write(&copy, read.to_json()).unwrap();
    assert_eq!(Case::from_file(&copy).unwrap(), read);
    // Path from the working directory, which is that of the crate.
    let here = std::env::current_dir().unwrap();
    let up = "../".repeat(here.components().count() - 1);
    let relative = std::path::Path::new(&up).join(file.strip_prefix("/").unwrap_or(&file));
    let from_here = Case::from_file(&relative).unwrap();
    assert!(std::path::Path::new(&mesh(&from_here)).is_absolute(), "{}", mesh(&from_here));
    assert_eq!(from_here.fingerprint(), read.fingerprint());
    let before = read.fingerprint();
    std::fs::write(folder.path().join("a.msh"), "another").unwrap();
    assert_ne!(read.fingerprint(), before, "the fingerprint covers the mesh");
}
