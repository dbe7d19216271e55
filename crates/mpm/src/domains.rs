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
