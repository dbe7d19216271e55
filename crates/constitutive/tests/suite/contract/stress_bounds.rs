//! Bounds of the stress: finite, inside the yield surface, constant without motion, and with dissipation that is not negative.

use colluvium_constitutive::{InitialCondition, Mat3, Motion, SymTensor};
use proptest::prelude::*;

use super::gradients;
use super::laws::{subjects, with_and_without_cohesion};

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn a_step_without_motion_keeps_the_stress(path in gradients(3, 0.05)) {
        for subject in subjects() {
            let point = subject.stopped(subject.end_of_path(&path, 1e-3));
            let still = subject.step(&point, &Mat3::ZERO, 1e-3);
            if subject.is_solid() {
                let change = (still.stress - point.stress).norm();
                let own = 1e-14 + subject.law.stress_tolerance();
                prop_assert!(change <= own * point.stress.norm(), "{}: {change}", subject.name());
            } else if subject.yield_value(&still) == f64::NEG_INFINITY {
                let shear = still.stress.deviator().norm();
                prop_assert!(shear <= 1e-14 * still.stress.norm(), "a resting fluid carries no shear");
            } else {
                let limit = point.stress.deviator().norm() * (1.0 + 1e-14);
                prop_assert!(still.stress.deviator().norm() <= limit, "{}: shear grew at rest", subject.name());
            }
        }
    }

    #[test]
    fn stress_stays_finite_and_inside_the_yield_surface(path in gradients(6, 0.1)) {
        for subject in subjects() {
            let mut point = subject.point();
            for a in &path {
                let next = subject.step(&point, a, 1e-3);
                prop_assert!(next.stress.is_finite(), "{}", subject.name());
                let excess = subject.yield_value(&next);
                // p_ref = 1 kPa.
                let scale = next.stress.pressure().abs() + 1e3;
                prop_assert!(excess <= 1e-9 * scale, "{}: f = {excess} Pa at {scale} Pa", subject.name());
                point = next;
            }
        }
    }

    #[test]
    fn extreme_motions_are_refused_or_give_finite_stress(entries in proptest::array::uniform9(prop_oneof![
        -1e3..1e3f64, Just(f64::NAN), Just(f64::INFINITY), Just(0.0), Just(-1.0), Just(1e300)
    ])) {
        for subject in subjects() {
            let point = subject.point();
            let gradient = Mat3(*entries.as_chunks::<3>().0.first_chunk::<3>().expect("nine entries"));
            let motion = Motion {
                deformation: Mat3::IDENTITY + gradient,
                velocity_gradient_dt: gradient,
                dt: 1e-3,
                density: point.density,
                size: 0.1,
                pore: Default::default(),
            };
            match subject.try_apply(&point, &motion) {
                Ok(_) if !gradient.is_finite() => {
                    prop_assert!(false, "{} took a motion that is not finite", subject.name());
                }
                Ok(new) => prop_assert!(new.stress.is_finite(), "{}: {:?}", subject.name(), new.stress),
                Err(_) => {}
            }
        }
    }

    #[test]
    fn plastic_flow_dissipates(path in gradients(5, 0.1)) {
        for subject in subjects() {
            let mut point = subject.point();
            for a in &path {
                let motion = subject.motion(a, 1e-3, point.density);
                let next = subject.apply(&point, &motion);
                let old = (&point.stress, &point.states.blocks()[0]);
                let new = (&next.stress, &next.states.blocks()[0]);
                if let Some(dissipated) = subject.law.dissipation(&motion, old, new) {
                    // Scale of the energy in a step.
                    let strain = motion.velocity_gradient_dt.sym().norm();
                    let scale = subject.stress_scale(&point, &motion) * strain + subject.energy(&point);
                    prop_assert!(dissipated >= -1e-12 * scale, "{}: {dissipated} J/m³ of {scale}", subject.name());
                }
                point = next;
            }
        }
    }
}

#[test]
fn the_smallest_stresses_and_strains_stay_finite() {
    // Ahead of a wave stresses are near the least numbers, and products of them vanish in rounding.
    let shear = SymTensor([0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    let directions = [SymTensor::isotropic(1.0), SymTensor::isotropic(-1.0), shear];
    for subject in with_and_without_cohesion() {
        let start = InitialCondition { stress: SymTensor::ZERO, density: subject.spec.density() };
        if subject.law.initial(&[start]).is_err() {
            continue;
        }
        for power in (150..=320).step_by(5) {
            let size = 10f64.powi(-150) * 10f64.powi(150 - power);
            assert!(size > 0.0);
            for stress in directions {
                let mut point = subject.point_at(SymTensor::ZERO);
                point.stress = stress * size;
                for strain in directions.into_iter().chain([SymTensor::ZERO]) {
                    let next = subject.step(&point, &(strain * size).to_matrix(), 1e-3);
                    assert!(next.stress.is_finite(), "{}: {size} of {stress:?}, {strain:?}", subject.name());
                }
            }
        }
    }
}
