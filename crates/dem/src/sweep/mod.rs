//! Forces of all contacts: slabs of one parity side by side, then those of the other, then the seam. Every grain receives
//! its forces in an order that the lists fix.

mod lanes;
mod side;

use std::ops::Range;

use crate::contact::dashpot::Steps;
use crate::contact::{APART, Law, Memory, Push, Side, Tally, Touch, act, end};
use crate::grains::Shown;
use crate::lists::Lists;
use crate::lists::close::Run;
use crate::pairs::{Listed, MemoriesMut};
pub use lanes::{AtPlane, Planes};
pub use side::{Laws, Motion, Received, Records, Way, deliver, records};

use crate::vector::{add, dot, minus, moment, spread, times};
use wide::f64x4 as Lanes;

/// What contacts see.
pub struct Scene<'a, const D: usize, const R: usize> {
    /// Positions (m).
    pub position: &'a [[f64; D]],
    /// Velocities to find forces with (m/s).
    pub velocity: &'a [[f64; D]],
    /// Angular velocities (rad/s).
    pub spin: &'a [[f64; R]],
    /// Radii (m).
    pub radius: &'a [f64],
    /// Masses (kg).
    pub mass: &'a [f64],
    /// Whether a grain is held.
    pub held: &'a [bool],
    /// Kinds.
    pub kind: &'a [u32],
    /// Laws of each pair of kinds, row by row.
    pub laws: &'a [Law],
    /// Number of kinds.
    pub kinds: usize,
    /// Shift and velocity of each image.
    pub shifts: &'a [([f64; D], [f64; D])],
    /// Time since the last forces (s).
    pub dt: f64,
    /// Time until the next forces (s).
    pub next: f64,
    /// Whether lever arms are radii.
    pub radii: bool,
    /// Rate at which radii grow (1/s).
    pub growth: f64,
    /// How contacts of grains are worked on.
    pub way: Way,
    /// How contacts with planes are.
    pub way_at_planes: Way,
    /// Places with radii, and motions, where contacts are worked on side by side.
    pub records: (&'a [Lanes], &'a [Motion]),
}

/// Pairs within the slabs, and the first grain of each slab.
#[derive(Clone, Copy)]
struct Inner<'a> {
    pairs: Listed<'a>,
    slabs: &'a [u32],
    close: &'a [Run],
}

/// A stress times volume, row by row (J).
pub type Virial<const D: usize> = [[f64; D]; D];

/// What contacts change.
pub struct Shares<'a, const D: usize, const R: usize> {
    /// First grain of what follows.
    pub first: usize,
    /// Forces and moments.
    pub received: &'a mut [Received],
    /// First pair of the memories.
    pub pair: usize,
    /// What contacts remember.
    pub memory: MemoriesMut<'a, R>,
    /// First slab of the sums.
    pub slab: usize,
    /// Sums of each slab.
    pub tallies: &'a mut [(Tally, Virial<D>)],
}

impl<'a, const D: usize, const R: usize> Shares<'a, D, R> {
    /// Parts before and from these grains, pairs and slabs on.
    fn split_at(self, grain: usize, pair: usize, slab: usize) -> (Self, Self) {
        let (received, more_received) = self.received.split_at_mut(grain - self.first);
        let (memory, more_memory) = self.memory.split_at(pair - self.pair);
        let (tallies, more_tallies) = self.tallies.split_at_mut(slab - self.slab);
        (
            Self { received, memory, tallies, ..self },
            Self {
                first: grain,
                received: more_received,
                pair,
                memory: more_memory,
                slab,
                tallies: more_tallies,
            },
        )
    }
}

impl<'a, const D: usize, const R: usize> Scene<'a, D, R> {
    /// Of these grains at rest in a cell that does not repeat itself.
    pub fn new(grains: Shown<'a, D, R>, laws: &'a [Law], kinds: usize) -> Self {
        let Shown { kind, held, radius, mass, position, velocity, spin } = grains;
        Self {
            position,
            velocity,
            spin,
            radius,
            mass,
            held,
            kind,
            laws,
            kinds,
            shifts: &[],
            dt: 0.0,
            next: 0.0,
            radii: false,
            growth: 0.0,
            way: Way::Single,
            way_at_planes: Way::Single,
            records: (&[], &[]),
        }
    }

    /// Steps before and after these forces.
    pub fn steps(&self) -> Steps {
        Steps::between(self.dt, self.next)
    }

