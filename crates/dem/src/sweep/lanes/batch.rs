//! Contacts that wait to be worked on side by side.

use wide::f64x4 as Lanes;

use crate::contact::Touch;
use crate::lists::close::Pair;
use crate::vector::WIDTH;

/// Contacts of a batch.
pub(super) const MOST: usize = 64;

/// Room for them, and for those that come with the last of them.
pub(super) const ROOM: usize = MOST + WIDTH;

/// What four contacts are, on their way through the stages of a batch. Stages are loops of their own: chains of roots and
/// divisions of several fours are then under way at once.
#[derive(Clone, Copy)]
pub(super) struct Four<const D: usize, const R: usize> {
    pub(super) touch: Touch<D, R, Lanes>,
    /// Lever arms over radii.
    pub(super) arm: Lanes,
    /// What lies between the centres (m), where it is asked for again.
    pub(super) apart: [Lanes; D],
    /// Radii of the first and the second grains (m), where they are asked for again.
    pub(super) radii: [Lanes; 2],
    /// Springs across, turned into the plane across the normal (m).
    pub(super) slide: [Lanes; R],
    /// Dissipative part of the normal force in the last step (N).
    pub(super) dash: Lanes,
}

impl<const D: usize, const R: usize> Four<D, R> {
    const NONE: Self = {
        let zero = Lanes::ZERO;
        Self {
            touch: Touch {
                overlap: zero,
                normal: [zero; D],
                separation: zero,
                sliding: [zero; R],
                turning: [zero; R],
                spin: zero,
                mass: zero,
                radius: zero,
                small: zero,
            },
            arm: zero,
            apart: [zero; D],
            radii: [zero; 2],
            slide: [zero; R],
            dash: zero,
        }
    };
}

/// Contacts that wait.
pub(super) struct Batch<const D: usize, const R: usize> {
    pub(super) fours: [Four<D, R>; MOST / WIDTH],
    pub(super) count: usize,
    pub(super) pairs: [Pair; ROOM],
}

impl<const D: usize, const R: usize> Batch<D, R> {
    pub(super) const EMPTY: Self = Self {
        fours: [Four::NONE; MOST / WIDTH],
        count: 0,
        pairs: [Pair { first: 0, second: 0, slot: 0, code: 0 }; ROOM],
    };

    /// Adds those of four pairs whose bits are set, without a branch on what cannot be foretold. Pairs are copied from where they are listed:
    /// numbers that were just written one by one are slow to read side by side.
    #[inline(always)]
    pub(super) fn push(&mut self, pairs: &[Pair; WIDTH], bits: u32) {
        // No more than that: whoever adds flushes what is full.
        let mut n = self.count.min(MOST);
        for (k, pair) in pairs.iter().enumerate() {
            // The next one goes over it where it does not count.
            self.pairs[n] = *pair;
            n += (bits >> k & 1) as usize;
        }
        self.count = n;
    }

    /// Four pairs.
    #[inline(always)]
    pub(super) fn pairs(&self, group: usize) -> &[Pair; WIDTH] {
        &self.pairs.as_chunks().0[group]
    }

    /// Copies contact `from` to place `to`.
    pub(super) fn copy(&mut self, from: usize, to: usize) {
        self.pairs[to] = self.pairs[from];
    }
}
