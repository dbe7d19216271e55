//! Initial stresses of laws whose state depends on pressure, §7.

use colluvium_constitutive::laws::{CamClaySpec, OriginalCamClaySpec, SimsandSpec};
use colluvium_constitutive::{MaterialSpec, PointLaw, SymTensor};
use colluvium_testkit::assert_relative;

use super::{CLAY, clay, elastic, start};

#[test]
fn overconsolidation_sizes_the_surface_through_the_initial_stress() {
    let stress = SymTensor::diagonal(-60e3, -60e3, -120e3);
    let (p, q) = (stress.pressure(), stress.q());
    for ratio in [1.0, 2.0] {
        let spec = CamClaySpec {
            preconsolidation_pressure: None,
            overconsolidation_ratio: Some(ratio),
            ..clay(1.0)
        };
        let modified = PointLaw::initial(&spec.law().unwrap(), &start(stress)).unwrap();
        assert_relative(modified.state.preconsolidation_pressure, ratio * (p + q * q / p), 1e-14);
        let original = OriginalCamClaySpec(spec).law().unwrap();
        let original = PointLaw::initial(&original, &start(stress)).unwrap();
        assert_relative(original.state.preconsolidation_pressure, ratio * p * (q / p).exp(), 1e-14);
    }
}

#[test]
fn inadmissible_initial_stresses_are_refused() {
    let laws: [MaterialSpec; 4] = [
        MaterialSpec::PressureElastic(elastic(CLAY)),
        MaterialSpec::CamClay(clay(100.0)),
        MaterialSpec::OriginalCamClay(OriginalCamClaySpec(clay(100.0))),
        MaterialSpec::Simsand(SimsandSpec::bui_nguyen(0.77)),
    ];
    for spec in laws {
        let law = spec.build().unwrap();
        for stress in [SymTensor::ZERO, SymTensor::isotropic(1e3), SymTensor::isotropic(f64::NAN)] {
            let error = law.initial(&[start(stress)]).err().unwrap().to_string();
            assert!(error.contains(spec.name()), "{error}");
        }
        let outside = law.initial(&[start(SymTensor::diagonal(-10e3, -10e3, -200e3))]);
        assert_eq!(outside.is_err(), spec.name() != "pressure-dependent-elastic", "{}", spec.name());
    }
}

#[test]
fn an_initial_stress_outside_is_returned_to_the_surface_on_request() {
    let outside = SymTensor([-100e3, -100e3, -400e3, 30e3, 0.0, 0.0]);
    let too_far = SymTensor::isotropic(-500e3);
    for spec in [
        MaterialSpec::CamClay(CamClaySpec { return_initial_stress_to_yield: true, ..clay(200.0) }),
        MaterialSpec::OriginalCamClay(OriginalCamClaySpec(CamClaySpec {
            return_initial_stress_to_yield: true,
            ..clay(200.0)
        })),
    ] {
        let law = spec.build().unwrap();
        let (stresses, states) = law.initial(&[start(outside), start(too_far)]).unwrap();
        let mut values = [0.0; 2];
        law.yield_values(&stresses, &states.blocks()[0], &mut values);
        assert!(values.iter().all(|value| value.abs() < 1e-9 * 200e3), "{}: {values:?}", spec.name());
        assert_relative(stresses[0].pressure(), 200e3, 1e-12);
        assert!(stresses[1].deviator().norm() == 0.0);
        assert_relative(stresses[1].pressure(), 200e3, 1e-12);
    }
}