    /// The law between two grains.
    #[inline]
    pub fn law(&self, i: usize, j: usize) -> &'a Law {
        &self.laws[self.kind[i] as usize * self.kinds + self.kind[j] as usize]
    }

    /// How a grain moves.
    #[inline]
    pub fn side(&self, i: usize) -> Side<D, R> {
        let inverse_mass = if self.held[i] { 0.0 } else { 1.0 / self.mass[i] };
        Side { velocity: self.velocity[i], spin: self.spin[i], radius: self.radius[i], inverse_mass }
    }

    /// What grain `i` and image `code` of grain `j` see of each other, at a distance, and their lever arms over their radii.
    #[inline]
    pub fn touch(
        &self,
        i: usize,
        j: usize,
        apart: &[f64; D],
        distance: f64,
        code: usize,
    ) -> (Touch<D, R>, f64) {
        let drift = (code > 0).then(|| &self.shifts[code].1);
        Touch::between([&self.side(i), &self.side(j)], (apart, distance), drift, self.radii)
    }

    /// Forces of the pairs of some grains, of which those that can touch are `close`. What other grains get is in `shares` too.
    fn rows(
        &self,
        (pairs, close): (Listed<'_>, &Run),
        rows: Range<usize>,
        shares: &mut Shares<'_, D, R>,
        slab: usize,
    ) {
        match self.way {
            Way::Single => self.single(pairs, rows, shares, slab),
            Way::Linear(false) => self.in_lanes::<false, false>((pairs, close), &rows, shares, slab),
            Way::Linear(true) => self.in_lanes::<false, true>((pairs, close), &rows, shares, slab),
            Way::Hertz(false) => self.in_lanes::<true, false>((pairs, close), &rows, shares, slab),
            Way::Hertz(true) => self.in_lanes::<true, true>((pairs, close), &rows, shares, slab),
        }
    }

    /// The same, one contact after another.
    fn single(&self, pairs: Listed<'_>, rows: Range<usize>, shares: &mut Shares<'_, D, R>, slab: usize) {
        let (mut tally, mut virial) = shares.tallies[slab - shares.slab];
        let periodic = !pairs.image.is_empty();
        for i in rows {
            let ends = pairs.starts[i] as usize..pairs.starts[i + 1] as usize;
            if ends.is_empty() {
                continue;
            }
            let (x, r) = (self.position[i], self.radius[i]);
            for k in ends {
                let j = pairs.other[k] as usize;
                let code = if periodic { pairs.image[k] as usize } else { 0 };
                let mut apart = minus(&x, &self.position[j]);
                if code > 0 {
                    apart = minus(&apart, &self.shifts[code].0);
                }
                let (square, sum) = (dot(&apart, &apart), r + self.radius[j]);
                let slot = k - shares.pair;
                let bonded = !shares.memory.bond.is_empty() && shares.memory.bond[slot].holds();
                if square >= sum * sum && shares.memory.state[slot] == APART && !bonded {
                    continue;
                }
                let (touch, arm) = self.touch(i, j, &apart, square.sqrt(), code);
                let Some(push) = self.push(self.law(i, j), &touch, slot, bonded, shares, &mut tally) else {
                    continue;
                };
                let mut on = spread(&push.across, &touch.normal);
                add(&mut on, push.normal, &touch.normal);
                let twisted = times(-arm, &moment::<D, R, f64>(&touch.normal, &push.across));
                let mut levers = [twisted; 2];
                for c in 0..R {
                    levers[0][c] += push.moment[c] * (1.0 / r);
                    levers[1][c] -= push.moment[c] * (1.0 / self.radius[j]);
                }
                shares.received[i - shares.first].take(&on, &levers[0]);
                shares.received[j - shares.first].take(&on.map(|f| -f), &levers[1]);
                for a in 0..D {
                    for b in 0..D {
                        virial[a][b] -= on[a] * apart[b];
                    }
                }
                tally.boundary += push.normal * self.growth * sum * self.dt;
                if code > 0 {
                    tally.boundary += dot(&on, &self.shifts[code].1) * self.dt;
                }
                count(&mut tally, &touch, &on, i);
            }
        }
        shares.tallies[slab - shares.slab] = (tally, virial);
    }

    /// What two grains that touch, or are bonded, do to each other; `None` where they do neither.
    #[inline]
    fn push(
        &self,
        law: &Law,
        touch: &Touch<D, R>,
        slot: usize,
        bonded: bool,
        shares: &mut Shares<'_, D, R>,
        tally: &mut Tally,
    ) -> Option<Push<R>> {
        let state = shares.memory.state[slot];
        let mut memory = shares.memory.get(slot);
        let meets = touch.overlap > 0.0 || touch.overlap > -law.bridge(state, touch.radius);
        let mut push = Push { normal: 0.0, across: [0.0; R], moment: [0.0; R] };
        if meets {
            push = act(law, touch, &mut memory, &self.steps(), tally);
            shares.memory.set(slot, &memory);
        } else if state != APART {
            end(law, touch, &mut memory, self.dt, tally);
            shares.memory.set(slot, &memory);
        }
        if bonded {
            law.bonded(touch, &mut shares.memory.bond[slot], &mut push, self.dt, tally);
        }
        (meets || bonded).then_some(push)
    }

    /// Slabs of one parity, those of `groups`: group `g` is slab `2 g + parity` with the one after.
    fn colour(&self, lists: Inner<'_>, groups: Range<usize>, parity: usize, mut shares: Shares<'_, D, R>) {
        if groups.len() > 1 {
            let middle = groups.start + groups.len() / 2;
            let slab = 2 * middle + parity;
            let grain = lists.slabs[slab] as usize;
            let (left, right) = shares.split_at(grain, lists.pairs.starts[grain] as usize, slab);
            rayon::join(
                || self.colour(lists, groups.start..middle, parity, left),
                || self.colour(lists, middle..groups.end, parity, right),
            );
        } else if let Some(group) = groups.into_iter().next() {
            let slab = 2 * group + parity;
            let rows = lists.slabs[slab] as usize..lists.slabs[slab + 1] as usize;
            self.rows((lists.pairs, &lists.close[slab]), rows, &mut shares, slab);
        }
    }

    /// Forces of all pairs; `tallies` are one per slab and one for the seam, to which sums are added.
    pub fn contacts(
        &self,
        lists: &mut Lists<D, R>,
        received: &mut [Received],
        tallies: &mut [(Tally, Virial<D>)],
    ) {
        let slabs = lists.slab_count();
        let (pairs, mut inner) = lists.inner.apart();
        let (seam_pairs, seam) = lists.seam.apart();
        let close = &lists.close;
        let lists = Inner { pairs, slabs: &lists.slabs, close: &close.slabs };
        let (of_slabs, of_seam) = tallies.split_at_mut(slabs);
        for parity in 0..2 {
            let groups = 0..(slabs + 1 - parity) / 2;
            let shares = Shares {
                first: 0,
                received: &mut *received,
                pair: 0,
                memory: inner.again(),
                slab: 0,
                tallies: &mut *of_slabs,
            };
            self.colour(lists, groups, parity, shares);
        }
        if !seam_pairs.other.is_empty() {
            let mut shares = Shares { first: 0, received, pair: 0, memory: seam, slab: 0, tallies: of_seam };
            self.rows((seam_pairs, &close.seam), 0..self.position.len(), &mut shares, 0);
        }
    }
}

