//! Fits.

use std::fs;

use serde_json::Value;

use super::names_in;
use crate::in_folder;

#[test]
fn the_template_of_a_fit_recovers_its_parameters_without_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    assert_eq!(in_folder(folder, &["new", "fit"]).0, 0);
    let (code, plan, errors) = in_folder(folder, &["fit", "--check", "fit.json"]);
    assert!(code == 0 && errors.is_empty() && plan.contains("cd100       23 rows"), "{plan}{errors}");
    assert!(!folder.join("fit").exists(), "a check writes nothing");
    let (code, text, errors) = in_folder(folder, &["fit", "fit.json"]);
    assert_eq!((code, errors.as_str()), (0, ""), "{text}");
    let out = folder.join("fit");
    let table = fs::read_to_string(out.join("fit.csv")).unwrap();
    for (name, exact) in [("youngs_modulus", 42e6), ("friction_angle", 36.5), ("dilatancy_angle", 6.5)] {
        let line = table.lines().find(|line| line.starts_with(name)).unwrap();
        let cells: Vec<&str> = line.split(',').collect();
        let [fitted, deviation] = [3, 4].map(|k| cells[k].parse::<f64>().unwrap());
        // Three standard deviations of the scatter.
        assert!((fitted - exact).abs() < 3.0 * deviation, "{line}");
        assert!(deviation < 0.05 * exact, "{line}");
    }
    let material: Value =
        serde_json::from_str(&fs::read_to_string(out.join("material.json")).unwrap()).unwrap();
    assert_eq!(material["model"], "mohr-coulomb");
    for name in ["cd100-q.png", "cd300-volumetric_strain.png", "cd100.csv", "fit.json"] {
        assert!(names_in(&out).contains(&name.to_owned()), "{name}");
    }
    let before = fs::read(out.join("fit.csv")).unwrap();
    let (code, _, errors) = in_folder(folder, &["fit", "fit.json"]);
    assert!(code == 1 && errors.contains("contains an earlier fit already"), "{errors}");
    let again = ["fit", "fit.json", "--overwrite", "--threads", "1", "--quiet"];
    assert_eq!(in_folder(folder, &again), (0, String::new(), String::new()));
    assert_eq!(fs::read(out.join("fit.csv")).unwrap(), before, "equal bits");
    let (code, _, errors) = in_folder(folder, &["verify", "fit"]);
    assert!(code == 2 && errors.contains("fit: is the folder of a fit"), "{errors}");
    // The folder of the input has files that no fit wrote.
    let (code, _, errors) = in_folder(folder, &["fit", "fit.json", "--out", ".", "--overwrite"]);
    assert!(code == 1 && errors.contains("contains fit.json, which no fit wrote"), "{errors}");
}

#[test]
fn the_schema_of_a_fit_has_its_keys() {
    let folder = tempfile::tempdir().unwrap();
    let (code, text, _) = in_folder(folder.path(), &["schema", "--fit"]);
    let schema: Value = serde_json::from_str(&text).unwrap();
    assert!(code == 0 && schema["properties"]["tests"].is_object());
    assert_eq!(in_folder(folder.path(), &["schema", "--fit", "--sweep"]).0, 2);
}
