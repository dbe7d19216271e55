//! Batch of points with each component in an array of its own, so that one operation serves several points
//! at once. The operations and their order are those of a single point.

use crate::contract::motion::{BlockArray, OUT_OF_PLANE_COMPONENTS};
use crate::{BLOCK_SIZE, Mat3, Motion, MotionBlock, Spectrum, SymTensor};

/// Velocity gradients times the time step and stresses of a batch of points, in one array per component.
pub struct ComponentArrays {
    gradient: [BlockArray; 9],
    /// Stress of the points, one array per component in the order xx, yy, zz, xy, yz, zx (Pa).
    pub(crate) stress: [BlockArray; 6],
    /// Whether no point moves or is sheared out of the plane of the first two axes: components there are zero.
    in_plane: bool,
}

/// Rotations of the points, in one array per matrix component; rotations in the plane leave the third axis unchanged.
pub(crate) struct Rotations {
    rows: [BlockArray; 9],
    in_plane: bool,
}

/// Tensor of point `index` of arrays per component (xx, yy, zz, xy, yz, zx).
#[inline(always)]
pub(crate) fn tensor<const N: usize>(lanes: &[[f64; N]; 6], index: usize) -> SymTensor {
    let [xx, yy, zz, xy, yz, zx] = lanes;
    SymTensor([xx[index], yy[index], zz[index], xy[index], yz[index], zx[index]])
}

/// Stores the tensor of point `index` in arrays per component (xx, yy, zz, xy, yz, zx).
#[inline(always)]
pub(crate) fn set_tensor<const N: usize>(lanes: &mut [[f64; N]; 6], index: usize, value: &SymTensor) {
    let [xx, yy, zz, xy, yz, zx] = lanes;
    (xx[index], yy[index], zz[index]) = (value.0[0], value.0[1], value.0[2]);
    (xy[index], yz[index], zx[index]) = (value.0[3], value.0[4], value.0[5]);
}

impl ComponentArrays {
    /// Arrays of a batch before they are filled.
    pub(crate) const EMPTY: Self =
        Self { gradient: [[0.0; BLOCK_SIZE]; 9], stress: [[0.0; BLOCK_SIZE]; 6], in_plane: false };

    /// Copies motions and stresses of a block of points to arrays per component.
    #[inline]
    pub(crate) fn fill(&mut self, motions: &[Motion], stresses: &[SymTensor]) {
        let [g0, g1, g2, g3, g4, g5, g6, g7, g8] = &mut self.gradient;
        let [xx, yy, zz, xy, yz, zx] = &mut self.stress;
        let points = || motions.iter().zip(stresses).enumerate().take(BLOCK_SIZE);
        let mut in_plane = true;
        for (i, (motion, stress)) in points() {
            let [[a, b, c], [d, e, f], [g, h, k]] = motion.velocity_gradient_dt.0;
            (g0[i], g1[i], g3[i], g4[i], g8[i]) = (a, b, d, e, k);
            let [sxx, syy, szz, sxy, syz, szx] = stress.0;
            (xx[i], yy[i], zz[i], xy[i]) = (sxx, syy, szz, sxy);
            in_plane &= [c, f, g, h, syz, szx] == [0.0; 6];
        }
        self.in_plane = in_plane;
        if !in_plane {
            for (i, (motion, stress)) in points() {
                let [[_, _, c], [_, _, f], [g, h, _]] = motion.velocity_gradient_dt.0;
                (g2[i], g5[i], g6[i], g7[i]) = (c, f, g, h);
                (yz[i], zx[i]) = (stress.0[4], stress.0[5]);
            }
        }
    }

