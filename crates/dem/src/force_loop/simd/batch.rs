//! Contacts that wait to be worked on side by side.

use wide::f64x4 as Lanes;

use crate::contact::ContactGeometry;
use crate::neighbours::active_pairs::ActivePair;
use crate::points::vector::WIDTH;

/// Contacts of a batch.
pub(super) const BATCH_SIZE: usize = 64;

/// Room for them, and for those that come with the last of them.
pub(super) const BATCH_CAPACITY: usize = BATCH_SIZE + WIDTH;

/// What four contacts are, on their way through the stages of a batch. Stages are loops of their own: chains of roots and
/// divisions of several fours are then under way at once.
#[derive(Clone, Copy)]
pub(super) struct FourContacts<const D: usize, const R: usize> {
    pub(super) touch: ContactGeometry<D, R, Lanes>,
    /// Lever arms over radii.
    pub(super) arm: Lanes,
    /// What lies between the centres (m), where it is asked for again.
    pub(super) apart: [Lanes; D],
    /// Radii of the first and the second grains (m), where they are asked for again.
    pub(super) radii: [Lanes; 2],
    /// Springs across, turned into the plane across the normal (m).
    pub(super) shear_displacement: [Lanes; R],
    /// Dissipative part of the normal force in the last step (N).
    pub(super) damping_force: Lanes,
}

impl<const D: usize, const R: usize> FourContacts<D, R> {
    const NONE: Self = {
        let zero = Lanes::ZERO;
        Self {
            touch: ContactGeometry {
                overlap: zero,
                normal: [zero; D],
                separation_velocity: zero,
                sliding_velocity: [zero; R],
                relative_spin: [zero; R],
                spin: zero,
                mass: zero,
                radius: zero,
                min_radius: zero,
            },
            arm: zero,
            apart: [zero; D],
            radii: [zero; 2],
            shear_displacement: [zero; R],
            damping_force: zero,
        }
    };
}

/// Contacts that wait.
pub(super) struct ContactBatch<const D: usize, const R: usize> {
    pub(super) fours: [FourContacts<D, R>; BATCH_SIZE / WIDTH],
    pub(super) count: usize,
    pub(super) pairs: [ActivePair; BATCH_CAPACITY],
}

impl<const D: usize, const R: usize> ContactBatch<D, R> {
    pub(super) const EMPTY: Self = Self {
        fours: [FourContacts::NONE; BATCH_SIZE / WIDTH],
        count: 0,
        pairs: [ActivePair { first: 0, second: 0, slot: 0, image_index: 0 }; BATCH_CAPACITY],
    };

    /// Adds those of four pairs whose bits are set, without a branch on what cannot be foretold. Pairs are copied from where they are listed:
    /// numbers that were just written one by one are slow to read side by side.
    #[inline(always)]
    pub(super) fn push(&mut self, pairs: &[ActivePair; WIDTH], bits: u32) {
        // No more than that: whoever adds flushes what is full.
        let mut n = self.count.min(BATCH_SIZE);
        for (k, pair) in pairs.iter().enumerate() {
            // The next one goes over it where it does not count.
            self.pairs[n] = *pair;
            n += (bits >> k & 1) as usize;
        }
        self.count = n;
    }

    /// Four pairs.
    #[inline(always)]
    pub(super) fn pairs(&self, group: usize) -> &[ActivePair; WIDTH] {
        &self.pairs.as_chunks().0[group]
    }

    /// Copies contact `from` to place `to`.
    pub(super) fn copy(&mut self, from: usize, to: usize) {
        self.pairs[to] = self.pairs[from];
    }
}
