//! Contacts of one law along the line of centres with friction, and nothing else, four side by side: the operations and
//! their order are those of [`act`](crate::contact::act), so that forces are the same to the last bit. Every contact writes its force; sums over the
//! contacts of a grain are made one after another, in the order of the lists.

use std::ops::Range;

use wide::f64x4 as Lanes;

use super::side::{Laws, Seen, WIDTH, seen};
use super::{Scene, Shares};
use crate::contact::friction::{left_in_lanes, rescaled_in_lanes};
use crate::contact::{APART, Elastic, TOUCHING, Tally, Touch, end};
use crate::pairs::Listed;
use crate::vector::{across, add, along, dot, follow, minus, moment, spread, times, turned};

/// Contacts of a batch.
const MOST: usize = 64;
/// Numbers of a batch.
type Column = [[f64; WIDTH]; MOST / WIDTH];

/// Contacts that wait, and what becomes of them.
struct Batch<const D: usize, const R: usize> {
    count: usize,
    first: [u32; MOST],
    second: [u32; MOST],
    slot: [u32; MOST],
    code: [u8; MOST],
    apart: [Column; D],
    square: Column,
    /// Velocity of the image.
    image: [Column; D],
    force: [Column; D],
    torques: [[Column; R]; 2],
    /// The grain whose contacts are being summed, and its sums.
    row: usize,
    own: ([f64; D], [f64; R]),
}

/// Sums over contacts, lane by lane.
#[derive(Default)]
struct Sums {
    elastic: Lanes,
    elastic_across: Lanes,
    friction: Lanes,
    dashpots: Lanes,
    rescaled: Lanes,
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
    pub(super) fn rows_in_lanes<const HERTZ: bool>(
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
                count: 0,
                first: [0; MOST],
                second: [0; MOST],
                slot: [0; MOST],
                code: [0; MOST],
                apart: [Column::default(); D],
                square: Column::default(),
                image: [Column::default(); D],
                force: [Column::default(); D],
                torques: [[Column::default(); R]; 2],
                row: rows.start,
                own: ([0.0; D], [0.0; R]),
            },
            common: alike.then(|| Laws::of([&self.laws[0]; WIDTH])),
            periodic: !pairs.image.is_empty(),
            tally,
            sums: Sums::default(),
            virial,
        };
        for i in rows {
            run.row::<HERTZ>(pairs, i);
        }
        run.flush::<HERTZ>();
        run.close();
        run.sums.into(&mut run.tally);
        let (tally, virial) = (run.tally, run.virial);
        shares.tallies[slab - shares.slab] = (tally, virial);
    }
}

