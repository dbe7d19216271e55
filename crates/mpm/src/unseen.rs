//! Motion of points that the grid does not see, and points that fly apart from the others.

use std::collections::{BTreeMap, BTreeSet};

use colluvium_case::spatial;

use crate::fall::{height, time_of_fall};
use crate::points::PointSet;
use crate::solver::MpmSolver;
use crate::vectors::square;

/// Share of the kinetic energy from which on unseen motion is told.
const NOTABLE: f64 = 0.5;
/// The same over what the mass would gain in a fall through the height of its body: at rest there is always some.
const LEAST: f64 = 1e-5;
/// Connected points of at most this share of all are apart from the others.
const FEW: f64 = 0.01;

impl<const D: usize> MpmSolver<D> {
    /// Velocity with which the grid moved a point in the last step (m/s), or its own where they are the same.
    pub(crate) fn grid_velocity(set: &PointSet<D>, p: usize) -> [f64; D] {
        let seen = set.points.seen.get(p).filter(|_| set.rigid.is_none());
        seen.copied().unwrap_or(set.points.velocity[p])
    }

    /// A word where most of the motion of the points is one that the grid does not see.
    pub(crate) fn remark_on_unseen_motion(&self) -> Option<String> {
        let case = &self.clock.case;
        let (mut all, mut unseen, mut fall, mut fastest) = (0.0, 0.0, 0.0, 0f64);
        for set in self.soft_sets() {
            let height = height(case, &case.bodies[set.body as usize]);
            for (p, (mass, velocity)) in set.points.mass.iter().zip(&set.points.velocity).enumerate() {
                let seen = Self::grid_velocity(set, p);
                let rest = square(&std::array::from_fn::<f64, D, _>(|c| velocity[c] - seen[c]));
                all += 0.5 * mass * square(velocity);
                unseen += 0.5 * mass * rest;
                fall += mass * case.gravity_size() * height;
                fastest = fastest.max(rest.sqrt());
            }
        }
        let time = time_of_fall(case)?;
        (unseen > NOTABLE * all && unseen > LEAST * fall).then(|| {
            let cure = match self.clock.options.residual_time {
                None => format!("methods.mpm.residual_time takes it away, {time:.2} s = √(H/g) for example"),
                Some(_) => "a shorter methods.mpm.residual_time takes it away sooner".to_owned(),
            };
            format!(
                "{unseen:.1e} J of the {all:.1e} J of kinetic energy are motion of the points beyond that of the grid, up to {fastest:.2} m/s: \
                 it moves nothing, and keeps them restless; {cure}. The field grid_velocity has what moves them"
            )
        })
    }

    /// A word on points that are apart from the others: their cells touch no cell of the others.
    pub(crate) fn remark_on_points_apart(&self) -> Option<String> {
        if self.background.is_meshed() || self.clock.case.gravity_size() == 0.0 {
            return None;
        }
        let grid = &self.background.grid;
        let mut cells: BTreeMap<[usize; D], usize> = BTreeMap::new();
        for x in self.soft_sets().flat_map(|set| &set.points.position) {
            *cells.entry(grid.cell_of(x)).or_default() += 1;
        }
        let total: usize = cells.values().sum();
        let mut lone = BTreeSet::new();
        let (mut left, mut count) = (cells.clone(), 0);
        while let Some((first, _)) = left.pop_first() {
            let (mut part, mut next) = (vec![first], 0);
            while next < part.len() {
                let near: Vec<_> = around(part[next]).filter(|cell| left.remove(cell).is_some()).collect();
                part.extend(near);
                next += 1;
            }
            let points: usize = part.iter().map(|cell| cells[cell]).sum();
            if points as f64 <= FEW * total as f64 {
                count += points;
                lone.extend(part);
            }
        }
        let apart = |x: &&[f64; D]| lone.contains(&grid.cell_of(x));
        let middle = self.middle();
        let far = |x: &[f64; D]| square(&std::array::from_fn::<f64, D, _>(|c| x[c] - middle[c]));
        let positions = self.soft_sets().flat_map(|set| &set.points.position);
        let farthest = positions.filter(apart).max_by(|a, b| far(a).total_cmp(&far(b)))?;
        let digits = (2.0 - grid.cell.log10()).ceil().max(0.0) as usize;
        Some(format!(
            "{count} of {total} points are apart from the others, in cells that touch none of theirs, the farthest at {:.digits$?} m: the contiguous \
             front and quantiles of the mass leave them out, the farthest point does not",
            spatial(farthest)
        ))
    }

    /// The centre of mass of what deforms (m).
    fn middle(&self) -> [f64; D] {
        let (mut mass, mut sum) = (0.0, [0.0; D]);
        for set in self.soft_sets() {
            for (m, x) in set.points.mass.iter().zip(&set.points.position) {
                mass += m;
                (0..D).for_each(|c| sum[c] += m * x[c]);
            }
        }
        sum.map(|c| c / mass)
    }
}

/// The cells around one, those beyond the grid among them.
fn around<const D: usize>(cell: [usize; D]) -> impl Iterator<Item = [usize; D]> {
    (0..3usize.pow(D as u32)).map(move |number| {
        std::array::from_fn(|axis| (cell[axis] + number / 3usize.pow(axis as u32) % 3).wrapping_sub(1))
    })
}

#[cfg(test)]
mod tests {
    use super::around;

    #[test]
    fn a_cell_has_all_its_neighbours_around_it() {
        let mut cells: Vec<[usize; 2]> = around([4, 7]).collect();
        cells.sort_unstable();
        let exact: Vec<[usize; 2]> = (3..6).flat_map(|i| (6..9).map(move |j| [i, j])).collect();
        assert_eq!(cells, exact);
    }
}
