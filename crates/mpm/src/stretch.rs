//! Point domains of contiguous-particle GIMP (MPM sheet §2.5c).

use colluvium_constitutive::SymTensor;
use colluvium_grid::{Basis, Stencil};

use crate::points::{Ground, PointDomain};

/// Widths of a domain, in cells.
const NARROWEST: f64 = 1e-3;
const WIDEST: f64 = 2.0;

pub(crate) type Square<const D: usize> = [[f64; D]; D];

pub(crate) fn identity<const D: usize>() -> Square<D> {
    std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }))
}

/// `F ← (1 + gradient) F`.
#[inline(always)]
pub(crate) fn follow<const D: usize>(deformation: &mut Square<D>, gradient: &Square<D>) {
    let old = *deformation;
    for i in 0..D {
        for j in 0..D {
            deformation[i][j] += (0..D).map(|k| gradient[i][k] * old[k][j]).sum::<f64>();
        }
    }
}

#[inline(always)]
fn widths<const D: usize>(initial: &[f64; D], stretch: impl Fn(usize) -> f64, cell: f64) -> [f64; D] {
    std::array::from_fn(|a| (initial[a] * stretch(a)).clamp(NARROWEST * cell, WIDEST * cell))
}

pub(crate) fn from_numbers<const D: usize>(numbers: &[f64]) -> Square<D> {
    let mut square = [[0.0; D]; D];
    square.as_flattened_mut().copy_from_slice(numbers);
    square
}

/// A domain that stretches with the diagonal of the deformation gradient (Wallstedt & Guilkey 2008).
/// It shrinks when its point turns, and in shear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StretchingDomain<const D: usize> {
    deformation: Square<D>,
}

impl<const D: usize> Default for StretchingDomain<D> {
    fn default() -> Self {
        Self { deformation: identity() }
    }
}

impl<const D: usize> PointDomain<D> for StretchingDomain<D> {
    type Support<const S: usize> = Stencil<D, S>;

    #[inline(always)]
    fn support<const S: usize, B: Basis<S>>(
        &self,
        ground: &Ground<'_, D>,
        position: &[f64; D],
        initial: &[f64; D],
    ) -> Stencil<D, S> {
        Stencil::new::<B>(ground.grid, position, &self.extent(initial, ground.grid.cell))
    }

    #[inline(always)]
    fn extent(&self, initial: &[f64; D], cell: f64) -> [f64; D] {
        widths(initial, |a| self.deformation[a][a], cell)
    }

    #[inline(always)]
    fn follow(&mut self, gradient: &Square<D>) {
        follow(&mut self.deformation, gradient);
    }

    fn to_numbers(self) -> Vec<f64> {
        self.deformation.as_flattened().to_vec()
    }

    fn from_numbers(numbers: &[f64]) -> Self {
        Self { deformation: from_numbers(numbers) }
    }
}

/// A domain that stretches with the diagonal of the right stretch tensor `U = √(FᵀF)`, which a
/// rotation leaves as it is (Coombs et al. 2020).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurningDomain<const D: usize> {
    deformation: Square<D>,
    /// Diagonal of `U`.
    stretch: [f64; D],
}

impl<const D: usize> Default for TurningDomain<D> {
    fn default() -> Self {
        Self { deformation: identity(), stretch: [1.0; D] }
    }
}

impl<const D: usize> PointDomain<D> for TurningDomain<D> {
    type Support<const S: usize> = Stencil<D, S>;

    #[inline(always)]
    fn support<const S: usize, B: Basis<S>>(
        &self,
        ground: &Ground<'_, D>,
        position: &[f64; D],
        initial: &[f64; D],
    ) -> Stencil<D, S> {
        Stencil::new::<B>(ground.grid, position, &self.extent(initial, ground.grid.cell))
    }

    #[inline(always)]
    fn extent(&self, initial: &[f64; D], cell: f64) -> [f64; D] {
        widths(initial, |a| self.stretch[a], cell)
    }

    #[inline]
    fn follow(&mut self, gradient: &Square<D>) {
        follow(&mut self.deformation, gradient);
        self.stretch = right_stretch(&self.deformation);
    }

    fn to_numbers(self) -> Vec<f64> {
        self.deformation.as_flattened().to_vec()
    }

    fn from_numbers(numbers: &[f64]) -> Self {
        let deformation = from_numbers(numbers);
        Self { deformation, stretch: right_stretch(&deformation) }
    }
}

