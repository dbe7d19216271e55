use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use serde_json::json;

use super::*;
use crate::constitutive::driver::ElementTest;

/// Drained triaxial tests of a Mohr–Coulomb soil, with data in cd.csv.
fn triaxial() -> Value {
    json!({
        "title": "triaxial",
        "material": {
            "model": "mohr-coulomb", "density": 1700, "youngs_modulus": 2e7, "poissons_ratio": 0.3,
            "friction_angle": 30, "dilatancy_angle": 2
        },
        "parameters": {
            "youngs_modulus": { "range": [5e6, 2e8], "scale": "logarithmic" },
            "friction_angle": { "range": [25, 45] },
            "dilatancy_angle": { "range": [0, 20] }
        },
        "tests": [{
            "name": "cd",
            "stages": [
                { "path": { "kind": "isotropic", "pressure": 1e5 }, "steps": 10 },
                { "path": { "kind": "triaxial-drained", "axial_compression": 0.04 }, "steps": 80 }
            ],
            "data": {
                "file": "cd.csv", "stage": 1, "over": "axial_compression",
                "curves": { "q": {}, "volumetric_strain": { "factor": -1 } }
            }
        }]
    })
}

/// Exact data of the driver for a material at every fourth step after the first stage, with axial and volumetric compression in per cent
/// and q in kPa. The strain of the isotropic stage is subtracted.
fn exact_data(fit: &Value, values: &[(&str, f64)]) -> String {
    let mut test = fit["tests"][0].clone();
    let mut material = fit["material"].clone();
    values.iter().for_each(|(name, value)| material[*name] = json!(value));
    for key in ["data", "name", "material"] {
        test.as_object_mut().unwrap().remove(key);
    }
    test["title"] = json!("exact");
    test["material"] = material;
    let path = serde_json::from_value::<ElementTest>(test).unwrap().run().unwrap();
    let [axial, q, volume] = ["strain_zz", "q", "volumetric_strain"].map(|name| path.column(name).unwrap());
    let mut text = "eps1 (%),q (kPa),volumetric_strain (%),u (kPa)\n".to_owned();
    for row in (10..path.rows.len()).step_by(4) {
        let [axial, volume] = [&axial, &volume].map(|column| -100.0 * (column[row] - column[10]));
        writeln!(text, "{axial:e},{:e},{volume:e},0", 1e-3 * q[row]).unwrap();
    }
    text
}

/// Loads a fit with the data in cd.csv, whose abscissa is called eps1.
fn load(fit: &Value, data: &str) -> Result<FitProblem, CaseErrors> {
    let folder = tempfile::tempdir().unwrap();
    let mut fit = fit.clone();
    let columns = &mut fit["tests"][0]["data"]["columns"];
    if columns.is_null() {
        *columns = json!({ "axial_compression": "eps1" });
    }
    fs::write(folder.path().join("cd.csv"), data).unwrap();
    let path = folder.path().join("fit.json");
    fs::write(&path, fit.to_string()).unwrap();
    Fit::load(&path)
}

const SOIL: [(&str, f64); 3] =
    [("youngs_modulus", 4.2e7), ("friction_angle", 36.5), ("dilatancy_angle", 6.5)];

fn assert_recovered(solution: &FitSolution, expected: &[(&str, f64)]) {
    for (name, exact) in expected {
        let found = solution.parameters.iter().find(|parameter| parameter.name == *name).unwrap();
        // The search ends at a misfit of a millionth, and values are rounded to six digits.
        assert!((found.fitted / exact - 1.0).abs() < 1e-4, "{name}: {found:?}");
        assert!(found.is_determined, "{found:?}");
    }
    assert!(solution.misfit < 1e-3 && !solution.is_exhausted, "{solution:?}");
}

