//! Vectors of `D` components, rotations of `R` components: one in the plane, three in space.
//!
//! Tangential vectors at a contact normal `n` are stored in *tangent coordinates*, of `R` components as well: in the plane the
//! component along `t = (-n_y, n_x)`, in space the vector itself.
//!
//! A component is a [`SimdNumber`]: one number, or those of four contacts at once.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use wide::f64x4;

/// Number of contacts in a SIMD vector.
pub const WIDTH: usize = 4;

/// Number type of a component: scalar or SIMD vector.
pub trait SimdNumber:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    /// Vector with the same number in all lanes.
    fn broadcast(value: f64) -> Self;
    /// Square root.
    fn root(self) -> Self;
    /// The number, or zero if it is negative.
    fn or_zero(self) -> Self;
    /// `above` if the number is greater than `limit`, else `otherwise`.
    fn select_above(self, limit: Self, above: Self, otherwise: Self) -> Self;
}

impl SimdNumber for f64 {
    #[inline(always)]
    fn broadcast(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn root(self) -> Self {
        self.sqrt()
    }
    #[inline(always)]
    fn or_zero(self) -> Self {
        self.max(0.0)
    }
    #[inline(always)]
    fn select_above(self, limit: Self, above: Self, otherwise: Self) -> Self {
        if self > limit { above } else { otherwise }
    }
}

impl SimdNumber for f64x4 {
    #[inline(always)]
    fn broadcast(value: f64) -> Self {
        Self::splat(value)
    }
    #[inline(always)]
    fn root(self) -> Self {
        self.sqrt()
    }
    #[inline(always)]
    fn or_zero(self) -> Self {
        self.fast_max(Self::ZERO)
    }
    #[inline(always)]
    fn select_above(self, limit: Self, above: Self, otherwise: Self) -> Self {
        self.simd_gt(limit).bitselect(above, otherwise)
    }
}

/// Scalar product.
#[inline(always)]
pub fn dot<const N: usize, T: SimdNumber>(a: &[T; N], b: &[T; N]) -> T {
    let mut sum = a[0] * b[0];
    for c in 1..N {
        sum += a[c] * b[c];
    }
    sum
}

/// Euclidean norm.
#[inline(always)]
pub fn norm<const N: usize>(a: &[f64; N]) -> f64 {
    dot(a, a).sqrt()
}

/// Difference `a - b`.
#[inline(always)]
pub fn difference<const N: usize, T: SimdNumber>(a: &[T; N], b: &[T; N]) -> [T; N] {
    std::array::from_fn(|c| a[c] - b[c])
}

/// Vector times a factor.
#[inline(always)]
pub fn scaled<const N: usize, T: SimdNumber>(s: T, a: &[T; N]) -> [T; N] {
    std::array::from_fn(|c| s * a[c])
}

/// Adds `s b` to `a`.
#[inline(always)]
pub fn add<const N: usize, T: SimdNumber>(a: &mut [T; N], s: T, b: &[T; N]) {
    for c in 0..N {
        a[c] += s * b[c];
    }
}

/// Vector product; in the plane, with scalars as vectors normal to it.
#[inline(always)]
pub fn cross<const A: usize, const B: usize, const C: usize, T: SimdNumber>(
    a: &[T; A],
    b: &[T; B],
) -> [T; C] {
    let mut out = [T::broadcast(0.0); C];
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
    out
}

/// Tangential part of a vector at a surface with normal `n`, in tangent coordinates.
#[inline(always)]
pub fn tangential_part<const D: usize, const R: usize, T: SimdNumber>(v: &[T; D], n: &[T; D]) -> [T; R] {
    let mut out = [T::broadcast(0.0); R];
    if D == 2 {
        out[0] = v[1] * n[0] - v[0] * n[1];
    } else {
        let along = dot(v, n);
        for c in 0..D {
            out[c] = v[c] - along * n[c];
        }
    }
    out
}

/// `ω × n` in tangent coordinates.
#[inline(always)]
pub fn spin_cross_normal<const D: usize, const R: usize, T: SimdNumber>(spin: &[T; R], n: &[T; D]) -> [T; R] {
    if D == 2 { *spin } else { cross(spin, n) }
}

/// Moment `n × f` of a force in tangent coordinates.
#[inline(always)]
pub fn moment<const D: usize, const R: usize, T: SimdNumber>(n: &[T; D], f: &[T; R]) -> [T; R] {
    if D == 2 { *f } else { cross(n, f) }
}

/// Vector from its tangent coordinates.
#[inline(always)]
pub fn from_tangential<const D: usize, const R: usize, T: SimdNumber>(f: &[T; R], n: &[T; D]) -> [T; D] {
    let mut out = [T::broadcast(0.0); D];
    if D == 2 {
        out[0] = -f[0] * n[1];
        out[1] = f[0] * n[0];
    } else {
        out.iter_mut().zip(f).for_each(|(to, from)| *to = *from);
    }
    out
}

/// Component of a rotation along `n`; zero in the plane.
#[inline(always)]
pub fn normal_spin<const D: usize, const R: usize, T: SimdNumber>(spin: &[T; R], n: &[T; D]) -> T {
    if D == 2 {
        return T::broadcast(0.0);
    }
    let mut sum = spin[0] * n[0];
    for c in 1..D {
        sum += spin[c] * n[c];
    }
    sum
}

/// Rotates a tangential vector of the last step into the plane normal to `n`, at constant length, and about `n` by `angle` (rad). In the
/// plane its coordinate is unchanged (sheet: dem §2.4). The angle is exact up to its fifth power, the length exactly.
#[inline(always)]
pub fn rotate_with_normal<const D: usize, const R: usize, T: SimdNumber>(
    v: &[T; R],
    n: &[T; D],
    angle: T,
) -> [T; R] {
    if D == 2 {
        return *v;
    }
    let (square, off) = (dot(v, v), normal_spin(v, n));
    // The square of the remaining in-plane length, and the tangent of the angle.
    let left = square - off * off;
    let tangent = angle + angle * angle * angle * T::broadcast(1.0 / 3.0);
    let grown = left * (T::broadcast(1.0) + tangent * tangent);
    // For a rotation by a right angle within a step nothing remains.
    let kept = left.select_above(T::broadcast(1e-12) * square, square / grown, T::broadcast(0.0)).root();
    let side: [T; R] = moment(n, v);
    std::array::from_fn(|c| kept * (v[c] - off * n[c] + tangent * side[c]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn tangent_coordinates_are_those_of_the_vector_across(
            v in prop::array::uniform2(-1.0..1.0f64), angle in 0.0..6.0f64, spin in -2.0..2.0f64,
        ) {
            let n = [angle.cos(), angle.sin()];
            let flat = from_tangential(&tangential_part::<2, 1, f64>(&v, &n), &n);
            let solid: [f64; 3] = tangential_part(&[v[0], v[1], 0.0], &[n[0], n[1], 0.0]);
            for c in 0..2 {
                prop_assert!((flat[c] - solid[c]).abs() < 1e-14);
            }
            let flat = from_tangential(&spin_cross_normal(&[spin], &n), &n);
            let solid: [f64; 3] = spin_cross_normal(&[0.0, 0.0, spin], &[n[0], n[1], 0.0]);
            prop_assert!((flat[0] - solid[0]).abs() + (flat[1] - solid[1]).abs() < 1e-14);
            let force = tangential_part::<2, 1, f64>(&v, &n);
            let solid: [f64; 3] = moment(&[n[0], n[1], 0.0], &[v[0], v[1], 0.0]);
            prop_assert!((moment(&n, &force)[0] - solid[2]).abs() < 1e-14);
        }

        #[test]
        fn vectors_rotated_with_the_normal_keep_their_length_and_stay_tangential(
            v in prop::array::uniform3(-1.0..1.0f64), n in prop::array::uniform3(-1.0..1.0f64), angle in -0.5..0.5f64,
        ) {
            prop_assume!(norm(&n) > 0.1 && norm(&v) > 0.1);
            let n = scaled(1.0 / norm(&n), &n);
            prop_assume!(dot(&v, &n).abs() < 0.9 * norm(&v));
            let out = rotate_with_normal(&v, &n, angle);
            prop_assert!((norm(&out) - norm(&v)).abs() < 1e-12 && dot(&out, &n).abs() < 1e-12);
        }
    }
}
