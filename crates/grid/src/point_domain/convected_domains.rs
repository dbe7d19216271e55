//! Point domains with grid functions evaluated at the corners (CPDI; sheet: mpm §2.5e).

use crate::point_domain::{
    GridView, PointDomain, RightStretchDiagonal, SquareMatrix, from_numbers, identity, update_deformation,
};
use crate::shape_functions::cpdi_basis::embed_plane_vector;
use crate::{Basis, CpdiBasis, NodeList};

/// Parallelogram (parallelepiped) that deforms with the deformation gradient (CPDI): half edges `r_a = F r_a⁰`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConvectedDomain<const D: usize> {
    deformation: SquareMatrix<D>,
}

impl<const D: usize> Default for ConvectedDomain<D> {
    fn default() -> Self {
        Self { deformation: identity() }
    }
}

impl<const D: usize> ConvectedDomain<D> {
    /// Half edge vectors of the deformed domain (m), one per row.
    #[inline(always)]
    pub(super) fn edges(&self, initial: &[f64; D]) -> SquareMatrix<D> {
        std::array::from_fn(|a| std::array::from_fn(|c| 0.5 * initial[a] * self.deformation[c][a]))
    }
}

impl<const D: usize> PointDomain<D> for ConvectedDomain<D> {
    type Support<const S: usize> = NodeList<D, S>;

    const CHECKPOINT_NUMBERS: usize = D * D;

    crate::point_domain::domain_columns::domain_column!(Convected);

    #[inline(always)]
    fn support<const S: usize, B: Basis<S>>(
        &self,
        ground: &GridView<'_, D>,
        position: &[f64; D],
        initial: &[f64; D],
    ) -> NodeList<D, S> {
        CpdiBasis::parallelogram_nodes(ground.grid, position, &self.edges(initial))
    }

    /// Widths of the bounding box of the domain.
    #[inline(always)]
    fn extent(&self, initial: &[f64; D], _cell: f64) -> [f64; D] {
        let edges = self.edges(initial);
        std::array::from_fn(|c| edges.iter().map(|edge| 2.0 * edge[c].abs()).sum())
    }

    #[inline(always)]
    fn update_deformation(&mut self, gradient: &SquareMatrix<D>, _right_stretch: RightStretchDiagonal<D>) {
        update_deformation(&mut self.deformation, gradient);
    }

    #[inline(always)]
    fn validity_error(&self, initial: &[f64; D], cell: f64) -> Option<String> {
        let widths = self.extent(initial, cell);
        // Written so that NaN counts as an error.
        if widths.iter().all(|width| *width <= 2.0 * CpdiBasis::MAX_CORNER_DISTANCE * cell) {
            return None;
        }
        let widest = widths.into_iter().fold(0.0, f64::max);
        Some(format!(
            "its domain has become {:.3} cells wide, and the corners of a cpdi domain may lie at most {} cells from \
             its point: the body has been torn or sheared too far (use larger cells, more points per cell, or cpgimp)",
            widest / cell,
            CpdiBasis::MAX_CORNER_DISTANCE
        ))
    }

    fn append_numbers(self, numbers: &mut Vec<f64>) {
        numbers.extend(self.deformation.as_flattened());
    }

    fn from_numbers(numbers: &[f64], _right_stretch: RightStretchDiagonal<D>) -> Self {
        Self { deformation: from_numbers(numbers) }
    }
}

/// Quadrilateral domain whose corners move with the grid velocity (CPDI2; Sadeghirad et al. 2013). Neighbours keep common corners, so that
/// no gap opens between them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ConvectedQuadrilateral {
    /// Displacements of the corners `(--), (+-), (++), (-+)` relative to the point (m).
    corner_offsets: [[f64; 2]; 4],
}

impl ConvectedQuadrilateral {
    /// Vectors from the point to the corners (m).
    #[inline(always)]
    pub(super) fn corner_vectors(&self, initial: &[f64; 2]) -> [[f64; 2]; 4] {
        let signs = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
        std::array::from_fn(|k| std::array::from_fn(|c| signs[k][c] * initial[c] + self.corner_offsets[k][c]))
    }

