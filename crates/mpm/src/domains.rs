//! Point domains that stand on other nodes than a product of one basis per axis (MPM sheet §2.5e, g).

use colluvium_grid::{Basis, Corners, NodeList, Pulled, Stencil};

use crate::points::{Ground, PointDomain};
use crate::stretch::{Square, follow, from_numbers, identity};

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
    fn edges(&self, initial: &[f64; D]) -> Square<D> {
        std::array::from_fn(|a| std::array::from_fn(|c| 0.5 * initial[a] * self.deformation[c][a]))
    }
}

impl<const D: usize> PointDomain<D> for ConvectedDomain<D> {
    type Support<const S: usize> = NodeList<D, S>;

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
    fn follow(&mut self, gradient: &Square<D>) {
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

    fn to_numbers(self) -> Vec<f64> {
        self.deformation.as_flattened().to_vec()
    }

    fn from_numbers(numbers: &[f64]) -> Self {
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
    fn arms(&self, initial: &[f64; 2]) -> [[f64; 2]; 4] {
        let signs = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]];
        std::array::from_fn(|k| std::array::from_fn(|c| signs[k][c] * initial[c] + self.gone[k][c]))
    }

    #[inline(always)]
    fn corners(&self, position: &[f64; 2], initial: &[f64; 2]) -> [[f64; 2]; 4] {
        self.arms(initial).map(|arm| [position[0] + arm[0], position[1] + arm[1]])
    }
}

impl PointDomain<2> for ConvectedCorners {
    type Support<const S: usize> = NodeList<2, S>;

    const CONVECTED: bool = true;

    #[inline(always)]
    fn support<const S: usize, B: Basis<S>>(
        &self,
        ground: &Ground<'_, 2>,
        position: &[f64; 2],
        initial: &[f64; 2],
    ) -> NodeList<2, S> {
        Corners::quadrilateral(ground.grid, &self.corners(position, initial))
    }

    /// Widths of the box around the domain.
    #[inline(always)]
    fn extent(&self, initial: &[f64; 2], _cell: f64) -> [f64; 2] {
        let arms = self.arms(initial);
        std::array::from_fn(|c| {
            let along = arms.map(|arm| arm[c]);
            along.into_iter().fold(f64::NEG_INFINITY, f64::max)
                - along.into_iter().fold(f64::INFINITY, f64::min)
        })
    }

    #[inline(always)]
    fn follow(&mut self, _gradient: &Square<2>) {}

    #[inline(always)]
    fn convect(
        &mut self,
        position: &[f64; 2],
        initial: &[f64; 2],
        velocity: &[f64; 2],
        dt: f64,
        read: impl Fn(&[f64; 2]) -> [f64; 2],
    ) {
        let corners = self.corners(position, initial);
        for (gone, corner) in self.gone.iter_mut().zip(&corners) {
            let own = read(corner);
            (0..2).for_each(|c| gone[c] += dt * (own[c] - velocity[c]));
        }
    }

    #[inline(always)]
    fn fault(&self, initial: &[f64; 2], cell: f64) -> Option<String> {
        let arms = self.arms(initial);
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

    fn to_numbers(self) -> Vec<f64> {
        self.gone.as_flattened().to_vec()
    }

    fn from_numbers(numbers: &[f64]) -> Self {
        let mut gone = [[0.0; 2]; 4];
        gone.as_flattened_mut().copy_from_slice(numbers);
        Self { gone }
    }
}

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
    fn follow(&mut self, gradient: &Square<D>) {
        follow(&mut self.deformation, gradient);
    }

    fn to_numbers(self) -> Vec<f64> {
        [&self.start[..], self.deformation.as_flattened()].concat()
    }

    fn from_numbers(numbers: &[f64]) -> Self {
        let (start, deformation) = numbers.split_at(D);
        Self { start: std::array::from_fn(|c| start[c]), deformation: from_numbers(deformation) }
    }
}

