//! Pairs found by size classes, listed in the order of a uniform grid.

use crate::boundary::periodic_cell::PeriodicCell;
use crate::neighbours::{MAX_DIMENSION, PairCriterion, VerletLists, cell_of, count_sort};

/// Ratio of largest to smallest radius above which pairs are searched by size classes (sheet: dem §3.2).
const MIN_SIZE_RATIO: f64 = 3.0;

/// Pairs found in the search: listing grain, position of the cell of the other grain, other grain and its image, and whether they are
/// periodic pairs.
#[derive(Clone, Debug, Default)]
pub(super) struct FoundPairs {
    pairs: Vec<(u32, u8, u32, u8, bool)>,
    row_offsets: Vec<u32>,
    order: Vec<u32>,
    keys: Vec<u32>,
}

impl<const D: usize, const R: usize> VerletLists<D, R> {
    /// Whether the radii differ so much that uniform cells would contain too many small grains.
    pub(super) fn is_wide(&self, radii: &[f64]) -> bool {
        let ends = |(low, high): (f64, f64), r: &f64| (low.min(*r), high.max(*r));
        let (low, high) = radii.iter().fold((f64::INFINITY, 0.0), ends);
        !self.uniform_cells && high > MIN_SIZE_RATIO * low
    }

    /// Lists the pairs that the size classes give, in the order of the search in uniform cells.
    pub(super) fn list_by_size_class(&mut self, criterion: &PairCriterion<'_, D, R>, all: bool) {
        let grains = criterion.grains;
        let Self { found_pairs, classes, slab_pairs, periodic_pairs, keys, order, counts, axes, .. } = self;
        let cells = UniformCells { counts: *counts, axes: *axes, keys, order };
        // Positions are finite: `build` has checked them.
        let built = classes.build(&grains.position, &grains.radius, criterion.cell, criterion.gap);
        debug_assert!(built.is_ok(), "{built:?}");
        let FoundPairs { pairs, row_offsets, order, keys } = found_pairs;
        pairs.clear();
        classes.visit(&grains.radius, |i, j, steps| {
            if let Some(code) = criterion.near_image(i, j, steps) {
                pairs.extend(cells.list_position((i, j), steps, code, all));
            }
        });
        keys.clear();
        keys.extend(pairs.iter().map(|pair| pair.0));
        count_sort(keys, grains.len(), row_offsets, order);
        for i in 0..grains.len() {
            let own = &mut order[row_offsets[i] as usize..row_offsets[i + 1] as usize];
            own.sort_unstable_by_key(|&k| (pairs[k as usize].1, pairs[k as usize].2));
            for &k in &*own {
                let (.., other, code, is_periodic) = pairs[k as usize];
                let list = if is_periodic { &mut *periodic_pairs } else { &mut *slab_pairs };
                list.second.push(other);
                if criterion.periodic {
                    list.image.push(code);
                }
            }
            slab_pairs.row_offsets.push(slab_pairs.second.len() as u32);
            periodic_pairs.row_offsets.push(periodic_pairs.second.len() as u32);
        }
    }
}

/// Uniform cells, and the cell of each grain.
struct UniformCells<'a> {
    counts: [usize; MAX_DIMENSION],
    axes: [usize; MAX_DIMENSION],
    keys: &'a [u32],
    order: &'a [u32],
}

