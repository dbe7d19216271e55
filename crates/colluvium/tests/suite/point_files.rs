//! Points from a file, and their estimated number, in every method.

use colluvium::case::{Case, Snapshot, Solver};
use serde_json::{Value, json};

/// Block under its own weight, with points at powers of two so that their widths are exact.
fn block(method: &str) -> Value {
    json!({
        "title": "block", "space": "plane-strain", "domain": { "min": [0, 0], "max": [4, 3] }, "gravity": [0, -10],
        "materials": { "m": { "model": "linear-elastic", "density": 1500, "youngs_modulus": 1e6, "poissons_ratio": 0.25 } },
        "bodies": [{
            "name": "block", "material": "m", "shape": { "kind": "box", "min": [1, 0], "max": [3, 2] },
            "velocity": { "kind": "linear", "value": [0.5, -0.25], "origin": [2, 1], "gradient": [[0.1, 0.3], [-0.2, 0.05]] },
            "stress": { "kind": "k0", "surface": 2, "coefficient": 0.5 }
        }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }],
        "stages": [{ "name": "s", "duration": 0.05 }],
        "methods": match method {
            "mpm" => json!({ "mpm": { "cell_size": 0.25, "points_per_cell": 2 } }),
            _ => json!({ "sph": { "spacing": 0.125 } }),
        }
    })
}

/// Points of a snapshot as a list, last first, with or without their volumes.
fn list(snapshot: &Snapshot, with_volumes: bool) -> String {
    let [velocity, stress] = ["velocity", "stress"].map(|name| snapshot.field(name).expect("a field"));
    let (colluvium::case::FieldData::Vector(velocity), colluvium::case::FieldData::Tensor(stress)) =
        (&velocity.data, &stress.data)
    else {
        panic!("vectors and tensors")
    };
    let volume = snapshot.scalars("volume").expect("volumes");
    let mut text = String::from(if with_volumes { "x (m),y (m),volume (m2)" } else { "x (m),y (m)" });
    text += ",velocity_x,velocity_y,stress_xx,stress_yy,stress_zz,stress_xy\n";
    for (k, x) in snapshot.positions.iter().enumerate() {
        let (v, s) = (velocity[k], stress[k].0);
        text += &format!("{:e},{:e},", x[0], x[1]);
        if with_volumes {
            text += &format!("{:e},", volume[k]);
        }
        text += &format!("{:e},{:e},{:e},{:e},{:e},{:e}\n", v[0], v[1], s[0], s[1], s[2], s[3]);
    }
    text
}

fn after(method: &str, case: &Case, steps: usize) -> Snapshot {
    let mut solver: Box<dyn Solver> =
        colluvium::method(method).expect("a method").build(case).expect("a solver");
    solver.begin_stage(0, 0.0).expect("a stage");
    for _ in 0..steps {
        let dt = solver.limit().dt;
        solver.step(dt).expect("a step");
    }
    solver.snapshot()
}

#[test]
fn points_from_a_file_move_as_the_equal_sampled_body() {
    for method in ["mpm", "sph"] {
        for with_volumes in [true, false] {
            let folder = tempfile::tempdir().unwrap();
            let mut value = block(method);
            let set = Case::from_value(&value, folder.path()).unwrap();
            let start = after(method, &set, 0);
            assert_eq!(start.ids.len(), 256);
            std::fs::write(folder.path().join("points.csv"), list(&start, with_volumes)).unwrap();
            let body = value["bodies"][0].as_object_mut().unwrap();
            body.remove("velocity");
            body.remove("stress");
            let points = if with_volumes {
                json!({ "file": "points.csv" })
            } else {
                json!({ "file": "points.csv", "spacing": 0.125 })
            };
            body.insert("points".to_owned(), points);
            let listed = Case::from_value(&value, folder.path()).unwrap();
            assert_eq!(after(method, &listed, 0).hash(), start.hash(), "{method}: start");
            let by = colluvium::method(method).unwrap();
            assert_eq!(by.problem_size(&listed).unwrap().points, 256.0, "{method}: the lines of the file");
            let (a, b) = (after(method, &set, 40), after(method, &listed, 40));
            assert_eq!(a.hash(), b.hash(), "{method}: after 40 steps");
            assert_ne!(a.positions, start.positions);
        }
    }
}

