//! Active pairs: listed pairs that can come into contact before grains have moved further. The other pairs stay apart for a while, and
//! steps skip them. Forces and their order are those of the whole lists.

use std::ops::Range;

use rayon::prelude::*;

use crate::contact::ContactState;
use crate::contact::contact_histories::PairList;
use crate::neighbours::VerletLists;
use crate::points::grains::Grains;
use crate::points::vector::{WIDTH, difference, dot};

/// Smallest gap up to which pairs are active, as a fraction of the list margin.
const MIN_GAP_FRACTION: f64 = 1.0 / 16.0;

/// Gap up to which pairs are active over the present approach of the grains.
const REACH_FACTOR: f64 = 4.0;

/// Factor below one as margin for round-off in sums of displacements.
const ROUND_OFF_FACTOR: f64 = 1.0 - 1e-9;

/// Pair of grains close to contact, as one record. Numbers count from the first grain and pair of its slab.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(align(16))]
pub struct ActivePair {
    /// Index of the first grain.
    pub first: u32,
    /// Index of the second grain.
    pub second: u32,
    /// Number of the pair in its list.
    pub slot: u32,
    /// Image index of the second grain.
    pub image_index: u32,
}

/// Pairs close to contact of a slab, or of the periodic pairs, in the order of their list.
#[derive(Clone, Debug, Default)]
pub struct ActivePairs {
    /// The pairs; the last one is repeated to fill up the last SIMD group.
    pairs: Vec<ActivePair>,
    count: usize,
}

/// Active pairs of all lists.
#[derive(Clone, Debug, Default)]
pub struct ActivePairLists {
    /// Active pairs of each slab.
    pub slabs: Vec<ActivePairs>,
    /// Active periodic pairs.
    pub periodic_pairs: ActivePairs,
    /// Approach of two grains since the list build for which the selection is valid (m); `None` before the first selection.
    valid_approach: Option<f64>,
}

impl ActivePairLists {
    /// Invalidates the selection, so that the next step selects again.
    pub fn clear(&mut self) {
        self.valid_approach = None;
    }
}

impl ActivePairs {
    /// Groups of four pairs, with the number of valid pairs in each.
    pub fn groups_of_four(&self) -> impl Iterator<Item = (&[ActivePair; WIDTH], usize)> {
        let (groups, _) = self.pairs.as_chunks();
        groups.iter().enumerate().map(|(n, group)| (group, (self.count - WIDTH * n).min(WIDTH)))
    }

    /// Selects the pairs of a range of grains that have a contact history or were `near` at the list build.
    fn select<const R: usize>(
        &mut self,
        pairs: &PairList<R>,
        rows: Range<usize>,
        near: impl Fn(usize, usize, usize) -> bool,
    ) {
        self.pairs.clear();
        let (row, pair) = (rows.start, pairs.row_offsets.get(rows.start).map_or(0, |start| *start));
        for i in rows {
            for k in pairs.row_offsets[i] as usize..pairs.row_offsets[i + 1] as usize {
                let (second, code) = (pairs.second[k], pairs.image.get(k).map_or(0, |code| u32::from(*code)));
                if pairs.histories.state[k] != ContactState::Apart || near(i, second as usize, code as usize)
                {
                    let first = (i - row) as u32;
                    let second = second - row as u32;
                    self.pairs.push(ActivePair { first, second, slot: k as u32 - pair, image_index: code });
                }
            }
        }
        self.count = self.pairs.len();
        let last = self.pairs.last().copied().unwrap_or_default();
        self.pairs.resize(self.count.next_multiple_of(WIDTH), last);
    }
}

impl<const D: usize, const R: usize> VerletLists<D, R> {
    /// Empties the selection, for steps that process all listed pairs.
    pub fn clear_active(&mut self) {
        self.active_pairs.clear();
        self.active_pairs.slabs.resize_with(self.slab_count(), ActivePairs::default);
    }

