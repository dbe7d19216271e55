//! Spectral decomposition of symmetric tensors (sheet: constitutive §3.5).

use crate::{Mat3, SymTensor};

/// Spectral decomposition: principal values, the largest first, and their directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spectrum {
    /// Principal values in descending order.
    pub values: [f64; 3],
    /// Unit directions, right-handed: `directions[a]` belongs to `values[a]`.
    pub directions: [[f64; 3]; 3],
}

/// Vector product.
#[inline(always)]
fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Scalar product.
#[inline(always)]
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Largest root of `x³ - 3x - 2c` for `0 ≤ c ≤ 1`, that is `2 cos(acos(c)/3)`, between √3 and 2.
#[inline(always)]
fn largest_root(c: f64) -> f64 {
    let root3 = 3f64.sqrt();
    let mut x = root3 + c * (1.0 / 3.0 + c * (5.0 / 3.0 - root3));
    // Newton's method from an error of 3e-3: three steps reach the last digit.
    for _ in 0..3 {
        let square = x * x;
        x -= (x * (square - 3.0) - 2.0 * c) / (3.0 * (square - 1.0));
    }
    x
}

/// Eigenvalue of largest magnitude of a deviator, as multiple `x` of the radius `√(J2/3)`.
#[derive(Clone, Copy)]
struct ExtremeEigenvalue {
    radius: f64,
    multiple: f64,
    is_largest: bool,
}

/// Eigenvalue of largest magnitude of a deviator (Pa), by the trigonometric formula; `None` for a zero deviator.
fn extreme_eigenvalue(deviator: &SymTensor) -> Option<ExtremeEigenvalue> {
    let j2 = 0.5 * deviator.dot(deviator);
    let radius = (j2 / 3.0).sqrt();
    if radius <= 0.0 {
        return None;
    }
    let cos3 = deviator.determinant() / (2.0 * radius * radius * radius);
    let multiple = largest_root(cos3.abs().min(1.0));
    Some(ExtremeEigenvalue { radius, multiple, is_largest: cos3 >= 0.0 })
}

/// Rotation `(cos, sin)` to the eigenvector of the larger eigenvalue of `[[a, c], [c, b]]`, and both
/// eigenvalues, the larger first.
#[inline(always)]
fn planar_eigen(a: f64, b: f64, c: f64) -> ([f64; 2], [f64; 2]) {
    let (centre, half) = (0.5 * (a + b), 0.5 * (a - b));
    let radius = (half * half + c * c).sqrt();
    // Of the two forms of the eigenvector, the one without cancellation.
    let longer = half.abs() + radius;
    let (x, y) = if half >= 0.0 { (longer, c) } else { (c, longer) };
    let length = (x * x + y * y).sqrt();
    let apart = length > 0.0;
    let (cos, sin) = (x / length, y / length);
    ([if apart { cos } else { 1.0 }, if apart { sin } else { 0.0 }], [centre + radius, centre - radius])
}

/// Longest of three vectors, normalised.
#[inline(always)]
fn longest_unit(vectors: [[f64; 3]; 3]) -> [f64; 3] {
    let [a, b, c] = vectors;
    let (la, lb, lc) = (dot(a, a), dot(b, b), dot(c, c));
    let first = la >= lb;
    let (x, y, z, l) = if first { (a[0], a[1], a[2], la) } else { (b[0], b[1], b[2], lb) };
    let second = l >= lc;
    let (x, y, z, l) = if second { (x, y, z, l) } else { (c[0], c[1], c[2], lc) };
    let length = l.sqrt();
    [x / length, y / length, z / length]
}

impl SymTensor {
    /// Principal values in descending order, from the invariants. Distinct ones are accurate to round-off of the deviator, two equal ones
    /// to half the digits.
    #[inline]
    pub fn principal_values(&self) -> [f64; 3] {
        let mean = self.trace() / 3.0;
        let Some(ExtremeEigenvalue { radius, multiple, is_largest }) = extreme_eigenvalue(&self.deviator())
        else {
            return [mean; 3];
        };
        let far = radius * multiple;
        let gap = radius * (12.0 - 3.0 * multiple * multiple).max(0.0).sqrt();
        let (high, low) = (0.5 * (gap - far), 0.5 * (-gap - far));
        if is_largest { [mean + far, mean + high, mean + low] } else { [mean - low, mean - high, mean - far] }
    }

    /// Whether the third axis is a principal axis, without a branch.
    #[inline(always)]
    pub(crate) fn lies_in_plane(&self) -> bool {
        (self.0[4] == 0.0) & (self.0[5] == 0.0)
    }

