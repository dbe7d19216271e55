//! Small linear algebra of rigid motion: three components of translation and three of rotation.

use colluvium_points::surface::{RigidTransform, cross, dot};
use nalgebra::{SMatrix, SVector};

/// Velocity and angular velocity, or force and moment: three components of translation, then three of rotation.
pub type Twist = [f64; 6];

/// Axes of a body without rotation.
pub const IDENTITY_AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Product of a matrix and a vector.
pub fn multiply<const N: usize>(matrix: &[[f64; N]; N], vector: &[f64; N]) -> [f64; N] {
    std::array::from_fn(|i| (0..N).map(|j| matrix[i][j] * vector[j]).sum())
}

/// Transposed matrix.
pub fn transposed(matrix: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|j| matrix[j][i]))
}

/// Velocity (m/s) at an arm (m) from the reference point of a motion with velocity and angular velocity (rad/s).
pub fn velocity_at(motion: &Twist, arm: &[f64; 3]) -> [f64; 3] {
    let [vx, vy, vz, wx, wy, wz] = *motion;
    let turn = cross(&[wx, wy, wz], arm);
    [vx + turn[0], vy + turn[1], vz + turn[2]]
}

/// Resultant and moment about the reference point of a vector at an arm (m).
pub fn wrench_at(vector: &[f64; 3], arm: &[f64; 3]) -> Twist {
    let moment = cross(arm, vector);
    [vector[0], vector[1], vector[2], moment[0], moment[1], moment[2]]
}

/// Rotation matrix of the rotation vector `turn`, whose length is the angle (rad).
pub fn rotation(turn: &[f64; 3]) -> [[f64; 3]; 3] {
    RigidTransform::rotation_about([0.0; 3], *turn, dot(turn, turn).sqrt()).rotation
}

/// Solution of `matrix · x = right` in the components that are `free`, with zeros in the others; `None` for a singular matrix.
pub fn solve(matrix: &[Twist; 6], right: &Twist, free: &[bool; 6]) -> Option<Twist> {
    let entry = |i: usize, j: usize| match (free[i] && free[j], i == j) {
        (true, _) => matrix[i][j],
        (false, true) => 1.0,
        (false, false) => 0.0,
    };
    let right = SVector::<f64, 6>::from_fn(|i, _| if free[i] { right[i] } else { 0.0 });
    let x = SMatrix::<f64, 6, 6>::from_fn(entry).lu().solve(&right)?;
    x.iter().all(|x| x.is_finite()).then(|| x.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_system_with_held_components_is_solved_in_the_others() {
        let matrix: [Twist; 6] = std::array::from_fn(|i| {
            std::array::from_fn(|j| if i == j { 4.0 } else { 1.0 / (1.0 + i as f64 + 2.0 * j as f64) })
        });
        let free = [true, false, true, true, false, true];
        let right = [1.0, 2.0, -3.0, 0.5, 9.0, 4.0];
        let x = solve(&matrix, &right, &free).unwrap();
        assert_eq!((x[1], x[4]), (0.0, 0.0));
        let back = multiply(&matrix, &x);
        for i in (0..6).filter(|i| free[*i]) {
            assert!((back[i] - right[i]).abs() < 1e-14, "{i}: {back:?}");
        }
    }

    #[test]
    fn a_rotation_preserves_lengths_and_its_axis() {
        let turn = [0.3, -0.7, 1.1];
        let matrix = rotation(&turn);
        let kept = multiply(&matrix, &turn);
        assert!((0..3).all(|c| (kept[c] - turn[c]).abs() < 1e-15));
        let turned = multiply(&matrix, &[1.0, 2.0, 3.0]);
        assert!((turned.iter().map(|c| c * c).sum::<f64>() - 14.0).abs() < 1e-14);
        let quarter = multiply(&rotation(&[0.0, 0.0, 0.5 * std::f64::consts::PI]), &[1.0, 0.0, 0.0]);
        assert!((quarter[0].abs() + (quarter[1] - 1.0).abs()) < 1e-15, "{quarter:?}");
    }
}
