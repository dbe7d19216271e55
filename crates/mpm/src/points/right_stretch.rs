//! Stretch of point domains by the right stretch tensor (sheet: mpm §2.5c).

use colluvium_constitutive::SymTensor;
use colluvium_grid::SquareMatrix;

/// Diagonal of the right stretch tensor of `f`. In two dimensions it follows from the theorem of Cayley and Hamilton, `U = (C + √det C 1) /
/// √(tr C + 2 √det C)` with `C = FᵀF`. In three it follows from the principal stretches.
pub fn right_stretch<const D: usize>(f: &SquareMatrix<D>) -> [f64; D] {
    let c = |i: usize, j: usize| (0..D).map(|k| f[k][i] * f[k][j]).sum::<f64>();
    match D {
        1 => [f[0][0].abs(); D],
        2 => {
            let root = (f[0][0] * f[1][1] - f[0][1] * f[1][0]).abs();
            let scale = 1.0 / (c(0, 0) + c(1, 1) + 2.0 * root).sqrt();
            std::array::from_fn(|a| (c(a, a) + root) * scale)
        }
        _ => {
            let spectrum = SymTensor([c(0, 0), c(1, 1), c(2, 2), c(0, 1), c(1, 2), c(2, 0)]).spectrum();
            let stretch = spectrum.compose(spectrum.values.map(|square| square.max(0.0).sqrt()));
            std::array::from_fn(|a| stretch[a])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use colluvium_grid::{PointDomain, RightStretchDomain, StretchingDomain};

    /// Rotates a point by `angle` (rad) about z in `steps` steps of exact rotation.
    fn rotated_domain<const D: usize, P: PointDomain<D>>(mut domain: P, angle: f64, steps: usize) -> P {
        let (s, c) = (angle / steps as f64).sin_cos();
        let mut gradient = [[0.0; D]; D];
        (gradient[0][0], gradient[0][1], gradient[1][0], gradient[1][1]) = (c - 1.0, -s, s, c - 1.0);
        (0..steps).for_each(|_| domain.update_deformation(&gradient, right_stretch));
        domain
    }

    fn stretched<const D: usize, P: PointDomain<D>>(stretch: [f64; D]) -> P {
        let mut gradient = [[0.0; D]; D];
        (0..D).for_each(|a| gradient[a][a] = stretch[a] - 1.0);
        let mut domain = P::default();
        domain.update_deformation(&gradient, right_stretch);
        domain
    }

    fn assert_widths<const D: usize>(widths: [f64; D], expected: [f64; D], tolerance: f64) {
        assert!(
            widths.iter().zip(expected).all(|(w, e)| (w - e).abs() < tolerance),
            "{widths:?}, {expected:?}"
        );
    }

    #[test]
    fn rigid_rotation_leaves_the_right_stretch_domain_unchanged() {
        for angle in [0.3, 1.2, std::f64::consts::FRAC_PI_2, 2.5, 6.0] {
            let flat = rotated_domain::<2, _>(RightStretchDomain::default(), angle, 100);
            assert_widths(flat.extent(&[0.5, 0.5], 1.0), [0.5, 0.5], 1e-12);
            let solid = rotated_domain::<3, _>(RightStretchDomain::default(), angle, 100);
            assert_widths(solid.extent(&[0.5; 3], 1.0), [0.5; 3], 1e-12);
        }
        // A domain with the diagonal of the deformation gradient has vanished after a quarter turn.
        let gone = rotated_domain::<2, _>(StretchingDomain::default(), std::f64::consts::FRAC_PI_2, 100);
        assert_widths(gone.extent(&[0.5, 0.5], 1.0), [1e-3; 2], 1e-12);
    }

    #[test]
    fn stretch_along_the_axes_is_followed_by_both() {
        assert_widths(
            stretched::<2, StretchingDomain<2>>([1.5, 0.6]).extent(&[0.5; 2], 1.0),
            [0.75, 0.3],
            1e-15,
        );
        assert_widths(
            stretched::<2, RightStretchDomain<2>>([1.5, 0.6]).extent(&[0.5; 2], 1.0),
            [0.75, 0.3],
            1e-15,
        );
        assert_widths(stretched::<1, RightStretchDomain<1>>([0.6]).extent(&[0.5], 1.0), [0.3], 1e-15);
        let solid: RightStretchDomain<3> = stretched([1.5, 0.6, 1.1]);
        assert_widths(solid.extent(&[0.5; 3], 1.0), [0.75, 0.3, 0.55], 1e-14);
        // After the rotation it has the widths that it had: those of the initial axes.
        assert_widths(rotated_domain(solid, 1.0, 50).extent(&[0.5; 3], 1.0), [0.75, 0.3, 0.55], 1e-12);
    }

    #[test]
    fn widths_stay_between_their_bounds_and_survive_a_checkpoint() {
        let thin: RightStretchDomain<2> = stretched([10.0, 1e-4]);
        assert_eq!(thin.extent(&[0.5; 2], 0.1), [0.2, 1e-4]);
        let mut numbers = Vec::new();
        thin.append_numbers(&mut numbers);
        assert_eq!(RightStretchDomain::<2>::from_numbers(&numbers, right_stretch), thin);
    }

    #[test]
    fn simple_shear_stretches_by_the_diagonal_of_u() {
        // F = [[1, γ], [0, 1]]: tan of the rotation is γ/2, U = Rᵀ F.
        let gamma: f64 = 1.5;
        let mut domain = RightStretchDomain::<2>::default();
        domain.update_deformation(&[[0.0, gamma], [0.0, 0.0]], right_stretch);
        let (s, c) = (0.5 * gamma).atan().sin_cos();
        assert_widths(domain.extent(&[0.5; 2], 1.0), [0.5 * c, 0.5 * (s * gamma + c)], 1e-14);
    }
}
