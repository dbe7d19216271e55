//! Original Cam-clay, §2.6 and V-12.

use colluvium_constitutive::driver::LoadingPath;
use colluvium_constitutive::laws::{CamClaySpec, OriginalCamClaySpec};
use colluvium_constitutive::{MaterialSpec, PointLaw, SmallStrain, SymTensor};
use colluvium_testkit::{assert_near, assert_relative};

use super::{clay, start, still, test};

#[test]
fn original_cam_clay_has_the_surface_of_the_sheet() {
    let spec = CamClaySpec { critical_state_slope: 1.2, ..clay(200.0) };
    let law = OriginalCamClaySpec(spec).law().unwrap();
    let e = std::f64::consts::E;
    for (p, q) in
        // The sheet prints …89 for the third; M p_c/e is 88.291 065 881.
        [
            (50.0, 83.177_661_67),
            (100.0, 83.177_661_67),
            (200.0 / e, 88.291_065_88),
            (150.0, 51.782_773_04),
        ]
    {
        assert_near(law.strength(p, 200.0), q, 0.5001 * 1e-8);
    }
    assert_relative(law.strength(200.0 / e, 200.0), 1.2 * 200.0 / e, 1e-14);
}

#[test]
fn original_cam_clay_reaches_its_undrained_strength() {
    let path = LoadingPath::TriaxialUndrained { axial_compression: 3.0, fluid_stiffness: None };
    let run = test(MaterialSpec::OriginalCamClay(OriginalCamClaySpec(clay(100.0))), 100.0, &[(path, 1000)]);
    let exact = 100e3 * (-0.75f64).exp();
    assert_relative(run.last("p"), exact, 1e-5);
    assert_relative(run.last("q"), exact, 1e-5);
    // During the path q = M p ln(p_c/p) with p_c falling as a power of p.
    for (p, q) in run.column("p").unwrap().into_iter().zip(run.column("q").unwrap()) {
        let size = 100e3 * (p / 100e3).powf(-0.05 / 0.15);
        assert!((q - p * (size / p).ln()).abs() <= 1e-5 * p, "{q} at {p}");
    }
}

#[test]
fn original_cam_clay_returns_to_its_tip() {
    let law = OriginalCamClaySpec(clay(100.0)).law().unwrap();
    let old = PointLaw::initial(&law, &start(SymTensor::isotropic(-100e3))).unwrap();
    let returned = |shear: f64| {
        let strain = SymTensor([-0.002, -0.002, -0.002, shear, 0.0, 0.0]);
        SmallStrain::update(&law, &strain, &still(), &old).unwrap()
    };
    // Isotropic: p = p_c = 100 exp(v Δ/λ); v/λ = 10, Δ = 0.006.
    let tip = returned(0.0);
    assert_relative(tip.stress.pressure(), 100e3 * 0.06f64.exp(), 1e-12);
    assert_relative(tip.state.preconsolidation_pressure, tip.stress.pressure(), 1e-12);
    // The plastic compression is Δ (λ-κ)/λ = 0.0045; plastic shear up to 1/M of it belongs to the tip.
    let limit = 0.0045 * 3f64.sqrt() / 2.0;
    let inside = returned(0.999 * limit);
    assert!(inside.stress.q() < 1e-14 * tip.stress.pressure(), "within the two normals");
    assert_relative(inside.stress.pressure(), tip.stress.pressure(), 1e-12);
    let outside = returned(1.001 * limit);
    assert!(outside.stress.q() > 0.0, "beyond them");
    assert!(outside.stress.q() < 1e-3 * outside.stress.pressure(), "continuous");
}
