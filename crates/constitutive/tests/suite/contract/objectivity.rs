//! Objectivity and isotropy: rotated observers, permuted axes, and rigid rotations of the material.

use colluvium_constitutive::{Mat3, Motion};
use proptest::prelude::*;

use super::laws::{isotropic, solids};
use super::{Subject, gradients, value_of};

impl Subject {
    /// Compares a path with its rotation by `q`.
    ///
    /// A path may lead to where a law amplifies the round-off of its own input: a band whose direction is that of a principal
    /// stress hardly larger than another one. Differences of that size, measured by a path that differs in its last digits, are not
    /// due to the rotation.
    fn check_rotated_path(&self, path: &[Mat3], q: &Mat3) -> Result<(), String> {
        let (mut here, mut there) = (self.point(), self.point_at(self.start.rotated(q)));
        let mut near = self.point();
        let mut allowed = 0.0;
        for a in path {
            let motion = self.motion(a, 1e-2, here.density);
            let nearly = self.motion(&last_digits_changed(a), 1e-2, near.density);
            let before = self.stress_scale(&here, &motion);
            near = self.apply(&near, &nearly);
            (here, there) = (self.apply(&here, &motion), self.apply(&there, &rotated_motion(&motion, q)));
            let after = self.stress_scale(&here, &motion);
            // Pressure-dependent stiffness carries earlier differences along.
            let own = 1e-12 + self.law.stress_tolerance();
            allowed = allowed * (after / before).max(1.0) + own * before.max(after);
            let amplified = AMPLIFIED * (near.stress - here.stress).norm();
            let difference = (there.stress - here.stress.rotated(q)).norm();
            if difference > allowed + amplified {
                return Err(format!("{difference} of {allowed} and {amplified}"));
            }
        }
        Ok(())
    }
}

/// Allowed ratio of the difference by a rotation, which rounds each entry several times, to that by the last digits of the input.
const AMPLIFIED: f64 = 16.0;

/// Gradient with other last digits, not all in proportion.
fn last_digits_changed(a: &Mat3) -> Mat3 {
    let size = 2.0 * f64::EPSILON * a.0.as_flattened().iter().map(|c| c * c).sum::<f64>().sqrt();
    *a + Mat3([[1.0, -0.4, 0.7], [0.2, -0.9, 0.5], [-0.6, 0.3, 0.8]]) * size
}

/// Motion rotated by `q`.
fn rotated_motion(motion: &Motion, q: &Mat3) -> Motion {
    let rotated = |m: &Mat3| *q * *m * q.transpose();
    Motion {
        deformation: rotated(&motion.deformation),
        velocity_gradient_dt: rotated(&motion.velocity_gradient_dt),
        ..*motion
    }
}

fn rotation() -> impl Strategy<Value = Mat3> {
    (0.0..6.2f64, 0.0..6.2f64, 0.0..6.2f64).prop_map(|(a, b, c)| {
        let (s, k) = b.sin_cos();
        let tilt = Mat3([[1.0, 0.0, 0.0], [0.0, k, -s], [0.0, s, k]]);
        Mat3::rotation_z(a) * tilt * Mat3::rotation_z(c)
    })
}

/// Rotations that permute the axes, without reflections.
fn permutations() -> [Mat3; 3] {
    [
        Mat3([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]),
        Mat3([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
        Mat3([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn the_stress_rotates_with_the_observer(path in gradients(4, 0.1), q in rotation()) {
        for subject in isotropic() {
            let result = subject.check_rotated_path(&path, &q);
            prop_assert!(result.is_ok(), "{}: {}", subject.name(), result.unwrap_err());
        }
    }

    #[test]
    fn permuted_axes_permute_the_stress(path in gradients(3, 0.1), q in proptest::sample::select(permutations().to_vec())) {
        for subject in isotropic() {
            let result = subject.check_rotated_path(&path, &q);
            prop_assert!(result.is_ok(), "{}: {}", subject.name(), result.unwrap_err());
        }
    }

    #[test]
    fn a_rigid_rotation_rotates_the_stress(path in gradients(3, 0.05), axis in rotation(), angle in -3.0..3.0f64) {
        let q = axis * Mat3::rotation_z(angle) * axis.transpose();
        for subject in solids() {
            let point = subject.stopped(subject.end_of_path(&path, 1e-3));
            // The deformation alone: the step itself computes the spin.
            let motion = Motion::from_deformation(&q, 1e-3, point.density, 0.1).expect("less than half a turn");
            let after = subject.apply(&point, &motion);
            let difference = (after.stress - point.stress.rotated(&q)).norm();
            // A rotation is given to the last digit of its entries, which the stiffness turns into stress; a
            // rotation by nearly 180° is known no better than the tangent of its half.
            let modulus = value_of(&point, |stress, block, out| subject.law.wave_moduli(stress, block, out));
            let given = 32.0 * f64::EPSILON * modulus / (0.5 * angle).cos().powi(2);
            prop_assert!(difference <= 1e-12 * point.stress.norm() + given, "{}: {difference}", subject.name());
        }
    }
}