    /// Positions of the four corners of the domain (m).
    #[inline(always)]
    fn corners(&self, position: &[f64; 2], initial: &[f64; 2]) -> [[f64; 2]; 4] {
        self.corner_vectors(initial).map(|arm| [position[0] + arm[0], position[1] + arm[1]])
    }
}

impl<const D: usize> PointDomain<D> for ConvectedQuadrilateral {
    type Support<const S: usize> = NodeList<D, S>;

    const CONVECTS_CORNERS: bool = true;
    const CHECKPOINT_NUMBERS: usize = 8;

    crate::point_domain::domain_columns::domain_column!(Corners);

    #[inline(always)]
    fn support<const S: usize, B: Basis<S>>(
        &self,
        ground: &GridView<'_, D>,
        position: &[f64; D],
        initial: &[f64; D],
    ) -> NodeList<D, S> {
        CpdiBasis::quadrilateral_nodes(
            ground.grid,
            &self.corners(&plane_components(position), &plane_components(initial)),
        )
    }

    /// Widths of the bounding box of the domain.
    #[inline(always)]
    fn extent(&self, initial: &[f64; D], _cell: f64) -> [f64; D] {
        let arms = self.corner_vectors(&plane_components(initial)).map(|arm| embed_plane_vector::<D>(&arm));
        std::array::from_fn(|c| {
            let along = arms.map(|arm| arm[c]);
            along.into_iter().fold(f64::NEG_INFINITY, f64::max)
                - along.into_iter().fold(f64::INFINITY, f64::min)
        })
    }

    #[inline(always)]
    fn advect_corners(
        &mut self,
        position: &[f64; D],
        initial: &[f64; D],
        velocity: &[f64; D],
        dt: f64,
        read: impl Fn(&[f64; D]) -> [f64; D],
    ) {
        let (corners, velocity) = (
            self.corners(&plane_components(position), &plane_components(initial)),
            plane_components(velocity),
        );
        for (gone, corner) in self.corner_offsets.iter_mut().zip(&corners) {
            let own = plane_components(&read(&embed_plane_vector(corner)));
            (0..2).for_each(|c| gone[c] += dt * (own[c] - velocity[c]));
        }
    }

    #[inline(always)]
    fn validity_error(&self, initial: &[f64; D], cell: f64) -> Option<String> {
        let arms = self.corner_vectors(&plane_components(initial));
        let farthest = arms.as_flattened().iter().fold(0.0, |far: f64, arm| far.max(arm.abs()));
        // The quadrilateral is convex. Both conditions are written so that NaN counts as an error.
        let turns = (0..4).all(|k| {
            let ([x0, y0], [x1, y1], [x2, y2]) = (arms[k], arms[(k + 1) % 4], arms[(k + 2) % 4]);
            (x1 - x0) * (y2 - y1) - (x2 - x1) * (y1 - y0) > 0.0
        });
        if !(farthest <= CpdiBasis::MAX_CORNER_DISTANCE * cell) {
            return Some(format!(
                "a corner of its domain has come {:.3} cells from it, and may be at most {} cells away: the body has \
                 been torn or sheared too far (use larger cells, or more points per cell)",
                farthest / cell,
                CpdiBasis::MAX_CORNER_DISTANCE
            ));
        }
        (!turns).then(|| {
            "its domain is no longer convex: the body has been deformed too far for cpdi2 (use cpdi)"
                .to_owned()
        })
    }

    fn append_numbers(self, numbers: &mut Vec<f64>) {
        numbers.extend(self.corner_offsets.as_flattened());
    }

    fn from_numbers(numbers: &[f64], _right_stretch: RightStretchDiagonal<D>) -> Self {
        let mut gone = [[0.0; 2]; 4];
        gone.as_flattened_mut().copy_from_slice(numbers);
        Self { corner_offsets: gone }
    }
}

/// Components of a vector in the plane of quadrilaterals, which exist in two dimensions only.
#[inline(always)]
fn plane_components<const D: usize>(vector: &[f64; D]) -> [f64; 2] {
    std::array::from_fn(|c| vector.get(c).copied().unwrap_or(0.0))
}
