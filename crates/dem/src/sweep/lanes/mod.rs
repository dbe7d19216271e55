//! Contacts of one law along the line of centres with friction and resistance against rolling and twisting, four side by side: the operations and
//! their order are those of [`act`](crate::contact::act), so that forces are the same to the last bit. Every contact writes its force; sums over the
//! contacts of a grain are made one after another, in the order of the lists.

mod batch;
mod planes;
mod push;
mod springs;

use std::ops::Range;

use batch::{Batch, MOST};
pub use planes::{AtPlane, Planes};
use push::{Account, Work};
use wide::f64x4 as Lanes;

use super::side::{Laws, Motion, seen};
use super::{Scene, Shares};
use crate::contact::dashpot::Steps;
use crate::contact::{APART, Touch, end};
use crate::lists::close::{Pair, Run as Close};
use crate::pairs::{Listed, SPRING};
use crate::vector::{WIDTH, dot, follow, minus};

/// What goes through the contacts of a run of rows. Numbers of grains and pairs count from the first of the rows on.
struct Run<'r, 'a, const D: usize, const R: usize> {
    scene: &'r Scene<'a, D, R>,
    places: &'r [Lanes],
    motions: &'r [Motion],
    periodic: bool,
    batch: Batch<D, R>,
    work: Work<'r, D, R>,
}

impl<'a, const D: usize, const R: usize> Scene<'a, D, R> {
    /// Forces of these pairs, as `rows` finds them.
    pub(super) fn in_lanes<const HERTZ: bool, const TURNS: bool>(
        &self,
        (pairs, close): (Listed<'_>, &Close),
        rows: &Range<usize>,
        shares: &mut Shares<'_, D, R>,
        slab: usize,
    ) {
        // The law of all contacts, where there is but one.
        let alike = self.laws.iter().all(|law| *law == self.laws[0]);
        let common = alike.then(|| Laws::of([&self.laws[0]; WIDTH]));
        let (first, pair) = (rows.start, pairs.starts[rows.start] as usize);
        let (tally, virial) = shares.tallies[slab - shares.slab];
        let (_, memory) = shares.memory.again().split_at(pair - shares.pair);
        let received = &mut shares.received[first - shares.first..];
        let mut run = Run {
            scene: self,
            places: &self.records.0[first..],
            motions: &self.records.1[first..],
            periodic: !pairs.image.is_empty(),
            batch: Batch::EMPTY,
            work: Work { received, memory, account: Account::new(tally, virial), first },
        };
        for (pairs, count) in close.side_by_side() {
            run.look::<HERTZ, TURNS>(pairs, count, common.as_ref());
        }
        run.flush::<HERTZ, TURNS>(common.as_ref());
        shares.tallies[slab - shares.slab] = run.work.account.sums(self.dt);
    }

    /// What lies between the centres of four pairs (m), the square of their distances (m²), and the radii of the first and the second (m).
    #[inline(always)]
    fn between(
        &self,
        places: &[Lanes],
        periodic: bool,
        pairs: &[Pair; WIDTH],
    ) -> ([Lanes; D], Lanes, [Lanes; 2]) {
        let place = Lanes::transpose(pairs.map(|pair| places[pair.first as usize]));
        let others = Lanes::transpose(pairs.map(|pair| places[pair.second as usize]));
        let mut apart: [Lanes; D] = std::array::from_fn(|c| place[c] - others[c]);
        if periodic {
            let [shift, _] = self.images(pairs);
            apart = minus(&apart, &shift);
        }
        (apart, dot(&apart, &apart), [place[3], others[3]])
    }

    /// Steps before and after these forces.
    #[inline(always)]
    fn lane_steps(&self) -> Steps<Lanes> {
        Steps::between(Lanes::splat(self.dt), Lanes::splat(self.next))
    }

    /// Shifts of the images of four pairs (m), and their velocities (m/s).
    #[inline(always)]
    fn images(&self, pairs: &[Pair; WIDTH]) -> [[Lanes; D]; 2] {
        let shifts = pairs.map(|pair| &self.shifts[pair.code as usize]);
        [
            std::array::from_fn(|c| Lanes::new(shifts.map(|shift| shift.0[c]))),
            std::array::from_fn(|c| Lanes::new(shifts.map(|shift| shift.1[c]))),
        ]
    }
}

impl<const D: usize, const R: usize> Run<'_, '_, D, R> {
    /// Takes those of four pairs, the first `count` of which count, that touch; ends contacts that no longer do.
    #[inline(always)]
    fn look<const HERTZ: bool, const TURNS: bool>(
        &mut self,
        pairs: &[Pair; WIDTH],
        count: usize,
        common: Option<&Laws>,
    ) {
        let (_, square, [a, b]) = self.scene.between(self.places, self.periodic, pairs);
        let sum = a + b;
        let valid = (1u32 << count) - 1;
        let near = square.simd_lt(sum * sum).to_bitmask() & valid;
        let kept = |k: usize| u32::from(self.work.memory.state[pairs[k].slot as usize] != APART) << k;
        let ends = (0..WIDTH).fold(0, |bits, k| bits | kept(k)) & valid & !near;
        if ends != 0 {
            self.end_far(pairs, ends);
        }
        self.batch.push(pairs, near);
        if self.batch.count >= MOST {
            self.flush::<HERTZ, TURNS>(common);
        }
    }