    /// Copies motions that are stored per component, and stresses.
    #[inline]
    pub(crate) fn fill_from_block(&mut self, motions: &MotionBlock, stresses: &[SymTensor]) {
        let count = stresses.len().min(BLOCK_SIZE);
        let [xx, yy, zz, xy, yz, zx] = &mut self.stress;
        for (i, stress) in stresses.iter().enumerate().take(BLOCK_SIZE) {
            (xx[i], yy[i], zz[i]) = (stress.0[0], stress.0[1], stress.0[2]);
            (xy[i], yz[i], zx[i]) = (stress.0[3], stress.0[4], stress.0[5]);
        }
        let is_zero = |lane: &BlockArray| lane[..count].iter().all(|value| *value == 0.0);
        let flat = motions.in_plane
            || OUT_OF_PLANE_COMPONENTS.iter().all(|c| is_zero(&motions.velocity_gradient_dt[*c]));
        for c in (0..9).filter(|c| !(flat && OUT_OF_PLANE_COMPONENTS.contains(c))) {
            self.gradient[c][..count].copy_from_slice(&motions.velocity_gradient_dt[c][..count]);
        }
        self.in_plane = flat && is_zero(yz) && is_zero(zx);
    }

    /// Stress of point `index` of the block (Pa).
    #[inline]
    pub(crate) fn stress_of(&self, index: usize) -> SymTensor {
        SymTensor(std::array::from_fn(|c| self.stress[c][index]))
    }

    /// Stores the stress of point `index` of the block (Pa).
    #[inline]
    pub(crate) fn set_stress(&mut self, index: usize, stress: &SymTensor) {
        for (lane, value) in self.stress.iter_mut().zip(stress.0) {
            lane[index] = value;
        }
    }

    /// Replaces the stress of each point by the result of `step` for its strain increment and stress. The second result of `step` is
    /// written to `out`.
    #[inline(always)]
    pub(crate) fn for_each(
        &mut self,
        out: &mut [f64; BLOCK_SIZE],
        step: impl Fn(&SymTensor, &SymTensor) -> (SymTensor, f64),
    ) {
        let [g0, g1, g2, g3, g4, g5, g6, g7, g8] = &self.gradient;
        let [xx, yy, zz, xy, yz, zx] = &mut self.stress;
        for i in 0..BLOCK_SIZE {
            let strain = SymTensor([
                g0[i],
                g4[i],
                g8[i],
                0.5 * (g1[i] + g3[i]),
                0.5 * (g5[i] + g7[i]),
                0.5 * (g6[i] + g2[i]),
            ]);
            let stress = SymTensor([xx[i], yy[i], zz[i], xy[i], yz[i], zx[i]]);
            let (new, value) = step(&strain, &stress);
            (xx[i], yy[i], zz[i]) = (new.0[0], new.0[1], new.0[2]);
            (xy[i], yz[i], zx[i]) = (new.0[3], new.0[4], new.0[5]);
            out[i] = value;
        }
    }

    /// Computes the principal stresses of all points in descending order, with their directions.
    pub(crate) fn spectra(&self, spectra: &mut Spectra) {
        spectra.compute(&self.stress);
    }

    /// Whether all gradients are finite and no strain increment is larger than `largest`.
    #[inline(never)]
    pub(crate) fn strains_are_within(&self, largest: f64) -> bool {
        let [g0, g1, g2, g3, g4, g5, g6, g7, g8] = &self.gradient;
        let (mut within, maximum) = (true, largest * largest);
        for i in 0..BLOCK_SIZE {
            let (xy, yz, zx) = (g1[i] + g3[i], g5[i] + g7[i], g6[i] + g2[i]);
            let square = g0[i] * g0[i] + g4[i] * g4[i] + g8[i] * g8[i] + 0.5 * (xy * xy + yz * yz + zx * zx);
            let spin = (g1[i] - g3[i]) + (g5[i] - g7[i]) + (g6[i] - g2[i]);
            // NaN and infinity make the product NaN.
            within &= (square <= maximum) & (spin * 0.0 == 0.0);
        }
        within
    }

