//! Invalid case files: each gives an error with path and description.

mod mutations;

use colluvium_case::Case;
use serde_json::{Value, json};

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

/// Valid case with the value at a JSON pointer replaced (or removed, for `Null`).
fn with(pointer: &str, value: Value) -> Value {
    let mut case = sound();
    let (parent, key) = pointer.rsplit_once('/').expect("a pointer");
    let parent = case.pointer_mut(parent).unwrap_or_else(|| panic!("{pointer} leads nowhere"));
    match parent {
        Value::Object(map) if value.is_null() => {
            map.remove(key);
        }
        Value::Object(map) => {
            map.insert(key.to_owned(), value);
        }
        Value::Array(items) => items[key.parse::<usize>().expect("an index")] = value,
        _ => panic!("{pointer} is not in an object or array"),
    }
    case
}

#[test]
fn the_sound_case_is_sound_and_round_trips() {
    let case = Case::from_json(&sound().to_string()).unwrap();
    assert_eq!(Case::from_json(&case.to_json()).unwrap(), case);
    assert_eq!(case.fingerprint(), Case::from_json(&case.to_json()).unwrap().fingerprint());
}

#[test]
fn every_kind_of_mistake_is_named_where_it_is() {
    let softening = json!({ "residual_friction_angle": 40, "residual_cohesion": 0, "friction_rate": 1, "cohesion_rate": 1 });
    // Pointer, value, path of the error, words of the error.
    let table: Vec<(&str, Value, &str, &str)> = vec![
        ("/titel", json!("x"), "titel", "did you mean \"title\"?"),
        // Keys of earlier versions.
        (
            "/materials/sand/project",
            json!(true),
            "materials.sand.project",
            "now called \"return_initial_stress_to_yield\"",
        ),
        ("/bodies/0/drop_outside", json!(true), "bodies[0].drop_outside", "now called \"remove_outside\""),
        ("/cuts", json!([]), "cuts", "now called \"removal_shapes\""),
        ("/loads/0/carrier", json!("nodes"), "loads[0].carrier", "now called \"applied_to\""),
        ("/stages/0/motions", json!([{ "of": "a" }]), "stages[0].motions[0].of", "now called \"target\""),
        (
            "/measures/push",
            json!({ "kind": "reaction", "of": "a" }),
            "measures.push.of",
            "now called \"target\"",
        ),
        (
            "/measures/arc",
            json!({ "kind": "arc-front", "of": "a" }),
            "measures.arc.of",
            "now called \"obstacle\"",
        ),
        ("/materials/sand/model", json!("other"), "materials.sand.model", "now called \"external\""),
        ("/title", Value::Null, "case file", "\"title\" is missing"),
        ("/title", json!(7), "title", "7 is not of type string"),
        ("/space", json!("2d"), "space", "is not one of 1d, plane-strain"),
        ("/domain/max", json!([1]), "domain.max", "1 entries, the space has 2"),
        ("/domain/max", json!([1, -1]), "domain.max[1]", "must be above min"),
        ("/gravity", json!([0, 0, -9.81]), "gravity", "3 entries"),
        ("/gravity", json!("down"), "gravity", "is not of type array"),
        ("/bodies/0/rigid", json!("yes"), "bodies[0].rigid", "is not of type boolean"),
        (
            "/patches",
            json!([{ "name": "a", "region": { "kind": "box", "min": [0, 0], "max": [1, 1] } }]),
            "patches[0].name",
            "is also the name of a body or another patch",
        ),
        (
            "/patches",
            json!([{ "name": "p", "region": { "kind": "ball", "centre": [0, 0], "radius": -1 } }]),
            "patches[0].region.radius",
            "must be finite and positive",
        ),
        (
            "/stages/0/motions",
            json!([{ "target": "a", "velocity": [0, 0] }]),
            "stages[0].motions[0].target",
            "is not the name of a rigid body or of a patch",
        ),
        ("/stages/0/damping_axes", json!([2]), "stages[0].damping_axes[0]", "is not an axis of a space of 2"),
        (
            "/measures/front",
            json!({ "kind": "reaction", "target": "b" }),
            "measures.front.target",
            "is not the name of a rigid body, a patch or an obstacle",
        ),
        (
            "/materials/sand/model",
            json!("mohr-columb"),
            "materials.sand.model",
            "did you mean \"mohr-coulomb\"?",
        ),
        ("/materials/sand/model", Value::Null, "materials.sand", "\"model\" is missing"),
        (
            "/materials/sand",
            json!({ "model": "eigenstrain", "volumetric_strain": 0, "duration": 1, "material": {
                "model": "saturation-softened", "saturated_cohesion": 0, "material": {
                    "model": "mohr-coulomb", "density": 1600, "youngs_modulus": 1e7, "poissons_ratio": 0.3,
                    "friction_angle": 30, "cohesion": 1e3 } } }),
            "bodies[0].material",
            "without a pore_fluid the body has no saturation",
        ),
        (
            "/materials/sand/friction_angle",
            json!(95),
            "materials.sand.friction_angle",
            "95 is not in 0..90 degrees",
        ),
        ("/materials/sand/friction_angle", Value::Null, "materials.sand", "\"friction_angle\" is missing"),
        (
            "/materials/sand/frction_angle",
            json!(30),
            "materials.sand.frction_angle",
            "did you mean \"friction_angle\"?",
        ),
        ("/materials/sand/poissons_ratio", json!(0.5), "materials.sand.poissons_ratio", "0.5 is not between"),
        ("/materials/sand/youngs_modulus", json!(-1), "materials.sand.youngs_modulus", "positive (Pa)"),
        ("/materials/sand/density", json!("heavy"), "materials.sand.density", "is not of type number"),
        (
            "/materials/sand/return_initial_stress_to_yield",
            json!("yes"),
            "materials.sand.return_initial_stress_to_yield",
            "is not of type boolean",
        ),
        (
            "/materials/sand/softening",
            softening,
            "materials.sand.softening.residual_friction_angle",
            "40 is not between 0 and the peak",
        ),
        ("/materials", json!({}), "bodies[0].material", "is not defined"),
        ("/bodies/0/material", json!("snad"), "bodies[0].material", "did you mean \"sand\"?"),
        ("/bodies/1/name", json!("a"), "bodies[1].name", "is the name of two bodies"),
        ("/bodies/1/shape/radius", json!(-0.2), "bodies[1].shape.radius", "-0.2 must be finite and positive"),
        ("/bodies/1/shape/centre", json!([0.3, 0.3]), "bodies[1].shape", "overlaps the body \"a\""),
        ("/bodies/1/shape/centre", json!([2, 2]), "bodies[1].shape", "beyond the domain"),
        ("/bodies/1/shape/kind", json!("bal"), "bodies[1].shape.kind", "did you mean \"ball\"?"),
        ("/bodies/0/shape/max", json!([-1, 0.4]), "bodies[0].shape.max[0]", "must be above min"),
        (
            "/bodies/0/velocity",
            json!({ "kind": "uniform", "value": [1] }),
            "bodies[0].velocity.value",
            "1 entries",
        ),
        (
            "/bodies/0/velocity",
            json!({ "kind": "bending", "along": 0, "across": 0, "clamp": 0, "length": 1, "tip": 1 }),
            "bodies[0].velocity.across",
            "two different axes",
        ),
        ("/bodies", json!([]), "loads[0].body", "is not the name of a body"),
        ("/boundaries/0/side", json!("z-min"), "boundaries[0].side", "z-min is normal to an axis"),
        (
            "/boundaries/0/wall/kind",
            json!("ruff"),
            "boundaries[0].wall.kind",
            "is not one of rough, smooth, frictional, absorbing",
        ),
        (
            "/boundaries/0/wall/friction_coefficient",
            json!(-1),
            "boundaries[0].wall.friction_coefficient",
            "negative",
        ),
        ("/boundaries/0/position", json!(5), "boundaries[0].position", "outside the domain"),
        ("/loads/0/body", json!("c"), "loads[0].body", "is not the name of a body"),
        ("/loads/0/ramp", json!(-1), "loads[0].ramp", "must not be negative"),
        ("/loads/0/stage", json!("gone"), "loads[0].stage", "is not the name of a stage"),
        ("/loads/0/stage", json!(1), "loads[0].stage", "is not of type string"),
        (
            "/loads/0/profile",
            json!({ "axis": "y", "shares": [[0, 1], [1, 0]] }),
            "loads[0].profile.axis",
            "is normal to the side y-max",
        ),
        (
            "/loads/0/profile",
            json!({ "axis": "z", "shares": [[0, 1], [1, 0]] }),
            "loads[0].profile.axis",
            "does not have this axis",
        ),
        (
            "/loads/0/profile",
            json!({ "axis": "x", "shares": [[0, 1]] }),
            "loads[0].profile.shares",
            "two entries or more",
        ),
        (
            "/loads/0/profile",
            json!({ "axis": "x", "shares": [[0, 1], [0.2, 1], [0.1, 0]] }),
            "loads[0].profile.shares[2][0]",
            "0.1 m lies before the entry above it, at 0.2 m",
        ),
        (
            "/boundaries/0",
            json!({ "side": "y-min", "separation": true,
                    "wall": { "kind": "frictional", "friction_coefficient": 0.5, "bilateral": true } }),
            "boundaries[0].separation",
            "the wall is bilateral",
        ),
        (
            "/loads/0",
            json!({ "kind": "pressure", "body": "c", "side": "y-max", "value": 10 }),
            "loads[0].body",
            "is not the name of a body",
        ),
        (
            "/loads/0",
            json!({ "kind": "pore-pressure", "body": "a", "side": "y-max", "value": 10 }),
            "loads[0].body",
            "has no pore_fluid",
        ),
        ("/bodies/0/rigid", json!(true), "loads[0].body", "the body \"a\" is rigid"),
        (
            "/loads/0",
            json!({ "kind": "pressure", "body": "a", "side": "y-max", "value": 10, "ramp": 1.5 }),
            "loads[0].ramp",
            "longer than the 1 s until the end of the stage \"settle\"",
        ),
        (
            "/stages/0",
            json!({ "name": "settle", "duration": 1, "equilibrium": {},
                    "motions": [{ "target": "a", "velocity": [0, -1], "ramp": 1.5 }] }),
            "stages[0].motions[0].ramp",
            "longer than the stage",
        ),
        (
            "/stages/0",
            json!({ "name": "settle", "duration": 1, "remove_bodies": ["a"] }),
            "loads[0].body",
            "the body \"a\" is removed by then",
        ),
        ("/measures/front/bodies", json!(["c"]), "measures.front.bodies[0]", "is not the name of a body"),
        ("/measures/front/bodies", json!([]), "measures.front.bodies", "name at least one body"),
        ("/domain/periodic", json!(["z"]), "domain.periodic[0]", "does not have this axis"),
        ("/domain/periodic", json!(["x", "x"]), "domain.periodic[1]", "named twice"),
        ("/domain/periodic", json!(["y"]), "boundaries[0].side", "periodic along the axis"),
        (
            "/boundaries/0/wall",
            json!({ "kind": "absorbing", "normal": -1 }),
            "boundaries[0].wall.normal",
            "negative",
        ),
        (
            "/boundaries/0/wall",
            json!({ "kind": "absorbing", "spring_length": 0 }),
            "boundaries[0].wall.spring_length",
            "positive",
        ),
        (
            "/boundaries/0",
            json!({ "side": "y-min", "wall": { "kind": "absorbing" }, "velocity": [0, 1] }),
            "boundaries[0].velocity",
            "cannot move",
        ),
        (
            "/stages/1/excavate",
            json!([{ "kind": "box", "min": [0, 0], "max": [0, 1] }]),
            "stages[1].excavate[0].max[0]",
            "must be above min",
        ),
        ("/stages", json!([]), "stages", "at least one stage"),
        ("/stages/1/duration", json!(0), "stages[1].duration", "must be positive"),
        ("/stages/0/damping", json!(1.0), "stages[0].damping", "is not in 0..1"),
        ("/stages/0/rayleigh_damping", json!(-1), "stages[0].rayleigh_damping", "must not be negative (1/s)"),
        ("/stages/0/equilibrium", json!({ "hold": 0 }), "stages[0].equilibrium.hold", "at least 1"),
        ("/stages/0/gravity_ramp", json!(2), "stages[0].gravity_ramp", "the stage's duration"),
        (
            "/stages/1/remove_boundaries",
            json!(["gate"]),
            "stages[1].remove_boundaries[0]",
            "is not the name of a boundary",
        ),
        ("/stages/1/name", json!("settle"), "stages[1].name", "is the name of two stages"),
        ("/stages/1/weakening", json!({ "factor": 0 }), "stages[1].weakening.factor", "0 must be positive"),
        (
            "/stages/1/weakening",
            json!({ "factor": 2, "materials": ["snad"] }),
            "stages[1].weakening.materials[0]",
            "did you mean \"sand\"?",
        ),
        ("/measures/front/side", json!("up"), "measures.front.side", "is not one of"),
        ("/measures/front/quantile", json!(1.5), "measures.front.quantile", "1.5 is not in 0..=1"),
        ("/measures/front/cell", json!(0), "measures.front.cell", "0 must be positive (m)"),
        (
            "/measures/front",
            json!({ "kind": "front", "side": "x-max", "quantile": 0.9, "cell": 0.1 }),
            "measures.front.cell",
            "does not use cells",
        ),
        ("/measures/a,b", json!({ "kind": "front", "side": "x-max" }), "measures.a,b", "letters, digits"),
        ("/measures/front", json!({ "kind": "dissipation", "side": "x-max" }), "measures.front.side", "key"),
        ("/measures/eye/radius", json!(0), "measures.eye.radius", "must be positive"),
        (
            "/measures/eye/position",
            json!([0.2, 1.5]),
            "measures.eye.position[1]",
            "1.5 is outside the domain, 0 to 1 m",
        ),
        (
            "/measures/eye/position",
            json!([-0.1, 0.2]),
            "measures.eye.position[0]",
            "-0.1 is outside the domain",
        ),
        ("/measures/eye/fields", json!(["stress", "a,b"]), "measures.eye.fields[1]", "letters, digits"),
        ("/measures/eye/fields", json!([]), "measures.eye.fields", "at least one field"),
        ("/output/frames", json!(-1), "output.frames", "must be positive"),
        ("/output/frames", json!(1e-9), "output.frames", "would give"),
        ("/output/frame", json!(1), "output.frame", "did you mean \"frames\"?"),
        ("/output/grid", json!(0), "output.grid", "must be positive"),
        ("/output/grid", json!(1e-9), "output.grid", "nodes"),
        ("/methods/mpm", json!(3), "methods.mpm", "object"),
        (
            "/boundaries/0",
            json!({ "side": "y-min", "group": "base", "position": 0.2, "wall": { "kind": "rough" } }),
            "boundaries[0].position",
            "group \"base\"",
        ),
    ];
    for (pointer, value, path, words) in table {
        let errors = Case::from_json(&with(pointer, value).to_string()).expect_err(pointer);
        let found = errors.0.iter().any(|error| error.path == path && error.problem.contains(words));
        assert!(found, "{pointer}: wanted `{path}: …{words}…`, found\n{errors}");
        assert!(errors.to_string().lines().all(|line| line.contains(": ")));
    }
}

