//! Tests of resumed runs.

use super::*;

#[test]
fn a_resumed_run_keeps_the_start_times_of_its_loads() {
    let stages = r#"[ { "name": "wait", "duration": 1 }, { "name": "load", "duration": 1 },
                      { "name": "settle", "duration": 40, "equilibrium": { "hold": 1 } } ]"#;
    let case = loaded_oscillators(stages, Some("load"));
    let whole = tempfile::tempdir().unwrap();
    let end = run(&case, Oscillators::boxed(3.0, None), &options(whole.path())).unwrap().snapshot.time;
    assert!((9.0..9.0 + CHECKS).contains(&end), "{end} s");
    let folder = tempfile::tempdir().unwrap();
    run(&case, Oscillators::boxed(3.0, Some(6.0)), &options(folder.path())).unwrap_err();
    let again = RunOptions { resume: true, ..options(folder.path()) };
    assert_eq!(run(&case, Oscillators::boxed(3.0, None), &again).unwrap().snapshot.time, end);
    assert!(output_files(folder.path()) == output_files(whole.path()));
}

#[test]
fn a_damaged_checkpoint_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let case = case(r#"[ { "name": "all", "duration": 2.0 } ]"#);
    run(&case, Oscillators::boxed(0.0, Some(1.2)), &options(folder.path())).unwrap_err();
    let path = folder.path().join("checkpoint.bin");
    let whole = std::fs::read(&path).unwrap();
    let resume = RunOptions { resume: true, ..options(folder.path()) };
    for place in [0, whole.len() / 2, whole.len() - 1] {
        let mut bytes = whole.clone();
        bytes[place] ^= 4;
        std::fs::write(&path, bytes).unwrap();
        let error = run(&case, Oscillators::boxed(0.0, None), &resume).unwrap_err();
        assert!(error.to_string().contains("checkpoint.bin: is damaged"), "{error}");
    }
    std::fs::write(&path, whole).unwrap();
    run(&case, Oscillators::boxed(0.0, None), &resume).unwrap();
}

#[test]
fn files_of_a_resumed_run_are_bit_identical() {
    let mut case = case(
        r#"[ { "name": "a", "duration": 1.3 }, { "name": "b", "duration": 0.7, "reset": ["velocity"] } ]"#,
    );
    case.output.grid = Some(0.5);
    let whole = tempfile::tempdir().unwrap();
    run(&case, Oscillators::boxed(0.1, None), &options(whole.path())).unwrap();
    let grids = Collection::read(&whole.path().join("grid.pvd")).unwrap().frames;
    assert_eq!(grids.len(), 5);
    assert!(grids.iter().all(|(_, name)| whole.path().join(name).exists()), "{grids:?}");
    for fail_at in [0.05, 0.49, 0.5, 1.0, 1.31, 1.7, 1.99] {
        let folder = tempfile::tempdir().unwrap();
        run(&case, Oscillators::boxed(0.1, Some(fail_at)), &options(folder.path())).unwrap_err();
        // Remains of a crash after the checkpoint: rows and frames that will be written again.
        for table in ["measures.csv", "profile-top.csv"] {
            let table = folder.path().join(table);
            let garbage = std::fs::read_to_string(&table).unwrap() + "1e9,torn ro";
            std::fs::write(&table, garbage).unwrap();
        }
        for torn in [
            "checkpoint.bin.tmp",
            "frames/frame-00099.vtu.tmp",
            "frames/grid-00099.vtr.tmp",
            "profile-old.csv",
        ] {
            std::fs::write(folder.path().join(torn), "torn").unwrap();
        }
        let again = RunOptions { resume: true, ..options(folder.path()) };
        let report = run(&case, Oscillators::boxed(0.1, None), &again).unwrap();
        let table = Table::read(&folder.path().join("measures.csv")).unwrap();
        assert_eq!((report.table.columns, report.table.rows.len()), (table.columns, table.rows.len()));
        assert!(output_files(folder.path()) == output_files(whole.path()), "crash at {fail_at} s");
    }
}