impl UniformCells<'_> {
    /// Position of a pair in the list of uniform cells, whose second grain is `steps` cells away; `None` if uniform cells would not list
    /// it.
    fn list_position<const D: usize>(
        &self,
        (i, j): (usize, usize),
        steps: [i32; D],
        code: u8,
        all: bool,
    ) -> Option<(u32, u8, u32, u8, bool)> {
        let back = PeriodicCell::image_index(&steps.map(|step| -step));
        if all {
            let (first, second, code) = if i < j { (i, j, code) } else { (j, i, back) };
            return Some((first as u32, 0, second as u32, code, false));
        }
        let half = 3usize.pow(D as u32) / 2;
        let cells: [[usize; D]; 2] = [i, j]
            .map(|grain| cell_of(self.keys[self.order[grain] as usize] as usize, &self.counts, &self.axes));
        let mut ahead = 0;
        for &axis in &self.axes[..D] {
            let other = cells[1][axis] as i64 + i64::from(steps[axis]) * self.counts[axis] as i64;
            let offset = other - cells[0][axis] as i64;
            if offset.abs() > 1 {
                return None;
            }
            ahead = 3 * ahead + (offset + 1) as usize;
        }
        let is_periodic = steps[self.axes[0]] != 0;
        let forward = if ahead == half { i < j } else { ahead > half };
        let (first, second, code) = if forward { (i, j, code) } else { (j, i, back) };
        Some((first as u32, ahead.abs_diff(half) as u8, second as u32, code, is_periodic))
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use crate::boundary::periodic_cell::{PeriodicCell, apply};
    use crate::contact::contact_histories::HistoryColumns;
    use crate::neighbours::{ListReach, VerletLists};
    use crate::points::grains::Grains;
    use crate::points::vector::{difference, dot};

    /// Random grains in a cell, with radii between two bounds, most of them small, some held.
    fn grains<const D: usize, const R: usize>(
        count: usize,
        [low, largest]: [f64; 2],
        cell: &PeriodicCell<D>,
        seed: u64,
    ) -> Grains<D, R> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut grains = Grains::default();
        for _ in 0..count {
            let radius = low * (largest / low).powf(random.random::<f64>().powi(2));
            let s: [f64; D] = std::array::from_fn(|_| random.random::<f64>());
            let x = apply(&cell.h, &s);
            grains.push(0, 0, std::array::from_fn(|c| cell.origin[c] + x[c]), radius, 1.0);
            let last = grains.len() - 1;
            grains.is_held[last] = random.random::<f64>() < 0.1;
        }
        grains
    }

    /// Pairs by ids, the smaller one first.
    fn ids<const D: usize, const R: usize>(
        lists: &VerletLists<D, R>,
        grains: &Grains<D, R>,
    ) -> Vec<(u32, u32)> {
        let mut all = Vec::new();
        for pairs in [&lists.slab_pairs, &lists.periodic_pairs] {
            for (i, k) in pairs.first_grains() {
                let (a, b) = (grains.id[i], grains.id[pairs.second[k] as usize]);
                all.push((a.min(b), a.max(b)));
            }
        }
        all
    }

    /// Pairs by a search over all grains and all images.
    fn all_pairs<const D: usize, const R: usize>(
        grains: &Grains<D, R>,
        cell: &PeriodicCell<D>,
        gap: f64,
    ) -> BTreeSet<(u32, u32)> {
        let mut shifts = Vec::new();
        cell.shifts(&mut shifts);
        let mut all = BTreeSet::new();
        for i in 0..grains.len() {
            for j in (0..i).filter(|&j| !(grains.is_held[i] && grains.is_held[j])) {
                let limit = grains.radius[i] + grains.radius[j] + gap;
                let apart = difference(&grains.position[i], &grains.position[j]);
                let near = (0..PeriodicCell::<D>::images()).filter(|&code| {
                    let own = PeriodicCell::<D>::image_steps(code as u8);
                    (0..D).all(|c| own[c] == 0 || cell.periodic[c])
                });
                let found = near.filter(|&code| {
                    let apart = difference(&apart, &shifts[code].0);
                    dot(&apart, &apart) < limit * limit
                });
                if found.count() > 0 {
                    let (a, b) = (grains.id[i], grains.id[j]);
                    all.insert((a.min(b), a.max(b)));
                }
            }
        }
        all
    }

    fn same_pairs<const D: usize, const R: usize>(
        periodic: [bool; D],
        shear: f64,
        (count, ends, gap): (usize, [f64; 2], f64),
        seed: u64,
    ) -> Result<(), TestCaseError> {
        let mut cell = PeriodicCell::new([-2.0; D], [8.0; D], periodic);
        cell.h[0][D - 1] = if periodic[0] && periodic[D - 1] { shear } else { 0.0 };
        cell.reduce();
        let mut drawn = grains::<D, R>(count, ends, &cell, seed);
        // Both radius bounds occur, whatever was drawn.
        (drawn.radius[0], drawn.radius[1]) = (ends[0], ends[1]);
        let reach = ListReach { gap, radius: drawn.radii().1 };
        let (mut by_class, mut by_cell) = (drawn.clone(), drawn.clone());
        let mut classes = VerletLists::<D, R>::default();
        let mut one = VerletLists::<D, R> { uniform_cells: true, ..VerletLists::default() };
        prop_assert!(classes.is_wide(&drawn.radius) && !one.is_wide(&drawn.radius));
        classes.build(&mut by_class, &cell, reach, HistoryColumns::default()).unwrap();
        one.build(&mut by_cell, &cell, reach, HistoryColumns::default()).unwrap();
        let found = ids(&classes, &by_class);
        let set: BTreeSet<(u32, u32)> = found.iter().copied().collect();
        prop_assert_eq!(set.len(), found.len());
        prop_assert_eq!(set, all_pairs(&drawn, &cell, gap));
        // The lists are equal to those of uniform cells, in the same order.
        prop_assert_eq!(&by_class.id, &by_cell.id);
        for (a, b) in [(&classes.slab_pairs, &one.slab_pairs), (&classes.periodic_pairs, &one.periodic_pairs)]
        {
            prop_assert_eq!(&a.row_offsets, &b.row_offsets);
            prop_assert_eq!(&a.second, &b.second);
            prop_assert_eq!(&a.image, &b.image);
        }
        Ok(())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(48))]

        #[test]
        fn pairs_by_size_classes_equal_those_of_an_all_pairs_search(
            axes in prop::array::uniform3(any::<bool>()),
            shear in -4.9..4.9f64,
            count in 40usize..400,
            largest in 0.5..2.0f64,
            ratio in 3.5..100.0f64,
            gap in 0.0..0.3f64,
            seed in any::<u64>(),
        ) {
            // Uniform cells are fewer than three along an axis where grains are large.
            let of = (count, [largest / ratio, largest], gap);
            same_pairs::<2, 1>([axes[0], axes[1]], shear, of, seed)?;
            same_pairs::<3, 3>(axes, shear, of, seed)?;
        }
    }
}
