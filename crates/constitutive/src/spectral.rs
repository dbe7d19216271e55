//! Spectral decomposition of symmetric tensors (constitutive sheet §3.5).

use crate::{Mat3, SymTensor};

/// Principal values, the largest first, and their directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spectrum {
    /// Principal values in descending order.
    pub values: [f64; 3],
    /// Unit directions, right-handed: `directions[a]` belongs to `values[a]`.
    pub directions: [[f64; 3]; 3],
}

/// Below this relative gap the closed form loses its directions and iteration takes over.
const GAP: f64 = 1e-6;

/// Residual, relative to the tensor, above which the closed form is not trusted.
const RESIDUAL: f64 = 1e-10;

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl SymTensor {
    /// Principal values in descending order, by the trigonometric closed form.
    #[inline]
    pub fn principal_values(&self) -> [f64; 3] {
        let mean = self.trace() / 3.0;
        let s = self.deviator();
        let j2 = 0.5 * s.dot(&s);
        let radius = 2.0 * (j2 / 3.0).sqrt();
        if radius == 0.0 {
            return [mean; 3];
        }
        let cos3 = (4.0 * s.determinant() / (radius * radius * radius)).clamp(-1.0, 1.0);
        let angle = cos3.acos() / 3.0;
        let (sin, cos) = angle.sin_cos();
        // cos(θ), cos(θ - 2π/3), cos(θ + 2π/3)
        let half_root3 = 0.5 * 3f64.sqrt();
        [
            mean + radius * cos,
            mean + radius * (half_root3 * sin - 0.5 * cos),
            mean - radius * (half_root3 * sin + 0.5 * cos),
        ]
    }

    /// Principal values and directions.
    pub fn spectrum(&self) -> Spectrum {
        let [.., yz, zx] = self.0;
        if yz == 0.0 && zx == 0.0 {
            return self.planar_spectrum();
        }
        let values = self.principal_values();
        let size = values[0].abs().max(values[2].abs());
        let gap = (values[0] - values[1]).min(values[1] - values[2]);
        if gap > GAP * size
            && let Some(spectrum) = self.closed_form(values)
        {
            return spectrum;
        }
        self.iterated()
    }

    /// z is a principal direction: a 2×2 problem in closed form.
    fn planar_spectrum(&self) -> Spectrum {
        let [xx, yy, zz, xy, ..] = self.0;
        let (centre, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
        let radius = half.hypot(xy);
        let angle = 0.5 * xy.atan2(half);
        let (s, c) = angle.sin_cos();
        let mut pairs =
            [(centre + radius, [c, s, 0.0]), (centre - radius, [-s, c, 0.0]), (zz, [0.0, 0.0, 1.0])];
        pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
        Spectrum::right_handed(pairs)
    }

    fn closed_form(&self, values: [f64; 3]) -> Option<Spectrum> {
        let first = self.direction(values[0])?;
        let last = self.direction(values[2])?;
        // Two directions of a symmetric tensor are orthogonal; make them so to the last digit.
        let overlap = dot(first, last);
        let last = normalised(std::array::from_fn(|c| last[c] - overlap * first[c]))?;
        let spectrum = Spectrum { values, directions: [first, cross(last, first), last] };
        let scale = RESIDUAL * self.norm();
        let fits = (0..3).all(|a| {
            let image = self.apply(spectrum.directions[a]);
            (0..3).all(|c| (image[c] - values[a] * spectrum.directions[a][c]).abs() <= scale)
        });
        fits.then_some(spectrum)
    }

    /// Direction of a single eigenvalue: the longest cross product of two rows of `σ - λ 1`.
    fn direction(&self, value: f64) -> Option<[f64; 3]> {
        let rows = (*self - Self::isotropic(value)).to_matrix().0;
        let products = [cross(rows[0], rows[1]), cross(rows[1], rows[2]), cross(rows[2], rows[0])];
        let longest = products.into_iter().max_by(|a, b| dot(*a, *a).total_cmp(&dot(*b, *b)))?;
        normalised(longest)
    }

    fn iterated(&self) -> Spectrum {
        let m = self.to_matrix().0;
        let eigen = nalgebra::Matrix3::from_fn(|i, j| m[i][j]).symmetric_eigen();
        let mut pairs: [(f64, [f64; 3]); 3] = std::array::from_fn(|a| {
            (eigen.eigenvalues[a], std::array::from_fn(|c| eigen.eigenvectors[(c, a)]))
        });
        pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
        Spectrum::right_handed(pairs)
    }
}

fn normalised(v: [f64; 3]) -> Option<[f64; 3]> {
    let length = dot(v, v).sqrt();
    (length > 0.0 && length.is_finite()).then(|| v.map(|c| c / length))
}

impl Spectrum {
    fn right_handed(pairs: [(f64, [f64; 3]); 3]) -> Self {
        let [first, second, _] = pairs.map(|(_, direction)| direction);
        Self { values: pairs.map(|(value, _)| value), directions: [first, second, cross(first, second)] }
    }

    /// The tensor with other principal values in the same directions.
    #[inline]
    pub fn compose(&self, values: [f64; 3]) -> SymTensor {
        let mut out = SymTensor::ZERO;
        for (value, n) in values.into_iter().zip(self.directions) {
            for (k, &(i, j)) in crate::tensor::PAIRS.iter().enumerate() {
                out[k] += value * n[i] * n[j];
            }
        }
        out
    }

    /// The directions as the columns of a rotation.
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
        assert!(error <= 1e-9 * size, "{tensor:?} is rebuilt with error {error}");
        let q = spectrum.rotation();
        let unit = q.transpose() * q - Mat3::IDENTITY;
        assert!(unit.0.iter().flatten().all(|e| e.abs() < 1e-12), "orthonormal");
        assert!((q.determinant() - 1.0).abs() < 1e-12, "right-handed");
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

    #[test]
    fn zero_and_isotropic_tensors_are_decomposed() {
        is_decomposition_of(SymTensor::ZERO);
        is_decomposition_of(SymTensor::isotropic(-3.0));
        is_decomposition_of(SymTensor([1.0, 1.0, 1.0, 0.0, 1e-300, 0.0]));
    }
}