#[test]
fn parameters_of_mohr_coulomb_are_recovered_from_exact_data_in_other_units() {
    let fit = triaxial();
    let problem = load(&fit, &exact_data(&fit, &SOIL)).unwrap();
    assert_eq!(problem.data[0].unused, ["u (kPa)"]);
    assert_eq!((problem.data[0].rows, problem.value_count()), (21, 42));
    let solution = problem.solve();
    assert_recovered(&solution, &SOIL);
    assert!(solution.start_misfit > 1.0);
    assert!(solution.warnings().is_empty(), "{:?}", solution.warnings());
    assert_eq!(problem.fitted_material(&solution)["friction_angle"], json!(36.5));
    assert_eq!(problem.solve(), solution, "equal bits");
    let one_thread = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(one_thread.install(|| problem.solve()), solution, "equal bits on one thread");
}

#[test]
fn slopes_of_modified_cam_clay_are_recovered_from_a_drained_test_after_compression() {
    let mut fit = triaxial();
    fit["material"] = json!({
        "model": "modified-cam-clay", "density": 1800, "critical_state_slope": 0.9, "compression_slope": 0.3,
        "swelling_slope": 0.02, "poissons_ratio": 0.3, "void_ratio": 1.0, "preconsolidation_pressure": 150e3
    });
    fit["parameters"] = json!({
        "critical_state_slope": { "range": [0.6, 1.6] },
        "compression_slope": { "range": [0.05, 1], "scale": "logarithmic" },
        "swelling_slope": { "range": [0.005, 0.045], "scale": "logarithmic" }
    });
    fit["tests"][0]["initial_stress"] = json!([-1e5, -1e5, -1e5, 0, 0, 0]);
    fit["tests"][0]["stages"][0]["path"]["pressure"] = json!(2e5);
    let exact = [("critical_state_slope", 1.2), ("compression_slope", 0.16), ("swelling_slope", 0.035)];
    let solution = load(&fit, &exact_data(&fit, &exact)).unwrap().solve();
    assert_recovered(&solution, &exact);
}

#[test]
fn a_parameter_without_effect_is_reported_and_keeps_its_start() {
    let mut fit = triaxial();
    fit["tests"][0]["data"]["curves"] = json!({ "q": {} });
    let solution = load(&fit, &exact_data(&fit, &SOIL)).unwrap().solve();
    let dilatancy = &solution.parameters[0];
    assert_eq!(
        (dilatancy.name.as_str(), dilatancy.is_determined, dilatancy.fitted),
        ("dilatancy_angle", false, 2.0)
    );
    assert!(
        solution
            .warnings()
            .iter()
            .any(|warning| warning.text.starts_with("dilatancy_angle is not determined"))
    );
    assert_recovered(&solution, &SOIL[..2]);
}

#[test]
fn a_value_at_an_end_of_its_range_and_the_limit_of_evaluations_give_warnings() {
    let mut fit = triaxial();
    fit["parameters"]["friction_angle"]["range"] = json!([25, 34]);
    let data = exact_data(&fit, &SOIL);
    let warnings = load(&fit, &data).unwrap().solve().warnings();
    assert!(
        warnings.iter().any(|warning| warning.text.starts_with("friction_angle = 34 is at the upper end")),
        "{warnings:?}"
    );
    fit["search"] = json!({ "evaluations": 60 });
    let solution = load(&fit, &data).unwrap().solve();
    assert!(solution.is_exhausted && solution.warnings()[0].text.contains("raise search.evaluations"));
    assert!(solution.misfit < solution.start_misfit);
}

#[test]
fn parameters_that_the_law_refuses_count_as_failed_evaluations() {
    let mut fit = triaxial();
    // Dilatancy above the friction angle is refused.
    fit["parameters"]["dilatancy_angle"]["range"] = json!([0, 44]);
    let solution = load(&fit, &exact_data(&fit, &SOIL)).unwrap().solve();
    assert!(solution.failures > 0 && solution.failure_reason.as_ref().unwrap().contains("dilatancy_angle"));
    assert!(solution.notes().iter().any(|note| note.text.contains("evaluations failed")));
    assert_recovered(&solution, &SOIL);
}

