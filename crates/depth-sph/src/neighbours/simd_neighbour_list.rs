//! Neighbour list of each node in packs of four, made by the sum of heights and used again by the forces of the step.

use rayon::prelude::*;
use wide::f64x4;

use crate::points::MIN_NODES_PER_TASK;

/// Relative margin of the lists for the growth of smoothing lengths in a step.
pub const MARGIN: f64 = 0.05;

/// Neighbours of each node in groups of four, stored for [`MIN_NODES_PER_TASK`] nodes at a time.
#[derive(Debug, Default)]
pub struct PackedNeighbours {
    blocks: Vec<NeighbourListBlock>,
    /// Whether the lists contain all neighbours that forces can reach.
    complete: bool,
}

/// Neighbour lists of consecutive nodes, one list after another.
#[derive(Debug, Default)]
pub struct NeighbourListBlock {
    row_ends: Vec<u32>,
    entries: Vec<u32>,
    is_incomplete: bool,
}

/// Entry of the list: index of the first of up to four nodes, and their number, from squared distances that are numbers for used nodes.
#[inline(always)]
pub fn pack_entry(first: usize, square: f64x4) -> u32 {
    (first as u32) << 3 | square.simd_eq(square).to_bitmask().count_ones()
}

/// Index of the first node of an entry, and number of its nodes.
#[inline(always)]
pub fn unpack_entry(entry: u32) -> (usize, usize) {
    ((entry >> 3) as usize, (entry & 7) as usize)
}

impl NeighbourListBlock {
    /// Clears the lists.
    pub fn clear(&mut self) {
        self.row_ends.clear();
        self.entries.clear();
        self.is_incomplete = false;
    }

    /// Adds the list of the next node; `None` marks the lists as incomplete.
    #[inline]
    pub fn push(&mut self, entries: Option<&[u32]>) {
        match entries {
            Some(entries) => self.entries.extend_from_slice(entries),
            None => self.is_incomplete = true,
        }
        self.row_ends.push(self.entries.len() as u32);
    }

    /// Marks the lists as incomplete: the smoothing length of a node has grown by more than the margin.
    #[inline]
    pub fn mark_incomplete(&mut self) {
        self.is_incomplete = true;
    }
}

impl PackedNeighbours {
    /// Storage of the lists of this number of nodes.
    pub fn blocks(&mut self, nodes: usize) -> &mut [NeighbourListBlock] {
        self.blocks.resize_with(nodes.div_ceil(MIN_NODES_PER_TASK), NeighbourListBlock::default);
        &mut self.blocks
    }

    /// Checks whether all nodes have lists.
    pub fn check_complete(&mut self) {
        self.complete = self.blocks.par_iter().all(|block| !block.is_incomplete);
    }

    /// Invalidates all lists after nodes have moved.
    pub fn clear(&mut self) {
        self.complete = false;
    }

    /// Whether the lists contain all neighbours that forces need.
    pub fn are_complete(&self) -> bool {
        self.complete
    }

    /// Entries of node `i`.
    #[inline]
    pub fn entries(&self, i: usize) -> &[u32] {
        let block = &self.blocks[i / MIN_NODES_PER_TASK];
        let k = i % MIN_NODES_PER_TASK;
        let start = if k == 0 { 0 } else { block.row_ends[k - 1] };
        &block.entries[start as usize..block.row_ends[k] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_blocks_are_concatenated_and_one_incomplete_block_invalidates_all() {
        let mut fours = PackedNeighbours::default();
        let no = f64::NAN;
        let whole = pack_entry(7, f64x4::splat(1.0));
        let two = pack_entry(40, f64x4::new([0.0, 2.0, no, no]));
        assert_eq!([whole, two].map(unpack_entry), [(7, 4), (40, 2)]);
        let fill = |blocks: &mut [NeighbourListBlock]| {
            for block in blocks {
                block.clear();
                let both = [whole, two];
                (0..MIN_NODES_PER_TASK).for_each(|k| block.push(Some(&both[..1 + k % 2])));
            }
        };
        fill(fours.blocks(2 * MIN_NODES_PER_TASK));
        assert!(!fours.are_complete());
        fours.check_complete();
        assert!(fours.are_complete());
        assert_eq!(
            (fours.entries(0), fours.entries(MIN_NODES_PER_TASK + 3)),
            (&[whole][..], &[whole, two][..])
        );
        fours.blocks(2 * MIN_NODES_PER_TASK)[1].mark_incomplete();
        fours.check_complete();
        assert!(!fours.are_complete());
        fill(fours.blocks(2 * MIN_NODES_PER_TASK));
        fours.blocks(2 * MIN_NODES_PER_TASK)[0].push(None);
        fours.check_complete();
        assert!(!fours.are_complete());
    }
}