#[test]
fn grains_have_the_radii_and_ids_of_their_file() {
    let folder = tempfile::tempdir().unwrap();
    let mut value = block("dem");
    let body = value["bodies"][0].as_object_mut().unwrap();
    body.remove("velocity");
    body.remove("stress");
    body.insert("points".to_owned(), json!({ "file": "grains.csv" }));
    let spring = json!({ "law": "linear", "stiffness": 1e6, "damping_ratio": 0.1 });
    let pairs = [["m", "m"], ["m", "iron"], ["iron", "iron"]];
    let pairs = pairs.map(|pair| json!({ "between": pair, "normal": spring }));
    value["methods"] = json!({ "dem": {
        "grains": { "m": { "density": 2000, "diameter": { "distribution": "equal", "value": 0.2 } },
                    "iron": { "density": 7800, "diameter": { "distribution": "equal", "value": 0.2 } } },
        "pairs": pairs
    } });
    let file = |text: &str| std::fs::write(folder.path().join("grains.csv"), text).unwrap();
    let case = || Case::from_value(&value, folder.path()).unwrap();
    file("x,y,radius,kind,spin_z,held,id\n1.5,0.5,0.1,m,0,0,9\n2.5,1.5,0.2,iron,3,1,4\n");
    let snapshot = after("dem", &case(), 20);
    assert_eq!(snapshot.ids, [4, 9]);
    let area = |radius: f64| std::f64::consts::PI * radius * radius;
    let mass = snapshot.scalars("mass").unwrap();
    for (found, asked) in mass.iter().zip([7800.0 * area(0.2), 2000.0 * area(0.1)]) {
        assert!((found / asked - 1.0).abs() < 1e-12, "{found} for {asked}");
    }
    // One point falls, the other is held.
    assert_eq!(snapshot.positions[0], [2.5, 1.5, 0.0]);
    assert!(snapshot.positions[1][1] < 0.5);
    let dem = colluvium::method("dem").unwrap();
    for (text, words) in [
        (
            "x,y,radius,kind\n1.5,0.5,0.1,lead\n",
            "the kind \"lead\" is not one of methods.dem.grains, which are iron, m",
        ),
        ("x,y,radius,id\n1.5,0.5,0.1,3\n2.5,0.5,0.1,3\n", "two grains have the number 3"),
    ] {
        file(text);
        let error = dem.build(&case()).err().expect("refused").to_string();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn point_spacings_unsuitable_for_the_method_are_refused_or_cause_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("points.csv"), "x,y\n1.5,0.5\n2.5,1.5\n").unwrap();
    let case = |method: &str, spacing: f64| {
        let mut value = block(method);
        value["bodies"][0]["points"] = json!({ "file": "points.csv", "spacing": spacing });
        Case::from_value(&value, folder.path()).unwrap()
    };
    let error = colluvium::method("mpm").unwrap().plan(&case("mpm", 0.5)).unwrap_err().to_string();
    assert!(
        error.starts_with("bodies[0].points: ") && error.contains("more than the cell size of 0.25 m"),
        "{error}"
    );
    // A width of a cell, to rounding, is not too wide.
    std::fs::write(folder.path().join("space.csv"), "x,y,z\n1.5,0.5,0.5\n2.5,1.5,0.5\n").unwrap();
    let mut value = block("mpm");
    value["space"] = json!("3d");
    value["domain"] = json!({ "min": [0, 0, 0], "max": [4, 3, 1] });
    value["gravity"] = json!([0, 0, -10]);
    value["bodies"][0] = json!({
        "name": "block", "material": "m", "shape": { "kind": "box", "min": [1, 0, 0], "max": [3, 2, 1] },
        "points": { "file": "space.csv", "spacing": 0.1 }
    });
    value["methods"]["mpm"]["cell_size"] = json!(0.1);
    let cubes = Case::from_value(&value, folder.path()).unwrap();
    assert!(cubes.point_list(0).unwrap().unwrap().spacing(3) > 0.1);
    assert_eq!(colluvium::method("mpm").unwrap().plan(&cubes).unwrap().points, 2);
    let plan = colluvium::method("sph").unwrap().plan(&case("sph", 0.5)).unwrap();
    assert!(
        plan.warnings.iter().any(|warning| warning.text.starts_with("bodies[0].points: ")),
        "{:?}",
        plan.warnings
    );
    let plan = colluvium::method("sph").unwrap().plan(&case("sph", 0.125)).unwrap();
    assert!(!plan.warnings.iter().any(|warning| warning.text.contains("bodies[0].points: ")));
    let mut value = block("mpm");
    for spacing in [-1.0, 1e300] {
        value["bodies"][0]["points"] = json!({ "file": "points.csv", "spacing": spacing });
        let error = Case::from_value(&value, folder.path()).unwrap_err().to_string();
        assert!(error.starts_with("bodies[0].points.spacing: "), "{error}");
    }
}

#[test]
fn estimated_problem_sizes_match_the_plan() {
    let mut compared = 0;
    let is_alone = |template: &&colluvium::Template| {
        template.kind == colluvium::TemplateKind::Case && template.files.is_empty()
    };
    for colluvium::Template { name, text, .. } in colluvium::TEMPLATES.iter().filter(is_alone) {
        let case = Case::from_json(text).unwrap();
        for method in case.methods.keys().filter_map(|name| colluvium::method(name)) {
            let (size, plan) = (method.problem_size(&case).unwrap(), method.plan(&case).unwrap());
            // The points of a disk or a polygon do not fill it exactly.
            let share = size.points / plan.points as f64;
            // The size includes the particles of rough walls.
            let most = if method.name() == "sph" { 1.35 } else { 1.05 };
            assert!((0.95..most).contains(&share), "{name}: {share} of the points");
            let share = size.memory / plan.memory as f64;
            // A plan estimates the memory of a run. Grains take up to 2.5 times that during generation, which the size includes.
            let limit = if method.name() == "dem" { 2.6 } else { 1.1 };
            assert!((0.6..limit).contains(&share), "{name}: {share} of the memory");
            assert!(size.check_memory(2.0 * size.memory).is_ok() && size.check_memory(1e3).is_err());
            compared += 1;
        }
    }
    assert!(compared >= 4);
}
