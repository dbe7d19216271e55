//! Verlet lists (sheet: dem §3.2): grains sorted by cell, each pair once, in slabs that can be processed in parallel.
//!
//! Cells are as wide as the longest reach of two grains. A slab is a run of layers of cells across the axis with most of
//! them; the pairs of a grain of slab `s` have their second grain in slab `s` or `s + 1`. Slabs of equal parity therefore have
//! no grain in common. Pairs across the periodic boundary, between the last layer and the first, are a separate list.
//!
//! Where the largest grain is more than three times as wide as the smallest, [`size_classes`] finds the pairs. They are listed under
//! the grains and in the order of uniform cells, so that the two searches differ only in time.

pub mod active_pairs;
mod class_pairs;
pub(crate) mod grain_neighbours;
pub(crate) mod list_build;
mod obstacle_facets;
pub mod size_classes;
pub(crate) mod wall_list;

use std::ops::Range;

use crate::neighbours::active_pairs::ActivePairLists;
use crate::neighbours::class_pairs::FoundPairs;
use crate::neighbours::size_classes::SizeClasses;
use colluvium_points::{ScratchBuffers, SearchError, farthest_from_mean, max_cells};
use rayon::prelude::*;

use crate::boundary::periodic_cell::{PeriodicCell, inverse};
use crate::contact::bond::Bond;
use crate::contact::contact_histories::{ContactHistories, HistoryColumns, PairList};
use crate::points::grains::Grains;
use crate::points::vector::{difference, dot};

/// Smallest number of grains of a slab.
const MIN_SLAB_GRAINS: usize = 384;

/// Verlet lists of grain pairs, with buffers for their construction.
#[derive(Default)]
pub struct VerletLists<const D: usize, const R: usize> {
    /// Pairs of each grain with grains ahead, within and between slabs.
    pub slab_pairs: PairList<R>,
    /// Pairs across the periodic boundary.
    pub periodic_pairs: PairList<R>,
    /// First grain of each slab, and the number of grains.
    pub slabs: Vec<u32>,
    /// Active pairs, for the SIMD kernels.
    pub active_pairs: ActivePairLists,
    /// First cell of each slab, and the number of cells.
    cells: Vec<u32>,
    counts: [usize; MAX_DIMENSION],
    axes: [usize; MAX_DIMENSION],
    keys: Vec<u32>,
    cell_offsets: Vec<u32>,
    order: Vec<u32>,
    positions_in_order: Vec<u32>,
    carried_histories: CarriedHistories<R>,
    scratch: ScratchBuffers,
    classes: SizeClasses<D>,
    found_pairs: FoundPairs,
    /// Whether the search uses uniform cells for any distribution of sizes.
    pub uniform_cells: bool,
}

/// Length of arrays over axes, of which the first `D` entries are used.
const MAX_DIMENSION: usize = 3;

/// Contact histories during a list build.
#[derive(Clone, Debug, Default)]
struct CarriedHistories<const R: usize> {
    first: Vec<u32>,
    second: Vec<u32>,
    history: ContactHistories<R>,
    row_offsets: Vec<u32>,
    entries: Vec<u32>,
    is_used: Vec<bool>,
}

/// Index of a cell along each axis from its number, for given cell counts and order of the axes.
fn cell_of<const D: usize>(
    number: usize,
    counts: &[usize; MAX_DIMENSION],
    axes: &[usize; MAX_DIMENSION],
) -> [usize; D] {
    let (mut rest, mut own) = (number, [0usize; D]);
    for &axis in axes[..D].iter().rev() {
        own[axis] = rest % counts[axis];
        rest /= counts[axis];
    }
    own
}

/// Reach of the pair lists.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ListReach {
    /// Gap up to which pairs are listed (m).
    pub gap: f64,
    /// Largest radius (m).
    pub radius: f64,
}

/// Error of a list build.
#[derive(Clone, Debug, PartialEq)]
pub enum ListError {
    /// The search fails.
    Search(SearchError),
    /// The cell is narrower than two reaches along an axis: length and reach (m).
    Narrow(usize, f64, f64),
    /// A bond is longer than any pair that is listed.
    Stretched(u32),
}