#[test]
fn resuming_a_run_without_a_checkpoint_restarts_it() {
    let mut case = case(r#"[ { "name": "all", "duration": 2.0 } ]"#);
    let whole = tempfile::tempdir().unwrap();
    run(&case, Oscillators::boxed(0.1, None), &options(whole.path())).unwrap();
    case.output.checkpoint = 1e6;
    let folder = tempfile::tempdir().unwrap();
    run(&case, Oscillators::boxed(0.1, Some(1.2)), &options(folder.path())).unwrap_err();
    for stale in ["profile-old.csv", "frames/frame-00099.vtu"] {
        std::fs::write(folder.path().join(stale), "stale").unwrap();
    }
    run(&case, Oscillators::boxed(0.1, None), &RunOptions { resume: true, ..options(folder.path()) })
        .unwrap();
    let results = |folder| output_files(folder).into_iter().filter(|(name, _)| name != "case.json");
    assert!(results(folder.path()).eq(results(whole.path())));
}

#[test]
fn resuming_with_rows_missing_is_refused() {
    let case = case(r#"[ { "name": "all", "duration": 2.0 } ]"#);
    let folder = tempfile::tempdir().unwrap();
    run(&case, Oscillators::boxed(0.1, Some(1.2)), &options(folder.path())).unwrap_err();
    let measures = folder.path().join("measures.csv");
    std::fs::write(&measures, "# nothing left\n").unwrap();
    let before = output_files(folder.path());
    let again = RunOptions { resume: true, ..options(folder.path()) };
    let error = run(&case, Oscillators::boxed(0.1, None), &again).unwrap_err();
    assert!(error.to_string().contains("measures.csv: has 15 bytes"), "{error}");
    assert!(output_files(folder.path()) == before);
}

#[test]
fn resuming_with_frames_missing_is_refused() {
    let mut case = case(r#"[ { "name": "all", "duration": 2.0 } ]"#);
    case.output.grid = Some(0.5);
    for gone in ["frames/frame-00001.vtu", "frames/grid-00000.vtr"] {
        let folder = tempfile::tempdir().unwrap();
        run(&case, Oscillators::boxed(0.1, Some(1.2)), &options(folder.path())).unwrap_err();
        std::fs::remove_file(folder.path().join(gone)).unwrap();
        let before = output_files(folder.path());
        let again = RunOptions { resume: true, ..options(folder.path()) };
        let error = run(&case, Oscillators::boxed(0.1, None), &again).unwrap_err();
        assert!(error.to_string().contains(&format!("needs {gone}, which is missing")), "{error}");
        assert!(output_files(folder.path()) == before);
    }
}

#[test]
fn a_checkpoint_does_not_grow_with_the_rows_before_it() {
    let size = |fail_at| {
        let mut case = case(r#"[ { "name": "all", "duration": 12.0 } ]"#);
        case.output.frames = None;
        let folder = tempfile::tempdir().unwrap();
        run(&case, Oscillators::boxed(0.1, Some(fail_at)), &options(folder.path())).unwrap_err();
        let rows = Table::read(&folder.path().join("measures.csv")).unwrap().rows.len();
        (rows, std::fs::metadata(folder.path().join("checkpoint.bin")).unwrap().len())
    };
    let ((few, small), (many, large)) = (size(1.0), size(11.5));
    assert!(few < 15 && many > 110);
    // Counters take up to a few bytes more.
    assert!(large < small + 16, "{small} bytes after {few} rows, {large} after {many}");
}

#[test]
fn kept_frames_of_a_resumed_run_begin_at_its_start() {
    let case = case(r#"[ { "name": "all", "duration": 2.0 } ]"#);
    let keep = RunOptions { keep_frames: true, ..RunOptions::default() };
    let whole = run(&case, Oscillators::boxed(0.1, None), &keep).unwrap().frames;
    let folder = tempfile::tempdir().unwrap();
    run(&case, Oscillators::boxed(0.1, Some(1.2)), &options(folder.path())).unwrap_err();
    let again = RunOptions { resume: true, keep_frames: true, ..options(folder.path()) };
    let resumed = run(&case, Oscillators::boxed(0.1, None), &again).unwrap().frames;
    assert_eq!(resumed.len(), 5);
    assert_eq!(resumed, whole);
}

#[test]
fn a_checkpoint_of_another_case_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let first = case(r#"[ { "name": "all", "duration": 2.0 } ]"#);
    run(&first, Oscillators::boxed(0.0, Some(1.0)), &options(folder.path())).unwrap_err();
    let other = case(r#"[ { "name": "all", "duration": 3.0 } ]"#);
    let before = output_files(folder.path());
    let again = RunOptions { resume: true, ..options(folder.path()) };
    let error = run(&other, Oscillators::boxed(0.0, None), &again).unwrap_err();
    assert!(error.to_string().contains("another case"), "{error}");
    assert!(output_files(folder.path()) == before, "a refused resume changes nothing");
}

#[test]
fn resuming_with_tables_or_frames_that_were_edited_is_refused() {
    let case = case(r#"[ { "name": "all", "duration": 2.0 } ]"#);
    let edits = [
        ("measures.csv", "was changed since the checkpoint"),
        ("profile-top.csv", "was changed since the checkpoint"),
        ("frames/frame-00001.vtu", "which is changed"),
    ];
    for (name, problem) in edits {
        let folder = tempfile::tempdir().unwrap();
        run(&case, Oscillators::boxed(0.1, Some(1.2)), &options(folder.path())).unwrap_err();
        let path = folder.path().join(name);
        let mut bytes = std::fs::read(&path).unwrap();
        bytes[10] ^= 1;
        std::fs::write(&path, bytes).unwrap();
        let before = output_files(folder.path());
        let again = RunOptions { resume: true, ..options(folder.path()) };
        let error = run(&case, Oscillators::boxed(0.1, None), &again).unwrap_err();
        assert!(error.to_string().contains(problem), "{name}: {error}");
        assert!(output_files(folder.path()) == before);
    }
}

#[test]
fn a_complete_run_verifies_until_one_of_its_files_changes() {
    let mut case = case(r#"[ { "name": "all", "duration": 2.0 } ]"#);
    case.output.grid = Some(0.5);
    let folder = tempfile::tempdir().unwrap();
    run(&case, Oscillators::boxed(0.1, Some(1.2)), &options(folder.path())).unwrap_err();
    let error = verify(folder.path()).unwrap_err().to_string();
    assert!(error.contains("the run is not complete (failed)"), "{error}");
    let again = RunOptions { resume: true, ..options(folder.path()) };
    run(&case, Oscillators::boxed(0.1, None), &again).unwrap();
    let whole = verify(folder.path()).unwrap();
    // All files except the summary itself.
    assert_eq!(whole, VerificationResult { files: output_files(folder.path()).len(), problems: Vec::new() });
    std::fs::write(folder.path().join("frames.pvd"), "").unwrap();
    let table = folder.path().join("measures.csv");
    let edited = std::fs::read_to_string(&table).unwrap().replacen("# SI", "# si", 1);
    std::fs::write(&table, edited).unwrap();
    std::fs::remove_file(folder.path().join("frames/grid-00000.vtr")).unwrap();
    let problems = verify(folder.path()).unwrap().problems;
    let starts = [
        "frames.pvd: has 0 bytes",
        "frames/grid-00000.vtr: ",
        "measures.csv: was changed since the run wrote it",
    ];
    assert_eq!(problems.len(), 3, "{problems:?}");
    assert!(problems.iter().zip(starts).all(|(problem, start)| problem.starts_with(start)), "{problems:?}");
}

#[test]
fn a_resumed_run_writes_a_missing_case_file() {
    for (fail_at, checkpoint) in [(1.2, 1e-6), (1.2, 1e6)] {
        let folder = tempfile::tempdir().unwrap();
        let mut case = case(r#"[ { "name": "all", "duration": 2.0 } ]"#);
        case.output.checkpoint = checkpoint;
        run(&case, Oscillators::boxed(0.0, Some(fail_at)), &options(folder.path())).unwrap_err();
        let written = folder.path().join("case.json");
        let text = std::fs::read(&written).unwrap();
        std::fs::rename(&written, folder.path().join("case.json.tmp")).unwrap();
        let resume = RunOptions { resume: true, ..options(folder.path()) };
        run(&case, Oscillators::boxed(0.0, None), &resume).unwrap();
        assert!(std::fs::read(&written).unwrap() == text);
        assert!(verify(folder.path()).unwrap().problems.is_empty());
        std::fs::remove_file(&written).unwrap();
        assert_eq!(verify(folder.path()).unwrap().problems.len(), 1);
    }
}

#[test]
fn a_run_without_its_case_is_not_verified() {
    let folder = tempfile::tempdir().unwrap();
    let case = case(r#"[ { "name": "all", "duration": 2.0 } ]"#);
    run(&case, Oscillators::boxed(0.0, None), &options(folder.path())).unwrap();
    let path = folder.path().join("summary.json");
    let mut summary: serde_json::Value = crate::output::read_json(&path).unwrap();
    summary["files"].as_object_mut().unwrap().remove("case.json").unwrap();
    std::fs::write(&path, summary.to_string()).unwrap();
    std::fs::remove_file(folder.path().join("case.json")).unwrap();
    let problems = verify(folder.path()).unwrap().problems;
    assert!(problems.len() == 1 && problems[0].starts_with("case.json"), "{problems:?}");
}
