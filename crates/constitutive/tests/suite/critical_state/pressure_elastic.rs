//! Pressure-dependent elasticity, §2.2.

use colluvium_constitutive::driver::{ElementPath, LoadingPath};
use colluvium_constitutive::laws::{PressureElasticSpec, PressureStiffness};
use colluvium_constitutive::{Corotational, Mat3, MaterialSpec, Motion, PointLaw, StressUpdate, SymTensor};
use colluvium_testkit::assert_relative;

use super::{CLAY, Change, SAND, elastic, problem_field, start, test};

#[test]
fn elastic_stiffness_follows_pressure() {
    let sand = elastic(SAND).law().unwrap();
    assert_relative(sand.shear_modulus(100e3, 0.8), 30e6, 1e-12);
    assert_relative(sand.shear_modulus(400e3, 0.8), 60e6, 1e-12);
    // 2(1+ν)/(3(1-2ν)) = 4/3 for ν = 0.2.
    assert_relative(sand.bulk_modulus(400e3, 0.8), 80e6, 1e-12);
    let clay = elastic(CLAY).law().unwrap();
    assert_relative(clay.bulk_modulus(50e3, 0.8), 1.8e6, 1e-12);
    assert_relative(clay.shear_modulus(50e3, 0.8), 1.35e6, 1e-12);
}

#[test]
fn elastic_pressure_is_a_function_of_volume_alone() {
    let volume = |run: &ElementPath| run.last("volumetric_strain");
    let run = |stiffness, pressure, steps| {
        let material = MaterialSpec::PressureElastic(elastic(stiffness));
        test(material, 100.0, &[(LoadingPath::Isotropic { pressure }, steps)])
    };
    // Clay: e + κ ln p is constant, in one step as in many.
    for steps in [1, 7] {
        let loaded = run(CLAY, 300e3, steps);
        assert_relative(loaded.last("void_ratio"), 0.8 - 0.05 * 3f64.ln(), 1e-12);
        assert_relative(1.8 * volume(&loaded).exp() - 1.0, loaded.last("void_ratio"), 1e-12);
    }
    // Sand: p^(1-n) is linear in volume.
    let exact = -(300e3f64.sqrt() - 100e3f64.sqrt()) * 2.0 * 100e3f64.sqrt() / 40e6;
    assert_relative(volume(&run(SAND, 300e3, 1)), exact, 1e-10);
    assert_relative(volume(&run(SAND, 300e3, 9)), exact, 1e-10);
}

#[test]
fn elastic_stiffness_does_not_fall_below_that_of_the_least_pressure() {
    for stiffness in [SAND, CLAY] {
        let spec = PressureElasticSpec { least_pressure: Some(2e3), ..elastic(stiffness) };
        let law = Corotational(spec.law().unwrap());
        let point = law.initial(&start(SymTensor::isotropic(-3e3))).unwrap();
        let by = |strain: f64, point: &_| {
            let motion =
                Motion::from_velocity_gradient(&(Mat3::IDENTITY * strain), 1.0, 1800.0, 1.0).unwrap();
            StressUpdate::update(&law, &motion, point).unwrap()
        };
        let whole = by(0.02, &point);
        assert!(whole.stress.pressure() < 0.0, "in tension");
        // Two halves, and back.
        let end = by(0.01, &by(0.01, &point));
        assert_relative(end.stress.pressure(), whole.stress.pressure(), 1e-10);
        assert_relative(by(-0.02, &end).stress.pressure(), 3e3, 1e-10);
    }
}

#[test]
fn elastic_triaxial_slope_is_three_times_the_shear_modulus() {
    let material = MaterialSpec::PressureElastic(elastic(SAND));
    let run = test(
        material,
        100.0,
        &[(LoadingPath::TriaxialUndrained { axial_compression: 1e-3, fluid_stiffness: None }, 10)],
    );
    assert_relative(run.last("q"), 3.0 * 30e6 * 1e-3, 1e-9);
    assert_relative(run.last("p"), 100e3, 1e-9);
}

/// Changes of a valid material that give a parameter out of range, and the parameter (sheet: constitutive §7).
const OUT_OF_RANGE: [(Change<PressureElasticSpec>, &str); 7] = [
    (|s| s.poissons_ratio = -1.0, "poissons_ratio"),
    (|s| s.void_ratio = -0.1, "void_ratio"),
    (|s| s.least_pressure = Some(0.0), "least_pressure"),
    (|s| s.stiffness = PressureStiffness::Clay { swelling_slope: 0.0 }, "stiffness.swelling_slope"),
    (
        |s| {
            s.stiffness =
                PressureStiffness::Sand { shear_modulus: 0.0, reference_pressure: 1e5, exponent: 0.5 }
        },
        "stiffness.shear_modulus",
    ),
    (
        |s| {
            s.stiffness =
                PressureStiffness::Sand { shear_modulus: 1e7, reference_pressure: 0.0, exponent: 0.5 }
        },
        "stiffness.reference_pressure",
    ),
    (
        |s| {
            s.stiffness =
                PressureStiffness::Sand { shear_modulus: 1e7, reference_pressure: 1e5, exponent: 1.1 }
        },
        "stiffness.exponent",
    ),
];

#[test]
fn pressure_elastic_parameters_out_of_range_are_named() {
    for (change, name) in OUT_OF_RANGE {
        let mut spec = elastic(CLAY);
        change(&mut spec);
        assert_eq!(problem_field(&spec.law().unwrap_err()), name);
    }
}