    /// Selects the active pairs again, if grains have approached by more than the last bound since the list build (m). `shifts` are the
    /// image displacements at the list build; without them all pairs are selected.
    pub fn select_active(
        &mut self,
        grains: &Grains<D, R>,
        shifts: Option<&[([f64; D], [f64; D])]>,
        closer: f64,
        skin: f64,
    ) {
        if self.active_pairs.valid_approach.is_some_and(|reach| closer < ROUND_OFF_FACTOR * reach) {
            return;
        }
        // A multiple of the present approach, so that few selections are made when displacements grow steadily.
        let ahead = (REACH_FACTOR * closer).max(MIN_GAP_FRACTION * skin);
        let reach = if ahead < skin && shifts.is_some() { ahead } else { f64::INFINITY };
        let near = |i: usize, j: usize, code: usize| {
            let mut apart = difference(&grains.listed_position[i], &grains.listed_position[j]);
            if let (Some(shifts), true) = (shifts, code > 0) {
                apart = difference(&apart, &shifts[code].0);
            }
            let limit = grains.radius[i] + grains.radius[j] + reach;
            dot(&apart, &apart) < limit * limit
        };
        let (slabs, slab_pairs) = (&self.slabs, &self.slab_pairs);
        let count = slabs.len().saturating_sub(1);
        self.active_pairs.slabs.resize_with(count, ActivePairs::default);
        self.active_pairs.slabs.par_iter_mut().zip(slabs.par_windows(2)).for_each(|(run, ends)| {
            run.select(slab_pairs, ends[0] as usize..ends[1] as usize, near);
        });
        let count = self.periodic_pairs.row_offsets.len().saturating_sub(1);
        self.active_pairs.periodic_pairs.select(&self.periodic_pairs, 0..count, near);
        self.active_pairs.valid_approach = Some(reach);
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::boundary::periodic_cell::PeriodicCell;
    use crate::contact::ContactState;
    use crate::contact::contact_histories::HistoryColumns;
    use crate::neighbours::ListReach;

    const SKIN: f64 = 0.3;

    fn random_grains() -> (Grains<3, 3>, VerletLists<3, 3>, ChaCha8Rng) {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let mut grains = Grains::default();
        for _ in 0..800 {
            let place = std::array::from_fn(|_| 9.0 * random.random::<f64>());
            grains.push(0, 0, place, 0.3 + 0.2 * random.random::<f64>(), 1.0);
        }
        let cell = PeriodicCell::new([0.0; 3], [9.0; 3], [false; 3]);
        let mut lists = VerletLists::default();
        let reach = ListReach { gap: SKIN, radius: grains.radii().1 };
        lists.build(&mut grains, &cell, reach, HistoryColumns::default()).unwrap();
        (grains, lists, random)
    }

    fn selected_pairs(lists: &VerletLists<3, 3>) -> Vec<u32> {
        let slots = |(slab, run): (usize, &ActivePairs)| {
            let from = lists.slab_pairs.row_offsets[lists.slabs[slab] as usize];
            run.pairs[..run.count].iter().map(move |pair| from + pair.slot).collect::<Vec<_>>()
        };
        lists.active_pairs.slabs.iter().enumerate().flat_map(slots).collect()
    }

    #[test]
    fn pairs_that_can_meet_within_the_allowed_approach_are_active() {
        let (mut grains, mut lists, mut random) = random_grains();
        let listed = lists.slab_pairs.second.len();
        for closer in [0.0, 0.01, 0.02, 0.09, 0.2, SKIN] {
            lists.select_active(&grains, Some(&[]), closer, SKIN);
            let chosen = selected_pairs(&lists);
            assert!(chosen.is_sorted());
            assert_eq!(
                chosen.len() == listed,
                REACH_FACTOR * closer >= SKIN,
                "{closer}: {} of {listed}",
                chosen.len()
            );
            grains.position.clone_from(&grains.listed_position);
            for x in &mut grains.position {
                // Half of the approach of the two, along a diagonal.
                let shift = 0.5 * closer / 3f64.sqrt();
                x.iter_mut().for_each(|c| *c += if random.random() { shift } else { -shift });
            }
            for (i, k) in lists.slab_pairs.first_grains() {
                let j = lists.slab_pairs.second[k] as usize;
                let apart = difference(&grains.position[i], &grains.position[j]);
                if dot(&apart, &apart).sqrt() < grains.radius[i] + grains.radius[j] {
                    assert!(chosen.binary_search(&(k as u32)).is_ok(), "{closer}: {k}");
                }
            }
        }
    }

    #[test]
    fn pairs_with_contact_history_are_active_at_any_distance() {
        let (grains, mut lists, _) = random_grains();
        lists.select_active(&grains, Some(&[]), 0.0, SKIN);
        let before = selected_pairs(&lists);
        let far = (0..).find(|k| !before.contains(k)).unwrap();
        lists.slab_pairs.histories.state[far as usize] = ContactState::Touching;
        lists.active_pairs.clear();
        lists.select_active(&grains, Some(&[]), 0.0, SKIN);
        assert_eq!(selected_pairs(&lists).len(), before.len() + 1);
        assert!(selected_pairs(&lists).contains(&far));
    }

    #[test]
    fn all_pairs_are_active_after_a_deformation_of_the_periodic_cell() {
        let (grains, mut lists, _) = random_grains();
        lists.select_active(&grains, None, 0.0, SKIN);
        assert_eq!(selected_pairs(&lists).len(), lists.slab_pairs.second.len());
    }
}
