//! Output of `check`, and messages that a terminal can show.

use serde_json::json;

use super::cli::{column, write};
use super::{output, program};

#[test]
fn check_prints_densities_and_time_scales() {
    let folder = tempfile::tempdir().unwrap();
    let mut case = column();
    case["materials"]["sand"]["density"] = json!(2000);
    case["bodies"][0]["pore_fluid"] = json!({ "porosity": 0.4, "permeability": 1e-2, "bulk_modulus": 1e7 });
    case["output"] = json!({ "frames": 1e-4 });
    let file = write(folder.path(), "wet.json", &case);
    let (code, text, warned) = output(program().arg("check").arg(&file));
    assert_eq!(code, 0, "{warned}");
    assert!(text.contains("densities      column: dry 2000, saturated 2400, grains 3333 kg/m³"), "{text}");
    assert!(text.contains("consolidation h²/c_v") && text.contains("fall √(h/g) 1.010e-1 s"), "{text}");
    assert!(warned.contains("materials.sand.density: 2000 kg/m³ gives grains of 3333 kg/m³"), "{warned}");
    let steps = text.lines().find_map(|line| line.strip_prefix("steps          about ")).unwrap();
    assert!(steps.parse::<f64>().unwrap() >= 1200.0, "{steps} steps for 1200 frames");
}

#[test]
fn control_characters_in_titles_are_escaped_and_long_names_are_shortened() {
    let folder = tempfile::tempdir().unwrap();
    let mut case = column();
    case["title"] = json!("red \u{1b}[31m title");
    let file = write(folder.path(), "red.json", &case);
    let (code, text, _) = output(program().arg("check").arg(&file));
    assert!(code == 0 && !text.contains('\u{1b}') && text.starts_with("red \\u{1b}[31m title\n"), "{text}");
    let name = "n".repeat(5000);
    case["materials"][&name] = json!({ "model": "mohr-coulomb", "density": -1, "youngs_modulus": 1e6, "poissons_ratio": 0.23, "friction_angle": 31 });
    let file = write(folder.path(), "long.json", &case);
    let (code, _, warned) = output(program().arg("check").arg(&file));
    let longest = warned.lines().map(|line| line.chars().count()).max().unwrap();
    assert!(code == 3 && longest < 600 && warned.contains("density"), "{longest}: {warned}");
}

#[cfg(unix)]
#[test]
fn output_folders_that_cannot_be_created_are_named_with_code_1() {
    let folder = tempfile::tempdir().unwrap();
    let file = write(folder.path(), "case.json", &column());
    let link = folder.path().join("link");
    std::os::unix::fs::symlink(folder.path().join("gone"), &link).unwrap();
    let (code, _, warned) = output(program().arg("run").arg(&file).arg("--quiet").arg("--out").arg(&link));
    assert!(
        code == 1 && warned.contains("is a link to") && warned.contains("does not exist"),
        "{code}: {warned}"
    );
    let out = folder.path().join("out");
    let (code, _, warned) = output(program().arg("run").arg(&file).arg("--quiet").arg("--out").arg(&out));
    assert_eq!(code, 0, "{warned}");
    let (code, _, warned) = output(program().arg("plot").arg(&out).arg("--out").arg(file.join("plots")));
    assert!(code == 1 && warned.contains("is a file"), "{code}: {warned}");
}

#[test]
fn an_element_test_without_a_valid_initial_stress_is_refused_before_its_table() {
    let folder = tempfile::tempdir().unwrap();
    let test = json!({
        "title": "shear",
        "material": { "model": "st-venant-kirchhoff", "density": 2000, "youngs_modulus": 5e-324, "poissons_ratio": 0.3 },
        "stages": [{ "path": { "kind": "simple-shear-constant-volume", "shear": 1 }, "steps": 100 }]
    });
    let file = write(folder.path(), "test.json", &test);
    let (code, text, warned) =
        output(program().arg("element-test").arg(&file).arg("--out").arg(folder.path().join("out")));
    assert!(
        code == 3 && warned.contains("the initial stress is not a number") && !text.contains("NaN"),
        "{code}: {warned}"
    );
}
