//! Element tests.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use super::{names_in, set, write};
use crate::{output, program};

/// Last value of a column of `path.csv`.
fn last(out: &Path, column: &str) -> f64 {
    let table = fs::read_to_string(out.join("path.csv")).expect("a table");
    let mut columns = table.lines().nth(1).expect("a head").split(',');
    let index = columns.position(|c| c.split(" (").next() == Some(column)).expect("the column");
    let row = table.lines().last().expect("a row");
    row.split(',').nth(index).expect("a value").parse().expect("a number")
}

fn triaxial(path: &Value) -> Value {
    json!({
        "title": "triaxial",
        "material": { "model": "drucker-prager", "density": 1600, "youngs_modulus": 2e7, "poissons_ratio": 0.3, "friction_angle": 30 },
        "initial_stress": [-1e5, -1e5, -1e5, 0, 0, 0],
        "stages": [{ "path": path, "steps": 100 }]
    })
}

#[test]
fn an_element_test_leaves_a_table_and_four_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let drained = triaxial(&json!({ "kind": "triaxial-drained", "axial_compression": 0.05 }));
    let file = write(folder.path(), "triaxial.json", &drained);
    let out = folder.path().join("out");
    let (code, _, errors) = output(program().arg("element-test").arg(&file).arg("--out").arg(&out));
    assert_eq!(code, 0, "{errors}");
    assert_eq!(
        names_in(&out),
        ["path.csv", "q-p.png", "q-strain.png", "volume-ln-p.png", "volume-strain.png"]
    );
    // Cohesionless, matched in triaxial compression: q = σ₃ (k - 1) = 200 kPa.
    assert!((last(&out, "q") / 2e5 - 1.0).abs() < 1e-6, "{}", last(&out, "q"));
    // Into the same folder: no result of the drained test remains.
    let undrained = triaxial(&json!({ "kind": "triaxial-undrained", "axial_compression": 0.05 }));
    let file = write(folder.path(), "undrained.json", &undrained);
    let mut command = program();
    let (code, _, errors) =
        output(command.arg("element-test").arg(&file).arg("--out").arg(&out).args(["--format", "svg"]));
    assert_eq!(code, 0, "{errors}");
    assert_eq!(
        names_in(&out),
        ["path.csv", "pore-pressure-strain.svg", "q-p.svg", "q-strain.svg", "volume-ln-p.svg"]
    );
    assert!(fs::read_to_string(out.join("q-p.svg")).unwrap().contains("yield surface"));
    // Files that no element test wrote remain.
    for foreign in ["path.csv", "q-p.png"] {
        let other = folder.path().join(foreign.replace('.', "-"));
        fs::create_dir(&other).unwrap();
        fs::write(other.join(foreign), "mine").unwrap();
        let (code, _, errors) = output(program().arg("element-test").arg(&file).arg("--out").arg(&other));
        assert!(code == 1 && errors.contains(foreign) && errors.contains("--out"), "{code}: {errors}");
        assert_eq!(fs::read_to_string(other.join(foreign)).unwrap(), "mine");
        assert_eq!(names_in(&other), [foreign]);
    }
}

#[test]
fn broken_element_tests_end_with_code_3_and_the_path_of_every_mistake() {
    let folder = tempfile::tempdir().unwrap();
    let breakages: Vec<(&str, &str, Value)> = vec![
        ("/title", "title", json!(1)),
        ("/initial_stress", "initial_stress", json!([1, 2, 3])),
        ("/initial_stress/2", "initial_stress", json!(-9e9)),
        ("/material/friction_angle", "material.friction_angle", json!(95)),
        ("/material/friction", "material.friction", json!(95)),
        ("/stages", "stages", json!([])),
        ("/stages/0/steps", "stages[0].steps", json!(0)),
        ("/stages/0/steps", "stages[0].steps", json!(-5)),
        ("/stages/0/duration", "stages[0].duration", json!(0)),
        ("/stages/0/path/kind", "stages[0].path.kind", json!("triaxal")),
        ("/stages/0/path/b", "stages[0].path.b", json!(1.5)),
        ("/stages/0/path/axial_compression", "stages[0].path.axial_compression", json!(10)),
        ("/stages/0/path", "stages[0].path", json!({ "kind": "reversal" })),
    ];
    for (number, (pointer, path, value)) in breakages.into_iter().enumerate() {
        let mut test = triaxial(&json!({ "kind": "true-triaxial", "axial_compression": 0.05, "b": 0.2 }));
        set(&mut test, pointer, value);
        let file = write(folder.path(), &format!("broken-{number}.json"), &test);
        let out = folder.path().join(format!("out-{number}"));
        let (code, _, errors) = output(program().arg("element-test").arg(&file).arg("--out").arg(&out));
        assert_eq!(code, 3, "{pointer}: {errors}");
        let first = errors.lines().next().unwrap_or_default();
        assert!(first.starts_with("error[") && first.contains(&format!("]: {path}: ")), "{pointer}: {first}");
        assert!(!out.exists(), "{pointer}: a broken test leaves nothing");
    }
}

