//! Contacts of one law along the line of centres with friction and resistance against rolling and twisting, four side by side: the operations and
//! their order are those of [`act`](crate::contact::act), so that forces are the same to the last bit. Every contact writes its force; sums over the
//! contacts of a grain are made one after another, in the order of the lists.

mod batch;
mod springs;

use batch::{Batch, Four, FourPairs, MOST, ROOM, four_of};
use wide::f64x4 as Lanes;

use super::side::{Laws, Received, WIDTH, seen};
use super::{Scene, Shares};
use crate::contact::{APART, TOUCHING, Tally, Touch, end};
use crate::lists::close::Run as Close;
use crate::pairs::SPRING;
use crate::vector::{add, dot, follow, minus, moment, spread, times};

/// Sums over contacts, lane by lane.
#[derive(Default)]
struct Sums {
    elastic: Lanes,
    elastic_across: Lanes,
    friction: Lanes,
    dashpots: Lanes,
    rescaled: Lanes,
    rolling: Lanes,
    elastic_rolling: Lanes,
    boundary: Lanes,
    squares: Lanes,
}

impl Sums {
    fn into(self, tally: &mut Tally) {
        let sum = |lanes: Lanes| {
            let [a, b, c, d] = lanes.to_array();
            (a + b) + (c + d)
        };
        tally.elastic += sum(self.elastic);
        tally.elastic_across += sum(self.elastic_across);
        tally.friction += sum(self.friction);
        tally.dashpots += sum(self.dashpots);
        tally.rescaled += sum(self.rescaled);
        tally.rolling += sum(self.rolling);
        tally.elastic_rolling += sum(self.elastic_rolling);
        tally.boundary += sum(self.boundary);
        tally.squares += sum(self.squares);
    }
}

/// What goes through the contacts of a run of rows.
struct Run<'r, 'a, 's, const D: usize, const R: usize> {
    scene: &'r Scene<'a, D, R>,
    shares: &'r mut Shares<'s, D, R>,
    batch: Batch<D, R>,
    periodic: bool,
    tally: Tally,
    sums: Sums,
    virial: super::Virial<D>,
}

impl<'a, const D: usize, const R: usize> Scene<'a, D, R> {
    /// Forces of these pairs, as `rows` finds them; images of the second grains stand in their whole list.
    pub(super) fn in_lanes<const HERTZ: bool, const TURNS: bool>(
        &self,
        close: &Close,
        images: &[u8],
        shares: &mut Shares<'_, D, R>,
        slab: usize,
    ) {
        let (tally, virial) = shares.tallies[slab - shares.slab];
        // The law of all contacts, where there is but one.
        let alike = self.laws.iter().all(|law| *law == self.laws[0]);
        let common = alike.then(|| Laws::of([&self.laws[0]; WIDTH]));
        let mut run = Run {
            scene: self,
            shares,
            batch: Batch::EMPTY,
            periodic: !images.is_empty(),
            tally,
            sums: Sums::default(),
            virial,
        };
        for k in (0..close.slot.len()).step_by(WIDTH) {
            run.look::<HERTZ, TURNS>(close, images, k, common.as_ref());
        }
        run.flush::<HERTZ, TURNS>(common.as_ref());
        run.sums.into(&mut run.tally);
        let (tally, virial) = (run.tally, run.virial);
        shares.tallies[slab - shares.slab] = (tally, virial);
    }
}

