//! Strains and stresses of a finite deformation (sheet: constitutive §2.13; Gaume et al. 2020, eqs. 1–6).
//!
//! `F = ∂x/∂X` is the deformation gradient, `τ = J σ` the Kirchhoff stress. Stress and strain are
//! tension-positive.

use crate::{Mat3, SymTensor};

/// Green's strain `E = (Fᵀ F - 1)/2`.
pub fn green_strain(f: &Mat3) -> SymTensor {
    let change = *f - Mat3::IDENTITY;
    change.sym() + SymTensor::IDENTITY.rotated(&change.transpose()) * 0.5
}

/// Small strain, the symmetric part of the displacement gradient `F - 1`.
pub fn small_strain(f: &Mat3) -> SymTensor {
    (*f - Mat3::IDENTITY).sym()
}

/// Hencky's strain `ε = ln(F Fᵀ)/2`; `None` where `F` is singular.
pub fn hencky_strain(f: &Mat3) -> Option<SymTensor> {
    let spectrum = SymTensor::IDENTITY.rotated(f).spectrum();
    (spectrum.values[2] > 0.0).then(|| spectrum.compose(spectrum.values.map(|square| 0.5 * square.ln())))
}

/// First Piola–Kirchhoff stress `P = τ F⁻ᵀ` of a Kirchhoff stress; `None` where `F` is singular.
pub fn first_piola_kirchhoff(kirchhoff: &SymTensor, f: &Mat3) -> Option<Mat3> {
    Some(kirchhoff.to_matrix() * f.inverse()?.transpose())
}

/// Second Piola–Kirchhoff stress `S = F⁻¹ P = F⁻¹ τ F⁻ᵀ` of a Kirchhoff stress; `None` if `F` is singular. Eq. 5 of the source prints `F
/// P`.
pub fn second_piola_kirchhoff(kirchhoff: &SymTensor, f: &Mat3) -> Option<SymTensor> {
    Some(kirchhoff.rotated(&f.inverse()?))
}

#[cfg(test)]
mod tests {
    use super::*;

    const F: Mat3 = Mat3([[1.1, 0.3, 0.0], [0.05, 0.9, -0.1], [0.0, 0.2, 1.05]]);
    const RATE: Mat3 = Mat3([[0.3, -0.2, 0.5], [0.1, 0.7, -0.4], [0.6, 0.2, -0.5]]);
    const KIRCHHOFF: SymTensor = SymTensor([-3.0, 2.0, 1.0, 0.5, -0.7, 1.2]);

    fn double_contraction(a: &Mat3, b: &Mat3) -> f64 {
        a.0.as_flattened().iter().zip(b.0.as_flattened()).map(|(a, b)| a * b).sum()
    }

    #[test]
    fn every_pair_of_stress_and_strain_has_the_same_power() {
        // τ : d = P : Ḟ = S : Ė with Ḟ = L F.
        let rate = RATE * F;
        let power = KIRCHHOFF.dot(&RATE.sym());
        let first = first_piola_kirchhoff(&KIRCHHOFF, &F).unwrap();
        assert!((double_contraction(&first, &rate) - power).abs() < 1e-13);
        let second = second_piola_kirchhoff(&KIRCHHOFF, &F).unwrap();
        let h = 1e-6;
        let strain = (green_strain(&(F + rate * h)) - green_strain(&(F - rate * h))) * (0.5 / h);
        assert!((second.dot(&strain) - power).abs() < 1e-9);
        let error = F.inverse().unwrap() * first - second.to_matrix();
        assert!(error.0.as_flattened().iter().all(|e| e.abs() < 1e-14));
    }

    #[test]
    fn strains_of_a_stretch_and_of_a_rotation() {
        let stretch = |x: f64| Mat3([[x, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let turned = Mat3::rotation_z(0.7) * stretch(1.3);
        assert!((green_strain(&turned) - SymTensor::diagonal(0.345, 0.0, 0.0)).norm() < 1e-15);
        let hencky = hencky_strain(&turned).unwrap();
        let exact = SymTensor::diagonal(1.3f64.ln(), 0.0, 0.0).rotated(&Mat3::rotation_z(0.7));
        assert!((hencky - exact).norm() < 1e-15);
        assert!((small_strain(&stretch(1.3)) - SymTensor::diagonal(0.3, 0.0, 0.0)).norm() < 1e-15);
        // Equal to second order.
        let size = 1e-5;
        let f = Mat3::IDENTITY + RATE * size;
        for strain in [green_strain(&f), hencky_strain(&f).unwrap()] {
            assert!((strain - small_strain(&f)).norm() < 2.0 * size * size);
        }
        assert_eq!(hencky_strain(&Mat3::ZERO), None);
    }
}
