//! Shape functions of convected particle domains (Sadeghirad et al. 2011; sheet: mpm §2.5e).

use crate::{Basis, Grid, NodeList, Vector4};

/// Linear shape functions evaluated at the corners of the point domains (CPDI). `S` is the number of nodes of all `2^D` corners, `4^D`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CpdiBasis;

/// Number of ghost nodes beyond each side of the grid.
const GHOSTS: usize = 2;

impl<const S: usize> Basis<S> for CpdiBasis {
    const NAME: &'static str = "cpdi";
    const GHOSTS: usize = GHOSTS;
    const NODES_BELOW: usize = 2;
    const NODES_ABOVE: usize = 3;

    fn nodes(cells: usize) -> usize {
        cells + 1 + 2 * GHOSTS
    }

    fn coordinate(index: usize, _cells: usize) -> f64 {
        index as f64 - GHOSTS as f64
    }

    #[inline]
    fn evaluate(x: f64, _width: f64, cells: usize) -> (usize, [f64; S], [f64; S]) {
        let (first, s) = CpdiBasis::cell_and_offset(x, cells);
        let (mut w, mut g) = ([0.0; S], [0.0; S]);
        (w[0], w[1]) = (1.0 - s, s);
        (g[0], g[1]) = (-1.0, 1.0);
        (first, w, g)
    }
}

impl CpdiBasis {
    /// Largest distance of a corner from its point, along an axis and in cells: the number of ghost node layers.
    pub const MAX_CORNER_DISTANCE: f64 = GHOSTS as f64;

    /// Index of the cell at a position in cell widths, ghost cells included, and position within it.
    #[inline(always)]
    fn cell_and_offset(x: f64, cells: usize) -> (usize, f64) {
        let local = (x + GHOSTS as f64).max(0.0);
        let first = (local as usize).min(cells + 2 * GHOSTS - 1);
        (first, local - first as f64)
    }

    /// Nodes, weights and gradients of a parallelogram or parallelepiped around `centre` (m) with the half edges `edges[a]` (m).
    ///
    /// With `s = ±1` for the two ends of each edge and the vectors `d_a` dual to the edges, a corner has the weight
    /// `1/2^D` and the gradient `Σ_a s_a d_a / 2^D`.
    #[inline(always)]
    pub fn parallelogram_nodes<const D: usize, const S: usize>(
        grid: &Grid<D>,
        centre: &[f64; D],
        edges: &[[f64; D]; D],
    ) -> NodeList<D, S> {
        let share = 0.5f64.powi(D as i32);
        let dual = dual_basis(edges);
        let mut list = NodeList::EMPTY;
        for corner in 0..1 << D {
            let sign = |axis: usize| if corner >> axis & 1 == 0 { -1.0 } else { 1.0 };
            let (mut place, mut slope) = (*centre, [0.0; D]);
            for axis in 0..D {
                for c in 0..D {
                    place[c] += sign(axis) * edges[axis][c];
                    slope[c] += sign(axis) * share * dual[axis][c];
                }
            }
            Self::write_corner_nodes(grid, &place, share, &slope, &mut list, corner << D);
        }
        list
    }

    /// Nodes, weights and gradients of a quadrilateral with `corners` (m) at `(--), (+-), (++), (-+)` (CPDI2; Sadeghirad et al. 2013). The
    /// weights of the corners are means of its shape functions.
    #[inline(always)]
    pub fn quadrilateral_nodes<const D: usize, const S: usize>(
        grid: &Grid<D>,
        corners: &[[f64; 2]; 4],
    ) -> NodeList<D, S> {
        let (weights, slopes) = corner_weights(corners);
        let mut list = NodeList::EMPTY;
        for corner in 0..4 {
            let (place, slope) = (embed_plane_vector(&corners[corner]), embed_plane_vector(&slopes[corner]));
            Self::write_corner_nodes(grid, &place, weights[corner], &slope, &mut list, 4 * corner);
        }
        list
    }