#[test]
fn walls_that_a_stage_removed_stay_away_beyond_the_last_stage() {
    let case = Case::from_json(&with("/stages/1/remove_boundaries", json!(["y-min"])).to_string()).unwrap();
    let standing = |stage| case.active_boundaries(stage).len();
    assert_eq!([standing(0), standing(1), standing(2), standing(usize::MAX)], [1, 0, 0, 0]);
}

#[test]
fn the_motion_of_an_obstacle_is_sent_to_the_obstacle() {
    let mut value = sound();
    value["obstacles"] = json!([
        { "name": "ground", "shape": { "kind": "plane", "point": [0, 0], "normal": [0, 1] }, "wall": { "kind": "rough" } }
    ]);
    value["stages"][0]["motions"] = json!([{ "target": "ground", "velocity": [0, 0] }]);
    let errors = Case::from_json(&value.to_string()).unwrap_err();
    assert_eq!(errors.0[0].path, "stages[0].motions[0].target", "{errors}");
    assert!(errors.0[0].problem.contains("give its motion in obstacles[0].motion"), "{errors}");
}

#[test]
fn broken_json_is_placed_by_line_and_column() {
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
        assert!(first.path.contains(place) && first.problem.contains(words), "{text}: {errors}");
    }
    let deep = "[".repeat(5000);
    assert!(Case::from_json(&deep).is_err());
}

