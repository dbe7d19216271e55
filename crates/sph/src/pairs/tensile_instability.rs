//! Artificial stress against tensile instability (sheet: sph §2.11).

use colluvium_constitutive::SymTensor;

use crate::config::Tensile;

/// Artificial stress `-ε₀ ⟨σ⟩ / ρ²` by principal values (of the mean stress for artificial pressure), rotated back.
pub fn artificial_stress<const D: usize>(tensile: Tensile, stress: &SymTensor, density: f64) -> SymTensor {
    match tensile {
        Tensile::None => SymTensor::ZERO,
        Tensile::ArtificialPressure { strength, .. } => {
            SymTensor::isotropic(-strength * (stress.trace() / 3.0).max(0.0) / (density * density))
        }
        Tensile::ArtificialStress { strength, .. } => {
            let scale = -strength / (density * density);
            let [xx, yy, _, xy, ..] = stress.0;
            match D {
                1 => SymTensor([scale * xx.max(0.0), 0.0, 0.0, 0.0, 0.0, 0.0]),
                2 => {
                    let (mean, half) = (0.5 * (xx + yy), 0.5 * (xx - yy));
                    let radius = (half * half + xy * xy).sqrt();
                    let (first, second) =
                        (scale * (mean + radius).max(0.0), scale * (mean - radius).max(0.0));
                    // f(σ) = (f1 + f2)/2 1 + (f1 - f2)/2 (σ - mean)/radius.
                    let isotropic = 0.5 * (first + second);
                    let turned = if radius > 0.0 { 0.5 * (first - second) / radius } else { 0.0 };
                    let (xx, yy) = (isotropic + turned * half, isotropic - turned * half);
                    SymTensor([xx, yy, 0.0, turned * xy, 0.0, 0.0])
                }
                _ => {
                    let spectrum = stress.spectrum();
                    spectrum.compose(spectrum.values.map(|value| scale * value.max(0.0)))
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_and_three_dimensions_agree_in_the_plane() {
        let tensile = Tensile::ArtificialStress { strength: 0.5, exponent: 2.55 };
        for stress in [
            [3.0, -1.0, -2.0, 0.7, 0.0, 0.0],
            [1.0, 1.0, -1.0, 0.0, 0.0, 0.0],
            [-1.0, 2.0, -3.0, -4.0, 0.0, 0.0],
        ] {
            let stress = SymTensor(stress);
            let (plane, space) = (
                artificial_stress::<2>(tensile, &stress, 2.0),
                artificial_stress::<3>(tensile, &stress, 2.0),
            );
            for a in 0..2 {
                for b in 0..2 {
                    assert!(
                        (plane.component(a, b) - space.component(a, b)).abs() < 1e-12,
                        "{plane:?} {space:?}"
                    );
                }
            }
        }
    }

    #[test]
    fn artificial_stress_is_zero_in_compression_and_repulsive_in_tension() {
        let tensile = Tensile::ArtificialStress { strength: 0.5, exponent: 2.55 };
        assert_eq!(artificial_stress::<2>(tensile, &SymTensor::isotropic(-5.0), 1.0), SymTensor::ZERO);
        assert_eq!(
            artificial_stress::<2>(tensile, &SymTensor::isotropic(5.0), 1.0),
            SymTensor::diagonal(-2.5, -2.5, 0.0)
        );
    }
    /// Expected `-ε₀ ⟨I1/3⟩ / ρ² 1` (BN 118 with the sign of K21), in the plane with the out-of-plane stress.
    #[test]
    fn artificial_pressure_depends_on_the_mean_tension_only() {
        let tensile = Tensile::ArtificialPressure { strength: 0.9, exponent: 2.55 };
        let pulled = SymTensor([6.0, -1.0, 1.0, 4.0, 0.0, 0.0]);
        let exact = SymTensor::isotropic(-0.9 * 2.0 / 4.0);
        assert!((artificial_stress::<2>(tensile, &pulled, 2.0) - exact).norm() < 1e-15);
        assert!((artificial_stress::<3>(tensile, &pulled, 2.0) - exact).norm() < 1e-15);
        // Tension along one axis under pressure on the whole: artificial stress acts, artificial pressure does not.
        let pressed = SymTensor([6.0, -5.0, -4.0, 0.0, 0.0, 0.0]);
        assert_eq!(artificial_stress::<3>(tensile, &pressed, 2.0), SymTensor::ZERO);
        let stress = Tensile::ArtificialStress { strength: 0.9, exponent: 2.55 };
        assert!(artificial_stress::<3>(stress, &pressed, 2.0)[0] < 0.0);
    }
}
