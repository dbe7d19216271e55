//! Files of another kind than a command takes.

use std::fs;
use std::path::Path;

use serde_json::json;

use super::{output, program};

/// Exit code, standard output and standard error of the program in a folder.
fn run(folder: &Path, arguments: &[&str]) -> (i32, String) {
    let (code, _, errors) = output(program().current_dir(folder).args(arguments));
    (code, errors)
}

#[test]
fn files_of_another_kind_are_refused_with_the_command_for_them() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let write =
        |name: &str, value: &serde_json::Value| fs::write(folder.join(name), value.to_string()).unwrap();
    let elastic =
        json!({ "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 });
    let stage = json!({ "path": { "kind": "strain", "increment": [-0.01, 0, 0, 0, 0, 0] }, "steps": 5 });
    write("test.json", &json!({ "title": "t", "material": elastic, "stages": [stage] }));
    write("sweep.json", &json!({ "title": "t", "case": "case.json", "parameters": {} }));
    write("fit.json", &json!({ "title": "t", "material": elastic, "parameters": {}, "tests": [] }));
    write("case.json", &json!({ "title": "t", "space": "1d", "domain": {}, "bodies": [] }));
    fs::create_dir(folder.join("run")).unwrap();
    write("run/summary.json", &json!({}));
    fs::create_dir(folder.join("driver")).unwrap();
    fs::write(folder.join("driver/test.inp"), "o\n*End\n").unwrap();
    for command in ["check", "run", "compare"] {
        for (file, line) in [
            (
                "test.json",
                "test.json: is an element test, and not a case: use `colluvium element-test test.json`",
            ),
            ("sweep.json", "sweep.json: is a sweep, and not a case: use `colluvium sweep sweep.json`"),
            ("fit.json", "fit.json: is a fit, and not a case: use `colluvium fit fit.json`"),
            ("run", "run: is the folder of a run, and not a case: `colluvium report run` writes its report"),
            (
                "driver",
                "driver: is the folder of an incrementalDriver, and not a case: `colluvium element-test driver --material FILE` runs it",
            ),
        ] {
            assert_eq!(
                run(folder, &[command, file]),
                (3, format!("error[wrong-file-kind]: {line}\n")),
                "{command} {file}"
            );
        }
    }
    for (command, file, is) in [
        ("sweep", "test.json", "is an element test, and not a sweep: use `colluvium element-test"),
        ("fit", "test.json", "is an element test, and not a fit: use `colluvium element-test"),
        ("fit", "case.json", "is a case, and not a fit: use `colluvium check"),
        ("element-test", "fit.json", "is a fit, and not an element test: use `colluvium fit"),
        ("sweep", "case.json", "is a case, and not a sweep: use `colluvium check"),
        ("element-test", "case.json", "is a case, and not an element test: use `colluvium check"),
        ("element-test", "sweep.json", "is a sweep, and not an element test: use `colluvium sweep"),
    ] {
        let (code, errors) = run(folder, &[command, file]);
        assert!(
            code == 3 && errors.contains(is) && errors.lines().count() == 1,
            "{command} {file}: {errors}"
        );
    }
    // A file of no known kind gives the message of the command.
    write("odd.json", &json!({ "title": "t" }));
    let (code, errors) = run(folder, &["check", "odd.json"]);
    assert!(code == 3 && errors.contains("\"space\" is missing"), "{errors}");
}

#[test]
fn input_files_results_and_folders_are_named_by_kind_in_errors() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let write =
        |name: &str, value: &serde_json::Value| fs::write(folder.join(name), value.to_string()).unwrap();
    write("area.geojson", &json!({ "type": "FeatureCollection", "features": [] }));
    write("area.json", &json!({ "type": "Polygon", "coordinates": [] }));
    write("summary.json", &json!({ "fingerprint": "0", "status": "completed", "method": "mpm" }));
    fs::write(folder.join("terrain.asc"), "ncols 2\n").unwrap();
    fs::create_dir(folder.join("empty")).unwrap();
    for (file, is) in [
        ("area.geojson", "area.geojson: is an outline, and not a case: name it in a case file"),
        ("area.json", "area.json: is an outline, and not a case: name it in a case file"),
        ("terrain.asc", "terrain.asc: is a raster, and not a case: name it in a case file"),
        (
            "summary.json",
            "summary.json: is the summary of a run, and not a case: give the folder of the run to `colluvium report`",
        ),
        ("empty", "empty: is a folder, and not a case: give the path of the file"),
    ] {
        let (code, errors) = run(folder, &["check", file]);
        assert!(code == 3 && errors.contains(is) && errors.lines().count() == 1, "{file}: {errors}");
    }
}

#[test]
fn a_law_that_ignores_the_properties_of_parameters_inp_causes_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("initialconditions.inp"), "6\n-100\n-100\n-100\n0\n0\n0\n0\n").unwrap();
    fs::write(folder.join("test.inp"), "o\n*OEDOMETRICE1\n5 1 1\n-0.01\n*END\n").unwrap();
    fs::write(folder.join("parameters.inp"), "Elastic\n2\n20000.0\n0.3\n").unwrap();
    let law = |name: &str, law: &serde_json::Value| fs::write(folder.join(name), law.to_string()).unwrap();
    law(
        "own.json",
        &json!({ "model": "linear-elastic", "density": 2000, "youngs_modulus": 2e7, "poissons_ratio": 0.3 }),
    );
    let test = |material: &str| {
        run(
            folder,
            &[
                "element-test",
                ".",
                "--material",
                material,
                "--stress-unit",
                "kPa",
                "--out",
                "out",
                "--allow-library",
            ],
        )
    };
    let (code, errors) = test("own.json");
    assert_eq!(
        (code, errors.as_str()),
        (
            0,
            "warning[unused-values]: parameters.inp: the law of --material does not use the 2 properties. Check that it is the intended law\n"
        )
    );
    let rows = || -> Vec<String> {
        let text = fs::read_to_string(folder.join("out/path.csv")).unwrap();
        text.lines().filter(|line| !line.starts_with('#')).map(str::to_owned).collect()
    };
    let of_own = rows();
    super::foreign_libraries::build(folder);
    law("umat.json", &json!({ "model": "umat", "density": 2000, "library": folder.join("soil.so") }));
    let (code, errors) = test("umat.json");
    assert_eq!((code, errors.as_str()), (0, ""));
    // The properties of the file give the same elastic law.
    let of_umat = rows();
    let column = |head: &str| head.split(',').position(|name| name.starts_with("stress_xx")).unwrap();
    let stress = |lines: &[String]| -> f64 {
        lines[lines.len() - 1].split(',').nth(column(&lines[0])).unwrap().parse().unwrap()
    };
    assert!((stress(&of_umat) / stress(&of_own) - 1.0).abs() < 1e-9);
}
