//! Batches of contacts for the SIMD kernels.

use wide::f64x4 as Lanes;

use crate::contact::{ContactGeometry, NormalResponse};
use crate::neighbours::active_pairs::ActivePair;
use crate::points::vector::WIDTH;

/// Number of contacts of a batch.
pub(super) const BATCH_SIZE: usize = 64;

/// Capacity of a batch, with space for the contacts that are added after it is full.
pub(super) const BATCH_CAPACITY: usize = BATCH_SIZE + WIDTH;

/// Data of four contacts in the stages of a batch. Each stage is a loop of its own, so that the chains of square roots and
/// divisions of several groups of four overlap.
#[derive(Clone, Copy)]
pub(super) struct FourContacts<const D: usize, const R: usize> {
    /// Contact geometry of the four contacts.
    pub(super) geometry: ContactGeometry<D, R, Lanes>,
    /// Lever arms over radii.
    pub(super) lever_arm: Lanes,
    /// Vectors between the centres (m), if later operations need them.
    pub(super) apart: [Lanes; D],
    /// Radii of the first and the second grains (m), if later operations need them.
    pub(super) radii: [Lanes; 2],
    /// Tangential springs, rotated into the tangent plane (m).
    pub(super) shear_displacement: [Lanes; R],
    /// Dissipative part of the normal force in the last step (N).
    pub(super) damping_force: Lanes,
    /// Normal forces with their tangential stiffnesses.
    pub(super) normal: SimdNormalForce,
}

/// Normal forces of four contacts.
#[derive(Clone, Copy)]
pub(super) struct SimdNormalForce {
    /// Elastic force with its energy, damping and tangential stiffness.
    pub(super) response: NormalResponse<Lanes>,
    /// Normal force (N).
    pub(super) force: Lanes,
}

impl<const D: usize, const R: usize> FourContacts<D, R> {
    /// Four contacts with all quantities zero.
    const ZERO: Self = {
        let zero = Lanes::ZERO;
        Self {
            geometry: ContactGeometry {
                overlap: zero,
                normal: [zero; D],
                separation_velocity: zero,
                sliding_velocity: [zero; R],
                relative_spin: [zero; R],
                spin: zero,
                mass: zero,
                inverse_mass: zero,
                radius: zero,
                min_radius: zero,
            },
            lever_arm: zero,
            apart: [zero; D],
            radii: [zero; 2],
            shear_displacement: [zero; R],
            damping_force: zero,
            normal: SimdNormalForce {
                response: NormalResponse {
                    force: zero,
                    energy: zero,
                    damping: zero,
                    tangential_stiffness: zero,
                    tangential_damping: zero,
                },
                force: zero,
            },
        }
    };
}

/// Contacts that are computed with SIMD instructions, four at a time.
pub(super) struct ContactBatch<const D: usize, const R: usize> {
    /// Contacts of the batch, in groups of four.
    pub(super) groups: [FourContacts<D, R>; BATCH_SIZE / WIDTH],
    /// Number of contacts in the batch.
    pub(super) count: usize,
    /// Pairs of grains of the contacts.
    pub(super) pairs: [ActivePair; BATCH_CAPACITY],
}

impl<const D: usize, const R: usize> ContactBatch<D, R> {
    /// Batch without contacts.
    pub(super) const EMPTY: Self = Self {
        groups: [FourContacts::ZERO; BATCH_SIZE / WIDTH],
        count: 0,
        pairs: [ActivePair { first: 0, second: 0, slot: 0, image_index: 0 }; BATCH_CAPACITY],
    };

    /// Adds those of four pairs whose bits are set, without a branch. Pairs are copied from their list: numbers that were just written one
    /// by one are slow to load as vectors.
    #[inline(always)]
    pub(super) fn push(&mut self, pairs: &[ActivePair; WIDTH], bits: u32) {
        // Upper bound: the caller processes full batches.
        let mut n = self.count.min(BATCH_SIZE);
        for (k, pair) in pairs.iter().enumerate() {
            // A pair that does not count is overwritten by the next one.
            self.pairs[n] = *pair;
            n += (bits >> k & 1) as usize;
        }
        self.count = n;
    }

    /// Four pairs of a group.
    #[inline(always)]
    pub(super) fn pairs(&self, group: usize) -> &[ActivePair; WIDTH] {
        &self.pairs.as_chunks().0[group]
    }

    /// Copies contact `from` to slot `to`.
    pub(super) fn copy(&mut self, from: usize, to: usize) {
        self.pairs[to] = self.pairs[from];
    }
}