    /// Computes half the Hughes–Winget rotation of each point, like `half_rotation` of the co-rotational adapter.
    #[inline(never)]
    pub(crate) fn half_rotations(&self, rotations: &mut Rotations) {
        let [_, g1, g2, g3, _, g5, g6, g7, _] = &self.gradient;
        let [q0, q1, q2, q3, q4, q5, q6, q7, q8] = &mut rotations.rows;
        rotations.in_plane = self.in_plane;
        // Factors of the axial vector and of the quadratic term, from its square.
        let factors = |square: f64| {
            let t2 = 0.25 * square;
            let factor = 0.5 / (1.0 + (1.0 + t2).sqrt());
            (factor, 2.0 / (1.0 + factor * factor * square))
        };
        if self.in_plane {
            for i in 0..BLOCK_SIZE {
                let z = 0.5 * (g3[i] - g1[i]);
                let (factor, c) = factors(z * z);
                let z = factor * z;
                (q0[i], q1[i]) = (1.0 - c * (z * z), c * -z);
                (q3[i], q4[i]) = (c * z, 1.0 - c * (z * z));
            }
            q8.fill(1.0);
            return;
        }
        for i in 0..BLOCK_SIZE {
            let (x, y, z) = (0.5 * (g7[i] - g5[i]), 0.5 * (g2[i] - g6[i]), 0.5 * (g3[i] - g1[i]));
            let (factor, c) = factors(x * x + y * y + z * z);
            let (x, y, z) = (factor * x, factor * y, factor * z);
            q0[i] = 1.0 - c * (y * y + z * z);
            q1[i] = c * (x * y - z);
            q2[i] = c * (x * z + y);
            q3[i] = c * (x * y + z);
            q4[i] = 1.0 - c * (x * x + z * z);
            q5[i] = c * (y * z - x);
            q6[i] = c * (x * z - y);
            q7[i] = c * (y * z + x);
            q8[i] = 1.0 - c * (x * x + y * y);
        }
    }
}

/// Principal values and directions of a batch of symmetric tensors.
pub(crate) struct Spectra<const N: usize = BLOCK_SIZE> {
    values: [[f64; N]; 3],
    directions: [[f64; N]; 9],
}

impl<const N: usize> Spectra<N> {
    /// Array of spectra before they are computed.
    pub(crate) const EMPTY: Self = Self { values: [[0.0; N]; 3], directions: [[0.0; N]; 9] };

    /// Computes the spectra of tensors in one array per component (xx, yy, zz, xy, yz, zx), equal to [`SymTensor::spectrum`].
    #[inline(never)]
    pub(crate) fn compute(&mut self, [xx, yy, zz, xy, yz, zx]: &[[f64; N]; 6]) {
        let [v0, v1, v2] = &mut self.values;
        let [n0, n1, n2, n3, n4, n5, n6, n7, n8] = &mut self.directions;
        for i in 0..N {
            let tensor = SymTensor([xx[i], yy[i], zz[i], xy[i], yz[i], zx[i]]);
            let Spectrum { values, directions: [a, b, c] } = tensor.spectrum_without_branches();
            (v0[i], v1[i], v2[i]) = (values[0], values[1], values[2]);
            (n0[i], n1[i], n2[i]) = (a[0], a[1], a[2]);
            (n3[i], n4[i], n5[i]) = (b[0], b[1], b[2]);
            (n6[i], n7[i], n8[i]) = (c[0], c[1], c[2]);
        }
    }

    /// Principal values and directions of point `index`.
    #[inline]
    pub(crate) fn spectrum(&self, index: usize) -> Spectrum {
        Spectrum {
            values: [self.values[0][index], self.values[1][index], self.values[2][index]],
            directions: std::array::from_fn(|a| std::array::from_fn(|c| self.directions[3 * a + c][index])),
        }
    }
}

impl Rotations {
    /// Array of rotations before they are computed.
    pub(crate) const EMPTY: Self = Self { rows: [[0.0; BLOCK_SIZE]; 9], in_plane: false };

    /// Rotation of point `index`.
    #[inline]
    pub(crate) fn rotation(&self, index: usize) -> Mat3 {
        Mat3(std::array::from_fn(|row| std::array::from_fn(|column| self.rows[3 * row + column][index])))
    }

