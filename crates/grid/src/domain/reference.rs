//! Points of the total-Lagrangian form (sheet: mpm §2.5g).

use super::{Ground, PointDomain, RightStretch, Square, follow, from_numbers, identity};
use crate::{Basis, Pulled, Stencil};

/// A point that looks at the grid from where it was at the start (total-Lagrangian MPM).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferencePoint<const D: usize> {
    start: [f64; D],
    deformation: Square<D>,
}

impl<const D: usize> Default for ReferencePoint<D> {
    fn default() -> Self {
        Self { start: [0.0; D], deformation: identity() }
    }
}

impl<const D: usize> PointDomain<D> for ReferencePoint<D> {
    type Support<const S: usize> = Pulled<D, S>;

    const NUMBERS: usize = D + D * D;

    super::columns::column!(Reference);

    const ANCHORED: bool = true;

    #[inline(always)]
    fn support<const S: usize, B: Basis<S>>(
        &self,
        ground: &Ground<'_, D>,
        _position: &[f64; D],
        initial: &[f64; D],
    ) -> Pulled<D, S> {
        let reference = Stencil::new::<B>(ground.grid, &self.start, initial);
        Pulled { reference, inverse: inverse(&self.deformation) }
    }

    #[inline(always)]
    fn extent(&self, initial: &[f64; D], _cell: f64) -> [f64; D] {
        *initial
    }

    fn start(&mut self, _ground: &Ground<'_, D>, position: &[f64; D]) -> Result<(), String> {
        self.start = *position;
        Ok(())
    }

    #[inline(always)]
    fn anchor(&self, _position: &[f64; D]) -> [f64; D] {
        self.start
    }

    #[inline(always)]
    fn follow(&mut self, gradient: &Square<D>, _right_stretch: RightStretch<D>) {
        follow(&mut self.deformation, gradient);
    }

    fn put(self, numbers: &mut Vec<f64>) {
        numbers.extend(self.start);
        numbers.extend(self.deformation.as_flattened());
    }

    fn from_numbers(numbers: &[f64], _right_stretch: RightStretch<D>) -> Self {
        let (start, deformation) = numbers.split_at(D);
        Self { start: std::array::from_fn(|c| start[c]), deformation: from_numbers(deformation) }
    }
}

#[inline(always)]
pub(super) fn inverse<const D: usize>(f: &Square<D>) -> Square<D> {
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
