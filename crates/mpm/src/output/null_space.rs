//! Null-space motion of points, which the grid does not represent, and points that are detached from the others.

use std::collections::{BTreeMap, BTreeSet};

use colluvium_case::spatial;

use crate::points::vectors::square;
use crate::setup::defaults::is_liquid;
use crate::setup::fall_time::{body_height, time_of_fall};
use crate::solver::MpmSolver;
use colluvium_case::Warning;

/// Fraction of null-space motion in the kinetic energy above which there is a warning.
const REPORTED_FRACTION: f64 = 0.5;
/// Least null-space energy for a warning, over the energy of a fall through the height of the body; at rest it is never exactly zero.
const MIN_ENERGY_RATIO: f64 = 1e-5;
/// Largest fraction of all points in a connected group that is regarded as detached.
const MAX_DETACHED_FRACTION: f64 = 0.01;

impl<const D: usize> MpmSolver<D> {
    /// Warning where null-space motion dominates the motion of the points.
    pub(crate) fn null_space_warning(&self) -> Option<Warning> {
        let case = &self.clock.case;
        let (mut all, mut null_space, mut fall, mut fastest) = (0.0, 0.0, 0.0, 0f64);
        for set in self.bodies.deformable_sets() {
            let height = body_height(case, &case.bodies[set.body as usize]);
            for (p, (mass, velocity)) in set.points.mass.iter().zip(&set.points.velocity).enumerate() {
                let grid_velocity = set.grid_velocity(p);
                let rest = square(&std::array::from_fn::<f64, D, _>(|c| velocity[c] - grid_velocity[c]));
                all += 0.5 * mass * square(velocity);
                null_space += 0.5 * mass * rest;
                fall += mass * case.gravity_magnitude() * height;
                fastest = fastest.max(rest.sqrt());
            }
        }
        let time = time_of_fall(case)?;
        (null_space > REPORTED_FRACTION * all && null_space > MIN_ENERGY_RATIO * fall).then(|| {
            let cure = match self.clock.options.residual_time {
                None => format!("set methods.mpm.residual_time to about {time:.2} s"),
                Some(_) => "shorten methods.mpm.residual_time".to_owned(),
            };
            Warning::new("noise-of-transfer", format!(
                "{null_space:.1e} J of the remaining kinetic energy ({all:.1e} J) is noise of the velocity \
                 transfer that does not move the material: velocities of points differ from those of the grid \
                 by up to {fastest:.2} m/s. To damp it, {cure}. The output field grid_velocity has the \
                 velocity without this noise"
            ))
        })
    }

    /// Warning for detached points, whose cells are not adjacent to cells of other points. Liquids spray: their detached points are drops.
    pub(crate) fn detached_points_warning(&self) -> Option<Warning> {
        let case = &self.clock.case;
        if self.background.is_meshed() || case.gravity_magnitude() == 0.0 || is_liquid(case) {
            return None;
        }
        let grid = &self.background.grid;
        let cell = |x: &[f64; D]| -> CellIndex {
            let own = grid.cell_of(x);
            std::array::from_fn(|axis| if axis < D { own[axis] } else { 0 })
        };
        let cells: Vec<CellIndex> =
            self.bodies.deformable_sets().flat_map(|set| &set.points.position).map(cell).collect();
        let (total, (count, lone)) = (cells.len(), detached_parts(&cells));
        let apart = |x: &&[f64; D]| lone.contains(&cell(x));
        let middle = self.centre_of_mass();
        let far = |x: &[f64; D]| square(&std::array::from_fn::<f64, D, _>(|c| x[c] - middle[c]));
        let positions = self.bodies.deformable_sets().flat_map(|set| &set.points.position);
        let farthest = positions.filter(apart).max_by(|a, b| far(a).total_cmp(&far(b)))?;
        let digits = (2.0 - grid.cell.log10()).ceil().max(0.0) as usize;
        Some(Warning::new(
            "detached-points",
            format!(
                "{count} of {total} points are detached: their cells do not touch cells of the other points. The \
             farthest is at {:.digits$?} m. The contiguous front and quantiles of the mass exclude these \
             points, the farthest point includes them",
                spatial(farthest)
            ),
        ))
    }

    /// Centre of mass of the deformable bodies (m).
    fn centre_of_mass(&self) -> [f64; D] {
        let (mut mass, mut sum) = (0.0, [0.0; D]);
        for set in self.bodies.deformable_sets() {
            for (m, x) in set.points.mass.iter().zip(&set.points.position) {
                mass += m;
                (0..D).for_each(|c| sum[c] += m * x[c]);
            }
        }
        sum.map(|c| c / mass)
    }
}

/// Index of a cell along the axes, zero along the axes that the space does not have.
type CellIndex = [usize; 3];

/// Number of points in detached groups of at most [`MAX_DETACHED_FRACTION`] of all points, and the cells of these groups.
fn detached_parts(cells: &[CellIndex]) -> (usize, BTreeSet<CellIndex>) {
    let mut held: BTreeMap<CellIndex, usize> = BTreeMap::new();
    for cell in cells {
        *held.entry(*cell).or_default() += 1;
    }
    let mut lone = BTreeSet::new();
    let (mut left, mut count) = (held.clone(), 0);
    while let Some((first, _)) = left.pop_first() {
        let (mut part, mut next) = (vec![first], 0);
        while next < part.len() {
            let near: Vec<_> =
                neighbouring_cells(part[next]).filter(|cell| left.remove(cell).is_some()).collect();
            part.extend(near);
            next += 1;
        }
        let points: usize = part.iter().map(|cell| held[cell]).sum();
        if points as f64 <= MAX_DETACHED_FRACTION * cells.len() as f64 {
            count += points;
            lone.extend(part);
        }
    }
    (count, lone)
}

/// Cells around a cell, cells outside the grid included.
fn neighbouring_cells(cell: CellIndex) -> impl Iterator<Item = CellIndex> {
    (0..27).map(move |number: usize| {
        std::array::from_fn(|axis| (cell[axis] + number / 3usize.pow(axis as u32) % 3).wrapping_sub(1))
    })
}

#[cfg(test)]
mod tests {
    use super::{CellIndex, detached_parts, neighbouring_cells};

    #[test]
    fn a_cell_has_all_its_neighbours_around_it() {
        let mut cells: Vec<CellIndex> = neighbouring_cells([4, 7, 1]).collect();
        cells.sort_unstable();
        let plane = |i: usize| (6..9).flat_map(move |j| (0..3).map(move |k| [i, j, k]));
        let exact: Vec<CellIndex> = (3..6).flat_map(plane).collect();
        assert_eq!(cells, exact);
    }

    #[test]
    fn small_groups_of_points_in_isolated_cells_are_detached() {
        let mut cells: Vec<CellIndex> = (0..400).map(|number| [number % 20, number / 20, 0]).collect();
        cells.extend([[21, 3, 0], [21, 3, 0], [20, 20, 0], [30, 5, 0]]);
        let (count, lone) = detached_parts(&cells);
        // Two beside an empty column and one farther off; across a corner cells touch.
        assert_eq!(count, 3);
        assert_eq!(lone.into_iter().collect::<Vec<_>>(), [[21, 3, 0], [30, 5, 0]]);
    }
}
