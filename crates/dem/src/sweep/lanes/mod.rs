//! Contacts of one law along the line of centres with friction and resistance against rolling and twisting, four side by side: the operations and
//! their order are those of [`act`](crate::contact::act), so that forces are the same to the last bit. Every contact writes its force; sums over the
//! contacts of a grain are made one after another, in the order of the lists.

mod springs;

use std::ops::Range;

use wide::f64x4 as Lanes;

use super::side::{Laws, Received, Seen, WIDTH, seen};
use super::{Scene, Shares};
use crate::contact::{APART, TOUCHING, Tally, Touch, end};
use crate::pairs::Listed;
use crate::vector::{across, add, along, dot, follow, minus, moment, spread, times, turned};

/// Contacts of a batch.
const MOST: usize = 64;

/// What four contacts are, on their way through the stages of a batch. Stages are loops of their own: chains of roots and
/// divisions of several fours are then under way at once.
#[derive(Clone, Copy)]
struct Four<const D: usize, const R: usize> {
    touch: Touch<D, R, Lanes>,
    /// Lever arms (m).
    arms: [Lanes; 2],
    /// What lies between the centres (m).
    apart: [Lanes; D],
    /// Springs across, turned into the plane across the normal (m).
    slide: [Lanes; R],
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
            arms: [zero; 2],
            apart: [zero; D],
            slide: [zero; R],
        }
    };
}

/// Contacts that wait.
struct Batch<const D: usize, const R: usize> {
    fours: [Four<D, R>; MOST / WIDTH],
    count: usize,
    first: [u32; MOST],
    second: [u32; MOST],
    slot: [u32; MOST],
    code: [u8; MOST],
    /// The grain whose contacts are being summed, and its sums.
    row: usize,
    own: Received,
}

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
    /// The law of all contacts, where there is but one.
    common: Option<Laws>,
    periodic: bool,
    tally: Tally,
    sums: Sums,
    virial: super::Virial<D>,
}

impl<'a, const D: usize, const R: usize> Scene<'a, D, R> {
    /// Forces of the pairs of some grains, as `rows` finds them.
    pub(super) fn rows_in_lanes<const HERTZ: bool, const TURNS: bool>(
        &self,
        pairs: Listed<'_>,
        rows: Range<usize>,
        shares: &mut Shares<'_, D, R>,
        slab: usize,
    ) {
        let (tally, virial) = shares.tallies[slab - shares.slab];
        let alike = self.laws.iter().all(|law| *law == self.laws[0]);
        let mut run = Run {
            scene: self,
            shares,
            batch: Batch {
                fours: [Four::NONE; MOST / WIDTH],
                count: 0,
                first: [0; MOST],
                second: [0; MOST],
                slot: [0; MOST],
                code: [0; MOST],
                row: rows.start,
                own: Received::default(),
            },
            common: alike.then(|| Laws::of([&self.laws[0]; WIDTH])),
            periodic: !pairs.image.is_empty(),
            tally,
            sums: Sums::default(),
            virial,
        };
        for i in rows {
            run.row::<HERTZ, TURNS>(pairs, i);
        }
        run.flush::<HERTZ, TURNS>();
        run.close();
        run.sums.into(&mut run.tally);
        let (tally, virial) = (run.tally, run.virial);
        shares.tallies[slab - shares.slab] = (tally, virial);
    }
}

