//! Element tests of the elastic laws: small strain, objectivity, finite strain (sheet: constitutive V-01, V-02, V-03, table of §2.13).

use colluvium::constitutive::driver::{ElementPath, LoadingPath};
use colluvium::constitutive::{InitialCondition, Mat3, MaterialSpec, Motion, SymTensor};
use colluvium::plots::{LineChart, Series, Style};
use serde_json::json;

use crate::benchmarks::BenchmarkOutcome;
use crate::benchmarks::element::element_tests::{MACHINE, material, test};

/// Shear modulus of reference set R1 (Pa).
const SHEAR_MODULUS: f64 = 20e6 / 2.6;

/// Checks V-01: oedometer and triaxial tests.
pub fn small_strain(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let elastic = || material("linear-elastic", json!({}));
    let compressed = test(elastic()?, 0.0, LoadingPath::Oedometer { axial_compression: 0.01 }, 10)?;
    let drained = test(elastic()?, 50e3, LoadingPath::TriaxialDrained { axial_compression: 0.01 }, 10)?;
    let path = LoadingPath::TriaxialUndrained { axial_compression: 0.01, fluid_stiffness: None };
    let undrained = test(elastic()?, 50e3, path, 10)?;
    let rows = [
        ("V-01 oedometer: axial stress (Pa)", -269_230.769_230_769, compressed.last("stress_zz")),
        ("V-01 oedometer: lateral stress (Pa)", -115_384.615_384_615, compressed.last("stress_xx")),
        ("V-01 drained triaxial: dq/dε₁ (Pa)", 20e6, drained.last("q") / 0.01),
        ("V-01 undrained triaxial: dq/dε₁ (Pa)", 3.0 * 20e6 / 2.6, undrained.last("q") / 0.01),
    ];
    outcome.assert_all_close(rows, 1e-9, MACHINE);
    Ok(())
}

/// Simple shear to 2 in `steps` steps.
fn shear_test(steps: usize) -> Result<ElementPath, String> {
    let path = LoadingPath::SimpleShearConstantVolume { shear: 2.0 };
    test(material("linear-elastic", json!({}))?, 0.0, path, steps)
}

/// Checks V-03: the Jaumann rate in simple shear.
pub fn jaumann_shear(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let error = |run: &ElementPath| {
        (run.last("stress_xy") / SHEAR_MODULUS - 2f64.sin())
            .hypot(run.last("stress_xx") / SHEAR_MODULUS - 1.0 + 2f64.cos())
    };
    let order = (error(&shear_test(20)?) / error(&shear_test(100)?)).ln() / 5f64.ln();
    let reason = "the sheet requires at least 1.95";
    outcome.assert_within("V-03 Jaumann simple shear: order", "2", order, (1.95, 2.1), reason);
    let table = [
        (5, 0.921_155_58, 1.424_212_99),
        (10, 0.912_263_68, 1.418_169_62),
        (20, 0.910_039_10, 1.416_652_92),
        (100, 0.909_327_09, 1.416_167_09),
    ];
    for (steps, tangential, normal) in table {
        let run = shear_test(steps)?;
        let name = format!("V-03 Jaumann simple shear to 2 in {steps} steps");
        let rows = [
            (format!("{name}: σ_12/G"), tangential, run.last("stress_xy") / SHEAR_MODULUS),
            (format!("{name}: σ_11/G"), normal, run.last("stress_xx") / SHEAR_MODULUS),
            (format!("{name}: -σ_22/G"), normal, -run.last("stress_yy") / SHEAR_MODULUS),
        ];
        outcome.assert_all_close(rows, 1e-8, "the sheet's eight digits");
    }
    let run = shear_test(100)?;
    let of = |name: &str| -> Vec<(f64, f64)> {
        let (x, y) = (run.column("strain_xy").unwrap_or_default(), run.column(name).unwrap_or_default());
        x.into_iter().map(|x| 2.0 * x).zip(y.into_iter().map(|y| y / SHEAR_MODULUS)).collect()
    };
    let exact = |f: fn(f64) -> f64| (0..=50).map(|i| 0.04 * f64::from(i)).map(|g| (g, f(g))).collect();
    let chart = LineChart {
        series: vec![
            Series::new("shear stress", of("stress_xy"), Style::Line),
            Series::new("sin γ", exact(f64::sin), Style::Dashed),
            Series::new("normal stress", of("stress_xx"), Style::Line),
            Series::new("1 - cos γ", exact(|g| 1.0 - g.cos()), Style::Dashed),
        ],
        ..LineChart::new("Hypoelastic simple shear", "shear strain", "stress over G")
    };
    outcome.svg("The Jaumann rate in simple shear: stress follows the sine.", &chart)
}

/// Stress of `spec` after one motion from the given stress.
fn stress_after(spec: &MaterialSpec, stress: SymTensor, motions: &[Motion]) -> Result<SymTensor, String> {
    let law = spec.build().map_err(|error| error.to_string())?;
    let start = InitialCondition { stress, density: spec.density() };
    let (mut stresses, mut states) = law.initial(&[start]).map_err(|error| error.to_string())?;
    for motion in motions {
        law.update(std::slice::from_ref(motion), &mut stresses, &mut states.blocks_mut()[0])
            .map_err(|error| error.to_string())?;
    }
    Ok(stresses[0])
}