    /// Smallest principal value of a tensor with the third axis as principal axis, for loops over many tensors.
    #[inline(always)]
    pub(crate) fn least_principal_value_in_plane(&self) -> f64 {
        let [xx, yy, zz, xy, ..] = self.0;
        let (centre, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        (centre - (half * half + xy * xy).sqrt()).min(zz)
    }

    /// Greatest principal value of a tensor with the third axis as principal axis, for loops over many tensors.
    #[inline(always)]
    pub(crate) fn greatest_principal_value_in_plane(&self) -> f64 {
        -(-*self).least_principal_value_in_plane()
    }

    /// Smallest value of [`SymTensor::principal_values`], for loops over many tensors.
    #[inline(always)]
    pub(crate) fn least_principal_value(&self) -> f64 {
        self.principal_values_without_branches()[2]
    }

    /// Greatest value of [`SymTensor::principal_values`], for loops over many tensors.
    #[inline(always)]
    pub(crate) fn greatest_principal_value(&self) -> f64 {
        self.principal_values_without_branches()[0]
    }

    /// Branch-free [`SymTensor::principal_values`] for loops over many tensors.
    #[inline(always)]
    pub(crate) fn principal_values_without_branches(&self) -> [f64; 3] {
        let mean = self.trace() / 3.0;
        let deviator = self.deviator();
        let radius = (0.5 * deviator.dot(&deviator) / 3.0).sqrt();
        let cos3 = deviator.determinant() / (2.0 * radius * radius * radius);
        let multiple = largest_root(cos3.abs().min(1.0));
        let far = radius * multiple;
        let gap = radius * (12.0 - 3.0 * multiple * multiple).max(0.0).sqrt();
        let (high, low) = (0.5 * (gap - far), 0.5 * (-gap - far));
        let value = |if_largest: f64, if_smallest: f64| {
            let shifted = if cos3 >= 0.0 { mean + if_largest } else { mean - if_smallest };
            if radius <= 0.0 { mean } else { shifted }
        };
        [value(far, low), value(high, high), value(low, far)]
    }

    /// Principal values and directions, accurate to round-off of the deviator also for equal values. The eigenvalue of largest magnitude
    /// follows from Newton's method, its direction from a vector product, the others from the plane normal to it.
    #[inline]
    pub fn spectrum(&self) -> Spectrum {
        self.spectrum_without_branches()
    }

    /// Branch-free [`SymTensor::spectrum`] for loops over many tensors.
    #[inline(always)]
    pub(crate) fn spectrum_without_branches(&self) -> Spectrum {
        let mean = self.trace() / 3.0;
        let [xx, yy, zz, xy, yz, zx] = self.deviator().0;
        let size = xx.abs().max(yy.abs()).max(zz.abs()).max(xy.abs()).max(yz.abs()).max(zx.abs());
        let scale = 1.0 / size;
        let scaled = Self([xx * scale, yy * scale, zz * scale, xy * scale, yz * scale, zx * scale]);
        // Close to an isotropic tensor the trace of the deviator is round-off as large as the deviator.
        let s = scaled.deviator();
        let radius = (0.5 * s.dot(&s) / 3.0).sqrt();
        // Also false where the tensor is not finite.
        let regular = (size < f64::MAX) & (size > 0.0) & (radius > 0.0);
        let shift = if regular { mean + size * scaled.trace() / 3.0 } else { mean };

        let cos3 = s.determinant() / (2.0 * radius * radius * radius);
        let largest = cos3 >= 0.0;
        let far = radius * largest_root(cos3.abs().min(1.0));
        let far = if largest { far } else { -far };
        let [xx, yy, zz, xy, yz, zx] = s.0;
        let rows = [[xx - far, xy, zx], [xy, yy - far, yz], [zx, yz, zz - far]];
        let w = longest_unit([cross(rows[0], rows[1]), cross(rows[1], rows[2]), cross(rows[2], rows[0])]);
        let leans = w[0].abs() > w[1].abs();
        let across = if leans { w[0] } else { w[1] };
        let length = (w[2] * w[2] + across * across).sqrt();
        let (p, q) = (w[2] / length, across / length);
        let u = [if leans { -p } else { 0.0 }, if leans { 0.0 } else { p }, if leans { q } else { -q }];
        let v = cross(w, u);
        let (sw, su, sv) = (s.apply(w), s.apply(u), s.apply(v));
        let ([cos, sin], [high, low]) = planar_eigen(dot(u, su), dot(v, sv), dot(u, sv));
        let far = dot(w, sw);
        let first = [cos * u[0] + sin * v[0], cos * u[1] + sin * v[1], cos * u[2] + sin * v[2]];
        let second = [cos * v[0] - sin * u[0], cos * v[1] - sin * u[1], cos * v[2] - sin * u[2]];

        let value = |a: f64, b: f64| if regular { shift + size * if largest { a } else { b } } else { shift };
        let along = |a: f64, b: f64, unit: f64| {
            let chosen = if largest { a } else { b };
            if regular { chosen } else { unit }
        };
        Spectrum {
            values: [value(far, high), value(high, low), value(low, far)],
            directions: [
                [along(w[0], first[0], 1.0), along(w[1], first[1], 0.0), along(w[2], first[2], 0.0)],
                [
                    along(first[0], second[0], 0.0),
                    along(first[1], second[1], 1.0),
                    along(first[2], second[2], 0.0),
                ],
                [along(second[0], w[0], 0.0), along(second[1], w[1], 0.0), along(second[2], w[2], 1.0)],
            ],
        }
    }
}

impl Spectrum {
    /// Tensor with given principal values in the directions of this spectrum.
    #[inline]
    pub fn compose(&self, values: [f64; 3]) -> SymTensor {
        let mut out = SymTensor::ZERO;
        for (value, n) in values.into_iter().zip(self.directions) {
            for (k, &(i, j)) in crate::tensors::tensor::PAIRS.iter().enumerate() {
                out[k] += value * n[i] * n[j];
            }
        }
        out
    }

