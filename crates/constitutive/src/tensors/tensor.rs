//! Second-order tensors in three dimensions: [`SymTensor`] for stress and strain, [`Mat3`] for
//! deformation and velocity gradients.

use std::ops::{Add, AddAssign, Index, IndexMut, Mul, Neg, Sub, SubAssign};

use serde::{Deserialize, Serialize};

/// Row and column of each stored component: xx yy zz xy yz zx.
pub(crate) const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];

/// Symmetric second-order tensor, stored as xx yy zz xy yz zx with *tensor* shear components. It has the memory layout of its array.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
#[repr(transparent)]
pub struct SymTensor(pub [f64; 6]);

impl From<[f64; 6]> for SymTensor {
    fn from(components: [f64; 6]) -> Self {
        Self(components)
    }
}

impl From<SymTensor> for [f64; 6] {
    fn from(tensor: SymTensor) -> Self {
        tensor.0
    }
}

impl SymTensor {
    /// Zero tensor.
    pub const ZERO: Self = Self([0.0; 6]);
    /// Unit tensor.
    pub const IDENTITY: Self = Self([1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);

    /// Diagonal tensor.
    #[inline(always)]
    pub const fn diagonal(xx: f64, yy: f64, zz: f64) -> Self {
        Self([xx, yy, zz, 0.0, 0.0, 0.0])
    }

    /// Isotropic tensor: `value` times the unit tensor.
    #[inline(always)]
    pub const fn isotropic(value: f64) -> Self {
        Self::diagonal(value, value, value)
    }

    /// Component `(row, column)`.
    #[inline]
    pub fn component(&self, row: usize, column: usize) -> f64 {
        /// Position of matrix component `[i][j]` in the array xx, yy, zz, xy, yz, zx.
        const MAP: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];
        self.0[MAP[row][column]]
    }

    /// Trace, the first invariant `I1`.
    #[inline(always)]
    pub fn trace(&self) -> f64 {
        self.0[0] + self.0[1] + self.0[2]
    }

    /// Mean pressure `p = -tr / 3`, compression-positive.
    #[inline(always)]
    pub fn pressure(&self) -> f64 {
        -self.trace() / 3.0
    }

    /// Deviator `s = σ + p 1`.
    #[inline(always)]
    pub fn deviator(&self) -> Self {
        let mean = self.trace() / 3.0;
        let [xx, yy, zz, xy, yz, zx] = self.0;
        Self([xx - mean, yy - mean, zz - mean, xy, yz, zx])
    }

    /// Full contraction `a : b`.
    #[inline(always)]
    pub fn dot(&self, other: &Self) -> f64 {
        let (a, b) = (&self.0, &other.0);
        a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + 2.0 * (a[3] * b[3] + a[4] * b[4] + a[5] * b[5])
    }

    /// Frobenius norm.
    #[inline]
    pub fn norm(&self) -> f64 {
        self.dot(self).sqrt()
    }

    /// Second invariant of the deviator, `J2 = s : s / 2`.
    #[inline(always)]
    pub fn j2(&self) -> f64 {
        let s = self.deviator();
        0.5 * s.dot(&s)
    }

    /// Third invariant of the deviator, `J3 = det s`.
    #[inline]
    pub fn j3(&self) -> f64 {
        self.deviator().determinant()
    }

    /// Deviatoric stress `q = sqrt(3 J2)`.
    #[inline(always)]
    pub fn q(&self) -> f64 {
        (3.0 * self.j2()).sqrt()
    }

    /// Lode angle in `[0, π/3]`: 0 is triaxial extension, π/3 triaxial compression
    /// (tension-positive stress). Zero where the deviator vanishes.
    pub fn lode_angle(&self) -> f64 {
        let j2 = self.j2();
        if j2 <= f64::MIN_POSITIVE {
            return 0.0;
        }
        let cos3 = 1.5 * 3f64.sqrt() * self.j3() / j2.powf(1.5);
        cos3.clamp(-1.0, 1.0).acos() / 3.0
    }