#[test]
fn several_mistakes_are_all_reported() {
    let mut case = with("/materials/sand/friction_angle", json!(95));
    case["stages"][0]["damping"] = json!(2);
    case["bodies"][0]["material"] = json!("clay");
    let errors = Case::from_json(&case.to_string()).unwrap_err();
    assert_eq!(errors.0.len(), 3, "{errors}");
}

#[test]
fn mistakes_in_the_space_hide_no_others() {
    let mut case = with("/domain/max", json!([1]));
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
fn plane_strain_cones_are_refused_where_they_mean_nothing() {
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
        assert!(wall("x-min", 0.5, kind).is_ok(), "a pile stands beside the axis");
        assert!(wall("x-max", 1.0, kind).is_ok());
    }
    assert!(wall("x-min", 0.0, "smooth").is_ok());
}

/// Valid case with all its numeric keys.
fn numbers() -> Case {
    let mut case = sound();
    case["bodies"][0]["stress"] = json!({ "kind": "uniform", "value": [1, 2, 3, 4, 5, 6] });
    case["bodies"][0]["velocity"] = json!({ "kind": "sine", "amplitude": [0, 1], "wave_vector": [1, 0] });
    case["bodies"][1]["stress"] = json!({ "kind": "k0", "surface": 1, "coefficient": 0.5 });
    case["bodies"][1]["velocity"] =
        json!({ "kind": "linear", "value": [0, 1], "origin": [0, 0], "gradient": [[0, 1], [1, 0]] });
    case["boundaries"][0]["position"] = json!(0);
    case["boundaries"][0]["velocity"] = json!([0, 0]);
    case["loads"][0]["profile"] = json!({ "axis": "x", "shares": [[0, 1], [0.4, 0]] });
    case["output"]["measures"] = json!(0.1);
    case["measures"]["slide"] =
        json!({ "kind": "run-out", "side": "x-max", "origin": 0, "initial_length": 1 });
    case["measures"]["top"] = json!({ "kind": "profile", "axis": 0, "height": 1, "bin": 0.1 });
    Case::from_json(&case.to_string()).unwrap()
}

