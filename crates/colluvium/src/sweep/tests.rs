use std::fs;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

use serde_json::json;

use super::*;

/// Small block that falls.
fn block() -> Value {
    json!({
        "title": "block", "space": "plane-strain", "domain": { "min": [0, 0], "max": [0.4, 0.2] }, "gravity": [0, -9.81],
        "materials": { "sand": {
            "model": "mohr-coulomb", "density": 1600, "youngs_modulus": 1e5, "poissons_ratio": 0.3, "friction_angle": 30
        } },
        "bodies": [{ "name": "block", "material": "sand", "shape": { "kind": "box", "min": [0, 0], "max": [0.1, 0.1] } }],
        "boundaries": [
            { "side": "x-min", "wall": { "kind": "smooth" } }, { "side": "x-max", "wall": { "kind": "smooth" } },
            { "side": "y-min", "wall": { "kind": "frictional", "friction_coefficient": 0.5 } }
        ],
        "stages": [{ "name": "go", "duration": 0.05 }],
        "measures": { "front": { "kind": "front", "side": "x-max", "quantile": 0.99 } },
        "methods": { "mpm": { "cell_size": 0.025 } }
    })
}

fn sweep() -> Value {
    json!({
        "title": "sweep", "case": "block.json",
        "parameters": {
            "friction": { "at": ["materials.sand.friction_angle"], "values": [20, 40] },
            "floor": { "at": ["boundaries[2].wall.friction_coefficient"], "values": [0.1, 0.5, 1.0] }
        },
        "targets": { "front": { "value": 0.12, "tolerance": 0.01 } }
    })
}

/// Folder with the files of a sweep.
fn files(sweep: &Value) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("block.json"), block().to_string()).unwrap();
    let path = folder.path().join("sweep.json");
    fs::write(&path, sweep.to_string()).unwrap();
    (folder, path)
}

fn problem(change: impl FnOnce(&mut Value)) -> String {
    let mut sweep = sweep();
    change(&mut sweep);
    let (_folder, path) = files(&sweep);
    Sweep::load(&path).unwrap_err().to_string()
}

#[test]
fn errors_in_sweeps_name_the_json_path() {
    let parameter = |key: &'static str, value: Value| {
        move |sweep: &mut Value| sweep["parameters"]["friction"][key] = value
    };
    let wrong: Vec<(String, &str)> = vec![
        (problem(parameter("at", json!(["materials.clay.friction_angle"]))), "parameters.friction.at[0]: "),
        (problem(parameter("at", json!([]))), "parameters.friction.at: is empty"),
        (
            problem(parameter("values", json!([20, 95]))),
            "run 2 (floor = 0.1, friction = 95): materials.sand.friction_angle: 95",
        ),
        (problem(parameter("values", json!([20, [1]]))), "parameters.friction.values: [1]"),
        (problem(parameter("values", json!([]))), "parameters.friction.values: is missing"),
        (problem(parameter("range", json!([1, 2]))), "parameters.friction.range: is given beside values"),
        (
            problem(parameter("scale", json!("logarithmic"))),
            "parameters.friction.scale: applies to a range only",
        ),
        (
            problem(|s| s["plan"] = json!({ "kind": "together" })),
            "parameters.friction.values: has 2 entries, and floor has 3",
        ),
        (problem(|s| s["plan"] = json!({ "kind": "sobol", "runs": 0 })), "plan.runs: 0 is not"),
        (
            problem(|s| s["targets"]["front"]["tolerance"] = json!(0)),
            "targets.front.tolerance: 0 is not above 0",
        ),
        (problem(|s| s["parameters"] = json!({})), "parameters: is empty"),
        (
            problem(|s| {
                let floor = s["parameters"].as_object_mut().unwrap().remove("floor").unwrap();
                s["parameters"]["../../x"] = floor;
            }),
            "parameters.../../x: a name is made of up to 100 letters",
        ),
        (problem(|s| s["case"] = json!("none.json")), "none.json: cannot be read"),
        (
            problem(|s| s["convergence"] = json!({ "parameter": "friction", "measures": ["front"] })),
            "convergence.parameter: needs three or more values",
        ),
        (
            problem(|s| {
                s["parameters"]["floor"] =
                    json!({ "at": ["boundaries[2].wall.friction_coefficient"], "range": [0.1, 1] });
            }),
            "parameters.floor.range: applies to the plans",
        ),
    ];
    for (found, expected) in wrong {
        assert!(found.contains(expected), "{found:?} for {expected:?}");
    }
}

