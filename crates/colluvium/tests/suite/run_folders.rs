//! Commands on the folder of a run: files of other origin, and missing files of the run.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use super::in_folder;

/// Run of a bar in the folder `out`, with five frames.
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
        // The command replaces its own files without a flag.
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

#[test]
fn missing_files_of_a_run_are_named_and_the_others_are_processed() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    bar(folder);
    let without = |name: &str, text: Option<&str>| {
        let path = folder.join("out").join(name);
        let whole = fs::read(&path).unwrap();
        fs::remove_file(&path).unwrap();
        if let Some(text) = text {
            fs::write(&path, text).unwrap();
        }
        for arguments in [&["report", "out"][..], &["plot", "out"], &["export", "out"]] {
            let (code, _, errors) = in_folder(folder, arguments);
            let named = errors
                .lines()
                .any(|line| line.starts_with("warning[results-missing]: ") && line.contains(name));
            assert!(code == 0 && named, "{arguments:?} without {name}: {code} {errors}");
        }
        fs::write(&path, whole).unwrap();
    };
    without("frames.pvd", None);
    without("frames.pvd", Some("<VTKFile"));
    without("measures.csv", None);
    without("measures.csv", Some("# about\ntime (s),front (m)\n0,x\n"));
    let page = fs::read_to_string(folder.join("out/report.html")).unwrap();
    assert!(page.contains("measures.csv: ") && page.contains("the report does not show the measures"));
    fs::remove_file(folder.join("out/frames.pvd")).unwrap();
    let (code, _, errors) = in_folder(folder, &["export", "out", "--points"]);
    assert!(code == 1 && errors.contains("frames.pvd"), "{errors}");
    fs::remove_file(folder.join("out/measures.csv")).unwrap();
    for command in ["plot", "export"] {
        let (code, _, errors) = in_folder(folder, &[command, "out"]);
        assert!(code == 1 && errors.contains("frames.pvd") && errors.contains("measures.csv"), "{errors}");
    }
}

#[test]
fn a_run_with_missing_terrain_is_plotted_and_exported_without_it() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    assert_eq!(in_folder(folder, &["new", "debris-flow"]).0, 0);
    let file = folder.join("debris-flow.json");
    let mut case: Value = serde_json::from_str(&fs::read_to_string(&file).unwrap()).unwrap();
    case["stages"][0]["duration"] = json!(0.5);
    case["methods"]["depth-sph"]["spacing"] = json!(4);
    fs::write(&file, case.to_string()).unwrap();
    let (code, _, errors) = in_folder(folder, &["run", "--quiet", "debris-flow.json", "--out", "out"]);
    assert_eq!(code, 0, "{errors}");
    let points = || {
        let (code, _, errors) = in_folder(folder, &["export", "out", "--points"]);
        assert_eq!(code, 0, "{errors}");
        (fs::read(folder.join("out/points.csv")).unwrap(), errors)
    };
    let (whole, errors) = points();
    assert!(errors.is_empty(), "{errors}");
    fs::rename(folder.join("debris-flow-terrain.asc"), folder.join("moved.asc")).unwrap();
    for arguments in [&["plot", "out"][..], &["report", "out"]] {
        let (code, _, errors) = in_folder(folder, arguments);
        let named =
            errors.contains("warning[results-missing]: ") && errors.contains("debris-flow-terrain.asc");
        assert!(code == 0 && named, "{arguments:?}: {code} {errors}");
    }
    assert!(folder.join("out/plots/map-peak_velocity.png").exists());
    assert!(fs::read_to_string(folder.join("out/report.html")).unwrap().contains("Maps"));
    let (without, errors) = points();
    assert!(without == whole, "the points do not depend on the terrain");
    assert!(
        errors.contains("warning[results-missing]: ") && errors.contains("debris-flow-terrain.asc"),
        "{errors}"
    );
    let (code, _, errors) = in_folder(folder, &["verify", "out"]);
    assert_eq!(code, 0, "{errors}");
    // File with the name of a result that the run did not write.
    fs::write(folder.join("out/rasters/final_speed.asc"), "mine").unwrap();
    let (code, said, errors) = in_folder(folder, &["verify", "out"]);
    let named = "rasters/final_speed.asc: has the name of a result, but the run did not write it";
    assert!(code == 1 && (said + &errors).contains(named));
}

#[test]
fn pictures_of_plane_contacts_label_forces_per_metre_of_thickness() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    assert_eq!(in_folder(folder, &["new", "two-grains"]).0, 0);
    let file = folder.join("two-grains.json");
    let mut case: Value = serde_json::from_str(&fs::read_to_string(&file).unwrap()).unwrap();
    case["output"]["contacts"] = json!(true);
    case["stages"] = json!([{ "name": "go", "duration": 0.01 }]);
    fs::write(&file, case.to_string()).unwrap();
    let (code, _, errors) = in_folder(folder, &["run", "--quiet", "two-grains.json", "--out", "out"]);
    assert_eq!(code, 0, "{errors}");
    let plot = ["plot", "out", "--dataset", "contacts", "--format", "svg"];
    let (code, _, errors) = in_folder(folder, &plot);
    assert_eq!(code, 0, "{errors}");
    let name = |entry: fs::DirEntry| entry.file_name().to_string_lossy().into_owned();
    let pictures = fs::read_dir(folder.join("out/plots")).unwrap().map(|entry| name(entry.unwrap()));
    let picture = pictures.into_iter().find(|name| name.starts_with("contacts-force")).unwrap();
    let text = fs::read_to_string(folder.join("out/plots").join(picture)).unwrap();
    let title = text.split("mean ").nth(1).unwrap().split(';').next().unwrap();
    let digits = |word: &str| word.split('e').next().unwrap().replace(['.', '-'], "");
    for word in title.split([' ', ',']).filter(|word| word.starts_with(|c: char| c.is_ascii_digit())) {
        assert!(digits(word).trim_matches('0').len() <= 3, "{title}");
    }
    assert_eq!(title.matches(" N/m").count(), 2, "{title}");
}

#[test]
fn memory_of_a_sweep_counts_the_program_once_per_job() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    bar(folder);
    let sweep = json!({
        "title": "cells", "case": "bar.json",
        "parameters": { "cell": { "at": ["methods.mpm.cell_size"], "values": [0.005, 0.004] } }
    });
    fs::write(folder.join("sweep.json"), sweep.to_string()).unwrap();
    let memory = |arguments: &[&str]| -> f64 {
        let (code, said, errors) = in_folder(folder, arguments);
        assert_eq!(code, 0, "{errors}");
        let line = said.lines().find(|line| line.starts_with("memory")).unwrap();
        line.split("about ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap()
    };
    // The memory of a run of a few points is small beside that of the program.
    let of_program = memory(&["check", "bar.json"]);
    let [one, two] = ["1", "2"].map(|jobs| memory(&["sweep", "--check", "sweep.json", "--jobs", jobs]));
    assert!(one > 0.5 * of_program && two > one + 3.0, "{of_program} {one} {two}");
}
