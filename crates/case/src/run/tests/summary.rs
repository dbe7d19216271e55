//! Tests of the summaries of runs.

use super::*;

#[test]
fn a_summary_contains_end_times_of_stages_and_limits_of_time_steps() {
    let case = case(
        r#"[ { "name": "settle", "duration": 100, "equilibrium": {} }, { "name": "go", "duration": 1 }, { "name": "on", "duration": 1 } ]"#,
    );
    let folder = tempfile::tempdir().unwrap();
    let warnings = vec![Warning::new("slow-law", "mind the step")];
    let report =
        run(&case, Oscillators::boxed(2.0, None), &RunOptions { warnings, ..options(folder.path()) })
            .unwrap();
    let text = std::fs::read_to_string(folder.path().join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
    let stages = summary["stages"].as_array().unwrap();
    let ended: Vec<&str> = stages.iter().map(|stage| stage["ended"].as_str().unwrap()).collect();
    assert_eq!(ended, ["at rest", "duration over", "duration over"]);
    let settled = stages[0]["end"].as_f64().unwrap();
    assert!(settled > 0.0 && settled < 100.0);
    assert!((stages[2]["end"].as_f64().unwrap() - settled - 2.0).abs() < 1e-9, "{text}");
    assert_eq!(stages[1]["start"], stages[0]["end"]);
    let limits = &summary["time_step_limits"];
    assert_eq!(limits.as_array().map(Vec::len), Some(1));
    assert_eq!(limits[0]["limit"], "fixed by the case");
    assert_eq!(limits[0]["steps"].as_u64(), Some(report.steps));
    assert_eq!(limits[0]["least"], 0.0137);
    assert_eq!(summary["warnings"][0], serde_json::json!({ "code": "slow-law", "text": "mind the step" }));
}

#[test]
fn the_summary_of_a_killed_run_states_its_progress() {
    let case = case(r#"[ { "name": "a", "duration": 0.6 }, { "name": "b", "duration": 1 } ]"#);
    // With checkpoints, and with nothing but frames.
    for (checkpoint, smallest) in [(1e-9, Oscillators::NAP), (1e6, 1.0)] {
        let mut case = case.clone();
        case.output.checkpoint = checkpoint;
        let folder = tempfile::tempdir().unwrap();
        let warnings = vec![Warning::new("slow-law", "mind the step")];
        let killed = std::panic::catch_unwind(|| {
            let solver = Oscillators { exits_on_failure: true, ..Oscillators::new(0.0, Some(1.2)) };
            run(&case, Box::new(solver), &RunOptions { warnings, ..options(folder.path()) })
        });
        assert!(killed.is_err());
        let text = std::fs::read_to_string(folder.path().join("summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(summary["status"], "running");
        assert_eq!(
            summary["warnings"][0],
            serde_json::json!({ "code": "slow-law", "text": "mind the step" })
        );
        let time = summary["time"].as_f64().unwrap();
        assert!((smallest - 1e-9..1.22).contains(&time), "{time} s");
        assert_eq!(summary["stages"][0]["ended"], "duration over");
        assert_eq!(
            (&summary["stages"][1]["name"], summary["stages"][1]["end"].is_null()),
            (&"b".into(), true)
        );
        assert_eq!(summary["time_step_limits"][0]["steps"], summary["steps"]);
        assert!(summary["measures"]["time"].as_f64().unwrap() > 0.85);
        assert_eq!(summary["case"]["title"], "oscillators");
    }
}

#[test]
fn a_failed_run_keeps_its_last_good_frame_and_the_error_names_it() {
    let folder = tempfile::tempdir().unwrap();
    let case = case(r#"[ { "name": "all", "duration": 2.0 } ]"#);
    let error = run(&case, Oscillators::boxed(0.0, Some(1.2)), &options(folder.path())).unwrap_err();
    assert!(error.to_string().contains("point 3"), "{error}");
    assert!(error.to_string().ends_with("; the last output is frames/frame-00002.vtu, t = 1 s"), "{error}");
    let summary: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(folder.path().join("summary.json")).unwrap()).unwrap();
    assert_eq!(summary["status"], "failed");
    assert!(summary["reason"].as_str().unwrap().contains("it was told to"));
    assert!(folder.path().join("frames/frame-00002.vtu").exists(), "the frame at 1 s");
    assert!(!folder.path().join("frames/frame-00003.vtu").exists());
}

#[test]
fn a_stage_without_required_equilibrium_ends_with_a_warning_at_its_duration() {
    let case = case(
        r#"[ { "name": "settle", "duration": 2, "equilibrium": { "required": false } }, { "name": "go", "duration": 1 } ]"#,
    );
    let folder = tempfile::tempdir().unwrap();
    let report = run(&case, Oscillators::boxed(0.0, None), &options(folder.path())).unwrap();
    assert!((report.snapshot.time - 3.0).abs() < 1e-9);
    assert!(
        report.warnings_at_end[0].text.starts_with("stages[0]: no equilibrium within its duration of 2 s"),
        "{:?}",
        report.warnings_at_end
    );
    let text = std::fs::read_to_string(folder.path().join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(
        (&summary["status"], &summary["stages"][0]["ended"]),
        (&"completed".into(), &"duration over".into())
    );
    // A stage that reaches equilibrium reports nothing, and ends then.
    let case =
        self::case(r#"[ { "name": "settle", "duration": 100, "equilibrium": { "required": false } } ]"#);
    let report = run(&case, Oscillators::boxed(2.0, None), &RunOptions::default()).unwrap();
    assert!(
        report.warnings_at_end.is_empty() && report.snapshot.time < 100.0,
        "{:?}",
        report.warnings_at_end
    );
}