impl<const D: usize, const R: usize> Run<'_, '_, '_, D, R> {
    /// Takes the pairs of a grain that touch; ends contacts that no longer do.
    #[inline(always)]
    fn row<const HERTZ: bool>(&mut self, pairs: Listed<'_>, i: usize) {
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
            batch.square.as_flattened_mut()[n] = square;
            for c in 0..D {
                batch.apart[c].as_flattened_mut()[n] = apart[c];
                if self.periodic {
                    batch.image[c].as_flattened_mut()[n] =
                        if code > 0 { scene.shifts[code].1[c] } else { 0.0 };
                }
            }
            batch.count += 1;
            if batch.count == MOST {
                self.flush::<HERTZ>();
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
    fn flush<const HERTZ: bool>(&mut self) {
        let count = self.batch.count;
        // What fills up the last four is the last contact again; nobody reads what becomes of it.
        for n in count..count.next_multiple_of(WIDTH) {
            let batch = &mut self.batch;
            (batch.first[n], batch.second[n], batch.slot[n]) =
                (batch.first[count - 1], batch.second[count - 1], batch.slot[count - 1]);
            batch.square.as_flattened_mut()[n] = batch.square.as_flattened()[count - 1];
            for c in 0..D {
                batch.apart[c].as_flattened_mut()[n] = batch.apart[c].as_flattened()[count - 1];
                batch.image[c].as_flattened_mut()[n] = batch.image[c].as_flattened()[count - 1];
            }
        }
        for group in 0..count.div_ceil(WIDTH) {
            self.four::<HERTZ>(group, (count - WIDTH * group).min(WIDTH));
        }
        self.hand_out(count);
        self.batch.count = 0;
    }

    /// Adds forces and moments to the grains.
    #[inline(always)]
    fn hand_out(&mut self, count: usize) {
        for n in 0..count {
            let i = self.batch.first[n] as usize;
            if i != self.batch.row {
                self.close();
                self.batch.row = i;
            }
            let batch = &mut self.batch;
            let at = batch.second[n] as usize - self.shares.first;
            let (force, torque) = (&mut self.shares.force[at], &mut self.shares.torque[at]);
            for c in 0..D {
                let f = batch.force[c].as_flattened()[n];
                batch.own.0[c] += f;
                force[c] -= f;
                if self.periodic {
                    for d in 0..D {
                        self.virial[c][d] -= f * batch.apart[d].as_flattened()[n];
                    }
                }
            }
            for c in 0..R {
                batch.own.1[c] += batch.torques[0][c].as_flattened()[n];
                torque[c] += batch.torques[1][c].as_flattened()[n];
            }
        }
    }

    /// Gives a grain the sums over its row.
    #[inline(always)]
    fn close(&mut self) {
        let at = self.batch.row - self.shares.first;
        let (force, torque) = std::mem::replace(&mut self.batch.own, ([0.0; D], [0.0; R]));
        add(&mut self.shares.force[at], 1.0, &force);
        add(&mut self.shares.torque[at], 1.0, &torque);
    }

    /// What four contacts are, and their lever arms.
    #[inline(always)]
    fn touch(
        &self,
        group: usize,
        firsts: [usize; WIDTH],
        seconds: [usize; WIDTH],
    ) -> (Touch<D, R, Lanes>, [Lanes; 2]) {
        let (scene, batch) = (self.scene, &self.batch);
        let one: Seen<D, R> = seen(firsts.map(|i| &scene.records[i]));
        let two: Seen<D, R> = seen(seconds.map(|j| &scene.records[j]));
        let (a, b) = (one.radius, two.radius);
        let sum = a + b;
        let distance = Lanes::new(batch.square[group]).sqrt();
        let apart: [Lanes; D] = std::array::from_fn(|c| Lanes::new(batch.apart[c][group]));
        let normal = times(Lanes::ONE / distance, &apart);
        let arms = if scene.radii {
            [a, b]
        } else {
            let arm = a / sum * distance;
            [arm, distance - arm]
        };
        let mut relative = minus(&one.velocity, &two.velocity);
        if self.periodic {
            relative = minus(&relative, &std::array::from_fn(|c| Lanes::new(batch.image[c][group])));
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
            turning: [Lanes::ZERO; R],
            spin: along(&mean, &normal),
            mass,
            radius: a * b / sum,
            small: a.fast_min(b),
        };
        (touch, arms)
    }

    /// Forces and moments of four contacts, of which `valid` count.
    #[inline(always)]
    fn four<const HERTZ: bool>(&mut self, group: usize, valid: usize) {
        let of = |list: &[u32; MOST]| std::array::from_fn(|k| list[WIDTH * group + k] as usize);
        let (firsts, seconds): ([usize; WIDTH], [usize; WIDTH]) =
            (of(&self.batch.first), of(&self.batch.second));
        let slots: [usize; WIDTH] = of(&self.batch.slot);
        let (touch, arms) = self.touch(group, firsts, seconds);
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
        let old: [Lanes; R] = std::array::from_fn(|c| Lanes::new(slots.map(|slot| memory.slide[slot][c])));
        let (across, slide) =
            self.friction::<HERTZ>(&laws, &touch, &base, normal.fast_max(Lanes::ZERO), (old, meets));
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
            let sum = touch.overlap + Lanes::new(self.batch.square[group]).sqrt();
            self.sums.boundary += meets & (normal * Lanes::splat(self.scene.growth) * sum * dt);
        }
        if self.periodic {
            let image: [Lanes; D] = std::array::from_fn(|c| Lanes::new(self.batch.image[c][group]));
            self.sums.boundary += meets & (dot(&on, &image) * dt);
        }
        for c in 0..D {
            self.batch.force[c][group] = (meets & on[c]).to_array();
        }
        let twisted = moment(&touch.normal, &across);
        for (arm, torque) in arms.iter().zip(&mut self.batch.torques) {
            for c in 0..R {
                torque[c][group] = (meets & (-*arm * twisted[c])).to_array();
            }
        }
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
                let apart = std::array::from_fn(|c| self.batch.apart[c].as_flattened()[n]);
                self.end(i, j, &apart, self.batch.code[n] as usize, slot);
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

    /// Force across and what is left of the spring.
    #[inline(always)]
    fn friction<const HERTZ: bool>(
        &mut self,
        laws: &Laws,
        touch: &Touch<D, R, Lanes>,
        base: &Elastic<Lanes>,
        cap: Lanes,
        (slide, meets): ([Lanes; R], Lanes),
    ) -> ([Lanes; R], [Lanes; R]) {
        let dt = Lanes::splat(self.scene.dt);
        let (stiffness, dashpot) = (base.across, base.damping_across);
        let mut old = follow(&slide, &touch.normal, touch.spin * dt);
        if HERTZ {
            let (rescaled, lost) =
                rescaled_in_lanes(&old, touch.overlap, touch.overlap + touch.separation * dt, stiffness);
            old = rescaled;
            self.sums.rescaled += meets & lost;
        }
        let mut slide: [Lanes; R] = std::array::from_fn(|c| old[c] + touch.sliding[c] * dt);
        let mut force: [Lanes; R] =
            std::array::from_fn(|c| -stiffness * slide[c] - dashpot * touch.sliding[c]);
        let square = dot(&force, &force);
        let limit = laws.at_rest * cap;
        let slips = square.simd_gt(limit * limit);
        if slips.any() {
            let limit = laws.coefficient * cap;
            let capped = times(limit / square.sqrt(), &force);
            let left = left_in_lanes(&capped, &touch.sliding, (stiffness, dashpot), limit, laws.spring);
            let mut lost = Lanes::ZERO;
            for c in 0..R {
                lost -= capped[c] * (touch.sliding[c] * dt - (left[c] - old[c]));
                force[c] = slips.bitselect(capped[c], force[c]);
                slide[c] = slips.bitselect(left[c], slide[c]);
            }
            self.sums.friction += meets & slips & lost;
            self.tally.sliding += u64::from((meets & slips).to_bitmask().count_ones());
        }
        let viscous = dashpot * dot(&touch.sliding, &touch.sliding) * dt;
        self.sums.dashpots += meets & slips.bitselect(Lanes::ZERO, viscous);
        self.sums.elastic_across += meets & (Lanes::HALF * stiffness * dot(&slide, &slide));
        (force, slide)
    }
}
