//! Commands on the folder of a run: files that are not theirs, and files of the run that are gone.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use super::in_folder;

/// A run of a bar in the folder `out`, with five frames.
fn bar(folder: &Path) {
    let case: Value = json!({
        "title": "bar", "space": "plane-strain", "domain": { "min": [0, 0], "max": [1, 1] }, "gravity": [0, 0],
        "materials": { "m": {
            "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0
        } },
        "bodies": [{ "name": "b", "material": "m", "velocity": { "kind": "uniform", "value": [1, 0] },
            "shape": { "kind": "box", "min": [0.2, 0.2], "max": [0.6, 0.4] } }],
        "stages": [{ "name": "s", "duration": 0.02 }], "output": { "frames": 0.005 },
        "methods": { "mpm": { "cell_size": 0.1 } }
    });
    fs::write(folder.join("bar.json"), case.to_string()).unwrap();
    let (code, _, errors) = in_folder(folder, &["run", "--quiet", "bar.json", "--out", "out"]);
    assert_eq!(code, 0, "{errors}");
}

#[test]
fn no_command_replaces_a_file_that_it_did_not_write() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    bar(folder);
    for (file, arguments) in [
        ("out/plots/velocity-00004.png", &["plot", "out", "--fields", "velocity"][..]),
        ("out/plots/velocity.gif", &["plot", "out", "--fields", "velocity", "--gif"]),
        ("out/npz/measures.npz", &["export", "out"]),
        ("out/points.csv", &["export", "out", "--points"]),
        ("out/report.html", &["report", "out"]),
    ] {
        let path = folder.join(file);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, "mine").unwrap();
        let (code, _, errors) = in_folder(folder, arguments);
        assert!(code == 1 && errors.contains(file) && errors.contains("--overwrite"), "{file}: {errors}");
        assert_eq!(fs::read_to_string(&path).unwrap(), "mine");
        let (code, _, errors) = in_folder(folder, &[arguments, &["--overwrite"]].concat());
        assert_eq!(code, 0, "{file}: {errors}");
        assert_ne!(fs::read(&path).unwrap(), b"mine");
        // Its own it replaces without being asked.
        let (code, _, errors) = in_folder(folder, arguments);
        assert_eq!(code, 0, "{file}: {errors}");
    }
}

#[test]
fn an_export_removes_the_archives_of_an_earlier_one_and_no_others() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    bar(folder);
    assert_eq!(in_folder(folder, &["export", "out"]).0, 0);
    fs::write(folder.join("out/npz/mine.npz"), "mine").unwrap();
    let list = fs::read_to_string(folder.join("out/frames.pvd")).unwrap();
    let shorter: Vec<&str> = list.lines().filter(|line| !line.contains("00004")).collect();
    fs::write(folder.join("out/frames.pvd"), shorter.join("\n")).unwrap();
    assert_eq!(in_folder(folder, &["export", "out"]).0, 0);
    let there = |name: &str| folder.join("out/npz").join(name).exists();
    assert!(there("mine.npz") && there("frame-00003.npz") && !there("frame-00004.npz"));
}
