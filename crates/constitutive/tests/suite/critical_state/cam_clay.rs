//! Modified Cam-clay, §3.7.5 and V-11.

use colluvium_constitutive::driver::{ElementPath, LoadingPath};
use colluvium_constitutive::laws::{CamClaySpec, OriginalCamClaySpec};
use colluvium_constitutive::{
    Corotational, MaterialError, MaterialSpec, Motion, PointLaw, SmallStrain, StressUpdate, SymTensor,
};
use colluvium_testkit::{assert_near, assert_relative};

use super::{Change, at, clay, problem_field, start, still, test};

#[test]
fn modified_cam_clay_returns_to_the_stress_of_the_sheet() {
    let law = clay(120.0).law().unwrap();
    let old = PointLaw::initial(&law, &start(SymTensor::isotropic(-100e3))).unwrap();
    let strain = SymTensor([-0.02, 0.004, 0.004, 0.003, 0.0, 0.0]);
    let new = SmallStrain::update(&law, &strain, &still(), &old).unwrap();
    assert_near(new.stress[0], -145_694.100, 0.5001 * 1e-3);
    assert_near(new.stress[1], -97_507.593, 0.5001 * 1e-3);
    assert_near(new.stress[2], -97_507.593, 0.5001 * 1e-3);
    assert_near(new.stress[3], 6_023.313, 0.5001 * 1e-3);
    assert_near(new.stress.pressure(), 113_569.762, 0.5001 * 1e-3);
    assert_near(new.stress.q(), 49_302.945, 0.5001 * 1e-3);
    assert_near(new.state.preconsolidation_pressure, 134_973.173, 0.5001 * 1e-3);
    assert_near(1.0 + new.state.void_ratio, 1.976_143_426, 0.5001 * 1e-9);
    let end = law.single_step_return(&strain, &old).unwrap().unwrap();
    assert_near(end.multiplier, 9.568_375_503e-8, 0.5001 * 1e-17);
}

#[test]
fn modified_cam_clay_trial_is_the_one_of_the_sheet() {
    // Strength so high that the step is elastic.
    let law = clay(1e4).law().unwrap();
    let old = PointLaw::initial(&law, &start(SymTensor::isotropic(-100e3))).unwrap();
    let strain = SymTensor([-0.02, 0.004, 0.004, 0.003, 0.0, 0.0]);
    let new = SmallStrain::update(&law, &strain, &still(), &old).unwrap();
    assert_near(new.stress.pressure(), 161_607.440, 0.5001 * 1e-3);
    assert_near(new.stress.q(), 116_371.992, 0.5001 * 1e-3);
}

#[test]
fn modified_cam_clay_reaches_its_undrained_strength() {
    for (size, exact) in [(100.0, 59_460.355_75), (400.0, 168_179.283_05)] {
        let path = LoadingPath::TriaxialUndrained { axial_compression: 3.0, fluid_stiffness: None };
        let run = test(MaterialSpec::CamClay(clay(size)), 100.0, &[(path, 1000)]);
        assert_relative(run.last("p"), exact, 1e-5);
        assert_relative(run.last("q"), exact, 1e-5);
    }
}

#[test]
fn modified_cam_clay_follows_its_undrained_path() {
    let path = LoadingPath::TriaxialUndrained { axial_compression: 0.2, fluid_stiffness: None };
    let run = test(MaterialSpec::CamClay(clay(100.0)), 100.0, &[(path, 1000)]);
    for (p, q) in run.column("p").unwrap().into_iter().zip(run.column("q").unwrap()) {
        assert_relative(p, 100e3 / (1.0 + (q / p).powi(2)).powf(0.75), 1e-5);
    }
    assert_relative(at(&run, "q", 47.714_981_28, "p"), 79.325_236_54, 1e-5);
}

