//! Point domains of which the grid is read at the corners (CPDI; sheet: mpm §2.5e).

use super::{Ground, PointDomain, RightStretch, Square, follow, from_numbers, identity};
use crate::corners::in_space;
use crate::{Basis, Corners, NodeList};

/// A parallelogram (parallelepiped) that the deformation gradient carries along (CPDI): half edges `r_a = F r_a⁰`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConvectedDomain<const D: usize> {
    deformation: Square<D>,
}

impl<const D: usize> Default for ConvectedDomain<D> {
    fn default() -> Self {
        Self { deformation: identity() }
    }
}

impl<const D: usize> ConvectedDomain<D> {
    #[inline(always)]
    pub(super) fn edges(&self, initial: &[f64; D]) -> Square<D> {
        std::array::from_fn(|a| std::array::from_fn(|c| 0.5 * initial[a] * self.deformation[c][a]))
    }
}

impl<const D: usize> PointDomain<D> for ConvectedDomain<D> {
    type Support<const S: usize> = NodeList<D, S>;

    const NUMBERS: usize = D * D;

    super::columns::column!(Convected);

    #[inline(always)]
    fn support<const S: usize, B: Basis<S>>(
        &self,
        ground: &Ground<'_, D>,
        position: &[f64; D],
        initial: &[f64; D],
    ) -> NodeList<D, S> {
        Corners::nodes(ground.grid, position, &self.edges(initial))
    }

    /// Widths of the box around the domain.
    #[inline(always)]
    fn extent(&self, initial: &[f64; D], _cell: f64) -> [f64; D] {
        let edges = self.edges(initial);
        std::array::from_fn(|c| edges.iter().map(|edge| 2.0 * edge[c].abs()).sum())
    }

    #[inline(always)]
    fn follow(&mut self, gradient: &Square<D>, _right_stretch: RightStretch<D>) {
        follow(&mut self.deformation, gradient);
    }

    #[inline(always)]
    fn fault(&self, initial: &[f64; D], cell: f64) -> Option<String> {
        let widths = self.extent(initial, cell);
        // Written so that NaN counts as a fault.
        if widths.iter().all(|width| *width <= 2.0 * Corners::REACH * cell) {
            return None;
        }
        let widest = widths.into_iter().fold(0.0, f64::max);
        Some(format!(
            "its domain has become {:.3} cells wide, and the corners of a cpdi domain may lie at most {} cells from \
             its point: the body has been torn or sheared too far (use larger cells, more points per cell, or cpgimp)",
            widest / cell,
            Corners::REACH
        ))
    }

    fn put(self, numbers: &mut Vec<f64>) {
        numbers.extend(self.deformation.as_flattened());
    }

    fn from_numbers(numbers: &[f64], _right_stretch: RightStretch<D>) -> Self {
        Self { deformation: from_numbers(numbers) }
    }
}

/// A quadrilateral whose corners move with the grid, each where it is (CPDI2; Sadeghirad et al. 2013): neighbours that
/// share a corner keep it, and nothing opens between them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ConvectedCorners {
    /// How far the corners `(--), (+-), (++), (-+)` have gone beyond the point (m).
    gone: [[f64; 2]; 4],
}

impl ConvectedCorners {
    /// The corners from the point (m).
    #[inline(always)]
    pub(super) fn arms(&self, initial: &[f64; 2]) -> [[f64; 2]; 4] {
        let signs = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
        std::array::from_fn(|k| std::array::from_fn(|c| signs[k][c] * initial[c] + self.gone[k][c]))
    }

    #[inline(always)]
    fn corners(&self, position: &[f64; 2], initial: &[f64; 2]) -> [[f64; 2]; 4] {
        self.arms(initial).map(|arm| [position[0] + arm[0], position[1] + arm[1]])
    }
}

impl<const D: usize> PointDomain<D> for ConvectedCorners {
    type Support<const S: usize> = NodeList<D, S>;

    const CONVECTED: bool = true;
    const NUMBERS: usize = 8;

    super::columns::column!(Corners);

    #[inline(always)]
    fn support<const S: usize, B: Basis<S>>(
        &self,
        ground: &Ground<'_, D>,
        position: &[f64; D],
        initial: &[f64; D],
    ) -> NodeList<D, S> {
        Corners::quadrilateral(ground.grid, &self.corners(&plane(position), &plane(initial)))
    }

    /// Widths of the box around the domain.
    #[inline(always)]
    fn extent(&self, initial: &[f64; D], _cell: f64) -> [f64; D] {
        let arms = self.arms(&plane(initial)).map(|arm| in_space::<D>(&arm));
        std::array::from_fn(|c| {
            let along = arms.map(|arm| arm[c]);
            along.into_iter().fold(f64::NEG_INFINITY, f64::max)
                - along.into_iter().fold(f64::INFINITY, f64::min)
        })
    }

    #[inline(always)]
    fn convect(
        &mut self,
        position: &[f64; D],
        initial: &[f64; D],
        velocity: &[f64; D],
        dt: f64,
        read: impl Fn(&[f64; D]) -> [f64; D],
    ) {
        let (corners, velocity) = (self.corners(&plane(position), &plane(initial)), plane(velocity));
        for (gone, corner) in self.gone.iter_mut().zip(&corners) {
            let own = plane(&read(&in_space(corner)));
            (0..2).for_each(|c| gone[c] += dt * (own[c] - velocity[c]));
        }
    }

    #[inline(always)]
    fn fault(&self, initial: &[f64; D], cell: f64) -> Option<String> {
        let arms = self.arms(&plane(initial));
        let farthest = arms.as_flattened().iter().fold(0.0, |far: f64, arm| far.max(arm.abs()));
        // Every corner turns the same way. Both written so that NaN counts as a fault.
        let turns = (0..4).all(|k| {
            let ([x0, y0], [x1, y1], [x2, y2]) = (arms[k], arms[(k + 1) % 4], arms[(k + 2) % 4]);
            (x1 - x0) * (y2 - y1) - (x2 - x1) * (y1 - y0) > 0.0
        });
        if !(farthest <= Corners::REACH * cell) {
            return Some(format!(
                "a corner of its domain has come {:.3} cells from it, and may be at most {} cells away: the body has \
                 been torn or sheared too far (use larger cells, or more points per cell)",
                farthest / cell,
                Corners::REACH
            ));
        }
        (!turns).then(|| {
            "its domain is no longer convex: the body has been deformed too far for cpdi2 (use cpdi)"
                .to_owned()
        })
    }

    fn put(self, numbers: &mut Vec<f64>) {
        numbers.extend(self.gone.as_flattened());
    }

    fn from_numbers(numbers: &[f64], _right_stretch: RightStretch<D>) -> Self {
        let mut gone = [[0.0; 2]; 4];
        gone.as_flattened_mut().copy_from_slice(numbers);
        Self { gone }
    }
}

/// What of a vector lies in the plane of quadrilaterals, of which there are none in other spaces.
#[inline(always)]
fn plane<const D: usize>(vector: &[f64; D]) -> [f64; 2] {
    std::array::from_fn(|c| vector.get(c).copied().unwrap_or(0.0))
}