    /// Ends the contacts of those of four pairs whose bits are set.
    #[cold]
    fn end_far(&mut self, pairs: &[Pair; WIDTH], bits: u32) {
        let ends = pairs.iter().enumerate().filter(|(lane, _)| bits & (1 << lane) != 0);
        ends.for_each(|(_, pair)| self.end(*pair));
    }

    #[cold]
    fn end(&mut self, pair: Pair) {
        let (i, j) = (self.work.first + pair.first as usize, self.work.first + pair.second as usize);
        let (code, slot) = (pair.code as usize, pair.slot as usize);
        let x = &self.scene.position;
        let mut apart = minus(&x[i], &x[j]);
        if code > 0 {
            apart = minus(&apart, &self.scene.shifts[code].0);
        }
        let (touch, _) = self.scene.touch(i, j, &apart, dot(&apart, &apart).sqrt(), code);
        let mut memory = self.work.memory.get(slot);
        end(self.scene.law(i, j), &touch, &mut memory, self.scene.dt, &mut self.work.account.tally);
        self.work.memory.set(slot, &memory);
    }

    /// Works on the contacts that wait: as many as fill a batch, or all of them.
    #[inline(never)]
    fn flush<const HERTZ: bool, const TURNS: bool>(&mut self, common: Option<&Laws>) {
        let count = self.batch.count.min(MOST);
        // What fills up the last four is the last contact again; nobody reads what becomes of it.
        for n in count..count.next_multiple_of(WIDTH) {
            self.batch.copy(count - 1, n);
        }
        let groups = count.div_ceil(WIDTH).min(MOST / WIDTH);
        let (records, springs) = ((self.places, self.motions), &*self.work.memory.spring);
        for group in 0..groups {
            let slots = self.batch.pairs(group).map(|pair| pair.slot as usize);
            let (slide, dash) = spring_lines(springs, &slots);
            touch::<D, R, TURNS>(&mut self.batch, group, records, (self.scene, self.periodic));
            let own = &mut self.batch.fours[group];
            (own.slide, own.dash) = (slide, dash);
        }
        for group in 0..groups {
            turn(&mut self.batch, group, self.scene.dt);
        }
        let mut work = self.work.again();
        let mut apart = 0u64;
        // In one place, whichever they are.
        let mut laws = common.copied().unwrap_or_else(|| Laws::of([&self.scene.laws[0]; WIDTH]));
        for group in 0..groups {
            let valid = (count - WIDTH * group).min(WIDTH);
            if common.is_none() {
                let grains = |pair: &Pair| [pair.first, pair.second].map(|i| work.first + i as usize);
                let law = |pair: &Pair| self.scene.law(grains(pair)[0], grains(pair)[1]);
                laws = Laws::of(self.batch.pairs(group).each_ref().map(law));
            }
            let bits =
                work.push::<HERTZ, TURNS>(&self.batch, group, (self.scene, self.periodic), &laws, valid);
            apart |= u64::from(!bits & ((1 << valid) - 1)) << (WIDTH * group);
        }
        self.work.account = work.account;
        // Those that do not overlap after all, by the last bit.
        while apart != 0 {
            let pair = self.batch.pairs[apart.trailing_zeros() as usize];
            if self.work.memory.state[pair.slot as usize] != APART {
                self.end(pair);
            }
            apart &= apart - 1;
        }
        for n in MOST..self.batch.count {
            self.batch.copy(n, n - MOST);
        }
        self.batch.count -= count;
    }
}

/// Finds what four contacts are.
#[inline(always)]
fn touch<const D: usize, const R: usize, const TURNS: bool>(
    batch: &mut Batch<D, R>,
    group: usize,
    (places, motions): (&[Lanes], &[Motion]),
    (scene, periodic): (&Scene<'_, D, R>, bool),
) {
    let pairs = batch.pairs(group);
    let drift = periodic.then(|| scene.images(pairs)[1]);
    let (apart, square, radii) = scene.between(places, periodic, pairs);
    let one = seen(pairs.map(|pair| &motions[pair.first as usize]), radii[0]);
    let two = seen(pairs.map(|pair| &motions[pair.second as usize]), radii[1]);
    let (touch, arm) = Touch::between([&one, &two], (&apart, square.sqrt()), drift.as_ref(), scene.radii);
    let own = &mut batch.fours[group];
    let Touch { overlap, normal, separation, sliding, turning, spin, mass, radius, small } = touch;
    if TURNS {
        (own.radii, own.touch.turning) = (radii, turning);
    }
    if periodic || scene.growth != 0.0 {
        own.apart = apart;
    }
    (own.touch.overlap, own.touch.normal, own.touch.separation) = (overlap, normal, separation);
    (own.touch.sliding, own.touch.spin, own.touch.mass) = (sliding, spin, mass);
    (own.touch.radius, own.touch.small, own.arm) = (radius, small, arm);
}

/// Turns the springs of four contacts with their normals.
#[inline(always)]
fn turn<const D: usize, const R: usize>(batch: &mut Batch<D, R>, group: usize, dt: f64) {
    let own = &mut batch.fours[group];
    own.slide = follow(&own.slide, &own.touch.normal, own.touch.spin * Lanes::splat(dt));
}

/// Springs across of four contacts (m), and the dissipative part of their normal forces (N).
#[inline(always)]
fn spring_lines<const R: usize>(springs: &[[f64; SPRING]], slots: &[usize; WIDTH]) -> ([Lanes; R], Lanes) {
    let old = Lanes::transpose(slots.map(|slot| Lanes::new(springs[slot])));
    (std::array::from_fn(|c| old[c]), old[SPRING - 1])
}
