//! Localisation bands inside a point: explicit kinematics of the double-scale approach
//! (sheet: constitutive §2.16, Bui & Nguyen 2021, eqs. 88–109) and loss of ellipticity.

use crate::{Mat3, MaterialError, SymTensor, Tangent};

/// Index of the component `(i, j)` in the storage of symmetric tensors.
const MAP: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];

/// Acoustic tensor `(n·D·n)_jk = n_i D_ijkl n_l` (Pa) of a stiffness for the unit normal `normal`.
pub fn acoustic_tensor(stiffness: &Tangent, normal: [f64; 3]) -> Mat3 {
    let mut acoustic = Mat3::ZERO;
    for j in 0..3 {
        for k in 0..3 {
            for i in 0..3 {
                for l in 0..3 {
                    acoustic.0[j][k] += normal[i] * stiffness.0[MAP[i][j]][MAP[k][l]] * normal[l];
                }
            }
        }
    }
    acoustic
}

/// Direction in which a stiffness is nearest to loss of ellipticity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipticity {
    /// Smallest determinant of the acoustic tensor (Pa³); ellipticity is lost if it is not positive.
    pub determinant: f64,
    /// Unit normal of that plane.
    pub normal: [f64; 3],
}

/// Least `det(n·D·n)` over all directions, by a scan every five degrees and a refinement of the best. The
/// scan is oriented along `axes` (columns): with the principal axes of stress it rotates with the
/// material.
pub fn least_ellipticity(stiffness: &Tangent, axes: &Mat3) -> Ellipticity {
    scan_directions(stiffness, axes, 72)
}

/// Least ellipticity like [`least_ellipticity`], for an isotropic law with the principal directions `axes` (columns). Of equivalent normals
/// the result is that with components of no negative sign along the axes.
pub fn least_isotropic_ellipticity(stiffness: &Tangent, axes: &Mat3) -> Ellipticity {
    let found = scan_directions(stiffness, axes, 18);
    let along = axes.transpose().apply(found.normal).map(f64::abs);
    Ellipticity { normal: axes.apply(along), ..found }
}

/// Scans `azimuths` steps of five degrees from the first axis.
fn scan_directions(stiffness: &Tangent, axes: &Mat3, azimuths: u32) -> Ellipticity {
    let normal = |polar: f64, azimuth: f64| {
        let (s, c) = polar.sin_cos();
        axes.apply([s * azimuth.cos(), s * azimuth.sin(), c])
    };
    let at = |angles: [f64; 2]| acoustic_tensor(stiffness, normal(angles[0], angles[1])).determinant();
    let mut step = 5f64.to_radians();
    let mut best = ([0.0; 2], at([0.0; 2]));
    for i in 1..=18 {
        for j in 0..=azimuths {
            let angles = [f64::from(i) * step, f64::from(j) * step];
            let value = at(angles);
            if value < best.1 {
                best = (angles, value);
            }
        }
    }
    // Compass search to the accuracy at which a minimum is defined.
    while step > 1e-9 {
        let ([polar, azimuth], _) = best;
        let around = [
            [polar + step, azimuth],
            [polar - step, azimuth],
            [polar, azimuth + step],
            [polar, azimuth - step],
        ];
        let better = around.map(|angles| (angles, at(angles))).into_iter().find(|(_, value)| *value < best.1);
        match better {
            Some(found) => best = found,
            None => step *= 0.5,
        }
    }
    Ellipticity { determinant: best.1, normal: normal(best.0[0], best.0[1]) }
}

/// Band of finite thickness in a point, with the stiffness inside and outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiniteBand {
    thickness: f64,
    size: f64,
    normal: [f64; 3],
    outside: Tangent,
    inside_tangent: Tangent,
}

/// Response of a banded point to a strain (increment).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BandResponse {
    /// Jump across the band (m).
    pub jump: [f64; 3],
    /// Stress outside (Pa).
    pub outside: SymTensor,
    /// Stress inside (Pa).
    pub inside_stress: SymTensor,
    /// Average stress of the point (Pa).
    pub mean: SymTensor,
}

impl FiniteBand {
    /// Returns a band of `thickness` (m) with unit `normal` in a point of effective `size` (m).
    ///
    /// # Errors
    /// Unless `0 < thickness ≤ size` and `normal` has unit length.
    pub fn new(
        thickness: f64,
        size: f64,
        normal: [f64; 3],
        outside: Tangent,
        inside_tangent: Tangent,
    ) -> Result<Self, MaterialError> {
        crate::contract::parameter_checks::positive("size", size, "m")?;
        let rule = format!("must be positive and at most the size of the point, {size} m");
        crate::contract::parameter_checks::check(
            "thickness",
            thickness,
            thickness > 0.0 && thickness <= size,
            &rule,
        )?;
        let length = normal.iter().map(|c| c * c).sum::<f64>().sqrt();
        crate::contract::parameter_checks::check(
            "normal",
            length,
            (length - 1.0).abs() < 1e-9,
            "is not a length of 1",
        )?;
        Ok(Self { thickness, size, normal, outside, inside_tangent })
    }

    /// Displacement jump and stresses of a strain, with continuous traction across the band (eqs. 2.19–2.20); `None` if the system is
    /// singular.
    pub fn response(&self, strain: &SymTensor) -> Option<BandResponse> {
        let (h, n) = (self.thickness, self.normal);
        let share = h / self.size;
        let acoustic = acoustic_tensor(&self.inside_tangent, n) * ((1.0 - share) / h)
            + acoustic_tensor(&self.outside, n) * (share / h);
        let mismatch = self.outside.apply(strain) - self.inside_tangent.apply(strain);
        let jump = acoustic.inverse()?.apply(mismatch.apply(n));
        let dyad = SymTensor::symmetric_dyad(n, jump);
        let outside = self.outside.apply(&(*strain - dyad * (share / h)));
        let inside_stress = self.inside_tangent.apply(&(*strain + dyad * ((1.0 - share) / h)));
        Some(BandResponse {
            jump,
            outside,
            inside_stress,
            mean: inside_stress * share + outside * (1.0 - share),
        })
    }
}

/// Displacement jump (m) across a band without thickness, eq. (2.21); `None` if it is not unique. `stiffness` is in Pa/m, `normal` a unit
/// vector and `size` the effective size of the point (m).
pub fn zero_thickness_jump(
    outside: &Tangent,
    stiffness: &Mat3,
    size: f64,
    normal: [f64; 3],
    strain: &SymTensor,
) -> Option<[f64; 3]> {
    let resistance = *stiffness + acoustic_tensor(outside, normal) * (1.0 / size);
    Some(resistance.inverse()?.apply(outside.apply(strain).apply(normal)))
}

/// Stress (Pa) of a point with the displacement jump `u`, `D : (ε - n ⊗ u / H)`.
pub fn zero_thickness_stress(
    outside: &Tangent,
    size: f64,
    normal: [f64; 3],
    jump: [f64; 3],
    strain: &SymTensor,
) -> SymTensor {
    outside.apply(&(*strain - SymTensor::symmetric_dyad(normal, jump) * (1.0 / size)))
}