#[inline(always)]
fn inverse<const D: usize>(f: &Square<D>) -> Square<D> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use colluvium_grid::{Grid, Linear, Mesh, Support};

    #[test]
    fn corners_follow_the_deformation() {
        let mut domain = ConvectedDomain::<2>::default();
        domain.follow(&[[0.0, 1.5], [0.0, 0.0]]);
        let edges = domain.edges(&[0.2, 0.4]);
        let apart = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).abs().max((a[1] - b[1]).abs());
        assert!(apart(edges[0], [0.1, 0.0]) < 1e-15 && apart(edges[1], [0.3, 0.2]) < 1e-15, "{edges:?}");
        assert!(apart(domain.extent(&[0.2, 0.4], 1.0), [0.8, 0.4]) < 1e-15);
        assert!(domain.fault(&[0.2, 0.4], 0.21).is_none());
        let fault = domain.fault(&[0.2, 0.4], 0.19).unwrap();
        assert!(fault.contains("4.211 cells wide"), "{fault}");
        domain.follow(&[[f64::NAN, 0.0], [0.0, 0.0]]);
        assert!(domain.fault(&[0.2, 0.4], 1.0).is_some());
    }

    #[test]
    fn corners_move_with_the_field_where_they_are() {
        // In a linear field they do what the deformation gradient does.
        let (initial, place, dt) = ([0.2, 0.4], [0.3, 0.7], 1.0);
        let field = |x: &[f64; 2]| [0.3 + 0.5 * x[0] - 0.2 * x[1], -0.1 + 0.7 * x[0] + 0.1 * x[1]];
        let (mut free, mut convected) = (ConvectedCorners::default(), ConvectedDomain::<2>::default());
        free.convect(&place, &initial, &field(&place), dt, field);
        convected.follow(&[[0.5, -0.2], [0.7, 0.1]]);
        let edges = convected.edges(&initial);
        for (arm, [s, t]) in
            free.arms(&initial).iter().zip([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
        {
            assert!((0..2).all(|c| (arm[c] - s * edges[0][c] - t * edges[1][c]).abs() < 1e-15), "{arm:?}");
        }
        assert!(free.fault(&initial, 0.2).is_none());
        assert!(free.fault(&initial, 0.1).unwrap().contains("cells from it"));
        assert_eq!(ConvectedCorners::from_numbers(&free.to_numbers()), free);
        let inward = |x: &[f64; 2]| if x[0] > 0.35 && x[1] > 0.8 { [-0.2, -0.4] } else { [0.0; 2] };
        let mut bent = ConvectedCorners::default();
        bent.convect(&place, &initial, &[0.0; 2], 1.0, inward);
        assert!(bent.fault(&initial, 1.0).unwrap().contains("convex"));
    }

    #[test]
    fn the_inverse_is_one() {
        let f = [[1.1, 0.3, -0.2], [0.1, 0.9, 0.4], [-0.3, 0.2, 1.2]];
        let g = inverse(&f);
        for i in 0..3 {
            for j in 0..3 {
                let product: f64 = (0..3).map(|k| f[i][k] * g[k][j]).sum();
                assert!((product - if i == j { 1.0 } else { 0.0 }).abs() < 1e-14);
            }
        }
        assert_eq!(inverse(&[[4.0]]), [[0.25]]);
        assert_eq!(inverse(&[[2.0, 0.0], [0.0, 4.0]]), [[0.5, 0.0], [0.0, 0.25]]);
    }

    #[test]
    fn gradients_of_the_reference_are_by_the_current_place() {
        // Nodes carried by x = F X make the gradient of place one.
        let grid = Grid::new([0.0; 2], [1.0; 2], 0.25).unwrap();
        let mesh = Mesh::default();
        let ground = Ground { grid: &grid, mesh: &mesh };
        let f = [[1.3, 0.4], [-0.2, 0.8]];
        let mut point = ReferencePoint::<2>::default();
        point.start(&ground, &[0.37, 0.61]).unwrap();
        point.follow(&[[f[0][0] - 1.0, f[0][1]], [f[1][0], f[1][1] - 1.0]]);
        let mut unit = [[0.0; 2]; 2];
        point.support::<2, Linear>(&ground, &[9.0, 9.0], &[0.1; 2]).for_each(&[5, 1], |number, _, g| {
            let node = [0.25 * (number / 5) as f64, 0.25 * (number % 5) as f64];
            for i in 0..2 {
                for j in 0..2 {
                    unit[i][j] += (f[i][0] * node[0] + f[i][1] * node[1]) * g[j];
                }
            }
        });
        for i in 0..2 {
            for j in 0..2 {
                assert!((unit[i][j] - if i == j { 1.0 } else { 0.0 }).abs() < 1e-13, "{unit:?}");
            }
        }
        let again = ReferencePoint::<2>::from_numbers(&PointDomain::<2>::to_numbers(point));
        assert_eq!(again, point);
    }
}
