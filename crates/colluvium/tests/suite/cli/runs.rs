//! Runs and sweeps, and their output files.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant, SystemTime};

use serde_json::json;

use super::{column, results, searched, summary, write};
use crate::{output, program};

#[test]
fn results_of_the_command_line_are_bit_identical_on_any_threads() {
    let folder = tempfile::tempdir().unwrap();
    let shapes = ["linear", "ugimp", "cpgimp", "quadratic", "cubic"];
    let pairs = shapes.iter().flat_map(|shape| ["usf", "usl", "musl"].map(|scheme| (*shape, scheme)));
    for (shape, scheme) in pairs {
        let mut case = column();
        case["methods"]["mpm"]["shape"] = json!(shape);
        case["methods"]["mpm"]["stress_update"] = json!(scheme);
        case["stages"] = json!([{ "name": "go", "duration": 0.03 }]);
        let name = format!("{shape}-{scheme}");
        let file = write(folder.path(), &format!("{name}.json"), &case);
        let run = |threads: &str| {
            let out = folder.path().join(format!("{name}-{threads}"));
            let mut command = program();
            command.args(["run", "--quiet", "--threads", threads, "--out"]).arg(&out).arg(&file);
            let (code, _, errors) = output(&mut command);
            assert_eq!(code, 0, "{name}: {errors}");
            (summary(&out)["snapshot_hash"].clone(), results(&out))
        };
        let (one, two) = (run("1"), run("2"));
        assert!(one.0.is_string() && one.0 == two.0, "{name}: {} and {}", one.0, two.0);
        assert!(one.1 == two.1, "{name}: every file is the same");
    }
}

#[cfg(unix)]
#[test]
fn an_interrupted_search_ends_with_code_4_and_resumes_to_the_same_result() {
    let folder = tempfile::tempdir().unwrap();
    let file = write(folder.path(), "slope.json", &searched());
    let run = |out: &Path, flag: Option<&str>| {
        let mut command = program();
        command.args(["run", "--quiet", "--out"]).arg(out).arg(&file).args(flag);
        command
    };
    let out = folder.path().join("cut");
    let mut child = run(&out, None).spawn().expect("the program starts");
    while !out.join("trials-safety.csv").exists() && child.try_wait().expect("a child").is_none() {
        std::thread::sleep(Duration::from_millis(1));
    }
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill");
    assert!(killed.success());
    assert_eq!(child.wait().expect("a child").code(), Some(4));
    assert_eq!(summary(&out)["status"], "interrupted");
    let (code, _, errors) = output(&mut run(&out, Some("--resume")));
    assert_eq!(code, 0, "{errors}");
    let whole = folder.path().join("whole");
    assert_eq!(output(&mut run(&whole, None)).0, 0);
    let (found, exact) = (summary(&out), summary(&whole));
    assert!(exact["factors_of_safety"]["safety"]["told"].is_string(), "{exact}");
    assert_eq!(found["factors_of_safety"], exact["factors_of_safety"]);
    assert_eq!(found["snapshot_hash"], exact["snapshot_hash"]);
    assert!(results(&out) == results(&whole), "every file is the same");
}

fn modified(file: &Path) -> Option<SystemTime> {
    fs::metadata(file).and_then(|data| data.modified()).ok()
}

/// The first frame after the start, once a checkpoint was written after it.
fn frame_before_checkpoint(out: &Path) -> Option<(PathBuf, SystemTime)> {
    let entries = fs::read_dir(out.join("frames")).ok()?.filter_map(|entry| Some(entry.ok()?.path()));
    let mut frames: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|extension| extension == "vtu")).collect();
    frames.sort();
    let frame = frames.into_iter().nth(1)?;
    let (written, saved) = (modified(&frame)?, modified(&out.join("checkpoint.bin"))?);
    (saved > written).then_some((frame, written))
}

