//! Comparison of one case by several methods.

use std::path::Path;

use colluvium::case::Case;
use colluvium::compare::{
    self, CompareError, CompareOptions, MethodOutcome, MethodResult, ReferenceProfiles,
};

/// Column of the template, for a short duration.
fn column() -> Case {
    let mut case = Case::from_json(colluvium::template("column-collapse").unwrap()).unwrap();
    case.stages[0].duration = 0.002;
    case.output.frames = Some(0.001);
    case.output.measures = Some(0.001);
    case
}

fn coarse() -> Case {
    let mut case = column();
    let options = serde_json::json!({ "cell_size": 0.02, "points_per_cell": 2, "shape": "ugimp" });
    case.methods.insert("mpm".to_owned(), options);
    case.domain.max[1] = 0.16;
    case
}

fn options(folder: &Path) -> CompareOptions {
    CompareOptions {
        output_folder: folder.to_owned(),
        free_memory: f64::INFINITY,
        ..CompareOptions::default()
    }
}

#[test]
fn a_case_with_one_entry_runs_with_two_methods_side_by_side_and_resumes() {
    let folder = tempfile::tempdir().unwrap();
    let case = coarse();
    let methods = compare::methods_by_name(&["mpm".to_owned(), "sph".to_owned(), "dem".to_owned()]).unwrap();
    let results = compare::run(&case, &methods, &options(folder.path()), &|_| {}).unwrap();
    let done = |result: &MethodResult| matches!(result.outcome, MethodOutcome::Completed(_));
    assert!(done(&results[0]) && done(&results[1]), "{results:?}");
    assert!(results[1].chosen_options.starts_with("spacing 0.01 m"), "{}", results[1].chosen_options);
    assert!(
        matches!(&results[2].outcome, MethodOutcome::Refused(why) if why.contains("dem")),
        "{:?}",
        results[2]
    );
    let measured = folder.path().join("measured.csv");
    std::fs::write(&measured, "position,height\n0,0.1\n0.1,0.1\n").unwrap();
    let reference = ReferenceProfiles::read(&measured).unwrap();
    let page = compare::write_page(folder.path(), &case, &results, [0, 1], &reference).unwrap();
    let html = std::fs::read_to_string(page).unwrap();
    for words in [
        "At equal times",
        "Profiles at equal times",
        "front along x",
        "does not support this case",
        "spacing 0.01 m",
        "Energy budget",
        "Profile, difference from the reference",
        "Mass at another place than in mpm",
        "Memory (MiB)",
    ] {
        assert!(html.contains(words), "{words}");
    }
    // Two methods at three times, and no external files.
    assert_eq!(html.matches("src=\"data:image/png;base64,").count(), 6);
    assert_eq!(html.matches("src=\"").count(), 6);
    // Both methods in one player.
    assert_eq!(html.matches("<div class=\"player\">").count(), 1);
    assert!(html.contains("\"name\":\"mpm\"") && html.contains("\"name\":\"sph\""));
    assert!(
        folder.path().join("mpm/summary.json").exists() && folder.path().join("sph/summary.json").exists()
    );
    let refused = compare::run(&case, &methods[..1], &options(folder.path()), &|_| {}).unwrap_err();
    assert!(refused.code() == "folder-has-run" && refused.to_string().contains("--resume"), "{refused}");
    let resumed = CompareOptions { resume: true, ..options(folder.path()) };
    let again = compare::run(&case, &methods[..2], &resumed, &|_| {}).unwrap();
    let hash = |result: &MethodResult| match &result.outcome {
        MethodOutcome::Completed(ran) => (ran.state_hash.clone(), ran.steps),
        other => panic!("{other:?}"),
    };
    assert_eq!(hash(&results[0]), hash(&again[0]));
    assert_eq!(hash(&results[1]), hash(&again[1]));
    let side_by_side =
        CompareOptions { jobs: 2, output_folder: folder.path().join("both"), ..options(folder.path()) };
    let both = compare::run(&case, &methods[..2], &side_by_side, &|_| {}).unwrap();
    assert_eq!(both.iter().map(hash).collect::<Vec<_>>(), [hash(&results[0]), hash(&results[1])]);
}

#[test]
fn a_failed_run_appears_on_the_comparison_page_with_escaped_error_text() {
    let folder = tempfile::tempdir().unwrap();
    let case = coarse();
    let mut results = compare::run(
        &case,
        &compare::methods_by_name(&["mpm".to_owned()]).unwrap(),
        &options(folder.path()),
        &|_| {},
    )
    .unwrap();
    results.push(MethodResult {
        method: "broken",
        chosen_options: String::new(),
        estimated_memory: f64::NAN,
        outcome: MethodOutcome::Failed { code: "unstable", reason: "step 3: <inside out>".to_owned() },
    });
    let page =
        compare::write_page(folder.path(), &case, &results, [0, 1], &ReferenceProfiles::default()).unwrap();
    let html = std::fs::read_to_string(page).unwrap();
    assert!(html.contains("failed: step 3: &lt;inside out&gt;") && html.contains("completed"));
}

#[test]
fn a_case_refused_by_all_methods_gives_no_page_and_unknown_methods_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let case = column();
    let results = [MethodResult {
        method: "dem",
        chosen_options: String::new(),
        estimated_memory: f64::NAN,
        outcome: MethodOutcome::Refused("methods.dem: is missing".to_owned()),
    }];
    let error = compare::write_page(folder.path(), &case, &results, [0, 1], &ReferenceProfiles::default())
        .unwrap_err();
    assert!(matches!(error, CompareError::NoMethod(_)) && error.to_string().contains("is missing"));
    assert!(!folder.path().join(compare::PAGE_FILE).exists());
    let error = compare::methods_by_name(&["lattice".to_owned()]).err().unwrap().to_string();
    assert!(error.contains("\"lattice\"") && error.contains("mpm"), "{error}");
}