/// Neighbouring cell and its image.
#[derive(Clone, Copy)]
struct NeighbourCell<const D: usize> {
    cell: [usize; D],
    steps: [i32; D],
    is_periodic: bool,
}

/// Criterion of a listed pair.
struct PairCriterion<'a, const D: usize, const R: usize> {
    grains: &'a Grains<D, R>,
    cell: &'a PeriodicCell<D>,
    /// Inverse of the cell matrix.
    unit: [[f64; D]; D],
    shifts: &'a [([f64; D], [f64; D])],
    gap: f64,
    periodic: bool,
}

impl<const D: usize, const R: usize> PairCriterion<'_, D, R> {
    /// Lists the pair of grains `i` and `j`, `steps` cells apart, if they are close and not both of prescribed motion.
    #[inline]
    fn pair(&self, i: usize, j: usize, steps: [i32; D], pairs: &mut PairList<R>) {
        let Some(code) = self.near_image(i, j, steps) else { return };
        pairs.second.push(j as u32);
        if self.periodic {
            pairs.image.push(code);
        }
    }

    /// Image index of grain `j`, `steps` cells away, if it is close to grain `i` and not both have a prescribed motion.
    #[inline]
    fn near_image(&self, i: usize, j: usize, steps: [i32; D]) -> Option<u8> {
        let grains = self.grains;
        if grains.is_held[i] && grains.is_held[j] {
            return None;
        }
        let mut apart = difference(&grains.position[i], &grains.position[j]);
        let code = PeriodicCell::image_index(&steps);
        if code > 0 {
            apart = difference(&apart, &self.shifts[code as usize].0);
        }
        let limit = grains.radius[i] + grains.radius[j] + self.gap;
        (dot(&apart, &apart) < limit * limit).then_some(code)
    }

    /// Lists the pairs of grain `i` with all later grains that are close, by their closest image.
    fn list_all(&self, i: usize, pairs: &mut PairList<R>) {
        let own = self.cell.reduced(&self.unit, &self.grains.position[i]);
        for j in i + 1..self.grains.len() {
            let other = self.cell.reduced(&self.unit, &self.grains.position[j]);
            let steps = std::array::from_fn(|c| {
                if self.cell.periodic[c] { (own[c] - other[c]).round() as i32 } else { 0 }
            });
            self.pair(i, j, steps, pairs);
        }
    }
}

impl<const D: usize, const R: usize> VerletLists<D, R> {
    /// Number of slabs.
    pub fn slab_count(&self) -> usize {
        self.slabs.len().saturating_sub(1)
    }

    /// Sorts the grains by cell and lists their pairs, with the contact histories. Positions must lie in the cell along its
    /// periodic axes.
    ///
    /// # Errors
    /// When positions are not finite or spread too far, the cell is too narrow, or a bond is too long.
    pub fn build(
        &mut self,
        grains: &mut Grains<D, R>,
        cell: &PeriodicCell<D>,
        reach: ListReach,
        columns: HistoryColumns,
    ) -> Result<(), ListError> {
        if let Some(lost) = grains.position.iter().position(|x| x.iter().any(|c| !c.is_finite())) {
            return Err(ListError::Search(SearchError::NotFinite(grains.id[lost] as usize)));
        }
        self.active_pairs.clear();
        self.store_histories(columns);
        let all =
            self.bin(&grains.position, cell, 2.0 * reach.radius + reach.gap).map_err(
                |error| match error {
                    ListError::Search(SearchError::TooSpread(cells, grain)) => {
                        ListError::Search(SearchError::TooSpread(cells, grains.id[grain] as usize))
                    }
                    error => error,
                },
            )?;
        self.positions_in_order.clear();
        self.positions_in_order.resize(grains.len(), 0);
        for (new, &old) in self.order.iter().enumerate() {
            self.positions_in_order[old as usize] = new as u32;
        }
        grains.reorder(&self.order, &mut self.scratch);
        grains.listed_position.clone_from(&grains.position);
        self.cut_slabs(grains.len(), all);
        self.find_pairs(grains, cell, reach, all);
        self.restore_histories(grains, columns)
    }

