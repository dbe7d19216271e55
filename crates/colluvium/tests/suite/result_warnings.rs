//! Warnings about the results of runs, and about cases whose results would mislead.

use colluvium::case::{Case, RunOptions, run_method};
use serde_json::json;

/// Codes of the warnings at the end of a run of the column of the template, in coarse cells, after a change.
fn codes_at_end(change: impl Fn(&mut Case)) -> Vec<String> {
    let mut case = Case::from_json(colluvium::template("column-collapse").unwrap()).unwrap();
    case.methods
        .insert("mpm".to_owned(), json!({ "cell_size": 0.02, "points_per_cell": 2, "shape": "ugimp" }));
    (case.domain.max[1], case.stages[0].duration) = (0.16, 0.1);
    change(&mut case);
    let report = run_method(colluvium::method("mpm").unwrap(), &case, &RunOptions::default()).unwrap();
    report.warnings_at_end.into_iter().map(|warning| warning.code.into_owned()).collect()
}

#[test]
fn a_run_out_of_a_mass_in_motion_is_not_final() {
    let codes = codes_at_end(|_| {});
    assert!(codes.contains(&"run-out-not-final".to_owned()), "{codes:?}");
    assert!(!codes.contains(&"front-at-domain-side".to_owned()), "{codes:?}");
}

#[test]
fn a_front_at_the_side_of_the_domain_is_named() {
    let codes = codes_at_end(|case| {
        *case = Case::from_json(colluvium::template("column-collapse").unwrap()).unwrap();
        (case.domain.max[0], case.stages[0].duration) = (0.15, 0.4);
    });
    assert!(codes.contains(&"front-at-domain-side".to_owned()), "{codes:?}");
}

#[test]
fn a_load_that_begins_after_the_state_of_a_search_is_refused() {
    let mut value: serde_json::Value =
        serde_json::from_str(colluvium::template("factor-of-safety").unwrap()).unwrap();
    let after = value["measures"]["safety"]["after"].clone();
    let body = value["bodies"][0]["name"].clone();
    value["stages"].as_array_mut().unwrap().push(json!({ "name": "later", "duration": 1 }));
    let load = |stage: &serde_json::Value| json!([{ "kind": "pressure", "body": body, "side": "y-max", "value": 1e4, "stage": stage }]);
    value["loads"] = load(&after);
    assert!(Case::from_json(&value.to_string()).is_ok());
    value["loads"] = load(&json!("later"));
    let error = Case::from_json(&value.to_string()).unwrap_err().to_string();
    assert!(error.starts_with("loads[0].stage: begins after the stage"), "{error}");
}
