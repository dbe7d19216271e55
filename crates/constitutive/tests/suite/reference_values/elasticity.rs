//! Elastic constants, invariants, and rotation of the stress in rate form.

use colluvium_constitutive::laws::LinearElastic;
use colluvium_constitutive::{Corotational, FirstOrderSpin, Mat3, Motion, Point, StressUpdate, SymTensor};
use colluvium_testkit::assert_close;

use crate::reference_materials::r1;

#[test]
fn elastic_constants_of_the_reference_set() {
    let e = r1();
    assert_close(e.bulk_modulus, 16_666.666_7, 1e-8);
    assert_close(e.shear_modulus, 7_692.307_7, 1e-8);
    assert_close(e.lame(), 11_538.461_5, 1e-8);
    assert_close(e.p_wave_modulus(), 26_923.076_9, 1e-8);
}

#[test]
fn a_rotated_stress_has_the_components_of_the_sheet() {
    let stress =
        SymTensor([-100.0, -50.0, -70.0, 20.0, 0.0, 0.0]).rotated(&Mat3::rotation_z(30f64.to_radians()));
    assert_close(stress[0], -104.820_508_08, 1e-9);
    assert_close(stress[1], -45.179_491_92, 1e-9);
    assert_close(stress[3], -11.650_635_09, 1e-9);
}

#[test]
fn hypoelastic_simple_shear_converges_to_the_sine() {
    // §3.2: with half rotations, and with the one-term spin update of the source.
    let law = LinearElastic { elasticity: r1() };
    let end = |law: &dyn Fn(&Motion, &Point<()>) -> Point<()>, steps: usize| {
        let l = Mat3([[0.0, 2.0 / steps as f64, 0.0], [0.0; 3], [0.0; 3]]);
        let motion = Motion::from_velocity_gradient(&l, 1.0, 2.0, 1.0).unwrap();
        let start = Point { stress: SymTensor::ZERO, state: () };
        let stress = (0..steps).fold(start, |p, _| law(&motion, &p)).stress;
        (stress[3] / r1().shear_modulus, stress[0] / r1().shear_modulus)
    };
    let halves = Corotational(law);
    let second = |m: &Motion, p: &Point<()>| StressUpdate::update(&halves, m, p).unwrap();
    let table = [
        (5, 0.921_155_58, 1.424_212_99),
        (10, 0.912_263_68, 1.418_169_62),
        (20, 0.910_039_10, 1.416_652_92),
        (100, 0.909_327_09, 1.416_167_09),
    ];
    for (steps, shear, normal) in table {
        let (found_shear, found_normal) = end(&second, steps);
        assert!((found_shear - shear).abs() < 1e-8 && (found_normal - normal).abs() < 1e-8, "{steps} steps");
    }
    let one_term = FirstOrderSpin(law);
    let first = |m: &Motion, p: &Point<()>| StressUpdate::update(&one_term, m, p).unwrap();
    let (shear, normal) = end(&first, 10);
    assert!((shear - 1.1191).abs() < 1e-4 && (normal - 1.4773).abs() < 1e-4, "{shear} {normal}");
    // A full turn in 36 steps ends far from the start.
    let spin = Mat3([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0; 3]]) * 10f64.to_radians();
    let motion = Motion::from_velocity_gradient(&spin, 1.0, 2.0, 1.0).unwrap();
    let start = Point { stress: SymTensor([-100.0, -50.0, 0.0, 20.0, 0.0, 0.0]), state: () };
    let turned = (0..36).fold(start, |p, _| first(&motion, &p)).stress;
    assert!((turned[0] + 178.4).abs() < 0.1 && (turned[3] - 231.6).abs() < 0.1, "{turned:?}");
}

#[test]
fn rotation_by_spin_or_by_rigid_step() {
    let law = Corotational(LinearElastic { elasticity: r1() });
    let start = Point { stress: SymTensor([-100.0, -50.0, 0.0, 20.0, 0.0, 0.0]), state: () };
    let turn = |motion: Motion, steps: usize| {
        (0..steps).fold(start, |p, _| StressUpdate::update(&law, &motion, &p).unwrap()).stress
    };
    let rigid =
        |angle: f64| Motion::from_deformation(&Mat3::rotation_z(angle.to_radians()), 1.0, 2.0, 1.0).unwrap();
    let full = turn(rigid(10.0), 36);
    assert!((full - start.stress).norm() < 1e-10);
    let spin = |angle: f64| {
        let l = Mat3([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0; 3]]) * angle.to_radians();
        Motion::from_velocity_gradient(&l, 1.0, 2.0, 1.0).unwrap()
    };
    for (angle, steps, xx, xy) in [(10.0, 36, -99.352_414, 20.783_646), (1.0, 360, -99.993_619, 20.007_973)] {
        let stress = turn(spin(angle), steps);
        assert!((stress[0] - xx).abs() < 1e-6 && (stress[3] - xy).abs() < 1e-6, "{stress:?}");
        assert_close(stress.j2(), start.stress.j2(), 1e-11);
    }
}

#[test]
fn invariants_follow_their_definitions() {
    let compression = SymTensor::diagonal(-1.0, -1.0, -4.0);
    assert_close(compression.pressure(), 2.0, 1e-15);
    assert_close(compression.q(), 3.0, 1e-15);
    assert_close(compression.lode_angle(), std::f64::consts::FRAC_PI_3, 1e-7);
    assert_close(SymTensor::diagonal(-1.0, -4.0, -4.0).lode_angle(), 0.0, 1e-7);
}