    /// Removes the pairs of removed grains; `place` is the new index of each grain, `u32::MAX` for a removed one. The lists must then be
    /// rebuilt.
    pub fn remove_grains(&mut self, place: &[u32], columns: HistoryColumns) {
        let count = place.iter().filter(|place| **place != u32::MAX).count();
        for pairs in [&mut self.slab_pairs, &mut self.periodic_pairs] {
            let mut left = PairList { row_offsets: vec![0; count + 1], ..PairList::default() };
            left.histories.clear(0, columns);
            for (i, k) in pairs.first_grains() {
                let (i, j) = (place[i], place[pairs.second[k] as usize]);
                if i != u32::MAX && j != u32::MAX {
                    left.second.push(j);
                    left.image.extend(pairs.image.get(k));
                    left.histories.push(&pairs.histories, k);
                    left.row_offsets[i as usize + 1] += 1;
                }
            }
            for i in 0..count {
                left.row_offsets[i + 1] += left.row_offsets[i];
            }
            *pairs = left;
        }
    }

    /// Stores the contact histories.
    fn store_histories(&mut self, columns: HistoryColumns) {
        let carried = &mut self.carried_histories;
        carried.first.clear();
        carried.second.clear();
        carried.history.clear(0, columns);
        for pairs in [&self.slab_pairs, &self.periodic_pairs] {
            for (i, k) in pairs.first_grains() {
                if pairs.histories.is_kept(k) {
                    carried.first.push(i as u32);
                    carried.second.push(pairs.second[k]);
                    carried.history.push(&pairs.histories, k);
                }
            }
        }
    }

