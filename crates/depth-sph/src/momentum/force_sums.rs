//! Sums over the neighbours of a node for the forces on it (sheet: depth-sph §2.5, §2.10).

use wide::f64x4;

use crate::neighbours::cell_sorted::{CellSorted, FIELDS, four_values, sum_lanes};
use crate::points::phase_nodes::{NeighbourData, PlanVector};

/// Determinant of the moment matrix below which the gradient correction is omitted (sheet: depth-sph §2.10).
const ILL_CONDITIONED: f64 = 1e-3;
/// Sums over the neighbours of a node.
pub(crate) struct ForceSums<const D: usize> {
    /// `Σ m (p_I + p_J) ∇W`, the pressure force over `-g_*`.
    pub(crate) pressure_gradient: PlanVector<D>,
    /// `-Σ m Π ∇W` (m/s²).
    pub(crate) viscous: PlanVector<D>,
    /// `Σ (m/h) (f_J - f_I) ∇W` of the fields.
    pub(crate) field_gradients: [PlanVector<D>; FIELDS],
    /// `Σ (m/h) (x_J - x_I) ⊗ ∇W`.
    pub(crate) moment: [PlanVector<D>; D],
    /// Largest speed of a neighbour relative to the node (m/s).
    pub(crate) relative_speed: f64,
}

/// Solution `A⁻¹ b` in one or two dimensions; `b` itself if `A` is ill-conditioned.
pub fn solve_or_copy<const D: usize>(matrix: &[PlanVector<D>; D], vector: &PlanVector<D>) -> PlanVector<D> {
    let mut result = *vector;
    if D == 1 {
        if matrix[0][0] > ILL_CONDITIONED {
            result[0] = vector[0] / matrix[0][0];
        }
        return result;
    }
    let determinant = matrix[0][0] * matrix[1][1] - matrix[0][1] * matrix[1][0];
    if determinant > ILL_CONDITIONED {
        result[0] = (matrix[1][1] * vector[0] - matrix[0][1] * vector[1]) / determinant;
        result[1] = (matrix[0][0] * vector[1] - matrix[1][0] * vector[0]) / determinant;
    }
    result
}

/// Force sums in lanes of four neighbours.
pub(super) struct SimdForceSums<const D: usize> {
    /// `Σ m (p_I + p_J) ∇W`.
    pub(super) pressure_gradient: [f64x4; D],
    /// `-Σ m Π ∇W` (m/s²).
    viscous: [f64x4; D],
    /// `Σ (m/h) (f_J - f_I) ∇W` of the fields.
    field_gradients: [[f64x4; D]; FIELDS],
    /// `Σ (m/h) (x_J - x_I) ⊗ ∇W`.
    moment: [[f64x4; D]; D],
    /// Largest square of the speed of a neighbour relative to the node (m²/s²).
    relative_square: f64x4,
}

impl<const D: usize> SimdForceSums<D> {
    /// Sums before the first neighbour.
    pub(super) const ZERO: Self = Self {
        pressure_gradient: [f64x4::ZERO; D],
        viscous: [f64x4::ZERO; D],
        field_gradients: [[f64x4::ZERO; D]; FIELDS],
        moment: [[f64x4::ZERO; D]; D],
        relative_square: f64x4::ZERO,
    };

    /// Includes the relative velocity of four neighbours (m/s), where `inside`.
    #[inline(always)]
    pub(super) fn include_relative_velocity(&mut self, inside: f64x4, velocity: &[f64x4; D]) {
        let mut square = f64x4::ZERO;
        for c in 0..D {
            square += velocity[c] * velocity[c];
        }
        self.relative_square = self.relative_square.fast_max(inside & square);
    }

    /// Adds the viscous terms `-m Π ∇W` of four neighbours; `strength` is `m Π (∂W/∂r)/r`, `apart` are the distance vectors (m).
    #[inline(always)]
    pub(super) fn add_viscosity(&mut self, strength: f64x4, apart: &[f64x4; D]) {
        for c in 0..D {
            self.viscous[c] -= strength * apart[c];
        }
    }

    /// Adds the terms of four neighbours to the gradients of the fields, with the factor `-(m/h) W'/r`. `here` are the values at the node.
    #[inline(always)]
    pub(super) fn add_field_gradients(
        &mut self,
        cell_sorted: &CellSorted<D>,
        first: usize,
        share: f64x4,
        here: &[f64x4; FIELDS],
        apart: &[f64x4; D],
    ) {
        for (f, slope) in self.field_gradients.iter_mut().enumerate() {
            let column = if f == 0 { &cell_sorted.partial_thickness } else { &cell_sorted.fields[f] };
            let change = share * (four_values(column, first) - here[f]);
            for c in 0..D {
                slope[c] += change * apart[c];
            }
        }
        for c in 0..D {
            for k in 0..D {
                self.moment[c][k] -= share * apart[c] * apart[k];
            }
        }
    }

    /// Sums of the lanes.
    #[inline(always)]
    pub(super) fn sums(self) -> ForceSums<D> {
        ForceSums {
            pressure_gradient: self.pressure_gradient.map(sum_lanes),
            viscous: self.viscous.map(sum_lanes),
            field_gradients: self.field_gradients.map(|slope| slope.map(sum_lanes)),
            moment: self.moment.map(|row| row.map(sum_lanes)),
            relative_speed: self.relative_square.to_array().into_iter().fold(0.0, f64::max).sqrt(),
        }
    }
}

/// Fields of a node whose gradients are computed; zero for fields that the problem does not have.
#[inline]
pub(super) fn gradient_fields<const D: usize>(data: &NeighbourData<D>, i: usize) -> [f64; FIELDS] {
    let of = |column: &[f64]| column.get(i).copied().unwrap_or(0.0);
    [data.height[i], of(&data.partner_height), of(&data.porosity), of(&data.excess), of(&data.level)]
}
