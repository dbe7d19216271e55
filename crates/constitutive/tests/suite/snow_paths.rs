//! Paths of single points of snow against closed forms and rates integrated independently (sheet: snow-mpm V5 to V8), and returns of
//! sand and ice (sheet: snow-mpm §2.10, V20).

use crate::cohesive_cam_clay::{slab, weak_layer};
use colluvium_constitutive::laws::cohesive_cam_clay::YieldEllipse;
use colluvium_constitutive::laws::{
    CamClayHardening, CamClayIntegration, CohesiveCamClaySpec, DruckerPragerSpec, Elasticity, Matching,
    Softening, StrainMeasure,
};
use colluvium_constitutive::{InitialCondition, Mat3, Model, Motion, SymTensor};

/// Material of W1.
fn snow(integration: CamClayIntegration) -> CohesiveCamClaySpec {
    CohesiveCamClaySpec {
        youngs_modulus: 3e6,
        critical_state_slope: 1.2,
        cohesion_ratio: 0.3,
        compressive_strength: 20e3,
        hardening_factor: 1.0,
        integration,
        ..slab()
    }
}

/// Material of V8.
fn anticrack() -> CohesiveCamClaySpec {
    CohesiveCamClaySpec {
        critical_state_slope: 1.2,
        cohesion_ratio: 0.3,
        compressive_strength: 3e3,
        hardening_factor: 0.02,
        hardening: CamClayHardening::WeakLayer { softening_factor: 50.0 },
        integration: CamClayIntegration::Explicit,
        ..weak_layer()
    }
}

/// Kirchhoff stresses (Pa) after each of `steps` equal steps.
pub fn walk(spec: &impl Model, step: &Mat3, steps: usize) -> Vec<SymTensor> {
    let law = spec.build().unwrap();
    let start = InitialCondition { stress: SymTensor::ZERO, density: 250.0 };
    let (mut stresses, mut states) = law.initial(&[start]).unwrap();
    let motion = Motion::from_deformation(step, 1.0, 250.0, 1.0).unwrap();
    let volume = step.determinant();
    let mut jacobian = 1.0;
    let walked = (0..steps).map(|_| {
        law.update(&[motion], &mut stresses, &mut states.blocks_mut()[0]).unwrap();
        jacobian *= volume;
        stresses[0] * jacobian
    });
    walked.collect()
}

pub fn diagonal(x: f64, y: f64, z: f64) -> Mat3 {
    Mat3([[x.exp(), 0.0, 0.0], [0.0, y.exp(), 0.0], [0.0, 0.0, z.exp()]])
}

pub fn within(found: f64, exact: f64, tolerance: f64, what: &str) {
    assert!((found / exact - 1.0).abs() <= tolerance, "{what}: {found} for {exact}");
}

#[test]
fn isotropic_compression_follows_its_closed_form() {
    // Pressure (Pa) and compression, V5.
    let table = [(25e3, 0.011_999_918_7), (50e3, 0.031_998_752_2), (200e3, 0.151_914_996_8)];
    for (pressure, strain) in table {
        for steps in [1usize, 7] {
            let part = -strain / 3.0 / steps as f64;
            let path = walk(&snow(CamClayIntegration::Implicit), &diagonal(part, part, part), steps);
            // The strain has ten digits.
            within(path[steps - 1].pressure(), pressure, 1e-8, "implicit");
        }
        let steps = (strain / 1e-5).ceil();
        let part = -strain / 3.0 / steps;
        let path = walk(&snow(CamClayIntegration::Explicit), &diagonal(part, part, part), steps as usize);
        within(path[steps as usize - 1].pressure(), pressure, 1e-3, "explicit, steps of 1e-5");
    }
}

#[test]
fn oedometric_compression_follows_the_rates() {
    // Strain, p, q, axial and lateral stress (Pa), V6 with d = 3.
    let table = [
        (0.01, [19_685.805, 11_755.607, 27_522.876, 15_767.269]),
        (0.05, [66_065.015, 32_258.440, 87_570.641, 55_312.201]),
        (0.1, [123_080.935, 59_995.577, 163_077.986, 103_082.409]),
    ];
    let step = 1e-5;
    let path = walk(&snow(CamClayIntegration::Implicit), &diagonal(0.0, -step, 0.0), 10_000);
    for (strain, exact) in table {
        let stress = path[(strain / step).round() as usize - 1];
        let found = [stress.pressure(), stress.q(), -stress[1], -stress[0]];
        for (found, exact) in found.into_iter().zip(exact) {
            // First order in the step.
            within(found, exact, 1e-3, "oedometer");
        }
    }
    let before = walk(&snow(CamClayIntegration::Implicit), &diagonal(0.0, -0.004_892_471_3, 0.0), 1)[0];
    within(-before[1], 19_758.057_6, 1e-7, "axial stress at yield");
}

