//! Checks of case files, and refusals.

use std::fs;

use serde_json::{Value, json};

use super::{column, searched, set, write};
use crate::{output, program};

/// Values that break the column: the pointer at which they are set, the path of the error, and the value.
fn breakages() -> Vec<(&'static str, &'static str, Value)> {
    vec![
        ("/title", "title", json!(1)),
        ("/space", "space", json!("4d")),
        ("/domain/min", "domain.max[0]", json!([1, 0])),
        ("/gravity", "gravity", json!([0])),
        ("/materials/sand/friction_angle", "materials.sand.friction_angle", json!(95)),
        ("/materials/sand/friction", "materials.sand.friction", json!(30)),
        ("/materials/sand/poissons_ratio", "materials.sand.poissons_ratio", json!(0.7)),
        ("/materials/sand/model", "materials.sand.model", json!("gravel")),
        ("/bodies/0/material", "bodies[0].material", json!("clay")),
        ("/bodies/0/shape/max", "bodies[0].shape", json!([0.1, 9])),
        ("/bodies/0/shape/kind", "bodies[0].shape.kind", json!("bx")),
        ("/boundaries/0/side", "boundaries[0].side", json!("left")),
        ("/boundaries/2/wall/friction_coefficient", "boundaries[2].wall.friction_coefficient", json!(-1)),
        ("/stages/0/duration", "stages[0].duration", json!(-1)),
        ("/stages/0/damping", "stages[0].damping", json!(3)),
        ("/stages/1/reset", "stages[1].reset[0]", json!(["all"])),
        ("/output/frames", "output.frames", json!(0)),
        ("/measures/front/side", "measures.front.side", json!("ahead")),
        ("/methods/mpm/cell_size", "methods.mpm.cell_size", json!(0.03)),
        ("/methods/mpm/shape", "methods.mpm.shape", json!("hexagonal")),
        ("/methods/mpm/time_step", "methods.mpm.time_step", json!(1.0)),
        ("/methods/unheard_of", "methods.unheard_of", json!({})),
        ("/methods/mpm/flip", "methods.mpm.flip", json!(2)),
        ("/output/fields", "output.fields[1]", json!(["stress", "strss"])),
        (
            "/measures/front",
            "measures.front.fields[0]",
            json!({ "kind": "probe", "position": [0, 0], "radius": 0.1, "fields": ["heat"] }),
        ),
        ("/measures/mass", "measures.mass", json!({ "kind": "front", "side": "x-max" })),
        (
            "/loads",
            "loads[0].body",
            json!([{ "kind": "traction", "body": "x", "side": "x-max", "value": [1, 0] }]),
        ),
    ]
}

#[test]
fn invalid_cases_end_with_code_3_and_one_error_line() {
    let folder = tempfile::tempdir().unwrap();
    for (number, (pointer, path, value)) in breakages().into_iter().enumerate() {
        let mut case = column();
        set(&mut case, pointer, value);
        let file = write(folder.path(), &format!("broken-{number}.json"), &case);
        let out = folder.path().join(format!("out-{number}"));
        for command in ["check", "run", "run --quiet"] {
            let mut run = program();
            run.args(command.split(' ')).arg(&file);
            if command != "check" {
                run.arg("--out").arg(&out);
            }
            let (code, _, errors) = output(&mut run);
            assert_eq!(code, 3, "{command} {pointer}: {errors}");
            // A run warns before its method looks at the case.
            let first = errors.lines().find(|line| !line.starts_with("warning[")).unwrap_or_default();
            assert!(
                first.starts_with("error[") && first.contains(&format!("]: {path}: ")),
                "{command} {pointer}: {first}"
            );
            assert!(!errors.contains("panicked"), "{errors}");
        }
        assert!(!out.exists(), "{pointer}: a broken case leaves nothing");
    }
}

#[test]
fn check_requires_a_method_among_several_and_prints_grid_nodes_for_mpm_only() {
    let folder = tempfile::tempdir().unwrap();
    let mut case = column();
    case["methods"]["sph"] = json!({ "spacing": 0.01 });
    let file = write(folder.path(), "both.json", &case);
    let (code, _, errors) = output(program().arg("check").arg(&file));
    assert!(code == 2 && errors.contains("several methods, mpm, sph: choose one with --method"), "{errors}");
    let text = |method: &str| output(program().args(["check", "--method", method]).arg(&file)).1;
    assert!(text("mpm").contains("grid nodes") && !text("sph").contains("grid nodes"));
}

