//! Vectors of points and nodes.

use colluvium_grid::Vector4;

/// Returns the vector of a space vector and a fourth number.
#[inline(always)]
pub fn vector4<const D: usize>(vector: &[f64; D], fourth: f64) -> Vector4 {
    let at = |c: usize| if c < D { vector[c] } else { 0.0 };
    Vector4::new([at(0), at(1), at(2), fourth])
}

/// Scalar product.
pub fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Length of a vector.
pub fn norm(a: &[f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// First three components.
pub fn first_three(lanes: Vector4) -> [f64; 3] {
    let [x, y, z, _] = lanes.to_array();
    [x, y, z]
}

/// Square of the length of a vector.
pub fn square<const D: usize>(vector: &[f64; D]) -> f64 {
    vector.iter().map(|c| c * c).sum()
}

/// Sum of the squares of vectors.
pub fn square_sum<const D: usize>(vectors: &[[f64; D]]) -> f64 {
    vectors.as_flattened().iter().map(|c| c * c).sum()
}

/// Power of forces (N) on points that move (m/s).
pub fn power<const D: usize>(forces: &[[f64; D]], velocities: &[[f64; D]]) -> f64 {
    forces
        .as_flattened()
        .iter()
        .zip(velocities.as_flattened())
        .map(|(force, velocity)| force * velocity)
        .sum()
}