/// Diagonal of the right stretch tensor of `f`: in two dimensions from `U = (C + √det C 1) / √(tr C +
/// 2 √det C)`, which is the theorem of Cayley and Hamilton for `U² = C = FᵀF`; in three by way of the
/// principal stretches.
fn right_stretch<const D: usize>(f: &Square<D>) -> [f64; D] {
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

    /// Turns a point by `angle` (rad) about z in `steps` steps of exact rotation.
    fn turned<const D: usize, P: PointDomain<D>>(mut domain: P, angle: f64, steps: usize) -> P {
        let (s, c) = (angle / steps as f64).sin_cos();
        let mut gradient = [[0.0; D]; D];
        (gradient[0][0], gradient[0][1], gradient[1][0], gradient[1][1]) = (c - 1.0, -s, s, c - 1.0);
        (0..steps).for_each(|_| domain.follow(&gradient));
        domain
    }

    fn stretched<const D: usize, P: PointDomain<D>>(stretch: [f64; D]) -> P {
        let mut gradient = [[0.0; D]; D];
        (0..D).for_each(|a| gradient[a][a] = stretch[a] - 1.0);
        let mut domain = P::default();
        domain.follow(&gradient);
        domain
    }

    fn close<const D: usize>(widths: [f64; D], expected: [f64; D], tolerance: f64) {
        assert!(
            widths.iter().zip(expected).all(|(w, e)| (w - e).abs() < tolerance),
            "{widths:?}, {expected:?}"
        );
    }

    #[test]
    fn rigid_rotation_leaves_the_right_stretch_domain_as_it_is() {
        for angle in [0.3, 1.2, std::f64::consts::FRAC_PI_2, 2.5, 6.0] {
            let flat = turned::<2, _>(TurningDomain::default(), angle, 100);
            close(flat.extent(&[0.5, 0.5], 1.0), [0.5, 0.5], 1e-12);
            let solid = turned::<3, _>(TurningDomain::default(), angle, 100);
            close(solid.extent(&[0.5; 3], 1.0), [0.5; 3], 1e-12);
        }
        // What follows the diagonal of the deformation gradient is gone after a quarter turn.
        let gone = turned::<2, _>(StretchingDomain::default(), std::f64::consts::FRAC_PI_2, 100);
        close(gone.extent(&[0.5, 0.5], 1.0), [1e-3; 2], 1e-12);
    }

    #[test]
    fn stretch_along_the_axes_is_followed_by_both() {
        close(stretched::<2, StretchingDomain<2>>([1.5, 0.6]).extent(&[0.5; 2], 1.0), [0.75, 0.3], 1e-15);
        close(stretched::<2, TurningDomain<2>>([1.5, 0.6]).extent(&[0.5; 2], 1.0), [0.75, 0.3], 1e-15);
        close(stretched::<1, TurningDomain<1>>([0.6]).extent(&[0.5], 1.0), [0.3], 1e-15);
        let solid: TurningDomain<3> = stretched([1.5, 0.6, 1.1]);
        close(solid.extent(&[0.5; 3], 1.0), [0.75, 0.3, 0.55], 1e-14);
        // Turned afterwards it keeps the widths it had: those of the axes of the start.
        close(turned(solid, 1.0, 50).extent(&[0.5; 3], 1.0), [0.75, 0.3, 0.55], 1e-12);
    }

    #[test]
    fn widths_stay_between_their_bounds_and_survive_a_checkpoint() {
        let thin: TurningDomain<2> = stretched([10.0, 1e-4]);
        assert_eq!(thin.extent(&[0.5; 2], 0.1), [0.2, 1e-4]);
        assert_eq!(TurningDomain::<2>::from_numbers(&PointDomain::<2>::to_numbers(thin)), thin);
    }

    #[test]
    fn simple_shear_stretches_by_the_diagonal_of_u() {
        // F = [[1, γ], [0, 1]]: tan of the rotation is γ/2, U = Rᵀ F.
        let gamma: f64 = 1.5;
        let mut domain = TurningDomain::<2>::default();
        domain.follow(&[[0.0, gamma], [0.0, 0.0]]);
        let (s, c) = (0.5 * gamma).atan().sin_cos();
        close(domain.extent(&[0.5; 2], 1.0), [0.5 * c, 0.5 * (s * gamma + c)], 1e-14);
    }
}