impl<const D: usize, const R: usize> Run<'_, '_, '_, D, R> {
    /// Takes the pairs of a grain that touch; ends contacts that no longer do.
    #[inline(always)]
    fn row<const HERTZ: bool, const TURNS: bool>(&mut self, pairs: Listed<'_>, i: usize) {
        let scene = self.scene;
        let (x, r) = (scene.position[i], scene.radius[i]);
        for k in pairs.starts[i] as usize..pairs.starts[i + 1] as usize {
            let j = pairs.other[k] as usize;
            let code = if self.periodic { pairs.image[k] as usize } else { 0 };
            let mut apart = minus(&x, &scene.position[j]);
            if code > 0 {
                apart = minus(&apart, &scene.shifts[code].0);
            }
            let (square, sum) = (dot(&apart, &apart), r + scene.radius[j]);
            let slot = k - self.shares.pair;
            if square >= sum * sum {
                if self.shares.memory.state[slot] != APART {
                    self.end(i, j, &apart, code, slot);
                }
                continue;
            }
            let batch = &mut self.batch;
            let n = batch.count;
            (batch.first[n], batch.second[n], batch.slot[n]) = (i as u32, j as u32, slot as u32);
            batch.code[n] = code as u8;
            batch.count += 1;
            if batch.count == MOST {
                self.flush::<HERTZ, TURNS>();
            }
        }
    }

    #[cold]
    fn end(&mut self, i: usize, j: usize, apart: &[f64; D], code: usize, slot: usize) {
        let (touch, _) = self.scene.touch(i, j, apart, dot(apart, apart).sqrt(), code);
        let mut memory = self.shares.memory.get(slot);
        end(self.scene.law(i, j), &touch, &mut memory, self.scene.dt, &mut self.tally);
        self.shares.memory.set(slot, &memory);
    }

    /// Works on all contacts that wait.
    #[inline(never)]
    fn flush<const HERTZ: bool, const TURNS: bool>(&mut self) {
        let count = self.batch.count;
        // What fills up the last four is the last contact again; nobody reads what becomes of it.
        for n in count..count.next_multiple_of(WIDTH) {
            let batch = &mut self.batch;
            (batch.first[n], batch.second[n], batch.slot[n], batch.code[n]) = (
                batch.first[count - 1],
                batch.second[count - 1],
                batch.slot[count - 1],
                batch.code[count - 1],
            );
        }
        let groups = count.div_ceil(WIDTH);
        for group in 0..groups {
            let images = self.periodic.then(|| self.images(group));
            let [firsts, seconds, _] = self.grains(group);
            let (touch, arms, apart) = self.touch(firsts, seconds, images.as_ref());
            let four = &mut self.batch.fours[group];
            (four.touch, four.arms, four.apart) = (touch, arms, apart);
        }
        let dt = Lanes::splat(self.scene.dt);
        for group in 0..groups {
            let [.., slots] = self.grains(group);
            let memory = &self.shares.memory.slide;
            let old: [Lanes; R] = std::array::from_fn(|c| Lanes::new(slots.map(|slot| memory[slot][c])));
            let four = &mut self.batch.fours[group];
            four.slide = follow(&old, &four.touch.normal, four.touch.spin * dt);
        }
        for group in 0..groups {
            self.four::<HERTZ, TURNS>(group, (count - WIDTH * group).min(WIDTH));
        }
        self.batch.count = 0;
    }

    /// Grains and slots of four contacts.
    #[inline(always)]
    fn grains(&self, group: usize) -> [[usize; WIDTH]; 3] {
        let of = |list: &[u32; MOST]| std::array::from_fn(|k| list[WIDTH * group + k] as usize);
        [of(&self.batch.first), of(&self.batch.second), of(&self.batch.slot)]
    }

    /// Adds forces and moments of four contacts, of which `valid` count, to their grains.
    #[inline(always)]
    fn hand_out(&mut self, group: usize, valid: usize, [one, two]: &[[Received; WIDTH]; 2]) {
        for k in 0..valid {
            let n = WIDTH * group + k;
            let i = self.batch.first[n] as usize;
            if i != self.batch.row {
                self.close();
                self.batch.row = i;
            }
            self.batch.own.join(&one[k]);
            self.shares.received[self.batch.second[n] as usize - self.shares.first].join(&two[k]);
        }
    }

    /// Gives a grain the sums over its row.
    #[inline(always)]
    fn close(&mut self) {
        let own = std::mem::take(&mut self.batch.own);
        self.shares.received[self.batch.row - self.shares.first].join(&own);
    }

    /// Shifts of the images of four contacts (m), and their velocities (m/s).
    #[inline(always)]
    fn images(&self, group: usize) -> [[Lanes; D]; 2] {
        let codes: [usize; WIDTH] = std::array::from_fn(|k| self.batch.code[WIDTH * group + k] as usize);
        let shifts = codes.map(|code| &self.scene.shifts[code]);
        [
            std::array::from_fn(|c| Lanes::new(shifts.map(|shift| shift.0[c]))),
            std::array::from_fn(|c| Lanes::new(shifts.map(|shift| shift.1[c]))),
        ]
    }

    /// What four contacts are, their lever arms, and what lies between their centres (m).
    #[inline(always)]
    fn touch(
        &self,
        firsts: [usize; WIDTH],
        seconds: [usize; WIDTH],
        images: Option<&[[Lanes; D]; 2]>,
    ) -> (Touch<D, R, Lanes>, [Lanes; 2], [Lanes; D]) {
        let scene = self.scene;
        let one: Seen<D, R> = seen(firsts.map(|i| &scene.records[i]));
        let two: Seen<D, R> = seen(seconds.map(|j| &scene.records[j]));
        let (a, b) = (one.radius, two.radius);
        let sum = a + b;
        let mut apart = minus(&one.place, &two.place);
        if let Some([shift, _]) = images {
            apart = minus(&apart, shift);
        }
        let distance = dot(&apart, &apart).sqrt();
        let normal = times(Lanes::ONE / distance, &apart);
        let arms = if scene.radii {
            [a, b]
        } else {
            let arm = a / sum * distance;
            [arm, distance - arm]
        };
        let mut relative = minus(&one.velocity, &two.velocity);
        if let Some([_, velocity]) = images {
            relative = minus(&relative, velocity);
        }
        let both: [Lanes; R] = std::array::from_fn(|c| arms[0] * one.spin[c] + arms[1] * two.spin[c]);
        let rolling = turned(&both, &normal);
        let sliding = minus(&across::<D, R, Lanes>(&relative, &normal), &rolling);
        let mean: [Lanes; R] = std::array::from_fn(|c| Lanes::HALF * (one.spin[c] + two.spin[c]));
        // A grain that is held moves like a wall.
        let (m, other) = (one.mass, two.mass);
        let held = other.simd_lt(Lanes::ZERO).bitselect(m, m * other / (m + other));
        let mass = m.simd_lt(Lanes::ZERO).bitselect(other, held);
        let touch = Touch {
            overlap: sum - distance,
            normal,
            separation: dot(&relative, &normal),
            sliding,
            turning: minus(&one.spin, &two.spin),
            spin: along(&mean, &normal),
            mass,
            radius: a * b / sum,
            small: a.fast_min(b),
        };
        (touch, arms, apart)
    }

    /// Forces and moments of four contacts, of which `valid` count.
    #[inline(always)]
    fn four<const HERTZ: bool, const TURNS: bool>(&mut self, group: usize, valid: usize) {
        let [firsts, seconds, slots] = self.grains(group);
        let Four { touch, arms, apart, slide } = self.batch.fours[group];
        let laws = self
            .common
            .unwrap_or_else(|| Laws::of(std::array::from_fn(|k| self.scene.law(firsts[k], seconds[k]))));
        let base = if HERTZ { laws.hertz.at(&touch) } else { laws.linear.at(&touch) };
        let lane = Lanes::new([0.0, 1.0, 2.0, 3.0]);
        let meets = touch.overlap.simd_gt(Lanes::ZERO) & lane.simd_lt(Lanes::splat(valid as f64));
        let memory = &mut self.shares.memory;
        let dt = Lanes::splat(self.scene.dt);
        let viscous = base.force - base.damping * touch.separation;
        let normal = (laws.clamp & viscous.simd_lt(Lanes::ZERO)).bitselect(Lanes::ZERO, viscous);
        let dissipative = normal - base.force;
        let dash = Lanes::new(slots.map(|slot| memory.dash[slot]));
        self.sums.dashpots -= meets & (Lanes::HALF * (dash + dissipative) * touch.separation * dt);
        self.sums.elastic += meets & base.energy;
        let cap = normal.fast_max(Lanes::ZERO);
        let (across, slide) = self.friction::<HERTZ>(&laws, &touch, &base, cap, (slide, meets));
        let (slides, dissipatives) = (slide.map(Lanes::to_array), dissipative.to_array());
        let bits = meets.to_bitmask();
        for (k, &slot) in slots.iter().enumerate().take(valid) {
            if bits & (1 << k) != 0 {
                self.shares.memory.slide[slot] = std::array::from_fn(|c| slides[c][k]);
                self.shares.memory.dash[slot] = dissipatives[k];
                self.shares.memory.state[slot] = TOUCHING;
            }
        }
        let mut on: [Lanes; D] = spread(&across, &touch.normal);
        add(&mut on, normal, &touch.normal);
        self.count(&touch, &on, (firsts, bits), meets);
        if self.scene.growth != 0.0 {
            let sum = touch.overlap + dot(&apart, &apart).sqrt();
            self.sums.boundary += meets & (normal * Lanes::splat(self.scene.growth) * sum * dt);
        }
        let on = on.map(|f| meets & f);
        if self.periodic {
            let [_, velocity] = &self.images(group);
            self.sums.boundary += meets & (dot(&on, velocity) * dt);
            self.stream(valid, &on, &apart);
        }
        let twisted = moment(&touch.normal, &across);
        let mut moments = arms.map(|arm| twisted.map(|across| meets & (-arm * across)));
        if TURNS {
            let turned = self.resist(&laws, &touch, &base, cap, (&slots, meets));
            for c in 0..R {
                moments[0][c] += turned[c];
                moments[1][c] -= turned[c];
            }
        }
        self.hand_out(group, valid, &Received::of_four(&on, &moments));
        if bits != (1 << valid) - 1 {
            self.end_apart(group, valid, bits);
        }
    }

    /// Ends those of four contacts that do not overlap after all, by the last bit.
    #[cold]
    fn end_apart(&mut self, group: usize, valid: usize, bits: u32) {
        for n in (WIDTH * group..).take(valid).filter(|n| bits & (1 << (n % WIDTH)) == 0) {
            let slot = self.batch.slot[n] as usize;
            if self.shares.memory.state[slot] != APART {
                let (i, j) = (self.batch.first[n] as usize, self.batch.second[n] as usize);
                let (x, code) = (&self.scene.position, self.batch.code[n] as usize);
                let mut apart = minus(&x[i], &x[j]);
                if code > 0 {
                    apart = minus(&apart, &self.scene.shifts[code].0);
                }
                self.end(i, j, &apart, code, slot);
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