    /// Linear interpolation at a position (m) of the nodal values `of`.
    #[inline(always)]
    pub fn interpolate_linear<const D: usize>(
        grid: &Grid<D>,
        place: &[f64; D],
        of: impl Fn(usize) -> Vector4,
    ) -> Vector4 {
        let mut sum = Vector4::ZERO;
        Self::visit_cell_nodes(grid, place, |_, number, weight, _| sum += of(number) * weight);
        sum
    }

    /// Writes the `2^D` nodes of a corner from entry `first` on.
    #[inline(always)]
    fn write_corner_nodes<const D: usize, const S: usize>(
        grid: &Grid<D>,
        place: &[f64; D],
        share: f64,
        slope: &[f64; D],
        list: &mut NodeList<D, S>,
        first: usize,
    ) {
        Self::visit_cell_nodes(grid, place, |k, number, weight, node| {
            list.positions[first + k] = node;
            list.nodes[first + k] = number as u32;
            list.weights[first + k] = share * weight;
            list.gradients[first + k] = slope.map(|c| c * weight);
        });
    }

    /// Calls `visit(k, number, linear weight, position)` for the `2^D` nodes around a position (m).
    #[inline(always)]
    fn visit_cell_nodes<const D: usize>(
        grid: &Grid<D>,
        place: &[f64; D],
        mut visit: impl FnMut(usize, usize, f64, [f64; D]),
    ) {
        let local = grid.local(place);
        let found: [(usize, f64); D] =
            std::array::from_fn(|a| Self::cell_and_offset(local[a], grid.cells[a]));
        for k in 0..1 << D {
            let (mut number, mut weight, mut node) = (0, 1.0, [0.0; D]);
            for axis in 0..D {
                let (cell, s) = found[axis];
                let upper = k >> axis & 1;
                number = number * <Self as Basis<1>>::nodes(grid.cells[axis]) + cell + upper;
                weight *= if upper == 1 { s } else { 1.0 - s };
                node[axis] = grid.origin[axis] + ((cell + upper) as f64 - GHOSTS as f64) * grid.cell;
            }
            visit(k, number, weight, node);
        }
    }
}

/// Weights of the corners `(--), (+-), (++), (-+)` of a quadrilateral: means of its bilinear shape functions and of their gradients (1/m;
/// sheet: mpm §2.5e).
#[inline(always)]
fn corner_weights(corners: &[[f64; 2]; 4]) -> ([f64; 4], [[f64; 2]; 4]) {
    let [[x1, y1], [x2, y2], [x3, y3], [x4, y4]] = *corners;
    let area = 0.5 * ((x3 - x1) * (y4 - y2) - (x4 - x2) * (y3 - y1));
    let a = (x4 - x1) * (y2 - y3) - (x2 - x3) * (y4 - y1);
    let b = (x3 - x4) * (y1 - y2) - (x1 - x2) * (y3 - y4);
    let weight = |skew: f64| (6.0 * area + skew) / (24.0 * area);
    let slope = |x: f64, y: f64| [x / (2.0 * area), y / (2.0 * area)];
    (
        [weight(-a - b), weight(-a + b), weight(a + b), weight(a - b)],
        [slope(y2 - y4, x4 - x2), slope(y3 - y1, x1 - x3), slope(y4 - y2, x2 - x4), slope(y1 - y3, x3 - x1)],
    )
}

/// Vectors dual to `edges`: `d_a · r_b = 1` for `a = b`, else zero.
#[inline(always)]
fn dual_basis<const D: usize>(edges: &[[f64; D]; D]) -> [[f64; D]; D] {
    let r = |a: usize, c: usize| edges[a][c];
    let mut dual = [[0.0; D]; D];
    match D {
        1 => dual[0][0] = 1.0 / r(0, 0),
        2 => {
            let inverse = 1.0 / (r(0, 0) * r(1, 1) - r(0, 1) * r(1, 0));
            dual[0][0] = r(1, 1) * inverse;
            dual[0][1] = -r(1, 0) * inverse;
            dual[1][0] = -r(0, 1) * inverse;
            dual[1][1] = r(0, 0) * inverse;
        }
        _ => {
            let cross = |a: usize, b: usize, c: usize| {
                let (i, j) = ((c + 1) % 3, (c + 2) % 3);
                r(a, i) * r(b, j) - r(a, j) * r(b, i)
            };
            let volume: f64 = (0..3).map(|c| r(0, c) * cross(1, 2, c)).sum();
            for a in 0..3 {
                for c in 0..3 {
                    dual[a][c] = cross((a + 1) % 3, (a + 2) % 3, c) / volume;
                }
            }
        }
    }
    dual
}

