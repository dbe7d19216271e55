//! Vectors of points and nodes.

use colluvium_grid::Vector4;

/// Components of a vector times `factor`, and a fourth number.
#[inline(always)]
pub fn vector4<const D: usize>(vector: &[f64; D], factor: f64, fourth: f64) -> Vector4 {
    let mut values = [0.0; 4];
    (0..D).for_each(|c| values[c] = factor * vector[c]);
    values[3] = fourth;
    Vector4::new(values)
}

/// Square of the length of a vector.
#[inline(always)]
pub fn square<const D: usize>(vector: &[f64; D]) -> f64 {
    vector.iter().map(|c| c * c).sum()
}