    /// Determinant.
    #[inline(always)]
    pub fn determinant(&self) -> f64 {
        let [xx, yy, zz, xy, yz, zx] = self.0;
        xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * zx) + zx * (xy * yz - yy * zx)
    }

    /// Full matrix of the tensor.
    #[inline(always)]
    pub fn to_matrix(&self) -> Mat3 {
        let [xx, yy, zz, xy, yz, zx] = self.0;
        Mat3([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]])
    }

    /// Rotated tensor `Q σ Qᵀ` (pushed forward where `q` is a general map).
    #[inline(always)]
    pub fn rotated(&self, q: &Mat3) -> Self {
        let s = q.0;
        let full = self.to_matrix().0;
        // t = Q σ, then the six components of t Qᵀ.
        let mut t = [[0.0; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                t[i][j] = s[i][0] * full[0][j] + s[i][1] * full[1][j] + s[i][2] * full[2][j];
            }
        }
        let mut out = [0.0; 6];
        for (k, &(i, j)) in PAIRS.iter().enumerate() {
            out[k] = t[i][0] * s[j][0] + t[i][1] * s[j][1] + t[i][2] * s[j][2];
        }
        Self(out)
    }

    /// Product with a vector.
    #[inline]
    pub fn apply(&self, v: [f64; 3]) -> [f64; 3] {
        let [xx, yy, zz, xy, yz, zx] = self.0;
        [
            xx * v[0] + xy * v[1] + zx * v[2],
            xy * v[0] + yy * v[1] + yz * v[2],
            zx * v[0] + yz * v[1] + zz * v[2],
        ]
    }

    /// Symmetrised dyad `(a ⊗ b + b ⊗ a) / 2`.
    pub fn symmetric_dyad(a: [f64; 3], b: [f64; 3]) -> Self {
        let mut out = [0.0; 6];
        for (k, &(i, j)) in PAIRS.iter().enumerate() {
            out[k] = 0.5 * (a[i] * b[j] + a[j] * b[i]);
        }
        Self(out)
    }

    /// Whether every component is finite.
    #[inline]
    pub fn is_finite(&self) -> bool {
        self.0.iter().all(|c| c.is_finite())
    }
}

// Written out and always inlined: loops over several points at once are vectorised only where nothing is called.

impl Add for SymTensor {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        Self([a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3], a[4] + b[4], a[5] + b[5]])
    }
}

impl Sub for SymTensor {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let (a, b) = (self.0, other.0);
        Self([a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3], a[4] - b[4], a[5] - b[5]])
    }
}

impl Neg for SymTensor {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        let a = self.0;
        Self([-a[0], -a[1], -a[2], -a[3], -a[4], -a[5]])
    }
}

impl Mul<f64> for SymTensor {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        let a = self.0;
        Self([a[0] * factor, a[1] * factor, a[2] * factor, a[3] * factor, a[4] * factor, a[5] * factor])
    }
}

impl Mul<SymTensor> for f64 {
    type Output = SymTensor;
    #[inline(always)]
    fn mul(self, tensor: SymTensor) -> SymTensor {
        tensor * self
    }
}

