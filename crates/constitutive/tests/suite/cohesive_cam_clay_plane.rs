//! Cohesive Cam Clay with the invariants of the plane, d = 2 (sheet: constitutive §2.15).

use crate::cohesive_cam_clay::slab;
use colluvium_constitutive::laws::{CohesiveCamClaySpec, StressInvariants};
use colluvium_constitutive::{InitialCondition, Mat3, Model, Motion, SymTensor};

fn walk(motions: &[Mat3]) -> (SymTensor, f64) {
    let spec = CohesiveCamClaySpec { invariants: StressInvariants::Plane, ..slab() };
    let law = spec.build().unwrap();
    let start = InitialCondition { stress: SymTensor::ZERO, density: 250.0 };
    let (mut stresses, mut states) = law.initial(&[start]).unwrap();
    for f in motions {
        let motion = Motion::from_deformation(f, 1.0, 250.0, 1.0).unwrap();
        law.update(&[motion], &mut stresses, &mut states.blocks_mut()[0]).unwrap();
    }
    let mut value = [0.0];
    law.yield_values(&stresses, &states.blocks()[0], &mut value);
    (stresses[0], value[0])
}

fn diagonal(x: f64, y: f64) -> Mat3 {
    Mat3([[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, 1.0]])
}

#[test]
fn elastic_stress_has_the_bulk_modulus_of_the_plane() {
    let (x, y) = ((-4e-4f64).exp(), (-2e-4f64).exp());
    let (found, value) = walk(&[diagonal(x, y)]);
    let (lame, mu) = (5e6 * 0.3 / (1.3 * 0.4), 5e6 / 2.6);
    // K = λ + μ.
    let pressure = (lame + mu) * 6e-4;
    let jacobian = x * y;
    assert!((found[0] * jacobian - (-pressure - 2.0 * mu * 1e-4)).abs() < 1e-8);
    assert!((found[1] * jacobian - (-pressure + 2.0 * mu * 1e-4)).abs() < 1e-8);
    assert!(value < 0.0);
    // q of the plane, √(3/2 s:s) with the two deviators ±2μ·10⁻⁴.
    assert!((found.q() * jacobian - 3f64.sqrt() * 2.0 * mu * 1e-4).abs() < 1e-8);
}

#[test]
fn isotropic_compaction_follows_the_closed_form() {
    // p = K sinh(ξ (x0 + x)), strain = x + p/K beyond p0/K.
    let modulus: f64 = 5e6 * 0.3 / (1.3 * 0.4) + 5e6 / 2.6;
    let x0 = (10e3 / modulus).asinh() / 10.0;
    let (plastic, steps): (f64, u32) = (1e-3, 50);
    let pressure = modulus * (10.0 * (x0 + plastic)).sinh();
    let strain = plastic + pressure / modulus;
    let part = (-0.5 * strain / f64::from(steps)).exp();
    let (found, value) = walk(&vec![diagonal(part, part); steps as usize]);
    let kirchhoff = found.pressure() * (-strain).exp();
    assert!((kirchhoff / pressure - 1.0).abs() < 1e-9, "{kirchhoff} for {pressure}");
    assert!(value.abs() < 1e-9 * pressure);
}

#[test]
fn the_stress_rotates_with_the_observer() {
    let path = [
        Mat3([[0.995, 0.004, 0.0], [0.0, 1.001, 0.0], [0.0, 0.0, 1.0]]),
        Mat3([[1.002, 0.01, 0.0], [-0.003, 0.97, 0.0], [0.0, 0.0, 1.0]]),
    ];
    let q = Mat3::rotation_z(0.7);
    let (here, _) = walk(&path);
    let (there, value) = walk(&path.map(|f| q * f * q.transpose()));
    assert!((there - here.rotated(&q)).norm() < 1e-12 * 5e6 * 0.03);
    assert!(value < 1e-9 * 1e3);
}

#[test]
fn motions_out_of_the_plane_are_refused() {
    let spec = CohesiveCamClaySpec { invariants: StressInvariants::Plane, ..slab() };
    let law = spec.build().unwrap();
    let start = InitialCondition { stress: SymTensor::ZERO, density: 250.0 };
    let (mut stresses, mut states) = law.initial(&[start]).unwrap();
    let f = Mat3([[1.0, 0.0, 1e-3], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let motion = Motion::from_deformation(&f, 1.0, 250.0, 1.0).unwrap();
    let refused = law.update(&[motion], &mut stresses, &mut states.blocks_mut()[0]);
    assert!(refused.unwrap_err().to_string().contains("leaves the plane"));
}