#[test]
fn shear_at_constant_volume_ends_at_the_top_of_the_ellipse() {
    let steps = 16_000;
    let part = 0.4 / f64::from(steps);
    let shear = Mat3([[1.0, part, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let path = walk(&snow(CamClayIntegration::Implicit), &shear, steps as usize);
    // Shear, p, q of V7.
    for (gamma, p, q) in [(0.01, 2939.5, 10_119.4), (0.02, 4843.9, 9335.6), (0.05, 5184.06, 9136.1)] {
        let stress = path[(gamma / part).round() as usize - 1];
        within(stress.pressure(), p, 5e-3, "pressure");
        within(stress.q(), q, 5e-3, "deviator");
    }
    let last = path[path.len() - 1];
    within(last.pressure(), 5185.15, 1e-3, "pressure at the end");
    within(last.q(), 9135.4, 1e-3, "deviator at the end");
}

#[test]
fn a_weak_layer_fails_softens_and_packs_on_the_path_of_the_sheet() {
    let step = 1e-6;
    let path = walk(&anticrack(), &diagonal(0.0, -step, 0.0), 20_000);
    let axial = |strain: f64| -path[(strain / step).round() as usize - 1][1];
    within(axial(0.0022), 2_963.708_6 * 0.0022 / 0.002_201_612_1, 1e-6, "elastic");
    let peak = (0..5000).map(|k| -path[k][1]).fold(0.0, f64::max);
    within(peak, 2970.95, 5e-3, "peak");
    for (strain, exact) in [(0.0025, 2954.588), (0.003, 2672.375), (0.0035, 1529.719)] {
        within(axial(strain), exact, 0.05, "softening");
    }
    let gone = (2000..6000).min_by(|&a, &b| path[a][1].abs().total_cmp(&path[b][1].abs())).unwrap();
    within((gone + 1) as f64 * step, 0.0036, 0.02, "strain at the collapse");
    assert!(path[gone].norm() < 0.01 * peak, "{}", path[gone].norm());
    let area: f64 = (0..=gone).map(|k| -path[k][1] * step).sum();
    within(area, 6.809, 0.02, "energy to the collapse");
    for (strain, exact) in [(0.01, 118.9), (0.02, 305.7)] {
        within(axial(strain), exact, 0.02, "packing");
    }
}

#[test]
fn without_cohesion_the_ellipse_is_that_of_modified_cam_clay() {
    for cohesion_ratio in [0.0, 0.3, 1.0] {
        let ellipse = YieldEllipse { slope: 1.2, cohesion_ratio, strength: 3e3 };
        // For any cohesion, the ellipse cuts the critical state line at half of p0 (sheet: snow-mpm §2.6).
        assert!(ellipse.yield_value(1.5e3, 1.2 * 1.5e3).abs() < 1e-9);
    }
    let ellipse = YieldEllipse { slope: 1.2, cohesion_ratio: 0.0, strength: 3e3 };
    for p in [0.0, 400.0, 1.5e3, 2.9e3, 3e3f64] {
        // q² = M² p (p0 - p).
        let q = 1.2 * (p * (3e3 - p)).sqrt();
        assert!(ellipse.yield_value(p, q).abs() < 1e-9, "{p}");
    }
}

/// Cone of the slope `slope` in `p` and `q`, with isochoric flow.
fn cone(slope: f64, youngs_modulus: f64) -> DruckerPragerSpec {
    DruckerPragerSpec {
        density: 917.0,
        youngs_modulus,
        poissons_ratio: 0.3,
        friction_angle: (3.0 * slope / (6.0 + slope)).asin().to_degrees(),
        cohesion: 0.0,
        dilatancy_angle: 0.0,
        matching: Matching::Compression,
        softening: None,
        dilatancy_decay: 0.0,
        integration: Default::default(),
        strain_measure: StrainMeasure::Hencky,
        return_initial_stress_to_yield: false,
    }
}

#[test]
fn the_cone_at_finite_strain_returns_as_sand_of_the_sheet_does() {
    // W4: 30 degrees, that is M = 1.2.
    let (sand, elasticity) = (cone(1.2, 353.7e3), Elasticity::new(353.7e3, 0.3).unwrap());
    let table = [
        ([0.01, -0.02, -0.004], [0.0056, -0.0154, -0.0042]),
        ([0.02, -0.01, 0.0], [0.0; 3]),
        ([0.002, -0.02, -0.012], [0.002, -0.02, -0.012]),
    ];
    for (trial, exact) in table {
        let found = walk(&sand, &diagonal(trial[0], trial[1], trial[2]), 1)[0];
        let exact = elasticity.stress(&SymTensor::diagonal(exact[0], exact[1], exact[2]));
        // The sheet has four decimals of the strain.
        let off = (found - exact).norm() / (2.0 * elasticity.shear_modulus);
        assert!(off < 1e-4, "{trial:?}: off by a strain of {off}");
    }
    let stress = walk(&sand, &diagonal(0.01, -0.02, -0.004), 1)[0];
    within(stress.q(), 1.2 * stress.pressure(), 1e-12, "slope of the cone");
    // Isochoric flow: not associated.
    within(stress.pressure(), elasticity.bulk_modulus * 0.014, 1e-12, "pressure");
}

#[test]
fn ice_is_the_cone_with_a_cohesion_that_decays_with_deviatoric_flow() {
    // Sheet: snow-mpm §2.10a with the parameters of A4: y = q - M p - c, c = c0 exp(-50 ε).
    let (slope, start, rate) = (1.0, 2e6, 50.0);
    let mut ice = cone(slope, 1e9);
    let sine = ice.friction_angle.to_radians().sin();
    ice.cohesion = start * (3.0 - sine) / (6.0 * ice.friction_angle.to_radians().cos());
    ice.softening = Some(Softening::of_cohesion(0.0, rate));
    let elasticity = Elasticity::new(1e9, 0.3).unwrap();
    let trial = [0.006, -0.008, 0.0];
    let found = walk(&ice, &diagonal(trial[0], trial[1], trial[2]), 1)[0];
    let before = elasticity.stress(&SymTensor::diagonal(trial[0], trial[1], trial[2]));
    within(found.pressure(), before.pressure(), 1e-10, "pressure");
    let flown = (before.q() - found.q()) / (3.0 * elasticity.shear_modulus);
    assert!(flown > 1e-3, "{flown}");
    within(found.q(), slope * before.pressure() + start * (-rate * flown).exp(), 1e-9, "deviator");
}
