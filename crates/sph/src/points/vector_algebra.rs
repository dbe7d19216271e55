//! Operations on vectors and stresses.

use colluvium_constitutive::SymTensor;

/// Square of the length of a vector.
pub fn square<const N: usize>(vector: &[f64; N]) -> f64 {
    vector.iter().map(|c| c * c).sum()
}

/// Scalar product of two vectors.
#[inline]
pub fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Separation `x_j - x_i` and its square.
#[inline(always)]
pub fn separation<const D: usize>(from: &[f64; D], to: &[f64; D]) -> ([f64; D], f64) {
    let apart: [f64; D] = std::array::from_fn(|c| to[c] - from[c]);
    let square = apart.iter().map(|c| c * c).sum();
    (apart, square)
}

/// Mirrored stress `H σ H` with `H = diag flip`.
#[inline]
pub fn mirrored_stress<const D: usize>(stress: &SymTensor, flip: &[f64; D]) -> SymTensor {
    let sign = |c: usize| if c < D { flip[c] } else { 1.0 };
    let [xx, yy, zz, xy, yz, zx] = stress.0;
    let (x, y, z) = (sign(0), sign(1), sign(2));
    SymTensor([xx, yy, zz, x * y * xy, y * z * yz, z * x * zx])
}

/// Stress with its shear on faces normal to `axis` multiplied by `factor`.
pub fn with_scaled_shear(stress: &SymTensor, axis: usize, factor: f64) -> SymTensor {
    let [xx, yy, zz, xy, yz, zx] = stress.0;
    let f = |a: usize, b: usize| if a == axis || b == axis { factor } else { 1.0 };
    SymTensor([xx, yy, zz, f(0, 1) * xy, f(1, 2) * yz, f(2, 0) * zx])
}

/// Geostatic stress `diag(K₀, K₀, 1)` times `vertical`, rotated to the direction `up`.
pub fn geostatic_stress<const D: usize>(vertical: f64, k0: f64, up: &[f64; D]) -> SymTensor {
    let along = |a: usize, b: usize| if a < D && b < D { up[a] * up[b] } else { 0.0 };
    let value = |a: usize, b: usize| vertical * (if a == b { k0 } else { 0.0 } + (1.0 - k0) * along(a, b));
    SymTensor([value(0, 0), value(1, 1), value(2, 2), value(0, 1), value(1, 2), value(2, 0)])
}