impl<const D: usize, const R: usize> Run<'_, '_, '_, D, R> {
    /// Takes those of four pairs from `k` on that touch; ends contacts that no longer do.
    #[inline(always)]
    fn look<const HERTZ: bool, const TURNS: bool>(
        &mut self,
        close: &Close,
        images: &[u8],
        k: usize,
        common: Option<&Laws>,
    ) {
        let scene = self.scene;
        // What fills up the last four is the last pair again, and does not count.
        let pairs = FourPairs {
            first: fill_up(&close.first, k),
            second: fill_up(&close.second, k),
            slot: fill_up(&close.slot, k),
        };
        let codes = if self.periodic { pairs.slot.map(|slot| images[slot as usize]) } else { [0; WIDTH] };
        let place = Lanes::transpose(pairs.first.map(|i| scene.records.0[i as usize]));
        let others = Lanes::transpose(pairs.second.map(|j| scene.records.0[j as usize]));
        let mut apart: [Lanes; D] = std::array::from_fn(|c| place[c] - others[c]);
        if self.periodic {
            let [shift, _] = self.images(codes);
            apart = minus(&apart, &shift);
        }
        let square = dot(&apart, &apart);
        let sum = place[3] + others[3];
        let valid = (1u32 << (close.slot.len() - k).min(WIDTH)) - 1;
        let near = square.simd_lt(sum * sum).to_bitmask() & valid;
        if near != valid {
            self.end_far(&pairs, codes, valid & !near);
        }
        if near != 0 {
            let origin = self.shares.pair as u32;
            self.batch.push((&pairs, codes, origin), (&apart, square, [place[3], others[3]]), near);
            if self.batch.count >= MOST {
                self.flush::<HERTZ, TURNS>(common);
            }
        }
    }

    /// Ends those of four contacts whose bits are set.
    #[inline]
    fn end_far(&mut self, pairs: &FourPairs, codes: [u8; WIDTH], bits: u32) {
        for lane in (0..WIDTH).filter(|lane| bits & (1 << lane) != 0) {
            let slot = pairs.slot[lane] as usize - self.shares.pair;
            if self.shares.memory.state[slot] != APART {
                let (i, j) = (pairs.first[lane] as usize, pairs.second[lane] as usize);
                self.end(i, j, codes[lane] as usize, slot);
            }
        }
    }

    #[cold]
    fn end(&mut self, i: usize, j: usize, code: usize, slot: usize) {
        let x = &self.scene.position;
        let mut apart = minus(&x[i], &x[j]);
        if code > 0 {
            apart = minus(&apart, &self.scene.shifts[code].0);
        }
        let (touch, _) = self.scene.touch(i, j, &apart, dot(&apart, &apart).sqrt(), code);
        let mut memory = self.shares.memory.get(slot);
        end(self.scene.law(i, j), &touch, &mut memory, self.scene.dt, &mut self.tally);
        self.shares.memory.set(slot, &memory);
    }

    /// Works on the contacts that wait: as many as fill a batch, or all of them.
    #[inline(never)]
    fn flush<const HERTZ: bool, const TURNS: bool>(&mut self, common: Option<&Laws>) {
        let count = self.batch.count.min(MOST);
        // What fills up the last four is the last contact again; nobody reads what becomes of it.
        for n in count..count.next_multiple_of(WIDTH) {
            self.batch.copy(count - 1, n);
        }
        let groups = count.div_ceil(WIDTH);
        for group in 0..groups {
            let group = group % (MOST / WIDTH);
            self.touch::<TURNS>(group);
        }
        for group in 0..groups {
            let group = group % (MOST / WIDTH);
            self.turn(group);
        }
        for group in 0..groups {
            let group = group % (MOST / WIDTH);
            self.four::<HERTZ, TURNS>(group, (count - WIDTH * group).min(WIDTH), common);
        }
        for n in MOST..self.batch.count {
            self.batch.copy(n, n - MOST);
        }
        self.batch.count -= count;
    }

    /// Grains and slots of four contacts.
    #[inline(always)]
    fn grains(&self, group: usize) -> [[usize; WIDTH]; 3] {
        let of = |list: &[u32; ROOM]| {
            let own = &list[WIDTH * group..][..WIDTH];
            std::array::from_fn(|k| own[k] as usize)
        };
        [of(&self.batch.first), of(&self.batch.second), of(&self.batch.slot)]
    }

    /// Adds forces and moments of four contacts, of which `valid` count, to their grains.
    #[inline(always)]
    fn hand_out(
        &mut self,
        [firsts, seconds]: [[usize; WIDTH]; 2],
        valid: usize,
        [one, two]: &[[Received; WIDTH]; 2],
    ) {
        let first = self.shares.first;
        for k in 0..valid {
            self.shares.received[firsts[k] - first].join(&one[k]);
            self.shares.received[seconds[k] - first].join(&two[k]);
        }
    }

    /// Shifts of the images of four contacts (m), and their velocities (m/s).
    #[inline(always)]
    fn images(&self, codes: [u8; WIDTH]) -> [[Lanes; D]; 2] {
        let shifts = codes.map(|code| &self.scene.shifts[code as usize]);
        [
            std::array::from_fn(|c| Lanes::new(shifts.map(|shift| shift.0[c]))),
            std::array::from_fn(|c| Lanes::new(shifts.map(|shift| shift.1[c]))),
        ]
    }

    /// Velocities of the images of four contacts (m/s).
    #[inline(always)]
    fn drift(&self, group: usize) -> Option<[Lanes; D]> {
        let codes = || std::array::from_fn(|k| self.batch.code[WIDTH * group + k]);
        self.periodic.then(|| self.images(codes())[1])
    }

    /// Finds what four contacts are.
    #[inline(always)]
    fn touch<const TURNS: bool>(&mut self, group: usize) {
        let drift = self.drift(group);
        let [firsts, seconds, _] = self.grains(group);
        let (scene, batch) = (self.scene, &mut self.batch);
        let radii = [0, 1].map(|side| four_of(&batch.radii[side], group));
        let one = seen(firsts.map(|i| &scene.records.1[i]), radii[0]);
        let two = seen(seconds.map(|j| &scene.records.1[j]), radii[1]);
        let apart: [Lanes; D] = std::array::from_fn(|c| four_of(&batch.apart[c], group));
        let distance = four_of(&batch.square, group).sqrt();
        let (touch, arm) = Touch::between([&one, &two], (&apart, distance), drift.as_ref(), scene.radii);
        let four = &mut batch.fours[group];
        let turning = if TURNS { touch.turning } else { four.touch.turning };
        (four.touch, four.arm) = (Touch { turning, ..touch }, arm);
    }

    /// Reads the springs of four contacts and turns them with their normals.
    #[inline(always)]
    fn turn(&mut self, group: usize) {
        let [.., slots] = self.grains(group);
        let four = &mut self.batch.fours[group];
        let old = Lanes::transpose(slots.map(|slot| Lanes::new(self.shares.memory.spring[slot])));
        let slide: [Lanes; R] = std::array::from_fn(|c| old[c]);
        four.slide = follow(&slide, &four.touch.normal, four.touch.spin * Lanes::splat(self.scene.dt));
        four.dash = old[SPRING - 1];
    }

    /// Forces and moments of four contacts, of which `valid` count.
    #[inline(always)]
    fn four<const HERTZ: bool, const TURNS: bool>(
        &mut self,
        group: usize,
        valid: usize,
        common: Option<&Laws>,
    ) {
        let [firsts, seconds, slots] = self.grains(group);
        let Four { touch, arm, slide, dash, .. } = self.batch.fours[group];
        let own;
        let laws = if let Some(laws) = common {
            laws
        } else {
            own = Laws::of(std::array::from_fn(|k| self.scene.law(firsts[k], seconds[k])));
            &own
        };
        let base = if HERTZ { laws.hertz.at(&touch) } else { laws.linear.at(&touch) };
        let lane = Lanes::new([0.0, 1.0, 2.0, 3.0]);
        let meets = touch.overlap.simd_gt(Lanes::ZERO) & lane.simd_lt(Lanes::splat(valid as f64));
        let dt = Lanes::splat(self.scene.dt);
        let viscous = base.force - base.damping * touch.separation;
        let normal = (laws.clamp & viscous.simd_lt(Lanes::ZERO)).bitselect(Lanes::ZERO, viscous);
        let dissipative = normal - base.force;
        self.sums.dashpots -= meets & (Lanes::HALF * (dash + dissipative) * touch.separation * dt);
        self.sums.elastic += meets & base.energy;
        let cap = normal.fast_max(Lanes::ZERO);
        let (across, slide) = self.friction::<HERTZ>(laws, &touch, &base, cap, (slide, meets));
        let bits = meets.to_bitmask();
        self.keep(&slots, &slide, dissipative, bits);
        let mut on: [Lanes; D] = spread(&across, &touch.normal);
        add(&mut on, normal, &touch.normal);
        self.count(&touch, &on, (firsts, bits), meets);
        let apart: [Lanes; D] = std::array::from_fn(|c| four_of(&self.batch.apart[c], group));
        if self.scene.growth != 0.0 {
            let sum = touch.overlap + dot(&apart, &apart).sqrt();
            self.sums.boundary += meets & (normal * Lanes::splat(self.scene.growth) * sum * dt);
        }
        let on = on.map(|f| meets & f);
        if let Some(velocity) = &self.drift(group) {
            self.sums.boundary += meets & (dot(&on, velocity) * dt);
            self.stream(valid, &on, &apart);
        }
        let lever: [Lanes; R] = times(-arm, &moment(&touch.normal, &across)).map(|own: Lanes| meets & own);
        let resistance = TURNS.then(|| {
            let turned = self.resist(laws, &touch, &base, cap, (&slots, meets));
            let [a, b] = [0, 1].map(|side| Lanes::ONE / four_of(&self.batch.radii[side], group));
            [times(a, &turned), times(b, &turned).map(|own| -own)]
        });
        let received = Received::of_four(&on, &lever, resistance);
        self.hand_out([firsts, seconds], valid, &received);
        if bits != (1 << valid) - 1 {
            self.end_apart(group, valid, bits);
        }
    }

    /// Keeps what the springs of those of four contacts whose bits are set remember.
    #[inline(always)]
    fn keep(&mut self, slots: &[usize; WIDTH], slide: &[Lanes; R], dash: Lanes, bits: u32) {
        let part = |c: usize| if c < R { slide[c] } else { Lanes::ZERO };
        let lines = Lanes::transpose([part(0), part(1), part(2), dash]);
        for (k, &slot) in slots.iter().enumerate() {
            if bits & (1 << k) != 0 {
                self.shares.memory.spring[slot] = lines[k].to_array();
                self.shares.memory.state[slot] = TOUCHING;
            }
        }
    }

    /// Ends those of four contacts that do not overlap after all, by the last bit.
    #[cold]
    fn end_apart(&mut self, group: usize, valid: usize, bits: u32) {
        for n in (WIDTH * group..).take(valid).filter(|n| bits & (1 << (n % WIDTH)) == 0) {
            let slot = self.batch.slot[n] as usize;
            if self.shares.memory.state[slot] != APART {
                let (i, j) = (self.batch.first[n] as usize, self.batch.second[n] as usize);
                self.end(i, j, self.batch.code[n] as usize, slot);
            }
        }
    }

    /// Adds four contacts to the stress, one after another.
    #[inline(always)]
    fn stream(&mut self, valid: usize, on: &[Lanes; D], apart: &[Lanes; D]) {
        let (on, apart) = (on.map(Lanes::to_array), apart.map(Lanes::to_array));
        for k in 0..valid {
            for c in 0..D {
                for d in 0..D {
                    self.virial[c][d] -= on[c][k] * apart[d][k];
                }
            }
        }
    }

    /// Counts contacts and their forces.
    #[inline(always)]
    fn count(
        &mut self,
        touch: &Touch<D, R, Lanes>,
        on: &[Lanes; D],
        (firsts, bits): ([usize; WIDTH], u32),
        meets: Lanes,
    ) {
        self.tally.contacts += u64::from(bits.count_ones());
        self.sums.squares += meets & dot(on, on);
        let deeper = touch.overlap.simd_gt(Lanes::splat(self.tally.overlap) * touch.small) & meets;
        if deeper.any() {
            let ratios = (touch.overlap / touch.small).to_array();
            for (k, ratio) in ratios.into_iter().enumerate() {
                if bits & (1 << k) != 0 && ratio > self.tally.overlap {
                    (self.tally.overlap, self.tally.deepest) = (ratio, firsts[k] as u32);
                }
            }
        }
    }
}

/// Four entries of a column from `k` on, the last one again where they go beyond it.
#[inline(always)]
fn fill_up<T: Copy>(column: &[T], k: usize) -> [T; WIDTH] {
    match column.get(k..k + WIDTH) {
        Some(four) => [four[0], four[1], four[2], four[3]],
        None => std::array::from_fn(|lane| column[(k + lane).min(column.len() - 1)]),
    }
}
