//! Files that are not JSON, with the line and the column of the error; messages that cannot be written.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::{Value, json};

use super::{in_folder, program};

/// JSON text that ends before a value: line 3, column 0.
const BROKEN: &str = "{\n  \"title\": \n";

/// Exit code and errors of the program in `folder`.
fn errors(folder: &Path, arguments: &[&str]) -> (i32, String) {
    let (code, _, errors) = in_folder(folder, arguments);
    (code, errors)
}

fn bar() -> Value {
    json!({
        "title": "bar", "space": "1d", "domain": { "min": [0], "max": [1] }, "gravity": [0],
        "materials": { "m": {
            "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0
        } },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.2], "max": [0.8] } }],
        "stages": [{ "name": "s", "duration": 0.02 }],
        "methods": { "mpm": { "cell_size": 0.1 } }
    })
}

#[test]
fn invalid_json_input_is_named_with_line_and_column() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let write = |name: &str, text: &str| fs::write(folder.join(name), text).unwrap();
    let sweep = |case: &str| {
        let at = json!({ "at": ["materials.m.density"], "values": [1, 2] });
        json!({ "title": "s", "case": case, "parameters": { "density": at } }).to_string()
    };
    write("broken.json", BROKEN);
    write("twice.json", "{ \"title\": \"a\",\n  \"title\": \"b\" }");
    write("of-broken.json", &sweep("broken.json"));
    let mut wrong = bar();
    wrong["materials"]["m"]["poissons_ratio"] = json!(0.7);
    write("wrong.json", &wrong.to_string());
    write("of-wrong.json", &sweep("wrong.json"));
    fs::create_dir(folder.join("test")).unwrap();
    write("test/initialconditions.inp", "0\n");
    write("test/test.inp", "out.txt\n");
    for (arguments, start) in [
        (&["check", "broken.json"][..], "broken.json: line 3, column 0: EOF"),
        (&["run", "broken.json"], "broken.json: line 3, column 0: EOF"),
        (&["run", "twice.json"], "twice.json: line 2, column 16: the key \"title\" appears twice"),
        (&["sweep", "broken.json"], "broken.json: line 3, column 0: EOF"),
        (&["sweep", "of-broken.json"], "broken.json: line 3, column 0: EOF"),
        (&["sweep", "of-wrong.json"], "wrong.json: materials.m.poissons_ratio: 0.7 "),
        (&["element-test", "broken.json"], "broken.json: line 3, column 0: EOF"),
        (&["element-test", "test", "--material", "broken.json"], "broken.json: line 3, column 0: EOF"),
    ] {
        let (code, errors) = errors(folder, arguments);
        assert!(
            code == 3 && errors.starts_with("error[") && errors.contains(&format!("]: {start}")),
            "{arguments:?}: {errors}"
        );
    }
}

#[test]
fn broken_json_files_of_a_run_are_named_with_line_and_column() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mut case = bar();
    case["stages"][0]["duration"] = json!(0.01);
    fs::write(folder.join("bar.json"), case.to_string()).unwrap();
    assert_eq!(errors(folder, &["run", "bar.json", "--out", "bar"]).0, 0);
    let summary = fs::read_to_string(folder.join("bar/summary.json")).unwrap();
    let broken = |arguments: &[&str], file: &str| {
        let (code, errors) = errors(folder, arguments);
        let place = format!("{file}: line 3, column 0: EOF");
        assert!(code != 0 && errors.contains(&place), "{arguments:?}: {errors}");
    };
    fs::write(folder.join("bar/summary.json"), BROKEN).unwrap();
    broken(&["report", "bar"], "summary.json");
    broken(&["run", "bar.json", "--out", "bar", "--resume"], "summary.json");
    fs::write(folder.join("bar/summary.json"), summary).unwrap();
    fs::write(folder.join("bar/case.json"), BROKEN).unwrap();
    broken(&["report", "bar"], "case.json");
    broken(&["plot", "bar"], "case.json");
}

#[test]
fn time_steps_too_short_to_reach_the_end_are_refused_before_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let refused = |case: &Value, place: &str, words: &str| {
        fs::write(folder.join("bar.json"), case.to_string()).unwrap();
        for arguments in [&["check", "bar.json"][..], &["run", "bar.json", "--out", "out"]] {
            let (code, errors) = errors(folder, arguments);
            assert!(code == 3 && errors.contains(place) && errors.contains(words), "{arguments:?}: {errors}");
        }
        assert!(!folder.join("out").exists(), "nothing was begun");
    };
    for method in [json!({ "mpm": { "cell_size": 0.1 } }), json!({ "sph": { "spacing": 0.05 } })] {
        let mut case = bar();
        case["methods"] = method;
        case["materials"]["m"]["youngs_modulus"] = json!(1e50);
        refused(&case, "stages: the time step, ", "more than 2^53 steps away");
        // Stiff, and of many steps, but all of them count.
        case["materials"]["m"]["youngs_modulus"] = json!(1e20);
        fs::write(folder.join("bar.json"), case.to_string()).unwrap();
        assert_eq!(errors(folder, &["check", "bar.json"]).0, 0);
    }
    let mut rigid = bar();
    rigid["bodies"][0]["rigid"] = json!(true);
    refused(&rigid, "bodies: ", "all bodies are rigid");
}

#[cfg(target_os = "linux")]
#[test]
fn unwritable_messages_do_not_end_the_program() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("bar.json"), bar().to_string()).unwrap();
    let full = || fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let arguments: [&[&str]; 4] = [
        &["check", "bar.json"],
        &["run", "bar.json", "--out", "out"],
        &["report", "out"],
        &["check", "none.json"],
    ];
    for arguments in arguments {
        let mut command = program();
        command.current_dir(folder.path()).args(arguments).stdout(full()).stderr(full());
        let code = command.status().unwrap().code();
        assert!(code.is_some_and(|code| code < 5), "{arguments:?}: {code:?}");
    }
    assert!(folder.path().join("out/summary.json").exists(), "the run went on");
}

/// Full disk, imitated by a limit of 64 KiB for the length of a file.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_ends_the_run_and_leaves_no_partial_frame() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let mut case = bar();
    case["methods"]["mpm"]["cell_size"] = json!(1e-4);
    case["stages"][0]["duration"] = json!(1e-5);
    fs::write(folder.join("bar.json"), case.to_string()).unwrap();
    let mut command = Command::new("sh");
    command.arg("-c").arg("trap '' XFSZ; ulimit -f 128; exec \"$0\" run bar.json --out out");
    let output = command.arg(env!("CARGO_BIN_EXE_colluvium")).current_dir(folder).output().unwrap();
    let errors = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success() && errors.contains("out/frames/frame-00000.vtu: "), "{errors}");
    let summary: Value =
        serde_json::from_str(&fs::read_to_string(folder.join("out/summary.json")).unwrap()).unwrap();
    assert_eq!(summary["status"], "failed", "{summary}");
    let frames: Vec<_> = fs::read_dir(folder.join("out/frames")).unwrap().collect();
    assert!(frames.is_empty(), "what could not be written whole is gone: {frames:?}");
}
