//! Contacts that wait to be worked on side by side.

use wide::f64x4 as Lanes;

use crate::contact::Touch;
use crate::sweep::side::WIDTH;

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
            slide: [zero; R],
            dash: zero,
        }
    };
}

/// Four pairs: grains and numbers in their list.
#[derive(Clone, Copy)]
pub(super) struct FourPairs {
    pub(super) first: [u32; WIDTH],
    pub(super) second: [u32; WIDTH],
    pub(super) slot: [u32; WIDTH],
}

/// Contacts that wait.
pub(super) struct Batch<const D: usize, const R: usize> {
    pub(super) fours: [Four<D, R>; MOST / WIDTH],
    pub(super) count: usize,
    pub(super) first: [u32; ROOM],
    pub(super) second: [u32; ROOM],
    pub(super) slot: [u32; ROOM],
    pub(super) code: [u8; ROOM],
    /// What lies between the centres (m), and the square of their distance (m²).
    pub(super) apart: [[f64; ROOM]; D],
    pub(super) square: [f64; ROOM],
    /// Radii of the first and the second grains (m).
    pub(super) radii: [[f64; ROOM]; 2],
}

/// Four of a column.
#[inline(always)]
pub(super) fn four_of(column: &[f64; ROOM], group: usize) -> Lanes {
    let own = &column[WIDTH * group..][..WIDTH];
    Lanes::new([own[0], own[1], own[2], own[3]])
}

impl<const D: usize, const R: usize> Batch<D, R> {
    pub(super) const EMPTY: Self = Self {
        fours: [Four::NONE; MOST / WIDTH],
        count: 0,
        first: [0; ROOM],
        second: [0; ROOM],
        slot: [0; ROOM],
        code: [0; ROOM],
        apart: [[0.0; ROOM]; D],
        square: [0.0; ROOM],
        radii: [[0.0; ROOM]; 2],
    };

    /// Adds those of four pairs whose bits are set; `origin` is the first pair of what contacts remember.
    #[inline(always)]
    pub(super) fn push(
        &mut self,
        (pairs, codes, origin): (&FourPairs, [u8; WIDTH], u32),
        (apart, square, radii): (&[Lanes; D], Lanes, [Lanes; 2]),
        bits: u32,
    ) {
        // No more than that: whoever adds flushes what is full, and nothing is looked up beyond the columns.
        let n = self.count.min(MOST);
        let slots = pairs.slot.map(|slot| slot - origin);
        if bits & (bits + 1) == 0 {
            // From the first on: all of them as they are, and those that do not count are written over.
            for c in 0..D {
                self.apart[c][n..][..WIDTH].copy_from_slice(apart[c].as_array());
            }
            self.square[n..][..WIDTH].copy_from_slice(square.as_array());
            for side in 0..2 {
                self.radii[side][n..][..WIDTH].copy_from_slice(radii[side].as_array());
            }
            self.first[n..][..WIDTH].copy_from_slice(&pairs.first);
            self.second[n..][..WIDTH].copy_from_slice(&pairs.second);
            self.slot[n..][..WIDTH].copy_from_slice(&slots);
            self.code[n..][..WIDTH].copy_from_slice(&codes);
        } else {
            let (mut bits, mut n) = (bits, n);
            while bits != 0 {
                let k = bits.trailing_zeros() as usize % WIDTH;
                for c in 0..D {
                    self.apart[c][n] = apart[c].as_array()[k];
                }
                self.square[n] = square.as_array()[k];
                for side in 0..2 {
                    self.radii[side][n] = radii[side].as_array()[k];
                }
                (self.first[n], self.second[n]) = (pairs.first[k], pairs.second[k]);
                (self.slot[n], self.code[n]) = (slots[k], codes[k]);
                bits &= bits - 1;
                n += 1;
            }
        }
        self.count = n + bits.count_ones() as usize;
    }

    /// Copies contact `from` to place `to`.
    pub(super) fn copy(&mut self, from: usize, to: usize) {
        for column in self.apart.iter_mut().chain(&mut self.radii).chain([&mut self.square]) {
            column[to] = column[from];
        }
        for column in [&mut self.first, &mut self.second, &mut self.slot] {
            column[to] = column[from];
        }
        self.code[to] = self.code[from];
    }
}