/// Vector of the plane of quadrilaterals, in `D` dimensions.
#[inline(always)]
pub(crate) fn embed_plane_vector<const D: usize>(vector: &[f64; 2]) -> [f64; D] {
    std::array::from_fn(|c| vector.get(c).copied().unwrap_or(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Layout, NodeSupport};
    use proptest::prelude::*;

    /// Sums over the nodes: weights, gradients, `N x`, `x ⊗ ∇N`.
    fn reproduces<const D: usize, const S: usize>(centre: [f64; D], edges: [[f64; D]; D]) {
        let grid = Grid::new([0.0; D], [0.9; D], 0.1).unwrap();
        let list: NodeList<D, S> = CpdiBasis::parallelogram_nodes(&grid, &centre, &edges);
        let strides = Layout::<D>::new::<S, CpdiBasis>(&grid).strides();
        let (mut one, mut zero, mut place, mut unit) = (0.0, [0.0; D], [0.0; D], [[0.0; D]; D]);
        let mut k = 0;
        list.for_each(&strides, |number, w, g| {
            let mut rest = number;
            for axis in 0..D {
                let index = rest / strides[axis];
                rest %= strides[axis];
                let x = <CpdiBasis as Basis<S>>::coordinate(index, 9) * 0.1;
                assert!((x - list.positions[k][axis]).abs() < 1e-14, "the list knows where its nodes are");
            }
            one += w;
            for i in 0..D {
                zero[i] += g[i];
                place[i] += w * list.positions[k][i];
                for j in 0..D {
                    unit[i][j] += list.positions[k][i] * g[j];
                }
            }
            k += 1;
        });
        assert!((one - 1.0).abs() < 1e-13);
        for i in 0..D {
            assert!((place[i] - centre[i]).abs() < 1e-13 && zero[i].abs() < 1e-10);
            for j in 0..D {
                let exact = if i == j { 1.0 } else { 0.0 };
                assert!((unit[i][j] - exact).abs() < 1e-11, "{unit:?}");
            }
        }
    }

    proptest! {
        #[test]
        fn linear_fields_are_reproduced(
            x in proptest::array::uniform3(0.0..0.9f64), r in proptest::array::uniform9(-0.02..0.02f64),
        ) {
            let edge = |a: usize, c: usize| r[3 * a + c] + if a == c { 0.05 } else { 0.0 };
            reproduces::<1, 4>([x[0]], [[edge(0, 0)]]);
            reproduces::<2, 16>([x[0], x[1]], std::array::from_fn(|a| std::array::from_fn(|c| edge(a, c))));
            reproduces::<3, 64>(x, std::array::from_fn(|a| std::array::from_fn(|c| edge(a, c))));
        }
    }

    #[test]
    fn corner_weights_of_a_quadrilateral_equal_gauss_integration() {
        // Means of N = (1 ± ξ)(1 ± η)/4 over the quadrilateral, by two Gauss points an axis: exact, as both N J and
        // ∇N J are bilinear at most of second order.
        let corners = [[0.1, 0.0], [0.9, 0.15], [1.2, 1.0], [-0.05, 0.7]];
        let signs = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let root = 1.0 / 3f64.sqrt();
        let (mut area, mut mean, mut slope) = (0.0, [0.0; 4], [[0.0; 2]; 4]);
        for [s, t] in signs.map(|[s, t]| [s * root, t * root]) {
            let local = signs.map(|[a, b]| [0.25 * a * (1.0 + b * t), 0.25 * b * (1.0 + a * s)]);
            let along =
                |c: usize, axis: usize| -> f64 { (0..4).map(|k| corners[k][c] * local[k][axis]).sum() };
            let [[xs, xt], [ys, yt]] = [0, 1].map(|c| [along(c, 0), along(c, 1)]);
            let jacobian = xs * yt - xt * ys;
            area += jacobian;
            for k in 0..4 {
                mean[k] += jacobian * 0.25 * (1.0 + signs[k][0] * s) * (1.0 + signs[k][1] * t);
                slope[k][0] += local[k][0] * yt - local[k][1] * ys;
                slope[k][1] += local[k][1] * xs - local[k][0] * xt;
            }
        }
        let (weights, slopes) = corner_weights(&corners);
        for k in 0..4 {
            assert!((weights[k] - mean[k] / area).abs() < 1e-14, "{weights:?}");
            assert!((0..2).all(|c| (slopes[k][c] - slope[k][c] / area).abs() < 1e-14), "{slopes:?}");
        }
    }

    #[test]
    fn a_quadrilateral_that_is_a_parallelogram_is_one() {
        let grid = Grid::new([0.0; 2], [1.0; 2], 0.25).unwrap();
        let (centre, r) = ([0.43, 0.58], [[0.11, 0.03], [-0.02, 0.09]]);
        let corner =
            |s: f64, t: f64| -> [f64; 2] { std::array::from_fn(|c| centre[c] + s * r[0][c] + t * r[1][c]) };
        let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        let sums = |list: NodeList<2, 16>| {
            let mut sums = vec![[0.0; 3]; 200];
            list.for_each(&[9, 1], |number, w, g| {
                [w, g[0], g[1]].iter().zip(&mut sums[number]).for_each(|(value, sum)| *sum += value);
            });
            sums
        };
        let (free, convected) = (
            CpdiBasis::quadrilateral_nodes(&grid, &corners),
            CpdiBasis::parallelogram_nodes(&grid, &centre, &r),
        );
        for (a, b) in sums(free).iter().zip(&sums(convected)) {
            assert!((0..3).all(|k| (a[k] - b[k]).abs() < 1e-12), "{a:?}, {b:?}");
        }
    }

    #[test]
    fn the_gradient_is_that_of_the_explicit_form_in_the_plane() {
        // sheet: mpm §2.5e: corners 1..4 = (--), (+-), (++), (-+), V = 4 |r1 × r2|.
        let grid = Grid::new([0.0; 2], [1.0; 2], 0.25).unwrap();
        let (centre, r) = ([0.43, 0.58], [[0.11, 0.03], [-0.02, 0.09]]);
        let list: NodeList<2, 16> = CpdiBasis::parallelogram_nodes(&grid, &centre, &r);
        let volume = 4.0 * (r[0][0] * r[1][1] - r[0][1] * r[1][0]);
        let hat = |node: &[f64; 2], sign: [f64; 2]| -> f64 {
            let distance =
                |c: usize| (centre[c] + sign[0] * r[0][c] + sign[1] * r[1][c] - node[c]).abs() / 0.25;
            (0..2).map(|c| (1.0 - distance(c)).max(0.0)).product()
        };
        for i in 0..5 {
            for j in 0..5 {
                let node = [0.25 * f64::from(i), 0.25 * f64::from(j)];
                let [n1, n2, n3, n4] =
                    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|s| hat(&node, s));
                let exact = [
                    ((n1 - n3) * (r[0][1] - r[1][1]) + (n2 - n4) * (r[0][1] + r[1][1])) / volume,
                    ((n1 - n3) * (r[1][0] - r[0][0]) - (n2 - n4) * (r[0][0] + r[1][0])) / volume,
                ];
                let mut sum = (0.0, [0.0; 2]);
                for k in (0..16).filter(|&k| (0..2).all(|c| (list.positions[k][c] - node[c]).abs() < 1e-12)) {
                    sum.0 += list.weights[k];
                    (0..2).for_each(|c| sum.1[c] += list.gradients[k][c]);
                }
                assert!((sum.0 - 0.25 * (n1 + n2 + n3 + n4)).abs() < 1e-14);
                assert!((0..2).all(|c| (sum.1[c] - exact[c]).abs() < 1e-12), "{:?} for {exact:?}", sum.1);
            }
        }
    }
}