#[test]
fn modified_cam_clay_approaches_its_drained_strength() {
    for (size, p, q) in [(100.0, 149.64, 148.93), (500.0, 150.15, 150.46)] {
        let path = LoadingPath::TriaxialDrained { axial_compression: 0.6 };
        let run = test(MaterialSpec::CamClay(clay(size)), 100.0, &[(path, 1000)]);
        assert_near(run.last("p") / 1e3, p, 0.5001 * 1e-2);
        assert_near(run.last("q") / 1e3, q, 0.5001 * 1e-2);
    }
}

#[test]
fn modified_cam_clay_compresses_along_its_lines() {
    let isotropic = |pressure: f64| LoadingPath::Isotropic { pressure };
    let run = |steps| {
        let stages = [(isotropic(400e3), steps), (isotropic(200e3), steps)];
        test(MaterialSpec::CamClay(clay(100.0)), 100.0, &stages)
    };
    let v = |run: &ElementPath, row: usize| 1.0 + run.column("void_ratio").unwrap()[row];
    let exact = 2.0 - 0.2 * 4f64.ln();
    // The specific volume is frozen over a step: first order.
    let error = |steps| v(&run(steps), steps) - exact;
    assert_relative(v(&run(1000), 1000), exact, 2e-5);
    assert_relative(error(500) / error(1000), 2.0, 0.02);
    let run = run(1000);
    assert_relative((v(&run, 2000) - v(&run, 1000)) / 2f64.ln(), 0.05, 1e-4);
}

#[test]
fn modified_cam_clay_settles_at_its_lateral_pressure() {
    let ratios = |steps| {
        let path = LoadingPath::Oedometer { axial_compression: 0.4 };
        let run = test(MaterialSpec::CamClay(clay(100.0)), 100.0, &[(path, steps)]);
        [run.last("q") / run.last("p"), run.last("stress_xx") / run.last("stress_zz")]
    };
    // First order in the step, so that two of them give the limit.
    let (coarse, fine) = (ratios(1000), ratios(2000));
    let limit = [0, 1].map(|k| 2.0 * fine[k] - coarse[k]);
    assert_near(limit[0], 0.352_184, 0.5001 * 1e-6);
    assert_near(limit[1], 0.714_782, 0.5001 * 1e-6);
}

#[test]
fn large_strain_increments_are_refused() {
    let law = Corotational(clay(200.0).law().unwrap());
    let old = PointLaw::initial(&law, &start(SymTensor::isotropic(-100e3))).unwrap();
    let motion = Motion { velocity_gradient_dt: SymTensor::isotropic(-0.7).to_matrix(), ..still() };
    let refused = StressUpdate::update(&law, &motion, &old);
    assert!(matches!(refused, Err(MaterialError::Motion { .. })));
}

/// Changes of a valid material that give a parameter out of range, and the parameter (sheet: constitutive §7).
const OUT_OF_RANGE: [(Change<CamClaySpec>, &str); 10] = [
    (|s| s.critical_state_slope = 0.0, "critical_state_slope"),
    (|s| s.swelling_slope = -0.05, "swelling_slope"),
    (|s| s.compression_slope = 0.05, "compression_slope"),
    (|s| s.poissons_ratio = Some(0.5), "poissons_ratio"),
    (|s| s.poissons_ratio = None, "poissons_ratio"),
    (|s| s.shear_modulus = Some(1e6), "poissons_ratio"),
    (|s| s.void_ratio = 0.0, "void_ratio"),
    (|s| s.preconsolidation_pressure = Some(0.0), "preconsolidation_pressure"),
    (|s| s.preconsolidation_pressure = None, "preconsolidation_pressure"),
    (
        |s| (s.preconsolidation_pressure, s.overconsolidation_ratio) = (None, Some(0.9)),
        "overconsolidation_ratio",
    ),
];

#[test]
fn cam_clay_parameters_out_of_range_are_named() {
    for (change, name) in OUT_OF_RANGE {
        let mut spec = clay(100.0);
        change(&mut spec);
        assert_eq!(problem_field(&spec.law().unwrap_err()), name);
        assert_eq!(problem_field(&OriginalCamClaySpec(spec).law().unwrap_err()), name);
    }
}