#[test]
fn a_limit_load_keeps_earlier_rows_and_ends_an_element_test_with_code_1() {
    let folder = tempfile::tempdir().unwrap();
    let push = triaxial(&json!({ "kind": "stress", "increment": [0, 0, -3e5, 0, 0, 0] }));
    let file = write(folder.path(), "push.json", &push);
    let out = folder.path().join("out");
    let (code, _, errors) = output(program().arg("element-test").arg(&file).arg("--out").arg(&out));
    assert_eq!(code, 1, "{errors}");
    assert!(
        errors.starts_with("error[limit-load]: stages[0].path: limit load reached in step 66"),
        "{errors}"
    );
    assert!((last(&out, "q") / 2e5 - 1.0).abs() < 1e-4, "{}", last(&out, "q"));
    assert_eq!(names_in(&out).len(), 5);
}

#[test]
fn a_folder_of_an_incremental_driver_is_an_element_test() {
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    put("parameters.inp", "Elastic\n2\n2.0d4\n0.3\n");
    put("initialconditions.inp", "6\n-100\n-100\n-100\n0\n0\n0\n1\n0.0\n");
    put("test.inp", "out.txt # triaxial\n*TriaxialE1\n100 10 1.0 : 10\n-0.01\n*End\n");
    let material =
        json!({ "model": "linear-elastic", "density": 1600, "youngs_modulus": 2e7, "poissons_ratio": 0.3 });
    let law = write(folder.path(), "law.json", &material);
    let out = folder.path().join("out");
    let run = |law: &Path| {
        let mut command = program();
        command.arg("element-test").arg(folder.path()).args(["--stress-unit", "kPa", "--material"]).arg(law);
        output(command.arg("--out").arg(&out))
    };
    let (code, text, errors) = run(&law);
    assert_eq!(code, 0, "{errors}");
    assert!(text.starts_with("12 rows"), "{text}");
    assert!(errors.starts_with("warning[unused-values]: parameters.inp: "), "{errors}");
    assert!((last(&out, "q") / 2e5 - 1.0).abs() < 1e-9, "{}", last(&out, "q"));
    put("test.inp", "out.txt\n*TriaxialE9\n100 10 1.0\n-0.01\n");
    let (code, _, errors) = run(&law);
    let place = folder.path().join("test.inp:2");
    assert!(
        code == 3
            && errors
                .starts_with(&format!("error[incremental-driver]: {}: \"*TriaxialE9\" ", place.display())),
        "{errors}"
    );
    for (key, value) in
        [("youngs_modulus", json!(-1)), ("youngs_modulus", json!("soft")), ("stiffness", json!(1))]
    {
        let mut wrong = material.clone();
        wrong[key] = value;
        put("test.inp", "out.txt\n*TriaxialE1\n100 10 1.0\n-0.01\n");
        let wrong = write(folder.path(), "wrong.json", &wrong);
        let (code, _, errors) = run(&wrong);
        let place = format!("]: {}: {key}: ", wrong.display());
        assert!(code == 3 && errors.starts_with("error[") && errors.contains(&place), "{errors}");
    }
    let (code, ..) = output(program().arg("element-test").arg(folder.path()));
    assert_eq!(code, 2, "a folder needs a law");
    let (code, ..) = output(program().arg("element-test").arg(&law).arg("--material").arg(&law));
    assert_eq!(code, 2, "a test file has its own law");
}