#[test]
fn unknown_columns_are_refused_with_a_suggestion() {
    let mut wrong = sweep();
    wrong["targets"] = json!({ "frnt": { "value": 1, "tolerance": 1 } });
    let (_folder, path) = files(&wrong);
    let (sweep, members) = Sweep::load(&path).unwrap();
    let solver = crate::method("mpm").unwrap().build(&members[0].case).unwrap();
    let columns = crate::case::run::column_names(&members[0].case, &*solver);
    let found = sweep.check_columns(&columns).unwrap_err().to_string();
    assert_eq!(found, "targets.frnt: \"frnt\" is not a column of the measures; did you mean \"front\"?");
}

#[test]
fn sampling_plans_generate_their_runs() {
    let (_folder, path) = files(&sweep());
    let (sweep, members) = Sweep::load(&path).unwrap();
    let values: Vec<&Vec<Value>> = members.iter().map(|member| &member.values).collect();
    assert_eq!(values.len(), 6);
    assert_eq!((values[0], values[5]), (&vec![json!(0.1), json!(20)], &vec![json!(1.0), json!(40)]));
    let mut drawn = Sweep { plan: SamplingPlan::LatinHypercube { runs: 8, seed: 1 }, ..sweep };
    let modulus = SweepParameter {
        paths: vec!["materials.sand.youngs_modulus".into()],
        values: Vec::new(),
        range: Some([1e4, 1e8]),
        scale: ParameterScale::Logarithmic,
    };
    drawn.parameters.insert("modulus".into(), modulus);
    let members = drawn.cases(&block(), Path::new("")).unwrap();
    let mut decades = [0; 4];
    let mut angles = [0; 2];
    for SweepCase { values, .. } in &members {
        decades[values[2].as_f64().unwrap().log10() as usize - 4] += 1;
        angles[values[1].as_u64().unwrap() as usize / 20 - 1] += 1;
    }
    assert_eq!((decades, angles), ([2; 4], [4; 2]), "each part as often as the others");
}

/// Runs the sweep of a file and returns its table without the times.
fn table(path: &Path, options: &SweepOptions) -> Result<(Vec<Vec<String>>, Vec<SweepRunState>), SweepError> {
    let (sweep, members) = Sweep::load(path).unwrap();
    let states = std::sync::Mutex::new(vec![SweepRunState::Interrupted; members.len()]);
    let on_state = |number: usize, state: &SweepRunState| states.lock().unwrap()[number] = state.clone();
    run_sweep(&sweep, &members, crate::method("mpm").unwrap(), options, &on_state)?;
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .from_path(options.output_folder.join("runs.csv"))
        .unwrap();
    let mut lines: Vec<Vec<String>> =
        reader.records().map(|record| record.unwrap().iter().map(str::to_owned).collect()).collect();
    let wall = lines[0].iter().position(|name| name == "wall_time (s)").unwrap();
    lines.iter_mut().for_each(|line| line[wall].clear());
    Ok((lines, states.into_inner().unwrap()))
}

