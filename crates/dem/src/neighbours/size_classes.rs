//! Search among grains of very different sizes: one grid per size class (sheet: dem §3.2).
//!
//! A class contains the radii between a power of one half of the largest and the next one; the cells of its grid are as wide as the
//! reach of two of its largest grains. A grain searches the grid of its own class and those of the larger ones: the smaller
//! grain of a pair finds the pair, and no search runs over the small grains in a cell as wide as the largest.

use colluvium_points::SearchError;

use crate::boundary::periodic_cell::{PeriodicCell, inverse};

/// Largest number of size classes; the last one contains all smaller grains.
const CLASSES: usize = 12;

/// Largest number of grid cells per grain, above which cells are made wider.
const CELLS_A_GRAIN: f64 = 4.0;

/// Margin of a search for round-off, in cells.
const ROUND_OFF: f64 = 1e-9;

/// Grid of a size class.
#[derive(Clone, Debug, Default)]
struct ClassGrid<const D: usize> {
    /// Largest radius (m).
    radius: f64,
    /// Cells along each axis.
    counts: Vec<usize>,
    /// Cells per unit of each reduced coordinate.
    scale: Vec<f64>,
    cell_offsets: Vec<u32>,
    /// Grains by cell, ascending within one.
    members: Vec<u32>,
}

/// Search grids of all size classes of a set of balls.
#[derive(Clone, Debug, Default)]
pub struct SizeClasses<const D: usize> {
    grids: Vec<ClassGrid<D>>,
    size_class: Vec<u8>,
    /// Reduced coordinates, along axes that are not periodic relative to the lowest grain.
    reduced_position: Vec<[f64; D]>,
    periodic: Vec<bool>,
    /// Reduced coordinate per metre across the sides of the cell (1/m).
    per_metre: Vec<f64>,
    gap: f64,
    keys: Vec<u32>,
}

/// Size class of a radius, of which the largest is `max_radius`.
fn class_of(radius: f64, max_radius: f64) -> u8 {
    let (mut class, mut bound) = (0u8, 0.5 * max_radius);
    while radius <= bound && usize::from(class) < CLASSES - 1 {
        bound *= 0.5;
        class += 1;
    }
    class
}

