//! Element tests of `validation/element` against their closed forms.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use rayon::prelude::*;

/// Shear modulus (Pa): Young's modulus of reference set R1 is 20 MPa, its Poisson's ratio 0.3.
const SHEAR: f64 = 20e6 / 2.6;

/// Expected values at the end of a file: column, value, relative tolerance.
type Expectations = Vec<(&'static str, f64, f64)>;

/// Shear strength of Mohr–Coulomb at φ = 30°, c = 10 kPa under 100 kPa (Pa): k = 3, 100 k + 2 c √k.
fn strength() -> f64 {
    300e3 + 20e3 * 3f64.sqrt()
}

/// Expected values at the end of each file.
fn expectations(name: &str) -> Option<Expectations> {
    elastic(name)
        .or_else(|| drucker_prager_and_von_mises(name))
        .or_else(|| mohr_coulomb(name))
        .or_else(|| clay_and_snow(name))
        .or_else(|| sand(name))
        .or_else(|| wrapped(name))
        .or_else(|| fluid(name))
}

fn elastic(name: &str) -> Option<Expectations> {
    let jacobian = 1.045_75;
    let checks = match name {
        // sheet: constitutive V-01.
        "linear-elastic-oedometer" => {
            vec![("stress_zz", -269_230.769_230_769, 1e-9), ("stress_xx", -115_384.615_384_615, 1e-9)]
        }
        "linear-elastic-triaxial-undrained" => {
            vec![("q", 0.03 * SHEAR, 1e-9), ("p", 100e3, 1e-9), ("excess_pore_pressure", 0.01 * SHEAR, 1e-9)]
        }
        // sheet: constitutive V-03, second order in the step.
        "linear-elastic-simple-shear" => vec![("stress_xy", SHEAR * 1f64.sin(), 1e-5)],
        // sheet: constitutive V-02.
        "linear-elastic-rotation" => {
            vec![("stress_xx", -104_820.508_08, 1e-9), ("stress_xy", -11_650.635_09, 1e-8)]
        }
        // sheet: constitutive §2.13.
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
        // sheet: constitutive §2.13.
        "st-venant-kirchhoff-simple-shear" => {
            vec![("stress_xy", 2.75 * SHEAR, 1e-9), ("stress_xx", 4.5 * SHEAR, 1e-9)]
        }
        "fixed-corotated-simple-shear" => {
            vec![("stress_xy", 1.105_572_81 * SHEAR, 1e-8), ("stress_xx", 1.316_718_43 * SHEAR, 1e-8)]
        }
        // e + κ ln p is constant.
        "pressure-dependent-elastic-isotropic" => {
            vec![("void_ratio", 0.9 - 0.1 * 4f64.ln(), 1e-9), ("p", 400e3, 1e-9)]
        }
        _ => return None,
    };
    Some(checks)
}

fn drucker_prager_and_von_mises(name: &str) -> Option<Expectations> {
    let (sin20, cos20) = 20f64.to_radians().sin_cos();
    let checks = match name {
        "drucker-prager-triaxial-drained" => vec![("q", strength() - 100e3, 1e-6)],
        "drucker-prager-triaxial-extension" => {
            vec![("stress_zz", (20e3 * 3f64.sqrt() - 100e3) / 3.0, 1e-6), ("lode_angle", 0.0, 1e-6)]
        }
        // sheet: constitutive V-06.
        "drucker-prager-biaxial" => vec![("stress_yy", -strength(), 1e-6), ("stress_zz", -237_693.0, 1e-6)],
        "drucker-prager-softening" => {
            vec![("q", (200e3 * sin20 + 2e3 * cos20) / (1.0 - sin20), 1e-6)]
        }
        // q = 2 s_u.
        "tresca-triaxial-drained" => vec![("q", 40e3, 1e-9)],
        // sheet: constitutive §2.4: k = c in plane strain.
        "von-mises-simple-shear" => vec![("q", 20e3 * 3f64.sqrt(), 1e-9)],
        // sheet: constitutive §2.8: √J2 = c + p tan φ.
        "cfd-soil-simple-shear" => {
            vec![("q", (10e3 + 100e3 / 3f64.sqrt()) * 3f64.sqrt(), 1e-9), ("p", 100e3, 1e-9)]
        }
        _ => return None,
    };
    Some(checks)
}

fn mohr_coulomb(name: &str) -> Option<Expectations> {
    let checks = match name {
        // sheet: constitutive V-09.
        "mohr-coulomb-triaxial-drained" => vec![("q", strength() - 100e3, 1e-6)],
        "mohr-coulomb-triaxial-undrained" => vec![("q", 140_784.610, 1e-6), ("p", 100e3, 1e-6)],
        "mohr-coulomb-true-triaxial" | "mohr-coulomb-direct-path" => vec![("stress_zz", -strength(), 1e-6)],
        "mohr-coulomb-biaxial" => vec![("stress_yy", -strength(), 1e-6)],
        // Elastic to (-300, -300, -900) kPa at 0.036, then 9/5 K = 20 MPa.
        "mohr-coulomb-oedometer" => vec![("stress_zz", -1100e3, 1e-6), ("stress_xx", -1100e3 / 3.0, 1e-6)],
        // ψ = 0: Mohr's circle keeps its centre; the spin turns it by τ/2G at most.
        "mohr-coulomb-simple-shear" => vec![("stress_xy", 50e3 + 5e3 * 3f64.sqrt(), 1e-4)],
        // ψ = φ: the plane of no extension is the plane of failure, τ = σ tan φ, up to elastic turning.
        "mohr-coulomb-direct-shear" => {
            vec![("stress_xy", 100e3 / 3f64.sqrt(), 1e-3), ("stress_yy", -100e3, 1e-9)]
        }
        _ => return None,
    };
    Some(checks)
}

fn clay_and_snow(name: &str) -> Option<Expectations> {
    let checks = match name {
        // sheet: constitutive V-11, V-12.
        "modified-cam-clay-triaxial-undrained" => {
            vec![("p", 59_460.355_75, 1e-5), ("q", 59_460.355_75, 1e-5)]
        }
        "original-cam-clay-triaxial-undrained" => {
            let end = 100e3 * (-0.75f64).exp();
            vec![("p", end, 1e-5), ("q", end, 1e-5)]
        }
        // sheet: constitutive V-15: the elastic stretch stays at the bound, its stress is scaled by e^{ξ(1 - J_P)}.
        "snow-uniaxial-extension" => {
            let (stretch, plastic) = (1.0075f64, 1.05 / 1.0075f64);
            let (mu, lame) = (1.4e5 / 2.4, 1.4e5 * 0.2 / (1.2 * 0.6));
            let tau = (2.0 * mu + lame) * stretch * (stretch - 1.0) * (10.0 * (1.0 - plastic)).exp();
            vec![("plastic_volume", plastic, 1e-9), ("stress_xx", tau / 1.05, 1e-9)]
        }
        // sheet: constitutive V-14, Kirchhoff pressure.
        "cohesive-cam-clay-weak-layer" => vec![("p", 4166.684 * 0.0198f64.exp(), 1e-3)],
        _ => return None,
    };
    Some(checks)
}

/// Expected values of models of sand, and of cells of grains.
fn sand(name: &str) -> Option<Expectations> {
    let checks = match name {
        // Prescribed values; each of 20 steps may miss 0.2 % of the stress. Grains have no closed form.
        "granular-cell-biaxial" => vec![("stress_xx", -100e3, 0.04), ("strain_yy", -0.02, 1e-6)],
        "granular-cell-triaxial" => vec![("stress_xx", -100e3, 0.02), ("strain_zz", -0.02, 1e-6)],
        // Elastic: q/p stays below the cone's 6 sin φ/(3 - sin φ). Hencky: τ = 2G ε + λ tr ε, σ = τ/J.
        "sand-uniaxial-compression" => {
            let (lame, confined) = (20e6 * 0.3 / (1.3 * 0.4), 20e6 * 0.7 / (1.3 * 0.4));
            let strain = 0.99f64.ln() / 0.99;
            vec![("stress_xx", confined * strain, 1e-9), ("stress_yy", lame * strain, 1e-9)]
        }
        // sheet: constitutive V-16: the stress ratio is 3.
        "hypoplastic-triaxial-drained" => vec![("q", 200e3, 5e-4)],
        // sheet: constitutive V-18, γ = 0.5.
        "simsand-shear-constant-volume" => vec![("stress_xy", 255_471.0, 1e-2), ("p", 352_076.0, 1e-2)],
        _ => return None,
    };
    Some(checks)
}

/// Expected values of models that act on other materials.
fn wrapped(name: &str) -> Option<Expectations> {
    let checks = match name {
        // No lateral strain, plastic strain along x alone.
        "tension-cut-uniaxial-strain" => {
            vec![("stress_xx", 5e3, 1e-9), ("stress_yy", 5e3 * 0.3 / 0.7, 1e-9)]
        }
        // sheet: constitutive §5.3: K_u = K + K_f/n.
        "undrained-isotropic" => {
            vec![("p", 5.391_666_666_667e9 * 3e-5, 1e-9), ("pore_pressure", 2.15e9 / 0.4 * 3e-5, 1e-9)]
        }
        // sheet: constitutive V-09: constant volume, so no pore pressure arises.
        "undrained-triaxial" => vec![("q", 140_784.610, 1e-6), ("p", 100e3, 1e-6)],
        "eigenstrain-relaxation" => vec![("stress_xx", 0.03 * 20e6 / 1.2, 1e-9)],
        // sheet: constitutive V-27: tan φ/F, c/F.
        "strength-reduced-triaxial-drained" => {
            let (sin, cos) = (30f64.to_radians().tan() / 1.4).atan().sin_cos();
            vec![("q", (200e3 * sin + 20e3 / 1.4 * cos) / (1.0 - sin), 1e-6)]
        }
        // Without water the strength is that of the material; the law with water is tested in the wrappers suite of the laws.
        "saturation-softened-triaxial-drained" => vec![("q", strength() - 100e3, 1e-6)],
        // sheet: constitutive V-23, H = 10 mm: u = Hσ/E - δ ln(σ/f_t) is 23.604906 µm at half of the strength.
        "double-scale-tension" => vec![("stress_zz", 1.5e6, 1e-6)],
        _ => return None,
    };
    Some(checks)
}

fn fluid(name: &str) -> Option<Expectations> {
    let checks = match name {
        "newtonian-fluid-flow" => vec![("stress_xy", 150.0, 1e-9)],
        // p = K (ρ/ρ₀ - 1) at ρ/ρ₀ = e^0.01.
        "newtonian-fluid-compression" => vec![("p", 2e6 * 0.01f64.exp_m1(), 1e-7), ("q", 0.0, 1e-9)],
        // τ = τ_y + μ γ̇, up to the square of the elastic strain.
        "bingham-flow" => vec![("q", 250.0 * 3f64.sqrt(), 1e-6)],
        "frictional-fluid-flow" => vec![("q", 560.0 * 3f64.sqrt(), 1e-6), ("p", 1e3, 1e-9)],
        // sheet: constitutive §2.9.
        "mu-i-flow" => vec![("q", 387.507_631_8 * 3f64.sqrt(), 1e-6)],
        _ => return None,
    };
    Some(checks)
}

#[test]
fn every_element_test_ends_at_its_closed_form() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../validation/element");
    let files: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert!(files.len() >= 40, "{} files", files.len());
    files.par_iter().for_each(|file| {
        let name = file.file_stem().unwrap().to_string_lossy().into_owned();
        let checks = expectations(&name).unwrap_or_else(|| panic!("{name}: what should it end at?"));
        let test = colluvium::element_test(&fs::read_to_string(file).unwrap());
        let path = test.unwrap_or_else(|error| panic!("{name}: {error}")).run();
        let path = path.unwrap_or_else(|error| panic!("{name}: {error}"));
        for (column, value, tolerance) in checks {
            let found = path.last(column);
            // Where zero is expected, the scale is 1 Pa or 1 rad.
            let scale = if value == 0.0 { 1.0 } else { value.abs() };
            assert!((found - value).abs() <= tolerance * scale, "{name}: {column} is {found}, not {value}");
        }
    });
}

/// Models that no file here can run: the law of a `umat` is in a library outside this repository (the routine for the tests of the law is
/// in `crates/umat`).
const NEEDS_A_LIBRARY: [&str; 1] = ["umat"];

#[test]
fn every_model_has_element_tests() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../validation/element");
    let mut tested = BTreeSet::new();
    for entry in fs::read_dir(folder).unwrap() {
        let text = fs::read_to_string(entry.unwrap().path()).unwrap();
        let file: serde_json::Value = serde_json::from_str(&text).unwrap();
        tested.insert(file["material"]["model"].as_str().unwrap().to_owned());
    }
    for (name, _) in colluvium::constitutive::MaterialSpec::MODELS {
        let possible = !NEEDS_A_LIBRARY.contains(name);
        assert_eq!(tested.contains(*name), possible, "element tests of {name}");
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