#[test]
fn the_table_does_not_depend_on_the_number_of_jobs() {
    let (folder, path) = files(&sweep());
    let options = |name: &str, jobs, threads| SweepOptions {
        output_folder: folder.path().join(name),
        jobs,
        threads,
        ..SweepOptions::default()
    };
    let (one, _) = table(&path, &options("one", 1, 2)).unwrap();
    let (three, states) = table(&path, &options("three", 3, 1)).unwrap();
    assert_eq!(one, three);
    assert!(states.iter().all(|state| *state == SweepRunState::Completed));
    let column = |name: &str| {
        let index = one[0].iter().position(|head| head == name).unwrap();
        one[1..].iter().map(|line| line[index].parse::<f64>().unwrap()).collect::<Vec<_>>()
    };
    let (front, misfit) = (column("front (m)"), column("misfit"));
    assert!(front[0] > front[1] && front[0] > front[4], "friction holds it back: {front:?}");
    for (front, misfit) in front.iter().zip(&misfit) {
        assert!((misfit - (front - 0.12).abs() / 0.01).abs() < 1e-9);
    }
    assert!(folder.path().join("one/pictures/front-floor.svg").exists());
}

#[test]
fn a_sweep_resumes_where_it_stopped_and_refuses_folders_of_other_sweeps() {
    let (folder, path) = files(&sweep());
    let out = folder.path().join("out");
    let options = SweepOptions { output_folder: out.clone(), jobs: 1, threads: 1, ..SweepOptions::default() };
    let (whole, _) =
        table(&path, &SweepOptions { output_folder: folder.path().join("whole"), ..options.clone() })
            .unwrap();

    // Stops after the second run.
    let (sweep, members) = Sweep::load(&path).unwrap();
    let stop = std::sync::Arc::new(AtomicBool::new(false));
    let on_state = |number: usize, _: &SweepRunState| stop.store(number == 1, Ordering::Relaxed);
    let method = crate::method("mpm").unwrap();
    let stopped = SweepOptions { stop_flag: stop.clone(), ..options.clone() };
    let results = run_sweep(&sweep, &members, method, &stopped, &on_state).unwrap();
    let status: Vec<&str> = results.rows.iter().map(|row| row.status.as_str()).collect();
    assert_eq!(status, ["completed", "completed", "", "", "", ""]);

    let refused = table(&path, &options).unwrap_err().to_string();
    assert!(refused.contains("contains an earlier sweep already"), "{refused}");
    let resumed = SweepOptions { resume: true, ..options.clone() };
    let (rest, states) = table(&path, &resumed).unwrap();
    assert_eq!(rest, whole);
    assert_eq!(states[1..3], [SweepRunState::AlreadyComplete, SweepRunState::Completed]);

    fs::remove_file(out.join("run-0001/measures.csv")).unwrap();
    let (_, states) = table(&path, &resumed).unwrap();
    assert!(
        matches!(&states[0], SweepRunState::Failed { code: "run-files-changed", reason } if reason.contains("measures.csv")),
        "{states:?}"
    );

    let mut other = self::sweep();
    other["parameters"]["friction"]["values"] = json!([20]);
    fs::write(&path, other.to_string()).unwrap();
    let refused = table(&path, &resumed).unwrap_err().to_string();
    assert!(refused.contains("contains another sweep"), "{refused}");
    for name in ["run-0004/notes.txt", "pictures/mine.svg"] {
        fs::write(out.join(name), "kept").unwrap();
    }
    table(&path, &SweepOptions { overwrite: true, ..options.clone() }).unwrap();
    assert!(
        out.join("run-0003/summary.json").exists() && !out.join("run-0005").exists(),
        "the old one is gone"
    );
    assert!(!out.join("run-0004/summary.json").exists() && out.join("run-0004/notes.txt").exists());
    assert!(out.join("pictures/mine.svg").exists());
    // A table that no sweep wrote.
    let foreign = folder.path().join("foreign");
    fs::create_dir(&foreign).unwrap();
    fs::write(foreign.join("runs.csv"), "mine").unwrap();
    let refused =
        table(&path, &SweepOptions { output_folder: foreign.clone(), ..options }).unwrap_err().to_string();
    assert!(refused.contains("runs.csv, which no sweep wrote"), "{refused}");
    assert_eq!(fs::read_to_string(foreign.join("runs.csv")).unwrap(), "mine");
}