impl<const D: usize> SizeClasses<D> {
    /// Sorts balls at `positions` (m) with their radii (m) into the grids; positions are in the cell along its periodic axes. Pairs are
    /// found up to a gap (m).
    ///
    /// # Errors
    /// When a coordinate is not finite.
    pub fn build(
        &mut self,
        positions: &[[f64; D]],
        radii: &[f64],
        cell: &PeriodicCell<D>,
        gap: f64,
    ) -> Result<(), SearchError> {
        if let Some(lost) = positions.iter().position(|x| x.iter().any(|c| !c.is_finite())) {
            return Err(SearchError::NotFinite(lost));
        }
        let (unit, _) = inverse(&cell.h);
        let widths = cell.widths();
        self.gap = gap;
        self.periodic = cell.periodic.to_vec();
        self.per_metre = widths.iter().map(|width| 1.0 / width).collect();
        self.reduced_position.clear();
        self.reduced_position.extend(positions.iter().map(|x| cell.reduced(&unit, x)));
        let mut extent = [1.0; D];
        for axis in (0..D).filter(|&axis| !cell.periodic[axis]) {
            let along = self.reduced_position.iter().map(|s| s[axis]);
            let (low, high) =
                along.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), s| (a.min(s), b.max(s)));
            self.reduced_position.iter_mut().for_each(|s| s[axis] -= low);
            extent[axis] = (high - low).max(0.0);
        }
        let max_radius = radii.iter().copied().fold(0.0, f64::max);
        self.size_class.clear();
        self.size_class.extend(radii.iter().map(|radius| class_of(*radius, max_radius)));
        let last = self.size_class.iter().copied().max().unwrap_or(0);
        self.grids.resize(usize::from(last) + 1, ClassGrid::default());
        for class in 0..=last {
            self.bin(class, radii, &extent);
        }
        Ok(())
    }

    /// Sorts the grains of a size class into cells that are as wide as the range of their contacts.
    fn bin(&mut self, class: u8, radii: &[f64], extent: &[f64; D]) {
        let members: Vec<usize> = (0..radii.len()).filter(|i| self.size_class[*i] == class).collect();
        let radius = members.iter().map(|&i| radii[i]).fold(0.0, f64::max);
        let grid = &mut self.grids[usize::from(class)];
        (grid.radius, grid.counts, grid.scale) = (radius, vec![1; D], vec![1.0; D]);
        grid.members.clear();
        if members.is_empty() {
            return;
        }
        let width = (2.0 * radius + self.gap) * (1.0 + ROUND_OFF);
        let along = |wider: f64| -> [f64; D] {
            std::array::from_fn(|c| (extent[c] / (self.per_metre[c] * width * wider)).floor().max(1.0))
        };
        let limit = (CELLS_A_GRAIN * members.len() as f64).max(64.0);
        let mut wider = 1.0;
        while along(wider).iter().product::<f64>() > limit {
            wider *= 1.25;
        }
        for (c, count) in along(wider).into_iter().enumerate() {
            grid.counts[c] = count as usize;
            grid.scale[c] = if extent[c] > 0.0 { count / extent[c] } else { 0.0 };
        }
        self.keys.clear();
        let place = |i: &usize| {
            (0..D).fold(0usize, |key, c| {
                let cell = (self.reduced_position[*i][c] * grid.scale[c]).max(0.0) as usize;
                key * grid.counts[c] + cell.min(grid.counts[c] - 1)
            }) as u32
        };
        self.keys.extend(members.iter().map(place));
        let total = grid.counts.iter().product();
        crate::neighbours::count_sort(&self.keys, total, &mut grid.cell_offsets, &mut grid.members);
        grid.members.iter_mut().for_each(|member| *member = members[*member as usize] as u32);
    }

    /// Calls `visit` once for each pair of balls that may be within the gap. The lattice steps are those to the image of the second ball.
    /// Where a cell is narrower than four reaches there may be two such images.
    pub fn visit(&self, radii: &[f64], mut visit: impl FnMut(usize, usize, [i32; D])) {
        for (i, radius) in radii.iter().enumerate() {
            let own = usize::from(self.size_class[i]);
            for (class, grid) in self.grids[..=own].iter().enumerate() {
                if grid.members.is_empty() {
                    continue;
                }
                self.visit_balls_within(grid, i, radius + grid.radius + self.gap, |j, steps| {
                    // Of two grains in one class the first finds the second.
                    if class < own || j > i {
                        visit(i, j, steps);
                    }
                });
            }
        }
    }

    /// Visits the balls in the grid cells within `reach` of ball `i` (m).
    #[inline]
    fn visit_balls_within(
        &self,
        grid: &ClassGrid<D>,
        i: usize,
        reach: f64,
        mut visit: impl FnMut(usize, [i32; D]),
    ) {
        let (mut low, mut spans) = ([0i64; D], [1i64; D]);
        for c in 0..D {
            let at = self.reduced_position[i][c] * grid.scale[c];
            let distance = reach * self.per_metre[c] * grid.scale[c] + ROUND_OFF;
            let last = grid.counts[c] as i64 - 1;
            let (mut from, mut to) = ((at - distance).floor() as i64, (at + distance).floor() as i64);
            if !self.periodic[c] {
                (from, to) = (from.clamp(0, last), to.clamp(0, last));
            }
            (low[c], spans[c]) = (from, to - from + 1);
        }
        for number in 0..spans.iter().product::<i64>() {
            let (mut rest, mut steps) = (number, [0i32; D]);
            let mut key = [0usize; D];
            for c in (0..D).rev() {
                let place = low[c] + rest % spans[c];
                rest /= spans[c];
                let count = grid.counts[c] as i64;
                (key[c], steps[c]) = (place.rem_euclid(count) as usize, place.div_euclid(count) as i32);
            }
            let key = (0..D).fold(0, |sum, c| sum * grid.counts[c] + key[c]);
            for &j in &grid.members[grid.cell_offsets[key] as usize..grid.cell_offsets[key + 1] as usize] {
                visit(j as usize, steps);
            }
        }
    }
}