/// Counts a contact and its force.
#[inline]
pub fn count<const D: usize, const R: usize>(
    tally: &mut Tally,
    touch: &Touch<D, R>,
    force: &[f64; D],
    grain: usize,
) {
    tally.contacts += 1;
    tally.squares += dot(force, force);
    let ratio = touch.overlap / touch.small;
    if ratio > tally.overlap {
        (tally.overlap, tally.deepest) = (ratio, grain as u32);
    }
}

/// A contact as it is after a step of `behind` (s), without going on.
pub fn look<const D: usize, const R: usize>(
    law: &Law,
    touch: &Touch<D, R>,
    mut memory: Memory<R>,
    bond: Option<&crate::contact::bond::Bond<R>>,
    behind: f64,
) -> Option<(Push<R>, Tally)> {
    let mut tally = Tally::default();
    let mut push = Push { normal: 0.0, across: [0.0; R], moment: [0.0; R] };
    let meets = touch.overlap > 0.0 || touch.overlap > -law.bridge(memory.state, touch.radius);
    let bonded = bond.is_some_and(crate::contact::bond::Bond::holds);
    if meets {
        push = act(law, touch, &mut memory, &Steps::after(behind), &mut tally);
    }
    if let (true, Some(bond)) = (bonded, bond) {
        law.bonded(touch, &mut { *bond }, &mut push, 0.0, &mut tally);
    }
    (meets || bonded).then_some((push, tally))
}
