//! The element tests of `validation/element` end where their closed forms say.

use std::fs;
use std::path::Path;

/// Young's modulus of reference set R1 is 20 MPa, its Poisson's ratio 0.3.
const SHEAR: f64 = 20e6 / 2.6;

/// What must hold at the end of each file: column, value, relative tolerance.
fn expectations(name: &str) -> Option<Vec<(&'static str, f64, f64)>> {
    // Mohr–Coulomb at φ = 30°, c = 10 kPa under 100 kPa: k = 3, 100 k + 2 c √k.
    let strength = 300e3 + 20e3 * 3f64.sqrt();
    let jacobian = 1.045_75;
    let (sin20, cos20) = 20f64.to_radians().sin_cos();
    let checks = match name {
        // Sheet V-01.
        "linear-elastic-oedometer" => {
            vec![("stress_zz", -269_230.769_230_769, 1e-9), ("stress_xx", -115_384.615_384_615, 1e-9)]
        }
        "linear-elastic-triaxial-undrained" => {
            vec![("q", 0.03 * SHEAR, 1e-9), ("p", 100e3, 1e-9), ("excess_pore_pressure", 0.01 * SHEAR, 1e-9)]
        }
        // Sheet V-03, second order in the step.
        "linear-elastic-simple-shear" => vec![("stress_xy", SHEAR * 1f64.sin(), 1e-5)],
        // Sheet V-02.
        "linear-elastic-rotation" => {
            vec![("stress_xx", -104_820.508_08, 1e-9), ("stress_xy", -11_650.635_09, 1e-8)]
        }
        // Sheet 2.13.
        "hencky-simple-shear" => {
            vec![("stress_xy", 0.860_817_88 * SHEAR, 1e-8), ("stress_xx", 0.430_408_94 * SHEAR, 1e-8)]
        }
        "neo-hookean-simple-shear" => {
            vec![("stress_xy", 0.5 * SHEAR, 1e-9), ("stored_energy", 0.125 * SHEAR, 1e-9)]
        }
        "neo-hookean-deformation-gradient" => vec![
            ("stress_xx", 0.367_101_5 * SHEAR / jacobian, 1e-7),
            ("stress_yy", -0.110_398_5 * SHEAR / jacobian, 1e-7),
            ("stress_xy", 0.325 * SHEAR / jacobian, 1e-9),
        ],
        "drucker-prager-triaxial-drained" => vec![("q", strength - 100e3, 1e-6)],
        "drucker-prager-triaxial-extension" => {
            vec![("stress_zz", (20e3 * 3f64.sqrt() - 100e3) / 3.0, 1e-6), ("lode_angle", 0.0, 1e-6)]
        }
        // Sheet V-06.
        "drucker-prager-biaxial" => vec![("stress_yy", -strength, 1e-6), ("stress_zz", -237_693.0, 1e-6)],
        "drucker-prager-softening" => {
            vec![("q", (200e3 * sin20 + 2e3 * cos20) / (1.0 - sin20), 1e-6)]
        }
        // Sheet V-09.
        "mohr-coulomb-triaxial-drained" => vec![("q", strength - 100e3, 1e-6)],
        "mohr-coulomb-triaxial-undrained" => vec![("q", 140_784.610, 1e-6), ("p", 100e3, 1e-6)],
        "mohr-coulomb-true-triaxial" | "mohr-coulomb-direct-path" => vec![("stress_zz", -strength, 1e-6)],
        "mohr-coulomb-biaxial" => vec![("stress_yy", -strength, 1e-6)],
        // Elastic to (-300, -300, -900) kPa at 0.036, then 9/5 K = 20 MPa.
        "mohr-coulomb-oedometer" => vec![("stress_zz", -1100e3, 1e-6), ("stress_xx", -1100e3 / 3.0, 1e-6)],
        // ψ = 0: Mohr's circle keeps its centre; the spin turns it by τ/2G at most.
        "mohr-coulomb-simple-shear" => vec![("stress_xy", 50e3 + 5e3 * 3f64.sqrt(), 1e-4)],
        // ψ = φ: the plane of no extension is the plane of failure, τ = σ tan φ, up to elastic turning.
        "mohr-coulomb-direct-shear" => {
            vec![("stress_xy", 100e3 / 3f64.sqrt(), 1e-3), ("stress_yy", -100e3, 1e-9)]
        }
        "newtonian-fluid-flow" => vec![("stress_xy", 150.0, 1e-9)],
        // p = K (ρ/ρ₀ - 1) at ρ/ρ₀ = e^0.01.
        "newtonian-fluid-compression" => vec![("p", 2e6 * 0.01f64.exp_m1(), 1e-7), ("q", 0.0, 1e-9)],
        _ => return None,
    };
    Some(checks)
}

#[test]
fn every_element_test_ends_at_its_closed_form() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../validation/element");
    let mut count = 0;
    for entry in fs::read_dir(folder).unwrap() {
        let file = entry.unwrap().path();
        let name = file.file_stem().unwrap().to_string_lossy().into_owned();
        let checks = expectations(&name).unwrap_or_else(|| panic!("{name}: what should it end at?"));
        let test = colluvium::element_test(&fs::read_to_string(&file).unwrap());
        let path = test.unwrap_or_else(|error| panic!("{name}: {error}")).run();
        let path = path.unwrap_or_else(|error| panic!("{name}: {error}"));
        for (column, value, tolerance) in checks {
            let found = path.last(column);
            // Where nothing should be left, 1 is the unit: Pa or rad.
            let scale = if value == 0.0 { 1.0 } else { value.abs() };
            assert!((found - value).abs() <= tolerance * scale, "{name}: {column} is {found}, not {value}");
        }
        count += 1;
    }
    assert!(count >= 20, "{count} files");
}

#[test]
fn every_model_has_element_tests() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../validation/element");
    let texts: Vec<String> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| fs::read_to_string(entry.unwrap().path()).unwrap())
        .collect();
    for model in colluvium::constitutive::MaterialSpec::examples() {
        let name = format!("\"{}\"", model.name());
        assert!(texts.iter().any(|text| text.contains(&name)), "no element test of {name}");
    }
}

#[test]
fn the_tests_in_the_documentation_run() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
    let mut count = 0;
    for page in ["element-tests.md", "cli.md", "theory/constitutive.md"] {
        let text = fs::read_to_string(docs.join(page)).unwrap();
        let blocks = text.split("```json\n").skip(1).filter_map(|rest| rest.split("```").next());
        for block in blocks.filter(|block| block.contains("\"stages\"")) {
            let test = colluvium::element_test(block).unwrap_or_else(|error| panic!("{page}: {error}"));
            test.run().unwrap_or_else(|error| panic!("{page}: {error}"));
            count += 1;
        }
    }
    assert!(count >= 3, "{count} tests");
}