    /// Rotation with the directions as columns.
    pub fn rotation(&self) -> Mat3 {
        Mat3(self.directions).transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn is_decomposition_of(tensor: SymTensor) {
        let spectrum = tensor.spectrum();
        let size = tensor.norm().max(f64::MIN_POSITIVE);
        let [a, b, c] = spectrum.values;
        assert!(a >= b && b >= c, "descending: {:?}", spectrum.values);
        let error = (spectrum.compose(spectrum.values) - tensor).norm();
        assert!(error <= 1e-14 * size, "{tensor:?} is rebuilt with error {error}");
        let q = spectrum.rotation();
        let unit = q.transpose() * q - Mat3::IDENTITY;
        assert!(unit.0.iter().flatten().all(|e| e.abs() < 1e-14), "orthonormal");
        assert!((q.determinant() - 1.0).abs() < 1e-14, "right-handed");
    }

    fn component() -> impl Strategy<Value = f64> {
        prop_oneof![-1e3..1e3f64, -1e-6..1e-6f64, Just(0.0), -1e9..1e9f64]
    }

    proptest! {
        #[test]
        fn any_tensor_is_decomposed(c in [component(), component(), component(), component(), component(), component()]) {
            is_decomposition_of(SymTensor(c));
        }

        #[test]
        fn nearly_equal_principal_values_are_decomposed(gap in -1e-4..1e-4f64, scale in -12i32..1, angle in 0.0..3.0f64) {
            let (s, c) = angle.sin_cos();
            let q = Mat3::rotation_z(angle) * Mat3([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]);
            let gap = gap * 10f64.powi(scale);
            is_decomposition_of(SymTensor::diagonal(-100.0, -100.0 + gap, -50.0).rotated(&q));
            is_decomposition_of(SymTensor::diagonal(-100.0, -100.0 + gap, -100.0 - gap).rotated(&q));
        }
    }

    proptest! {
        #[test]
        fn isotropic_tensors_with_round_off_are_decomposed(mean in -1e5..1e5f64, noise in proptest::array::uniform6(-3i32..4)) {
            let ulp = mean.abs() * f64::EPSILON;
            let tensor = SymTensor(std::array::from_fn(|k| if k < 3 { mean } else { 0.0 } + f64::from(noise[k]) * ulp));
            is_decomposition_of(tensor);
        }
    }

    proptest! {
        #[test]
        fn principal_values_without_branches_have_the_same_bits(c in [component(), component(), component(), component(), component(), component()]) {
            for tensor in [SymTensor(c), SymTensor::isotropic(c[0])] {
                let values = tensor.principal_values();
                prop_assert_eq!(tensor.principal_values_without_branches().map(f64::to_bits), values.map(f64::to_bits));
            }
            let [xx, yy, zz, xy, ..] = c;
            let plane = SymTensor([xx, yy, zz, xy, 0.0, 0.0]);
            let close = |found: f64, exact: f64| (found - exact).abs() <= 1e-7 * plane.norm();
            prop_assert!(close(plane.greatest_principal_value_in_plane(), plane.principal_values()[0]));
            prop_assert!(close(plane.least_principal_value_in_plane(), plane.principal_values()[2]));
        }
    }

    #[test]
    fn zero_and_isotropic_tensors_are_decomposed() {
        is_decomposition_of(SymTensor::ZERO);
        is_decomposition_of(SymTensor::isotropic(-3.0));
        is_decomposition_of(SymTensor([1.0, 1.0, 1.0, 0.0, 1e-300, 0.0]));
    }
}