#[test]
fn tests_with_materials_of_their_own_are_fitted_together() {
    let mut fit = triaxial();
    fit["parameters"] = json!({ "friction_angle": { "range": [25, 45] } });
    fit["tests"][0]["material"] = json!({ "youngs_modulus": 5e7, "dilatancy_angle": 6.5 });
    let exact = [("youngs_modulus", 5e7), ("friction_angle", 36.5), ("dilatancy_angle", 6.5)];
    let solution = load(&fit, &exact_data(&fit, &exact)).unwrap().solve();
    assert_recovered(&solution, &[("friction_angle", 36.5)]);
}

/// Text of the errors of a changed fit, with exact data changed as text.
fn problem(change: impl FnOnce(&mut Value), data: impl FnOnce(String) -> String) -> String {
    let mut fit = triaxial();
    let exact = exact_data(&fit, &SOIL);
    change(&mut fit);
    load(&fit, &data(exact)).err().unwrap().to_string()
}

#[test]
fn errors_of_a_fit_name_path_and_value() {
    type Change = fn(&mut Value);
    let changes: [(Change, &str); 13] = [
        (
            |fit| fit["parameters"]["friction_angel"] = json!({ "range": [1, 2] }),
            "parameters.friction_angel: \"friction_angel\" is not a number of the material (cohesion, density",
        ),
        (|fit| fit["parameters"]["model"] = json!({ "range": [1, 2] }), "parameters.model: \"mohr-coulomb\""),
        (
            |fit| fit["parameters"]["softening"] = json!({ "range": [1, 2] }),
            "parameters.softening: has no value",
        ),
        (
            |fit| fit["material"]["friction_angle"] = json!(50),
            "material.friction_angle: 50 is outside the range 25 to 45 in parameters.friction_angle",
        ),
        (
            |fit| fit["parameters"]["friction_angle"]["range"] = json!([45, 25]),
            "parameters.friction_angle.range: 45 is not below 25",
        ),
        (
            |fit| {
                fit["parameters"]["dilatancy_angle"] = json!({ "range": [0, 20], "scale": "logarithmic" });
            },
            "parameters.dilatancy_angle.range: 0 is not above 0, which a logarithmic scale requires",
        ),
        (
            |fit| fit["tests"][0]["data"]["curves"] = json!({ "qq": {} }),
            "tests[0].data.curves.qq: \"qq\" is not a column of the element test (time, strain_xx",
        ),
        (
            |fit| fit["tests"][0]["data"]["curves"] = json!({ "p": {} }),
            "tests[0].data.curves.p: \"p\" is not a column of cd.csv (eps1 (%), q (kPa)",
        ),
        (
            |fit| fit["tests"][0]["data"]["stage"] = json!(2),
            "tests[0].data.stage: 2 is not below the number of stages, 2",
        ),
        (
            |fit| fit["tests"][0]["data"]["file"] = json!("ab.csv"),
            "tests[0].data.file: ab.csv: cannot be read",
        ),
        (
            |fit| fit["tests"][0]["material"] = json!({ "friction_angle": 30 }),
            "tests[0].material.friction_angle: is a fitted parameter",
        ),
        (|fit| fit["material"]["poissons_ratio"] = json!(0.7), "material.poissons_ratio: 0.7 "),
        (|fit| fit["tests"][0]["name"] = json!("fit"), "tests[0].name: \"fit\" is the name of another table"),
    ];
    for (change, expected) in changes {
        let found = problem(change, |data| data);
        assert!(found.starts_with(expected), "{found}\nexpected: {expected}");
    }
}

