//! Operations on vectors of `D` components.

/// Difference `a - b` of two vectors.
pub(crate) fn difference<const D: usize>(a: &[f64; D], b: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|c| a[c] - b[c])
}

/// Sum `a + t b` of a vector and a multiple of another one.
pub(crate) fn add_scaled<const D: usize>(a: &[f64; D], t: f64, b: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|c| a[c] + t * b[c])
}

/// Scalar product of two vectors.
pub fn dot<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    (0..D).map(|c| a[c] * b[c]).sum()
}

/// Unit vector of this direction; `None` for a vector without length.
pub(crate) fn unit<const D: usize>(a: &[f64; D]) -> Option<[f64; D]> {
    let length = dot(a, a).sqrt();
    (length > 0.0 && length.is_finite()).then(|| a.map(|c| c / length))
}

/// Vector product of two vectors in the plane, as its component normal to the plane.
pub(crate) fn cross_2d(a: &[f64; 2], b: &[f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

/// Vector product of two vectors.
pub fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
