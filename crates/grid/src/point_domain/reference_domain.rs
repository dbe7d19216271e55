//! Point domains of the total-Lagrangian formulation (sheet: mpm §2.5g).

use crate::point_domain::{
    GridView, PointDomain, RightStretchDiagonal, SquareMatrix, from_numbers, identity, update_deformation,
};
use crate::{Basis, ReferenceStencil, Stencil};

/// Domain of a point whose shape functions are evaluated at its initial position (total-Lagrangian MPM).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferenceDomain<const D: usize> {
    start: [f64; D],
    deformation: SquareMatrix<D>,
}

impl<const D: usize> Default for ReferenceDomain<D> {
    fn default() -> Self {
        Self { start: [0.0; D], deformation: identity() }
    }
}

impl<const D: usize> PointDomain<D> for ReferenceDomain<D> {
    type Support<const S: usize> = ReferenceStencil<D, S>;

    const CHECKPOINT_NUMBERS: usize = D + D * D;

    crate::point_domain::domain_columns::domain_column!(Reference);

    const REFERENCE_CONFIGURATION: bool = true;

    #[inline(always)]
    fn support<const S: usize, B: Basis<S>>(
        &self,
        ground: &GridView<'_, D>,
        _position: &[f64; D],
        initial: &[f64; D],
    ) -> ReferenceStencil<D, S> {
        let reference = Stencil::new::<B>(ground.grid, &self.start, initial);
        ReferenceStencil { reference, inverse: inverse(&self.deformation) }
    }

    #[inline(always)]
    fn extent(&self, initial: &[f64; D], _cell: f64) -> [f64; D] {
        *initial
    }

    fn initialise(&mut self, _ground: &GridView<'_, D>, position: &[f64; D]) -> Result<(), String> {
        self.start = *position;
        Ok(())
    }

    #[inline(always)]
    fn evaluation_position(&self, _position: &[f64; D]) -> [f64; D] {
        self.start
    }

    #[inline(always)]
    fn update_deformation(&mut self, gradient: &SquareMatrix<D>, _right_stretch: RightStretchDiagonal<D>) {
        update_deformation(&mut self.deformation, gradient);
    }

    fn append_numbers(self, numbers: &mut Vec<f64>) {
        numbers.extend(self.start);
        numbers.extend(self.deformation.as_flattened());
    }

    fn from_numbers(numbers: &[f64], _right_stretch: RightStretchDiagonal<D>) -> Self {
        let (start, deformation) = numbers.split_at(D);
        Self { start: std::array::from_fn(|c| start[c]), deformation: from_numbers(deformation) }
    }
}

/// Inverse of a deformation gradient, by its adjugate.
#[inline(always)]
pub(super) fn inverse<const D: usize>(f: &SquareMatrix<D>) -> SquareMatrix<D> {
    let mut adjugate = [[0.0; D]; D];
    for i in 0..D {
        for j in 0..D {
            let (i1, i2, j1, j2) = ((i + 1) % D, (i + 2) % D, (j + 1) % D, (j + 2) % D);
            adjugate[j][i] = match D {
                1 => 1.0,
                2 if i == j => f[i1][j1],
                2 => -f[i1][j1],
                _ => f[i1][j1] * f[i2][j2] - f[i1][j2] * f[i2][j1],
            };
        }
    }
    let determinant: f64 = (0..D).map(|k| f[0][k] * adjugate[k][0]).sum();
    adjugate.map(|row| row.map(|c| c / determinant))
}