#[test]
fn a_check_warns_on_standard_error() {
    let folder = tempfile::tempdir().unwrap();
    let file = write(folder.path(), "column.json", &column());
    let (code, text, errors) = output(program().arg("check").arg(&file));
    assert!(code == 0 && text.contains("points") && !text.contains("warning"), "{text}");
    assert!(errors.starts_with("warning[option-slows-motion]: stages[0].damping: "), "{errors}");
}

#[test]
fn a_problem_that_does_not_fit_in_memory_is_refused_before_it_is_made() {
    let folder = tempfile::tempdir().unwrap();
    let mut mpm = column();
    mpm["methods"]["mpm"]["cell_size"] = json!(1e-7);
    let mut sph = column();
    sph["methods"] = json!({ "sph": { "spacing": 1e-7 } });
    let mut coarse = column();
    coarse["methods"]["mpm"]["cell_size"] = json!(0.01);
    for (name, case, key, points) in [
        ("mpm", mpm, "methods.mpm.cell_size", "4.0e12 points and 4.8e12 grid nodes"),
        ("sph", sph, "methods.sph.spacing", "1.0e12 points"),
    ] {
        let file = write(folder.path(), &format!("{name}.json"), &case);
        let out = folder.path().join(name);
        for command in [vec!["check"], vec!["run", "--out", out.to_str().unwrap()]] {
            let (code, _, errors) = output(program().args(&command).arg(&file));
            assert_eq!(code, 3, "{command:?}: {errors}");
            let start =
                format!("error[not-enough-memory]: {key}: gives about {points}, which need at least ");
            assert!(errors.starts_with(&start) && errors.contains(" GB of memory; "), "{errors}");
        }
        assert!(!out.exists());
    }
    let sweep = json!({ "title": "finer", "case": "coarse.json",
        "parameters": { "cell": { "at": ["methods.mpm.cell_size"], "values": [0.01, 1e-7] } } });
    write(folder.path(), "coarse.json", &coarse);
    let (code, _, errors) =
        output(program().args(["sweep", "--check"]).arg(write(folder.path(), "sweep.json", &sweep)));
    assert!(
        code == 3 && errors.contains("methods.mpm.cell_size: gives about 4.0e12 points"),
        "{code} {errors}"
    );
}

#[test]
fn files_that_are_no_cases_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("none.json");
    let (code, _, errors) = output(program().arg("check").arg(&missing));
    assert!(code == 3 && errors.contains("cannot be read"), "{errors}");
    let torn = folder.path().join("torn.json");
    fs::write(&torn, "{ \"title\": \"x\", ").unwrap();
    let (code, _, errors) = output(program().arg("run").arg(&torn));
    let place = format!("error[syntax]: {}: line 1, column 16: ", torn.display());
    assert!(code == 3 && errors.starts_with(&place), "{errors}");
    let (code, ..) = output(program().arg("frobnicate"));
    assert_eq!(code, 2);
}

/// Eight halvings of 19.5 come below 0.1; undecided trials leave both halves to search. A time window is a twelfth of the duration.
#[test]
fn check_prints_the_cost_of_a_safety_factor_search() {
    let folder = tempfile::tempdir().unwrap();
    let file = write(folder.path(), "slope.json", &searched());
    let (code, text, _) = output(program().arg("check").arg(&file));
    let line = text.lines().find(|line| line.starts_with("search")).unwrap_or_else(|| panic!("{text}"));
    let expected = "search         safety: 10 trials, 17 at most, of 12 time windows at most, about 0.008 s each: about ";
    assert!(code == 0 && line.starts_with(expected), "{line}");
}

#[test]
fn the_schema_is_json_and_includes_options_of_methods() {
    let (code, text, _) = output(program().arg("schema"));
    let schema: Value = serde_json::from_str(&text).unwrap();
    assert!(
        code == 0
            && schema["properties"]["methods"]["properties"]["mpm"]["properties"]["cell_size"].is_object()
    );
    let (code, text, _) = output(program().args(["schema", "--markdown"]));
    assert!(
        code == 0 && text.starts_with("# Space, domain and gravity") && text.contains("`friction_angle`")
    );
}
