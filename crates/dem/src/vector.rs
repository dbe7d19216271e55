//! Vectors of `D` components, rotations of `R` components: one in the plane, three in space.
//!
//! What lies across a contact normal `n` is kept in *tangent coordinates*, of `R` components as well: in the plane the
//! component along `t = (-n_y, n_x)`, in space the vector itself.

#[inline(always)]
pub fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    let mut sum = 0.0;
    for c in 0..N {
        sum += a[c] * b[c];
    }
    sum
}

#[inline(always)]
pub fn norm<const N: usize>(a: &[f64; N]) -> f64 {
    dot(a, a).sqrt()
}

#[inline(always)]
pub fn minus<const N: usize>(a: &[f64; N], b: &[f64; N]) -> [f64; N] {
    std::array::from_fn(|c| a[c] - b[c])
}

#[inline(always)]
pub fn times<const N: usize>(s: f64, a: &[f64; N]) -> [f64; N] {
    std::array::from_fn(|c| s * a[c])
}

#[inline(always)]
pub fn add<const N: usize>(a: &mut [f64; N], s: f64, b: &[f64; N]) {
    for c in 0..N {
        a[c] += s * b[c];
    }
}

#[inline(always)]
fn cross<const A: usize, const B: usize, const C: usize>(a: &[f64; A], b: &[f64; B]) -> [f64; C] {
    let mut out = [0.0; C];
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
    out
}

/// What of a vector lies across `n`, in tangent coordinates.
#[inline(always)]
pub fn across<const D: usize, const R: usize>(v: &[f64; D], n: &[f64; D]) -> [f64; R] {
    let mut out = [0.0; R];
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
pub fn turned<const D: usize, const R: usize>(spin: &[f64; R], n: &[f64; D]) -> [f64; R] {
    if D == 2 { *spin } else { cross(spin, n) }
}

/// `n × f` of a force in tangent coordinates.
#[inline(always)]
pub fn moment<const D: usize, const R: usize>(n: &[f64; D], f: &[f64; R]) -> [f64; R] {
    if D == 2 { *f } else { cross(n, f) }
}

/// The vector with these tangent coordinates.
#[inline(always)]
pub fn spread<const D: usize, const R: usize>(f: &[f64; R], n: &[f64; D]) -> [f64; D] {
    let mut out = [0.0; D];
    if D == 2 {
        out[0] = -f[0] * n[1];
        out[1] = f[0] * n[0];
    } else {
        out.iter_mut().zip(f).for_each(|(to, from)| *to = *from);
    }
    out
}

/// Component along `n` of a rotation; none in the plane.
#[inline(always)]
pub fn along<const D: usize, const R: usize>(spin: &[f64; R], n: &[f64; D]) -> f64 {
    if D == 2 {
        return 0.0;
    }
    let mut sum = 0.0;
    for c in 0..D {
        sum += spin[c] * n[c];
    }
    sum
}

/// Turns what was across the normal of a step ago into the plane across `n`, its length kept, and about `n` by `angle`
/// (rad): in the plane it keeps its coordinate (sheet: dem §2.4).
#[inline(always)]
pub fn follow<const D: usize, const R: usize>(v: &[f64; R], n: &[f64; D], angle: f64) -> [f64; R] {
    if D == 2 {
        return *v;
    }
    let square = dot(v, v);
    if square == 0.0 {
        return *v;
    }
    let off = along(v, n);
    let mut out = *v;
    for c in 0..D {
        out[c] -= off * n[c];
    }
    let left = dot(&out, &out);
    // Turned by a right angle within a step nothing is left of it.
    let scale = if left > 1e-12 * square { (square / left).sqrt() } else { 0.0 };
    let mut out = times(scale, &out);
    if angle != 0.0 {
        let side: [f64; R] = moment(n, &out);
        let (sin, cos) = angle.sin_cos();
        out = std::array::from_fn(|c| cos * out[c] + sin * side[c]);
    }
    out
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
            let flat = spread(&across::<2, 1>(&v, &n), &n);
            let solid: [f64; 3] = across(&[v[0], v[1], 0.0], &[n[0], n[1], 0.0]);
            for c in 0..2 {
                prop_assert!((flat[c] - solid[c]).abs() < 1e-14);
            }
            let flat = spread(&turned(&[spin], &n), &n);
            let solid: [f64; 3] = turned(&[0.0, 0.0, spin], &[n[0], n[1], 0.0]);
            prop_assert!((flat[0] - solid[0]).abs() + (flat[1] - solid[1]).abs() < 1e-14);
            let force = across::<2, 1>(&v, &n);
            let solid: [f64; 3] = moment(&[n[0], n[1], 0.0], &[v[0], v[1], 0.0]);
            prop_assert!((moment(&n, &force)[0] - solid[2]).abs() < 1e-14);
        }

        #[test]
        fn what_follows_the_normal_keeps_its_length(
            v in prop::array::uniform3(-1.0..1.0f64), n in prop::array::uniform3(-1.0..1.0f64), angle in -0.5..0.5f64,
        ) {
            prop_assume!(norm(&n) > 0.1 && norm(&v) > 0.1);
            let n = times(1.0 / norm(&n), &n);
            prop_assume!(dot(&v, &n).abs() < 0.9 * norm(&v));
            let out = follow(&v, &n, angle);
            prop_assert!((norm(&out) - norm(&v)).abs() < 1e-12 && dot(&out, &n).abs() < 1e-12);
        }
    }
}
