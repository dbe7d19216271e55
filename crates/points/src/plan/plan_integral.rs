//! Integrals over polygons in plan, cell by cell of a grid.

use crate::plan::polygon::signed_area;
use crate::{Polygon, Ring};

/// Grid of cells in plan.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlanGrid {
    /// Corner of a cell of the grid (m).
    pub(crate) origin: [f64; 2],
    /// Widths of the cells (m).
    pub(crate) step: [f64; 2],
}

/// Area (m²) and first moments (m³) of the part of a polygon in a cell.
#[derive(Clone, Copy, Debug, Default)]
struct AreaMoments {
    area: f64,
    first: [f64; 2],
}

impl AreaMoments {
    /// Adds area and moments of a ring, times `sign`.
    fn add(&mut self, ring: &[[f64; 2]], sign: f64) {
        let mut last = match ring {
            [] => return,
            [.., last] => *last,
        };
        for next in ring {
            let cross = sign * (last[0] * next[1] - next[0] * last[1]);
            self.area += 0.5 * cross;
            for c in 0..2 {
                self.first[c] += cross * (last[c] + next[c]) / 6.0;
            }
            last = *next;
        }
    }
}

/// Integral of a function over disjoint polygons (m² times its unit). In each cell of the grid it is the area of the polygons times the
/// function at their centroid. Functions that are bilinear in cells are integrated exactly over whole cells.
pub(crate) fn integrate_over_polygons(
    polygons: &[Polygon],
    grid: &PlanGrid,
    function: &mut dyn FnMut([f64; 2]) -> f64,
) -> f64 {
    polygons.iter().map(|polygon| integrate_over_polygon(polygon, grid, function)).sum()
}

/// Integral of a function over a polygon, cell by cell of a grid.
fn integrate_over_polygon(
    polygon: &Polygon,
    grid: &PlanGrid,
    function: &mut dyn FnMut([f64; 2]) -> f64,
) -> f64 {
    let corners = || polygon.iter().flatten();
    let low: [f64; 2] = std::array::from_fn(|c| corners().map(|x| x[c]).fold(f64::INFINITY, f64::min));
    let high: [f64; 2] = std::array::from_fn(|c| corners().map(|x| x[c]).fold(f64::NEG_INFINITY, f64::max));
    let cell = |x: f64, c: usize| (x - grid.origin[c]) / grid.step[c];
    let first: [f64; 2] = std::array::from_fn(|c| cell(low[c], c).floor());
    let [columns, rows] = [0, 1].map(|c| (cell(high[c], c).ceil() - first[c]).max(1.0) as usize);
    // Coordinates relative to the first cell, so that no digits are lost far from the origin.
    let start: [f64; 2] = std::array::from_fn(|c| grid.origin[c] + first[c] * grid.step[c]);
    let rings: Vec<(Ring, f64)> = (polygon.iter().enumerate())
        .map(|(number, ring)| {
            let ring: Ring = ring.iter().map(|x| [x[0] - start[0], x[1] - start[1]]).collect();
            let sign = signed_area(&ring).signum() * if number == 0 { 1.0 } else { -1.0 };
            (ring, sign)
        })
        .collect();
    let (mut sum, mut row_of, [mut strip, mut piece, mut half]) =
        (0.0, vec![AreaMoments::default(); columns], [(); 3].map(|()| Ring::new()));
    for row in 0..rows {
        row_of.fill(AreaMoments::default());
        for (ring, sign) in &rings {
            clip_to_strip(
                ring,
                1,
                [row as f64, (row + 1) as f64].map(|y| y * grid.step[1]),
                &mut strip,
                &mut half,
            );
            let (low, high) = strip
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x[0]), high.max(x[0])));
            if !(low < high) {
                continue;
            }
            let last = ((high / grid.step[0]) as usize).min(columns - 1);
            for column in (low / grid.step[0]) as usize..=last {
                let ends = [column as f64, (column + 1) as f64].map(|x| x * grid.step[0]);
                clip_to_strip(&strip, 0, ends, &mut piece, &mut half);
                row_of[column].add(&piece, *sign);
            }
        }
        for own in row_of.iter().filter(|own| own.area > 1e-12 * grid.step[0] * grid.step[1]) {
            sum += own.area * function(std::array::from_fn(|c| start[c] + own.first[c] / own.area));
        }
    }
    sum
}

/// Part of a ring between two values of a coordinate (m), written to `out`. Edges there and back along the ends have no area.
fn clip_to_strip(ring: &[[f64; 2]], axis: usize, ends: [f64; 2], out: &mut Ring, half: &mut Ring) {
    clip_to_half_plane(ring, axis, ends[0], 1.0, half);
    clip_to_half_plane(half, axis, ends[1], -1.0, out);
}

/// Part of a ring on one side of a value of a coordinate, written to `out`.
fn clip_to_half_plane(ring: &[[f64; 2]], axis: usize, value: f64, side: f64, out: &mut Ring) {
    out.clear();
    let Some(mut last) = ring.last() else { return };
    for next in ring {
        let (from, to) = (side * (last[axis] - value), side * (next[axis] - value));
        if (from < 0.0) != (to < 0.0) {
            let share = from / (from - to);
            let mut crossing: [f64; 2] = std::array::from_fn(|c| last[c] + share * (next[c] - last[c]));
            crossing[axis] = value;
            out.push(crossing);
        }
        if to >= 0.0 {
            out.push(*next);
        }
        last = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRID: PlanGrid = PlanGrid { origin: [0.3, -0.1], step: [0.5, 0.25] };

    fn assert_close(found: f64, exact: f64) {
        assert!((found / exact - 1.0).abs() < 1e-12, "{found} for {exact}");
    }

    #[test]
    fn areas_and_moments_of_polygons_with_holes_are_exact() {
        let outer = vec![[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [2.0, 1.0], [0.0, 3.0]];
        let hole = vec![[0.5, 0.5], [1.0, 0.5], [1.0, 1.0], [0.5, 1.0]];
        for shift in [0.0, 5e6] {
            let moved = |ring: &Ring| -> Ring { ring.iter().map(|x| [x[0] + shift, x[1] + shift]).collect() };
            let mut turned = moved(&outer);
            turned.reverse();
            for first in [moved(&outer), turned] {
                let polygons = vec![vec![first, moved(&hole)]];
                assert_close(integrate_over_polygons(&polygons, &GRID, &mut |_| 1.0), 12.0 - 4.0 - 0.25);
                let found = integrate_over_polygons(&polygons, &GRID, &mut |x| x[0] - shift);
                assert!((found - (2.0 * 8.0 - 0.25 * 0.75)).abs() < 1e-8, "{found}");
            }
        }
    }

    #[test]
    fn functions_that_are_bilinear_in_cells_are_integrated_exactly_over_whole_cells() {
        let [x, y] = [0.3, -0.1];
        let ring = vec![[x, y], [x + 2.0, y], [x + 2.0, y + 1.0], [x, y + 1.0]];
        let found = integrate_over_polygons(&[vec![ring]], &GRID, &mut |p| (p[0] - x) * (p[1] - y));
        assert_close(found, 2.0 * 0.5);
    }
}