#[test]
fn numbers_that_are_not_finite_are_refused_where_they_are() {
    use colluvium_case::description::{InitialStress, Load, Measure, Velocity, Wall};
    use colluvium_constitutive::MaterialSpec;
    use colluvium_points::Shape;
    type Spoil = fn(&mut Case, f64);
    macro_rules! inside {
        ($pattern:pat = $place:expr => $value:expr, $bad:expr) => {
            if let $pattern = $place { *$value = $bad } else { panic!("the case has no such thing") }
        };
    }
    let table: Vec<(&str, Spoil)> = vec![
        ("domain.min[0]", |c, bad| c.domain.min[0] = bad),
        ("domain.max[1]", |c, bad| c.domain.max[1] = bad),
        ("gravity[1]", |c, bad| c.gravity[1] = bad),
        ("materials.sand.cohesion", |c, bad| {
            inside!(Some(MaterialSpec::MohrCoulomb(spec)) = c.materials.get_mut("sand") => &mut spec.cohesion, bad);
        }),
        ("bodies[0].shape.min[0]", |c, bad| {
            inside!(Shape::Box { min, .. } = &mut c.bodies[0].shape => &mut min[0], bad);
        }),
        ("bodies[0].stress.value[3]", |c, bad| {
            inside!(InitialStress::Uniform { value } = &mut c.bodies[0].stress => &mut value[3], bad);
        }),
        ("bodies[1].stress.surface", |c, bad| {
            inside!(InitialStress::K0 { surface, .. } = &mut c.bodies[1].stress => surface, bad);
        }),
        ("bodies[1].stress.coefficient", |c, bad| {
            inside!(InitialStress::K0 { coefficient, .. } = &mut c.bodies[1].stress => coefficient, bad);
        }),
        ("bodies[0].velocity.phase", |c, bad| {
            inside!(Velocity::Sine { phase, .. } = &mut c.bodies[0].velocity => phase, bad);
        }),
        ("bodies[1].velocity.gradient[1][0]", |c, bad| {
            inside!(Velocity::Linear { gradient, .. } = &mut c.bodies[1].velocity => &mut gradient[1][0], bad);
        }),
        ("boundaries[0].position", |c, bad| c.boundaries[0].position = Some(bad)),
        ("boundaries[0].velocity[0]", |c, bad| c.boundaries[0].velocity = Some(vec![bad, 0.0])),
        ("boundaries[0].wall.friction_coefficient", |c, bad| {
            c.boundaries[0].wall = Wall::Frictional { friction_coefficient: bad, bilateral: false };
        }),
        ("loads[0].value[1]", |c, bad| {
            inside!(Load::Traction { value, .. } = &mut c.loads[0] => &mut value[1], bad);
        }),
        ("loads[0].ramp", |c, bad| {
            inside!(Load::Traction { ramp, .. } = &mut c.loads[0] => ramp, bad);
        }),
        ("loads[0].profile.shares[1][0]", |c, bad| {
            inside!(Load::Traction { profile: Some(profile), .. } = &mut c.loads[0] => &mut profile.shares[1][0], bad);
        }),
        ("loads[0].profile.shares[1][1]", |c, bad| {
            inside!(Load::Traction { profile: Some(profile), .. } = &mut c.loads[0] => &mut profile.shares[1][1], bad);
        }),
        ("stages[1].duration", |c, bad| c.stages[1].duration = bad),
        ("stages[1].damping", |c, bad| c.stages[1].damping = bad),
        ("stages[1].gravity_ramp", |c, bad| c.stages[1].gravity_ramp = bad),
        ("stages[1].rayleigh_damping", |c, bad| c.stages[1].rayleigh_damping = bad),
        ("stages[0].equilibrium.kinetic_energy", |c, bad| {
            inside!(Some(criterion) = &mut c.stages[0].equilibrium => &mut criterion.kinetic_energy, bad);
        }),
        ("output.frames", |c, bad| c.output.frames = Some(bad)),
        ("output.measures", |c, bad| c.output.measures = Some(bad)),
        ("output.grid", |c, bad| c.output.grid = Some(bad)),
        ("output.checkpoint", |c, bad| c.output.checkpoint = bad),
        ("measures.front.quantile", |c, bad| {
            inside!(Some(Measure::Front { quantile, .. }) = c.measures.get_mut("front") => quantile, bad);
        }),
        ("measures.front.cell", |c, bad| {
            inside!(Some(Measure::Front { cell, .. }) = c.measures.get_mut("front") => cell, Some(bad));
        }),
        ("measures.slide.origin", |c, bad| {
            inside!(Some(Measure::RunOut { origin, .. }) = c.measures.get_mut("slide") => origin, bad);
        }),
        ("measures.slide.initial_length", |c, bad| {
            inside!(Some(Measure::RunOut { initial_length, .. }) = c.measures.get_mut("slide") => initial_length, bad);
        }),
        ("measures.top.bin", |c, bad| {
            inside!(Some(Measure::Profile { bin, .. }) = c.measures.get_mut("top") => bin, bad);
        }),
        ("measures.eye.position[0]", |c, bad| {
            inside!(Some(Measure::Probe { position, .. }) = c.measures.get_mut("eye") => &mut position[0], bad);
        }),
        ("measures.eye.radius", |c, bad| {
            inside!(Some(Measure::Probe { radius, .. }) = c.measures.get_mut("eye") => radius, bad);
        }),
    ];
    let whole = numbers();
    for (path, spoil) in table {
        for bad in [f64::NAN, f64::INFINITY] {
            let mut case = whole.clone();
            spoil(&mut case, bad);
            let errors = case.validate().expect_err(path);
            assert!(errors.0.iter().any(|error| error.path == path), "{path} = {bad}, found\n{errors}");
        }
    }
}