    /// Sorts the grains into cells. Returns whether there are too few cells to distinguish periodic images, so that all pairs must be
    /// checked.
    fn bin(&mut self, positions: &[[f64; D]], cell: &PeriodicCell<D>, reach: f64) -> Result<bool, ListError> {
        let (unit, _) = inverse(&cell.h);
        let widths = cell.widths();
        let (mut low, mut scale, mut few, mut total) = ([0.0; D], [1.0; D], false, 1.0);
        let mut counts = [1usize; D];
        for axis in 0..D {
            if cell.periodic[axis] {
                if widths[axis] < 2.0 * reach {
                    return Err(ListError::Narrow(axis, widths[axis], reach));
                }
                counts[axis] = (widths[axis] / reach).floor().clamp(1.0, 1e9) as usize;
                scale[axis] = counts[axis] as f64;
                few |= counts[axis] < 3;
            } else {
                let along = positions.iter().map(|x| cell.reduced(&unit, x)[axis]);
                let (from, to) =
                    along.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), s| (a.min(s), b.max(s)));
                let count = ((to - from) * widths[axis] / reach).floor().max(0.0) + 1.0;
                counts[axis] = count.min(1e9) as usize;
                (low[axis], scale[axis]) = (from, widths[axis] / reach);
            }
            total *= counts[axis] as f64;
        }
        if total > max_cells(positions.len()) {
            return Err(ListError::Search(SearchError::TooSpread(total, farthest_from_mean(positions))));
        }
        let mut axes: [usize; D] = std::array::from_fn(|axis| axis);
        axes.sort_by_key(|&axis| std::cmp::Reverse(counts[axis]));
        self.counts[..D].copy_from_slice(&counts);
        self.axes[..D].copy_from_slice(&axes);
        self.keys.clear();
        self.keys.extend(positions.iter().map(|x| {
            let s = cell.reduced(&unit, x);
            axes.iter().fold(0, |key, &axis| {
                let place = ((s[axis] - low[axis]) * scale[axis]).max(0.0) as usize;
                key * counts[axis] + place.min(counts[axis] - 1)
            }) as u32
        }));
        count_sort(&self.keys, total as usize, &mut self.cell_offsets, &mut self.order);
        Ok(few)
    }

    /// Divides the layers of cells into slabs.
    fn cut_slabs(&mut self, grains: usize, all: bool) {
        self.slabs.clear();
        self.slabs.push(0);
        self.cells.clear();
        self.cells.push(0);
        let layers = self.counts[self.axes[0]];
        let per_layer: usize = self.axes[1..D].iter().map(|&axis| self.counts[axis]).product();
        for layer in 1..layers {
            let start = self.cell_offsets[layer * per_layer];
            let last = self.slabs[self.slabs.len() - 1];
            if !all
                && (start - last) as usize >= MIN_SLAB_GRAINS
                && grains - start as usize >= MIN_SLAB_GRAINS
            {
                self.slabs.push(start);
                self.cells.push((layer * per_layer) as u32);
            }
        }
        self.slabs.push(grains as u32);
        self.cells.push((layers * per_layer) as u32);
    }

    /// Lists the pairs of all grains.
    fn find_pairs(&mut self, grains: &Grains<D, R>, cell: &PeriodicCell<D>, reach: ListReach, all: bool) {
        for pairs in [&mut self.slab_pairs, &mut self.periodic_pairs] {
            pairs.row_offsets.clear();
            pairs.second.clear();
            pairs.image.clear();
            pairs.row_offsets.push(0);
        }
        let mut shifts = Vec::new();
        cell.shifts(&mut shifts);
        let criterion = PairCriterion {
            grains,
            cell,
            shifts: &shifts,
            gap: reach.gap,
            periodic: cell.is_periodic(),
            unit: inverse(&cell.h).0,
        };
        if self.is_wide(&grains.radius) {
            self.list_by_size_class(&criterion, all);
            return;
        }
        let slabs: Vec<[PairList<R>; 2]> =
            self.cells.par_windows(2).map(|ends| self.find_in(&criterion, ends[0]..ends[1], all)).collect();
        for slab in slabs {
            for (pairs, more) in [&mut self.slab_pairs, &mut self.periodic_pairs].into_iter().zip(slab) {
                let before = pairs.second.len() as u32;
                pairs.row_offsets.extend(more.row_offsets.iter().map(|start| before + start));
                pairs.second.extend(more.second);
                pairs.image.extend(more.image);
            }
        }
    }

    /// Pairs of the grains in a range of cells, within slabs and across periodic boundaries, with the end of the list of each grain.
    fn find_in(&self, criterion: &PairCriterion<'_, D, R>, cells: Range<u32>, all: bool) -> [PairList<R>; 2] {
        let [mut slab_pairs, mut periodic_pairs] = [PairList::default(), PairList::default()];
        let mut neighbours: Vec<NeighbourCell<D>> = Vec::new();
        for number in cells.start as usize..cells.end as usize {
            let (from, to) = (self.cell_offsets[number] as usize, self.cell_offsets[number + 1] as usize);
            if from == to {
                continue;
            }
            if !all {
                self.neighbours(number, criterion.cell, &mut neighbours);
            }
            for i in from..to {
                if all {
                    criterion.list_all(i, &mut slab_pairs);
                } else {
                    for j in i + 1..to {
                        criterion.pair(i, j, [0; D], &mut slab_pairs);
                    }
                    for near in &neighbours {
                        let key = self.axes[..D]
                            .iter()
                            .fold(0, |key, &axis| key * self.counts[axis] + near.cell[axis]);
                        let pairs = if near.is_periodic { &mut periodic_pairs } else { &mut slab_pairs };
                        for j in self.cell_offsets[key]..self.cell_offsets[key + 1] {
                            criterion.pair(i, j as usize, near.steps, pairs);
                        }
                    }
                }
                slab_pairs.row_offsets.push(slab_pairs.second.len() as u32);
                periodic_pairs.row_offsets.push(periodic_pairs.second.len() as u32);
            }
        }
        [slab_pairs, periodic_pairs]
    }

    /// Neighbouring cells of cell `number` in one half of the directions, so that each pair of cells occurs once.
    fn neighbours(&self, number: usize, cell: &PeriodicCell<D>, out: &mut Vec<NeighbourCell<D>>) {
        out.clear();
        let own = cell_of(number, &self.counts, &self.axes);
        let half = 3usize.pow(D as u32) / 2;
        'offsets: for code in half + 1..2 * half + 1 {
            let mut near = NeighbourCell { cell: own, steps: [0; D], is_periodic: false };
            let mut rest = code;
            for (rank, &axis) in self.axes[..D].iter().enumerate().rev() {
                let offset = (rest % 3) as i64 - 1;
                rest /= 3;
                let count = self.counts[axis] as i64;
                let place = own[axis] as i64 + offset;
                if !(0..count).contains(&place) {
                    if !cell.periodic[axis] {
                        continue 'offsets;
                    }
                    near.steps[axis] = if place < 0 { -1 } else { 1 };
                    near.is_periodic |= rank == 0;
                }
                near.cell[axis] = place.rem_euclid(count) as usize;
            }
            out.push(near);
        }
    }

    /// Restores the histories of contacts that are listed again.
    fn restore_histories(&mut self, grains: &Grains<D, R>, columns: HistoryColumns) -> Result<(), ListError> {
        let count = grains.len();
        let carried = &mut self.carried_histories;
        for column in [&mut carried.first, &mut carried.second] {
            column.iter_mut().for_each(|grain| *grain = self.positions_in_order[*grain as usize]);
        }
        // Entries under both grains.
        carried.row_offsets.clear();
        carried.row_offsets.resize(count + 1, 0);
        for &grain in carried.first.iter().chain(&carried.second) {
            carried.row_offsets[grain as usize + 1] += 1;
        }
        for grain in 0..count {
            carried.row_offsets[grain + 1] += carried.row_offsets[grain];
        }
        let kept = carried.first.len();
        carried.entries.clear();
        carried.entries.resize(2 * kept, 0);
        for side in [&carried.first, &carried.second] {
            for (entry, &grain) in side.iter().enumerate() {
                let slot = &mut carried.row_offsets[grain as usize];
                carried.entries[*slot as usize] = entry as u32;
                *slot += 1;
            }
        }
        carried.row_offsets.rotate_right(1);
        carried.row_offsets[0] = 0;
        carried.is_used.clear();
        carried.is_used.resize(kept, false);
        for pairs in [&mut self.slab_pairs, &mut self.periodic_pairs] {
            pairs.histories.clear(pairs.second.len(), columns);
            for i in 0..count {
                let own = carried.row_offsets[i] as usize..carried.row_offsets[i + 1] as usize;
                if own.is_empty() {
                    continue;
                }
                for k in pairs.row_offsets[i] as usize..pairs.row_offsets[i + 1] as usize {
                    let j = pairs.second[k];
                    for &entry in &carried.entries[own.clone()] {
                        let entry = entry as usize;
                        let ends = (carried.first[entry], carried.second[entry]);
                        let flip = ends == (j, i as u32);
                        if flip || ends == (i as u32, j) {
                            pairs.histories.copy_from(k, &carried.history, entry, flip);
                            carried.is_used[entry] = true;
                        }
                    }
                }
            }
        }
        let lost = |entry: &usize| {
            !carried.is_used[*entry] && carried.history.bond.get(*entry).is_some_and(Bond::is_intact)
        };
        match (0..kept).find(lost) {
            Some(entry) => Err(ListError::Stretched(grains.id[carried.first[entry] as usize])),
            None => Ok(()),
        }
    }
}

/// Stable counting sort by key: first index of each key, and the order.
fn count_sort(keys: &[u32], key_count: usize, starts: &mut Vec<u32>, order: &mut Vec<u32>) {
    starts.clear();
    starts.resize(key_count + 1, 0);
    for &key in keys {
        starts[key as usize + 1] += 1;
    }
    for key in 0..key_count {
        starts[key + 1] += starts[key];
    }
    order.clear();
    order.resize(keys.len(), 0);
    for (item, &key) in keys.iter().enumerate() {
        let slot = &mut starts[key as usize];
        order[*slot as usize] = item as u32;
        *slot += 1;
    }
    // Every start has become that of the next key.
    starts.rotate_right(1);
    starts[0] = 0;
}