#[test]
fn a_killed_run_resumes_bit_identically() {
    let folder = tempfile::tempdir().unwrap();
    let file = write(folder.path(), "column.json", &column());
    let whole = folder.path().join("whole");
    let (code, _, errors) = output(program().args(["run", "--quiet", "--out"]).arg(&whole).arg(&file));
    assert_eq!(code, 0, "{errors}");
    assert_eq!(summary(&whole)["status"], "completed");
    assert_eq!(summary(&whole)["commit"].as_str(), colluvium::COMMIT);
    let killed = folder.path().join("killed");
    let mut kills = 0;
    let mut kept = None;
    // Later and later, so that the run progresses between two kills at any speed of the machine.
    for attempt in 0..60u64 {
        let mut command = program();
        command.args(["run", "--quiet", "--out"]).arg(&killed).arg(&file);
        if killed.join("summary.json").exists() {
            command.arg("--resume");
        }
        let mut child = command.spawn().expect("the program starts");
        let patience = Instant::now() + Duration::from_millis(30 + 37 * attempt);
        // The first kill waits until there is output that only a run from the start would write again.
        while kept.is_none() && child.try_wait().expect("a child").is_none() {
            std::thread::sleep(Duration::from_millis(1));
            kept = frame_before_checkpoint(&killed);
        }
        while child.try_wait().expect("a child").is_none() && Instant::now() < patience {
            std::thread::sleep(Duration::from_millis(1));
        }
        // The child may end by itself before the signal comes; its status shows which.
        let _ = child.kill();
        let done = child.wait().expect("a dead child").success();
        kills += usize::from(!done);
        // A run that the signal reached between its last message and its end is complete as well; the files below show if it was not.
        if done || (killed.join("summary.json").exists() && summary(&killed)["status"] == "completed") {
            break;
        }
    }
    assert!(kills > 0, "the run was killed at least once");
    assert_eq!(summary(&killed)["status"], "completed");
    for same in ["snapshot_hash", "stages", "time_step_limits", "warnings"] {
        assert_eq!(summary(&killed)[same], summary(&whole)[same], "{same}");
    }
    assert!(results(&killed) == results(&whole), "every file is the same after {kills} kills");
    let (frame, written) = kept.expect("a checkpoint after the first frame");
    assert_eq!(modified(&frame), Some(written), "runs from the start write {} again", frame.display());
}

#[test]
fn a_folder_with_results_is_not_overwritten_without_the_option() {
    let folder = tempfile::tempdir().unwrap();
    let mut case = column();
    case["stages"] = json!([{ "name": "go", "duration": 0.002 }]);
    let file = write(folder.path(), "column.json", &case);
    let out = folder.path().join("out");
    let run = |flag: Option<&str>| {
        let mut command = program();
        command.args(["run", "--quiet", "--out"]).arg(&out).arg(&file).args(flag);
        output(&mut command)
    };
    assert_eq!(run(None).0, 0);
    let (code, _, errors) = run(None);
    assert!(code == 1 && errors.contains("earlier run"), "{errors}");
    assert_eq!(run(Some("--overwrite")).0, 0);
    assert!(fs::read_to_string(out.join("frames.pvd")).unwrap().contains("timestep"));
}

#[test]
fn a_sweep_prints_each_run_and_writes_one_table() {
    let folder = tempfile::tempdir().unwrap();
    let mut case = column();
    case["stages"] = json!([{ "name": "go", "duration": 0.02 }]);
    write(folder.path(), "column.json", &case);
    let mut sweep = json!({
        "title": "cells", "case": "column.json",
        "parameters": { "cell": { "at": ["methods.mpm.cell_size"], "values": [0.02, 0.01, 0.005] } },
        "convergence": { "parameter": "cell", "measures": ["front"] },
        "targets": { "front": { "value": 0.1, "tolerance": 0.01 } }
    });
    let file = write(folder.path(), "sweep.json", &sweep);
    let out = folder.path().join("out");
    let (code, said, errors) = output(program().arg("sweep").arg(&file).arg("--out").arg(&out));
    assert_eq!(code, 0, "{errors}");
    for line in
        ["run 2 (cell = 0.01): completed", "nearest to the targets: run ", "front: ", "3 of 3 runs complete"]
    {
        assert!(said.contains(line), "{line:?} in {said}");
    }
    assert_eq!(fs::read_to_string(out.join("runs.csv")).unwrap().lines().count(), 4);
    assert_eq!(fs::read_to_string(out.join("convergence.csv")).unwrap().lines().count(), 4);
    let again = ["sweep", "--quiet", "--resume", "--out"];
    let (code, said, errors) = output(program().args(again).arg(&out).arg(&file));
    assert_eq!((code, said.as_str()), (0, ""), "{errors}");

    sweep["parameters"]["cell"]["values"] = json!([0.02, 0.01, 0.03]);
    let file = write(folder.path(), "sweep.json", &sweep);
    let (code, _, errors) = output(program().arg("sweep").arg("--check").arg(&file));
    assert_eq!(code, 3);
    assert!(
        errors.starts_with("error[domain-not-divisible]: run 3 (cell = 0.03): methods.mpm.cell_size: "),
        "{errors}"
    );
}