#[test]
fn motions_that_make_no_sense_are_named_where_they_are() {
    let driven = |motion: Value| {
        let mut case = sound();
        case["loads"] = json!([]);
        case["bodies"][0]["rigid"] = json!(true);
        case["patches"] =
            json!([{ "name": "p", "region": { "kind": "ball", "centre": [0.5, 0.5], "radius": 0.1 } }]);
        case["stages"][0]["motions"] = json!([motion]);
        Case::from_json(&case.to_string())
    };
    assert!(driven(json!({ "target": "a", "velocity": [0, -1], "ramp": 0.5 })).is_ok());
    assert!(driven(json!({ "target": "p", "velocity": [null, -1] })).is_ok());
    assert!(
        driven(
            json!({ "target": "a", "velocity": [0, null], "force": [0, -1], "turns": true, "moment": [2] })
        )
        .is_ok()
    );
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
        let errors = driven(motion).unwrap_err();
        assert!(errors.0[0].path == path && errors.0[0].problem.contains(words), "{errors}");
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
fn what_is_removed_is_neither_moved_nor_loaded() {
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
fn a_case_is_the_same_from_wherever_it_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let mut case = sound();
    case["methods"]["mpm"]["mesh"] = json!({ "kind": "file", "file": "a.msh" });
    let file = folder.path().join("case.json");
    std::fs::write(&file, case.to_string()).unwrap();
    std::fs::write(folder.path().join("a.msh"), "one mesh").unwrap();
    let read = Case::load(&file).unwrap();
    let mesh = |case: &Case| case.methods["mpm"]["mesh"]["file"].as_str().unwrap().to_owned();
    assert_eq!(mesh(&read), folder.path().join("a.msh").to_str().unwrap());
    // The copy of the case in another folder.
    let copy = folder.path().join("out/case.json");
    std::fs::create_dir(folder.path().join("out")).unwrap();
    std::fs::write(&copy, read.to_json()).unwrap();
    assert_eq!(Case::load(&copy).unwrap(), read);
    // Path from the working directory, which is that of the crate.
    let here = std::env::current_dir().unwrap();
    let up = "../".repeat(here.components().count() - 1);
    let relative = std::path::Path::new(&up).join(file.strip_prefix("/").unwrap_or(&file));
    let from_here = Case::load(&relative).unwrap();
    assert!(std::path::Path::new(&mesh(&from_here)).is_absolute(), "{}", mesh(&from_here));
    assert_eq!(from_here.fingerprint(), read.fingerprint());
    let before = read.fingerprint();
    std::fs::write(folder.path().join("a.msh"), "another").unwrap();
    assert_ne!(read.fingerprint(), before, "what is in the mesh counts");
}