impl AddAssign for SymTensor {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for SymTensor {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl Index<usize> for SymTensor {
    type Output = f64;
    #[inline]
    fn index(&self, k: usize) -> &f64 {
        &self.0[k]
    }
}

impl IndexMut<usize> for SymTensor {
    #[inline]
    fn index_mut(&mut self, k: usize) -> &mut f64 {
        &mut self.0[k]
    }
}

/// General 3×3 matrix, row-major: deformation gradients, velocity gradients, rotations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Mat3(pub [[f64; 3]; 3]);

impl Default for Mat3 {
    fn default() -> Self {
        Self::ZERO
    }
}

impl Mat3 {
    /// Zero matrix.
    pub const ZERO: Self = Self([[0.0; 3]; 3]);
    /// Unit matrix.
    pub const IDENTITY: Self = Self([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);

    /// Rotation by `angle` (rad, right-handed) about the z axis.
    pub fn rotation_z(angle: f64) -> Self {
        let (s, c) = angle.sin_cos();
        Self([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    }

    /// Transpose.
    #[inline]
    pub fn transpose(&self) -> Self {
        Self(std::array::from_fn(|i| std::array::from_fn(|j| self.0[j][i])))
    }

    /// Trace.
    #[inline(always)]
    pub fn trace(&self) -> f64 {
        self.0[0][0] + self.0[1][1] + self.0[2][2]
    }

    /// Determinant.
    #[inline(always)]
    pub fn determinant(&self) -> f64 {
        let m = &self.0;
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
            + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    }

    /// Inverse, or `None` where the determinant vanishes or is not finite.
    pub fn inverse(&self) -> Option<Self> {
        let m = &self.0;
        let det = self.determinant();
        if det == 0.0 || !det.is_finite() {
            return None;
        }
        let cofactor = |i: usize, j: usize| {
            let (a, b) = ((i + 1) % 3, (i + 2) % 3);
            let (c, d) = ((j + 1) % 3, (j + 2) % 3);
            m[a][c] * m[b][d] - m[a][d] * m[b][c]
        };
        Some(Self(std::array::from_fn(|i| std::array::from_fn(|j| cofactor(j, i) / det))))
    }

    /// Square root of a rotation or deformation, by the iteration of Denman and Beavers. `None` for half turns and for a determinant that
    /// is not positive.
    pub fn square_root(&self) -> Option<Self> {
        let (mut root, mut inverse) = (*self, Self::IDENTITY);
        for _ in 0..40 {
            let next = (root + inverse.inverse()?) * 0.5;
            inverse = (inverse + root.inverse()?) * 0.5;
            let change = (next - root).0.as_flattened().iter().fold(0.0, |m: f64, c| m.max(c.abs()));
            root = next;
            if change <= 1e-15 {
                return Some(root);
            }
        }
        let error = root * root - *self;
        error.0.as_flattened().iter().all(|c| c.abs() < 1e-12).then_some(root)
    }

    /// Symmetric part.
    #[inline(always)]
    pub fn sym(&self) -> SymTensor {
        let m = &self.0;
        SymTensor([
            m[0][0],
            m[1][1],
            m[2][2],
            0.5 * (m[0][1] + m[1][0]),
            0.5 * (m[1][2] + m[2][1]),
            0.5 * (m[2][0] + m[0][2]),
        ])
    }

    /// Skew part.
    #[inline]
    pub fn skew(&self) -> Self {
        let m = &self.0;
        Self(std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (m[i][j] - m[j][i]))))
    }

    /// Product with a vector.
    #[inline]
    pub fn apply(&self, v: [f64; 3]) -> [f64; 3] {
        self.0.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
    }

    /// Whether every entry is finite.
    #[inline]
    pub fn is_finite(&self) -> bool {
        self.0.iter().flatten().all(|c| c.is_finite())
    }
}

impl Mul for Mat3 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let (a, b) = (&self.0, &other.0);
        let mut out = [[0.0; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                out[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
            }
        }
        Self(out)
    }
}

impl Mul<f64> for Mat3 {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        let a = &self.0;
        let mut out = [[0.0; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                out[i][j] = a[i][j] * factor;
            }
        }
        Self(out)
    }
}

impl Add for Mat3 {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        let (a, b) = (&self.0, &other.0);
        let mut out = [[0.0; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                out[i][j] = a[i][j] + b[i][j];
            }
        }
        Self(out)
    }
}

impl Sub for Mat3 {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        let (a, b) = (&self.0, &other.0);
        let mut out = [[0.0; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                out[i][j] = a[i][j] - b[i][j];
            }
        }
        Self(out)
    }
}