    /// Rotates the stresses of all points, `Q σ Qᵀ`, like [`SymTensor::rotated`].
    #[inline(never)]
    pub(crate) fn rotate_stresses(&self, stress: &mut [BlockArray; 6]) {
        let [q0, q1, q2, q3, q4, q5, q6, q7, q8] = &self.rows;
        let [sxx, syy, szz, sxy, syz, szx] = stress;
        if self.in_plane {
            for i in 0..BLOCK_SIZE {
                let (a, b, d, e) = (q0[i], q1[i], q3[i], q4[i]);
                let (xx, yy, xy) = (sxx[i], syy[i], sxy[i]);
                let (t0, t1) = (a * xx + b * xy, a * xy + b * yy);
                let (t3, t4) = (d * xx + e * xy, d * xy + e * yy);
                let (yz, zx) = (syz[i], szx[i]);
                sxx[i] = t0 * a + t1 * b;
                syy[i] = t3 * d + t4 * e;
                sxy[i] = t0 * d + t1 * e;
                syz[i] = d * zx + e * yz;
                szx[i] = zx * a + yz * b;
            }
            return;
        }
        for i in 0..BLOCK_SIZE {
            let (a, b, c) = (q0[i], q1[i], q2[i]);
            let (d, e, f) = (q3[i], q4[i], q5[i]);
            let (g, h, k) = (q6[i], q7[i], q8[i]);
            let (xx, yy, zz, xy, yz, zx) = (sxx[i], syy[i], szz[i], sxy[i], syz[i], szx[i]);
            // t = Q σ, then the six components of t Qᵀ.
            let (t0, t1, t2) = (a * xx + b * xy + c * zx, a * xy + b * yy + c * yz, a * zx + b * yz + c * zz);
            let (t3, t4, t5) = (d * xx + e * xy + f * zx, d * xy + e * yy + f * yz, d * zx + e * yz + f * zz);
            let (t6, t7, t8) = (g * xx + h * xy + k * zx, g * xy + h * yy + k * yz, g * zx + h * yz + k * zz);
            sxx[i] = t0 * a + t1 * b + t2 * c;
            syy[i] = t3 * d + t4 * e + t5 * f;
            szz[i] = t6 * g + t7 * h + t8 * k;
            sxy[i] = t0 * d + t1 * e + t2 * f;
            syz[i] = t3 * g + t4 * h + t5 * k;
            szx[i] = t6 * a + t7 * b + t8 * c;
        }
    }
}

/// Computes principal values and directions of many tensors, equal to those of [`SymTensor::spectrum`].
pub fn spectra(tensors: &[SymTensor], out: &mut [Spectrum]) {
    let (mut lanes, mut found) = (ComponentArrays::EMPTY, Spectra::EMPTY);
    for (tensors, out) in tensors.chunks(BLOCK_SIZE).zip(out.chunks_mut(BLOCK_SIZE)) {
        for (index, tensor) in tensors.iter().enumerate() {
            lanes.set_stress(index, tensor);
        }
        lanes.spectra(&mut found);
        for (index, slot) in out.iter_mut().enumerate() {
            *slot = found.spectrum(index);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn tensors() -> impl Strategy<Value = Vec<SymTensor>> {
        let component = prop_oneof![-1e3..1e3f64, Just(0.0), -1e-9..1e-9f64];
        let tensor = proptest::array::uniform6(component).prop_map(SymTensor);
        proptest::collection::vec(tensor, 1..150)
    }

    proptest! {
        #[test]
        fn batched_spectra_equal_single_spectra(tensors in tensors()) {
            let mut found = vec![SymTensor::ZERO.spectrum(); tensors.len()];
            spectra(&tensors, &mut found);
            for (tensor, found) in tensors.iter().zip(&found) {
                prop_assert_eq!(tensor.spectrum(), *found);
            }
        }
    }
}