#[test]
fn errors_of_data_name_line_and_value() {
    let none = |_: &mut Value| {};
    let beyond = problem(none, |data| data + "4.5,290,0,0\n");
    let expected = "tests[0].data.file: cd.csv: line 23 has axial_compression = 0.045, but the test is computed from 0 to 0.04";
    assert!(beyond.starts_with(expected), "{beyond}");
    let text = problem(none, |data| data + "x,290,0,0\n");
    assert!(text.starts_with("tests[0].data.file: cd.csv: line 23: \"x\" is not a finite number"), "{text}");
    let unit = problem(none, |data| data.replacen("q (kPa)", "q (mm)", 1));
    assert!(
        unit.starts_with("tests[0].data.curves.q: cd.csv: column \"q (mm)\": the unit must be"),
        "{unit}"
    );
    let angle = problem(none, |data| data.replacen("eps1 (%)", "eps1 (deg)", 1));
    assert!(
        angle.starts_with("tests[0].data.columns.axial_compression: cd.csv: column \"eps1 (deg)\""),
        "{angle}"
    );
    // q is constant after failure, and the stage returns.
    let over = |fit: &mut Value| {
        let reversal = json!({ "path": { "kind": "reversal", "fraction": 0.5 }, "steps": 10 });
        fit["tests"][0]["stages"].as_array_mut().unwrap().push(reversal);
    };
    let turned = problem(over, |data| data);
    assert!(
        turned.starts_with("tests[0].data.over: axial_compression changes from 0.04 to 0.03")
            && turned.contains("such as time"),
        "{turned}"
    );
}

#[test]
fn rows_without_a_value_are_left_out_of_their_curve_only() {
    let fit = triaxial();
    let data = exact_data(&fit, &SOIL) + "3.9,,1.2,\n";
    let problem = load(&fit, &data).unwrap();
    let counts: Vec<usize> = problem.data[0].curves.iter().map(|curve| curve.values.len()).collect();
    assert_eq!((problem.data[0].rows, counts), (22, vec![21, 22]));
    // 5 % of the largest value by default.
    let q = &problem.data[0].curves[0];
    let largest = q.values.iter().fold(0.0, |largest: f64, value| largest.max(value.y));
    assert!((q.tolerance / (0.05 * largest) - 1.0).abs() < 1e-12);
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    names
}

#[test]
fn results_replace_those_of_an_earlier_fit_and_no_other_files() {
    let fit = triaxial();
    let problem = load(&fit, &exact_data(&fit, &SOIL)).unwrap();
    let solution = problem.solve();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let open = |format: &str, overwrite: bool| FitFolder::open(&out, &problem.fit, format, overwrite);
    open("svg", false).unwrap().write(&problem, &solution, "{}").unwrap();
    let files = ["cd-q.svg", "cd-volumetric_strain.svg", "cd.csv", "correlations.csv", "derived.txt"];
    assert_eq!(names(&out), [&files[..], &["fit.csv", "fit.json", "material.json"]].concat());
    assert!(open("svg", false).unwrap_err().to_string().contains("contains an earlier fit already"));
    fs::write(out.join("mine.txt"), "").unwrap();
    open("png", true).unwrap().write(&problem, &solution, "{}").unwrap();
    assert!(names(&out).contains(&"mine.txt".to_owned()) && !names(&out).contains(&"cd-q.svg".to_owned()));
    fs::write(out.join("cd.csv"), "edited").unwrap();
    let refused = open("png", true).unwrap_err().to_string();
    assert!(refused.contains("contains cd.csv, which no fit wrote in this state"), "{refused}");

    let table = fs::read_to_string(out.join("fit.csv")).unwrap();
    assert!(table.contains("\nfriction_angle,degrees,3e1,3.65e1,"), "{table}");
    let material: Value =
        serde_json::from_str(&fs::read_to_string(out.join("material.json")).unwrap()).unwrap();
    assert!(json::from_value::<MaterialSpec>(&material, "").is_ok());
    assert_eq!(material["youngs_modulus"], json!(4.2e7));
}
