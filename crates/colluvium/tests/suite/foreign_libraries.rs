//! Libraries that a file names are foreign code: they run only where the user allows it, and their failures end in messages.

use std::path::Path;
use std::process::Command;

use super::{output, program};

/// Builds the C routines of the tests of `crates/umat`, which write a file `loaded` when any of their code runs.
pub fn build(folder: &Path) {
    let routines = Path::new(env!("CARGO_MANIFEST_DIR")).join("../umat/tests/elastic_umat.c");
    let trace = "#include <stdio.h>\n\
                 __attribute__((constructor)) static void trace(void) { FILE *f = fopen(\"loaded\", \"w\"); if (f) fclose(f); }\n";
    std::fs::write(folder.join("trace.c"), trace).unwrap();
    let compiler = std::env::var("CC").unwrap_or("cc".to_owned());
    let mut command = Command::new(compiler);
    let output =
        command.current_dir(folder).args(["-shared", "-fPIC", "-o", "soil.so", "trace.c"]).arg(routines);
    let output = output.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// Exit code and standard error of the program in a folder.
fn run(folder: &Path, arguments: &[&str], allowed: Option<&str>) -> (i32, String) {
    let mut command = program();
    command.current_dir(folder).args(arguments).env_remove("COLLUVIUM_ALLOW_LIBRARY");
    let (code, _, errors) = output(command.envs(allowed.map(|value| ("COLLUVIUM_ALLOW_LIBRARY", value))));
    (code, errors)
}

fn material(symbol: &str) -> serde_json::Value {
    serde_json::json!({
        "model": "umat", "density": 2000, "library": "./soil.so", "symbol": symbol, "props": [20e3, 0.3],
        "state_variables": [0, 0], "pascals": 1000
    })
}

fn element_test(folder: &Path, name: &str, material: &serde_json::Value) {
    let test = serde_json::json!({
        "title": "compression along x", "material": material,
        "stages": [{ "path": { "kind": "strain", "increment": [-0.01, 0, 0, 0, 0, 0] }, "steps": 5 }]
    });
    std::fs::write(folder.join(name), test.to_string()).unwrap();
}

#[test]
fn a_library_runs_only_where_the_user_allows_it() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    build(folder);
    element_test(folder, "plain.json", &material("umat_"));
    let around =
        serde_json::json!({ "model": "strength-reduced", "factor": 1.2, "material": material("umat_") });
    let case = serde_json::json!({
        "title": "block", "space": "plane-strain", "domain": { "min": [0, 0], "max": [1, 1] }, "gravity": [0, -9.81],
        "materials": { "soil": material("umat_") },
        "bodies": [{ "name": "block", "material": "soil", "shape": { "kind": "box", "min": [0, 0], "max": [0.5, 0.5] } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }],
        "stages": [{ "name": "go", "duration": 0.001 }], "methods": { "mpm": { "cell_size": 0.1 } }
    });
    std::fs::write(folder.join("case.json"), case.to_string()).unwrap();
    for wrapped in [false, true] {
        let mut case = case.clone();
        if wrapped {
            case["materials"]["soil"] = around.clone();
        }
        std::fs::write(folder.join("case.json"), case.to_string()).unwrap();
        for command in ["check", "run"] {
            for value in [None, Some("0"), Some("")] {
                let (code, errors) = run(folder, &[command, "case.json"], value);
                assert!(code == 3 && !folder.join("loaded").exists(), "{command} {value:?}: {code} {errors}");
                assert!(wrapped || errors.contains("materials.soil.library: ./soil.so: "), "{errors}");
                assert!(wrapped || errors.contains("--allow-library"), "{errors}");
            }
        }
    }
    let (code, errors) = run(folder, &["element-test", "plain.json"], None);
    assert!(code != 0 && errors.contains("--allow-library") && !folder.join("loaded").exists(), "{errors}");
    std::fs::write(folder.join("case.json"), case.to_string()).unwrap();
    let ways = [
        (&["check", "case.json", "--allow-library"][..], None),
        (&["element-test", "plain.json"][..], Some("1")),
    ];
    for (arguments, value) in ways {
        let (code, errors) = run(folder, arguments, value);
        assert!(code == 0 && folder.join("loaded").exists(), "{arguments:?}: {code} {errors}");
        std::fs::remove_file(folder.join("loaded")).unwrap();
    }
}

#[test]
fn a_user_library_that_exits_the_program_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    build(folder);
    element_test(folder, "exit.json", &material("exit_"));
    let (code, errors) = run(folder, &["element-test", "exit.json", "--allow-library"], None);
    assert_eq!((code, errors.as_str()), (1, "error[umat]: the library of a umat ended the program\n"));
}