#[test]
fn a_failed_run_of_a_sweep_is_reported_and_the_others_complete() {
    let mut sweep = sweep();
    sweep["parameters"] = json!({ "side": { "at": ["domain.max[0]"], "values": [0.4, 0.1, 0.8] } });
    let (folder, path) = files(&sweep);
    let mut case = block();
    // After a while the block leaves the narrow domain.
    case["boundaries"].as_array_mut().unwrap().remove(1);
    case["stages"][0]["duration"] = json!(0.2);
    fs::write(folder.path().join("block.json"), case.to_string()).unwrap();
    let options = SweepOptions {
        output_folder: folder.path().join("out"),
        jobs: 1,
        threads: 1,
        ..SweepOptions::default()
    };
    let (lines, states) = table(&path, &options).unwrap();
    assert!(
        matches!(&states[1], SweepRunState::Failed { reason: why, .. } if why.contains("domain")),
        "{states:?}"
    );
    let status: Vec<&str> = lines[1..].iter().map(|line| line[1].as_str()).collect();
    assert_eq!(status, ["completed", "failed", "completed"]);
    assert!(lines[2].last().unwrap().contains("domain"));
}

#[test]
fn the_study_of_convergence_finds_the_order_of_each_series() {
    let mut sweep = sweep();
    sweep["parameters"]["cell"] = json!({ "at": ["methods.mpm.cell_size"], "values": [0.0125, 0.05, 0.025] });
    sweep["parameters"].as_object_mut().unwrap().remove("floor");
    sweep["convergence"] = json!({ "parameter": "cell", "measures": ["front"] });
    let (folder, path) = files(&sweep);
    let (sweep, members) = Sweep::load(&path).unwrap();
    let row = |member: &SweepCase| {
        let (cell, friction) = (member.values[0].as_f64().unwrap(), member.values[1].as_f64().unwrap());
        let front = 0.2 + cell.powf(friction / 20.0);
        let measures = vec![("front".to_owned(), "m".to_owned(), front)];
        SweepRow {
            values: member.values.clone(),
            status: "completed".into(),
            reason: None,
            measures,
            wall_time: 1.0,
        }
    };
    let results = SweepResults { sweep: &sweep, rows: members.iter().map(row).collect() };
    let messages = results.write_convergence(folder.path()).unwrap();
    assert_eq!(messages.len(), 2);
    assert!(messages[0].starts_with("front (friction = 20): order 1.00, limit 2.000000e-1"), "{messages:?}");
    assert!(messages[1].starts_with("front (friction = 40): order 2.00, limit 2.000000e-1"), "{messages:?}");
    let lines = fs::read_to_string(folder.path().join("convergence.csv")).unwrap();
    assert_eq!(lines.lines().count(), 1 + 6);
}

#[test]
fn a_parameter_without_effect_on_the_runs_is_named() {
    let (_folder, path) = files(&sweep());
    let (sweep, members) = Sweep::load(&path).unwrap();
    let names: Vec<&String> = sweep.parameters.keys().collect();
    let results = |front: &dyn Fn(&[Value]) -> f64| {
        let row = |member: &SweepCase| SweepRow {
            values: member.values.clone(),
            status: "completed".into(),
            reason: None,
            measures: vec![("front".to_owned(), "m".to_owned(), front(&member.values))],
            wall_time: 1.0,
        };
        let found = SweepResults { sweep: &sweep, rows: members.iter().map(row).collect() };
        found.warnings().into_iter().map(|warning| warning.text).collect::<Vec<_>>()
    };
    let number = |value: &Value| value.to_string().bytes().map(f64::from).sum::<f64>();
    assert_eq!(results(&|values| number(&values[0]) + 1e3 * number(&values[1])), [""; 0]);
    let found = results(&|values| number(&values[0]));
    assert!(found.len() == 1 && found[0].starts_with(&format!("parameters.{}:", names[1])), "{found:?}");
    assert_eq!(results(&|_| f64::NAN).len(), 2);
}