/// Checks V-02: the stress turns with a rigid rotation.
pub fn objectivity(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    let spec = material("linear-elastic", json!({}))?;
    let start = SymTensor([-100.0, -50.0, -70.0, 20.0, 0.0, 0.0]);
    let rotation = |angle: f64| {
        Motion::from_deformation(&Mat3::rotation_z(angle), 1.0, 2000.0, 1.0).ok_or("singular rotation")
    };
    let turned = stress_after(&spec, start, &[rotation(30f64.to_radians())?])?;
    outcome.assert_close("V-02 rotation by 30°: σ_xx", -104.820_508_08, 1e-9, turned[0], MACHINE);
    outcome.assert_close("V-02 rotation by 30°: σ_xy", -11.650_635_09, 1e-8, turned[3], MACHINE);
    outcome.assert_close("V-02 rotation by 30°: σ_yy", -45.179_491_92, 1e-9, turned[1], MACHINE);
    // Plane stress of the sheet for full turns.
    let start = SymTensor([-100e3, -50e3, 0.0, 20e3, 0.0, 0.0]);
    let full = stress_after(&spec, start, &[rotation(10f64.to_radians())?; 36])?;
    let turn = "the sheet's 10⁻¹⁰";
    outcome.assert_close("V-02 a full turn in 36 rigid steps: σ_xx (Pa)", -100e3, 1e-10, full[0], turn);
    outcome.assert_close("V-02 a full turn in 36 rigid steps: σ_xy (Pa)", 20e3, 1e-10, full[3], turn);
    let digits = "the sheet's digits";
    for (angle, steps, xx, xy) in [(10f64, 36, -99.352_414, 20.783_646), (1.0, 360, -99.993_619, 20.007_973)]
    {
        let spin = Mat3([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0; 3]]) * angle.to_radians();
        let motion = Motion::from_velocity_gradient(&spin, 1.0, 2000.0, 1.0).ok_or("singular spin")?;
        let driven = stress_after(&spec, start, &vec![motion; steps])?;
        let name = format!("V-02 {steps} steps of spin {angle}°");
        outcome.assert_close(format!("{name}: σ_xx (Pa)"), xx * 1e3, 1e-8, driven[0], digits);
        outcome.assert_close(format!("{name}: σ_xy (Pa)"), xy * 1e3, 5e-8, driven[3], digits);
        let change = (driven.j2() / start.j2() - 1.0).abs();
        outcome.assert_below(format!("{name}: change of J2"), "0", change, 1e-12, "the sheet's 10⁻¹²");
    }
    let change = (full.j2() / start.j2() - 1.0).abs();
    outcome.assert_below("V-02 36 rigid steps: change of J2", "0", change, 1e-12, "the sheet's 10⁻¹²");
    Ok(())
}

/// Checks the elastic laws of finite strain of §2.13.
pub fn finite_strain(outcome: &mut BenchmarkOutcome) -> Result<(), String> {
    // Kirchhoff stress over G, sheet: constitutive §2.13: simple shear γ = 1, and uniaxial stretch 0.8 along y.
    let shear = Mat3([[1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let stretch = Mat3([[1.0, 0.0, 0.0], [0.0, 0.8, 0.0], [0.0, 0.0, 1.0]]);
    let general = Mat3([[1.1, 0.3, 0.0], [0.05, 0.9, -0.1], [0.0, 0.2, 1.05]]);
    let neo = material("neo-hookean", json!({}))?;
    let hencky = material("linear-elastic", json!({ "strain_measure": "hencky" }))?;
    let table: [(&str, &MaterialSpec, &Mat3, usize, f64); 10] = [
        ("neo-Hookean, simple shear: τ₁₂/G", &neo, &shear, 3, 1.0),
        ("neo-Hookean, simple shear: τ₁₁/G", &neo, &shear, 0, 1.0),
        ("neo-Hookean, stretch 0.8: τ₂₂/G", &neo, &stretch, 1, -0.694_715_33),
        ("neo-Hookean, general F: τ₁₁/G", &neo, &general, 0, 0.367_101_5),
        ("neo-Hookean, general F: τ₂₃/G", &neo, &general, 4, 0.075),
        ("Hencky, simple shear: τ₁₂/G", &hencky, &shear, 3, 0.860_817_88),
        ("Hencky, simple shear: τ₁₁/G", &hencky, &shear, 0, 0.430_408_94),
        ("Hencky, stretch 0.8: τ₂₂/G", &hencky, &stretch, 1, -0.781_002_43),
        ("Hencky, general F: τ₁₂/G", &hencky, &general, 3, 0.321_123_16),
        ("Hencky, general F: τ₁₃/G", &hencky, &general, 5, 0.039_726_07),
    ];
    for (name, spec, f, component, exact) in table {
        let motion = Motion::from_deformation(f, 1.0, 2000.0, 1.0).ok_or("singular deformation")?;
        let stress = stress_after(spec, SymTensor::ZERO, &[motion])? * (f.determinant() / (20e6 / 2.6));
        outcome.assert_close(name, exact, 2e-7, stress[component], "the sheet gives eight digits");
    }
    Ok(())
}
