//! Length of a step, and the properties that a law declares of itself.

use colluvium_constitutive::{Mat3, Motion, SymTensor};

use super::laws::subjects;
use super::{motion, value_of};

#[test]
fn two_half_steps_differ_from_one_by_the_square_of_the_step() {
    // From a state on the yield surface, in a direction that continues loading and rotates.
    let before = Mat3([[0.002, 0.002, 0.0], [0.001, -0.004, 0.0005], [0.0, 0.001, 0.001]]);
    let direction = Mat3([[0.2, 0.5, 0.0], [-0.1, -0.6, 0.1], [0.0, 0.2, 0.25]]);
    for subject in subjects() {
        let point = subject.end_of_path(&[before, before * 0.5], 1e-3);
        let difference = |size: f64| {
            let a = direction * size;
            let whole = subject.apply(&point, &motion(&a, 1e-3 * size / 4e-4, point.density));
            // Half of the logarithm of the motion, so that both paths end at the same deformation.
            let root = square_root(&motion(&a, 1.0, 1.0).deformation);
            let half = |density: f64| {
                let mut m =
                    Motion::from_deformation(&root, 0.5e-3 * size / 4e-4, density, 0.1).expect("small");
                m.density = density / root.determinant();
                m
            };
            let middle = subject.apply(&point, &half(point.density));
            let end = subject.apply(&middle, &half(middle.density));
            // A strain is given to the last digit of the deformation, which the stiffness turns into stress.
            let modulus = value_of(&point, |stress, block, out| subject.law.wave_moduli(stress, block, out));
            ((end.stress - whole.stress).norm(), 64.0 * f64::EPSILON * modulus + 1e-12 * point.stress.norm())
        };
        let mut size = 1e-5;
        let mut last = difference(size).0;
        for _ in 0..3 {
            size *= 0.5;
            let (now, floor) = difference(size);
            assert!(now <= 0.27 * last + floor, "{}: {last} to {now} at {size}", subject.name());
            last = now;
        }
    }
}

/// Square root of a matrix near the unit matrix (Denman–Beavers).
fn square_root(m: &Mat3) -> Mat3 {
    let (mut y, mut z) = (*m, Mat3::IDENTITY);
    for _ in 0..20 {
        let (a, b) = (z.inverse().expect("regular"), y.inverse().expect("regular"));
        (y, z) = ((y + a) * 0.5, (z + b) * 0.5);
    }
    y
}

#[test]
fn wrapped_laws_have_the_properties_of_the_inner_law() {
    for subject in subjects() {
        let (law, tolerance) = (&subject.law, subject.law.stress_tolerance());
        assert!((0.0..1e-3).contains(&tolerance), "{}: {tolerance}", subject.name());
        let Some(inner) = subject.spec.inner() else {
            assert_eq!(law.name(), subject.spec.name());
            continue;
        };
        let inner = inner.build().expect("it has built within another");
        assert_eq!((law.is_isotropic(), tolerance), (inner.is_isotropic(), inner.stress_tolerance()));
        assert!(law.is_time_dependent() || !inner.is_time_dependent(), "{}", subject.name());
    }
}

#[test]
fn only_hypoelastic_laws_keep_a_stress_changed_from_outside() {
    for subject in subjects() {
        let whole = subject.point();
        let mut less = whole.clone();
        less.stress = whole.stress * 0.99;
        let strain = SymTensor([1e-5, -2e-5, 0.0, 1e-5, 0.0, 0.0]).to_matrix();
        let differs = subject.step(&whole, &strain, 1e-3).stress != subject.step(&less, &strain, 1e-3).stress;
        // Fluids whose shear is in rate form have their pressure from density: shear is the stress they keep.
        let shears = whole.stress.deviator() != SymTensor::ZERO;
        assert_eq!(differs, subject.law.is_hypoelastic() && shears, "{}", subject.name());
    }
}

#[test]
fn without_motion_only_time_dependent_laws_depend_on_the_step() {
    for subject in subjects().iter().filter(|s| s.law.is_hypoelastic()) {
        let mut beyond = subject.point();
        // Beyond the yield surface of most laws.
        beyond.stress += SymTensor([2e4, -1e4, -1e4, 5e4, 0.0, 0.0]);
        let after = |dt: f64| {
            let motion = motion(&Mat3::ZERO, dt, beyond.density);
            subject.try_apply(&beyond, &motion).map(|point| point.stress)
        };
        let differs = after(1e-4) != after(1e-3);
        assert!(!differs || subject.law.is_time_dependent(), "{}", subject.name());
        // Without viscosity the stress of a flow is its yield stress at any rate.
        let flows = subject.spec.is_fluid() && !subject.name().contains("viscosity: 0.0");
        assert!(differs || !flows, "{}", subject.name());
    }
}
