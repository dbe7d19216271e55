//! SIMD contact kernel: four contacts of one normal law at once, with friction and resistance to rolling and torsion. The operations and
//! their order are those of [`contact_force`](crate::contact::contact_force), so that forces are equal to the last bit. Every contact
//! writes its force; sums over the contacts of a grain are made one after another, in the order of the lists.

mod batch;
mod contact_force;
mod planes;
mod springs;

use std::ops::Range;

use crate::force_loop::simd::batch::{BATCH_SIZE, ContactBatch};
use crate::force_loop::simd::contact_force::{ContactOutput, ContactSums};
pub use crate::force_loop::simd::planes::{PlaneContact, PlaneSums};
use wide::f64x4 as Lanes;

use crate::contact::contact_histories::{PairListView, SPRING_WIDTH};
use crate::contact::dashpot::StepLengths;
use crate::contact::{ContactGeometry, ContactState, PairLaw, release_contact};
use crate::force_loop::simd_records::{
    GrainMotion, SimdFrictionLaws, SimdLaws, SimdNormalLaws, contact_bodies,
};
use crate::force_loop::{ContactInput, ForceAccumulators};
use crate::neighbours::active_pairs::{ActivePair, ActivePairs as Close};
use crate::points::vector::{WIDTH, difference, dot, rotate_with_normal};

/// Computation of contact forces for a range of grains with SIMD kernels. Numbers of grains and pairs count from the first grain and pair
/// of the range.
struct SimdPass<'r, 'a, const D: usize, const R: usize> {
    input: &'r ContactInput<'a, D, R>,
    positions: &'r [Lanes],
    motions: &'r [GrainMotion],
    periodic: bool,
    batch: ContactBatch<D, R>,
    work: ContactOutput<'r, D, R>,
}

impl<'a, const D: usize, const R: usize> ContactInput<'a, D, R> {
    /// Adds the contact forces of the pairs of a range of grains.
    pub(super) fn simd_forces<const HERTZ: bool, const TURNS: bool>(
        &self,
        (pairs, active): (PairListView<'_>, &Close),
        rows: &Range<usize>,
        accumulators: &mut ForceAccumulators<'_, D, R>,
        slab: usize,
    ) {
        // The common law of all contacts, if there is only one.
        let alike = self.laws.iter().all(|law| *law == self.laws[0]);
        let common = alike.then(|| SimdLaws::gather([&self.laws[0]; WIDTH]));
        let (first, pair) = (rows.start, pairs.row_offsets[rows.start] as usize);
        let (energies, virial) = accumulators.energies[slab - accumulators.slab];
        let (_, history) = accumulators.history.reborrow().split_at(pair - accumulators.pair);
        let (_, records) = accumulators.records.reborrow().split_at(first - accumulators.first);
        let mut run = SimdPass {
            input: self,
            positions: records.position_and_radius,
            motions: records.motion,
            periodic: !pairs.image.is_empty(),
            batch: ContactBatch::EMPTY,
            work: ContactOutput {
                forces: records.forces,
                history,
                account: ContactSums::new(energies, virial),
                first,
            },
        };
        for (pairs, count) in active.groups_of_four() {
            run.collect_contacts::<HERTZ, TURNS>(pairs, count, common.as_ref());
        }
        run.process_batch::<HERTZ, TURNS>(common.as_ref());
        accumulators.energies[slab - accumulators.slab] = run.work.account.sums(self.dt);
    }

    /// Vectors between the centres of four pairs (m), their squared distances (m²), and the radii of the first and the second grains (m).
    #[inline(always)]
    fn separations(
        &self,
        places: &[Lanes],
        periodic: bool,
        pairs: &[ActivePair; WIDTH],
    ) -> ([Lanes; D], Lanes, [Lanes; 2]) {
        let place = Lanes::transpose(pairs.map(|pair| places[pair.first as usize]));
        let others = Lanes::transpose(pairs.map(|pair| places[pair.second as usize]));
        let mut apart: [Lanes; D] = std::array::from_fn(|c| place[c] - others[c]);
        if periodic {
            let [shift, _] = self.images(pairs);
            apart = difference(&apart, &shift);
        }
        (apart, dot(&apart, &apart), [place[3], others[3]])
    }

    /// Steps before and after the forces.
    #[inline(always)]
    fn simd_steps(&self) -> StepLengths<Lanes> {
        StepLengths::from_steps(Lanes::splat(self.dt), Lanes::splat(self.next_step))
    }

    /// Shifts of the images of four pairs (m), and their velocities (m/s).
    #[inline(always)]
    fn images(&self, pairs: &[ActivePair; WIDTH]) -> [[Lanes; D]; 2] {
        let shifts = pairs.map(|pair| &self.shifts[pair.image_index as usize]);
        [
            std::array::from_fn(|c| Lanes::new(shifts.map(|shift| shift.0[c]))),
            std::array::from_fn(|c| Lanes::new(shifts.map(|shift| shift.1[c]))),
        ]
    }
}

impl<const D: usize, const R: usize> SimdPass<'_, '_, D, R> {
    /// Adds those of up to four pairs that are in contact to the batch, and ends contacts that have separated. The first `count` pairs are
    /// used.
    #[inline(always)]
    fn collect_contacts<const HERTZ: bool, const TURNS: bool>(
        &mut self,
        pairs: &[ActivePair; WIDTH],
        count: usize,
        common: Option<&SimdLaws>,
    ) {
        let (_, square, [a, b]) = self.input.separations(self.positions, self.periodic, pairs);
        let sum = a + b;
        let valid = (1u32 << count) - 1;
        let near = square.simd_lt(sum * sum).to_bitmask() & valid;
        let kept =
            |k: usize| u32::from(self.work.history.state[pairs[k].slot as usize] != ContactState::Apart) << k;
        let ends = (0..WIDTH).fold(0, |bits, k| bits | kept(k)) & valid & !near;
        if ends != 0 {
            self.release_separated(pairs, ends);
        }
        self.batch.push(pairs, near);
        if self.batch.count >= BATCH_SIZE {
            self.process_batch::<HERTZ, TURNS>(common);
        }
    }

    /// Ends the contacts of those of four pairs whose bits are set.
    #[cold]
    fn release_separated(&mut self, pairs: &[ActivePair; WIDTH], bits: u32) {
        let ends = pairs.iter().enumerate().filter(|(lane, _)| bits & (1 << lane) != 0);
        ends.for_each(|(_, pair)| self.release_contact(*pair));
    }

    /// Ends a contact whose grains have separated; its stored energy is dissipated.
    #[cold]
    fn release_contact(&mut self, pair: ActivePair) {
        let (i, j) = (self.work.first + pair.first as usize, self.work.first + pair.second as usize);
        let (code, slot) = (pair.image_index as usize, pair.slot as usize);
        let x = &self.input.position;
        let mut apart = difference(&x[i], &x[j]);
        if code > 0 {
            apart = difference(&apart, &self.input.shifts[code].0);
        }
        let (geometry, _) = self.input.contact_geometry(i, j, &apart, dot(&apart, &apart).sqrt(), code);
        let mut history = self.work.history.get(slot);
        release_contact(
            self.input.law(i, j),
            &geometry,
            &mut history,
            self.input.dt,
            &mut self.work.account.energies,
        );
        self.work.history.set(slot, &history);
    }

    /// Computes the forces of the contacts in the batch, which is full or the last one.
    #[inline(never)]
    fn process_batch<const HERTZ: bool, const TURNS: bool>(&mut self, common: Option<&SimdLaws>) {
        let count = self.batch.count.min(BATCH_SIZE);
        // The last contact is repeated to fill up the last group of four; its results are not used.
        for n in count..count.next_multiple_of(WIDTH) {
            self.batch.copy(count - 1, n);
        }
        let groups = count.div_ceil(WIDTH).min(BATCH_SIZE / WIDTH);
        let (records, springs) = ((self.positions, self.motions), &*self.work.history.spring);
        for group in 0..groups {
            let slots = self.batch.pairs(group).map(|pair| pair.slot as usize);
            let (shear_displacement, damping_force) = load_springs(springs, &slots);
            contact_geometry::<D, R, TURNS>(&mut self.batch, group, records, (self.input, self.periodic));
            let own = &mut self.batch.groups[group];
            (own.shear_displacement, own.damping_force) = (shear_displacement, damping_force);
        }
        // One copy of the laws, common or not.
        let mut laws = common.copied().unwrap_or_else(|| SimdLaws::gather([&self.input.laws[0]; WIDTH]));
        let steps = self.input.simd_steps();
        for group in 0..groups {
            rotate_springs(&mut self.batch, group, self.input.dt);
            if common.is_none() {
                let first = self.work.first;
                laws.normal = SimdNormalLaws::gather(pair_laws(self.input, &self.batch, group, first));
            }
            let slots = self.batch.pairs(group).map(|pair| pair.slot as usize);
            let own = &mut self.batch.groups[group];
            own.normal = self.work.normal_force::<HERTZ>(&own.geometry, &laws.normal, &slots, &steps);
        }
        let mut work = self.work.reborrow();
        let mut apart = 0u64;
        for group in 0..groups {
            let valid = (count - WIDTH * group).min(WIDTH);
            if common.is_none() {
                laws.friction =
                    SimdFrictionLaws::gather(pair_laws(self.input, &self.batch, group, work.first));
            }
            let bits = work.contact_forces::<HERTZ, TURNS>(
                &self.batch,
                group,
                (self.input, self.periodic),
                &laws.friction,
                valid,
            );
            apart |= u64::from(!bits & ((1 << valid) - 1)) << (WIDTH * group);
        }
        self.work.account = work.account;
        // Contacts that by rounding do not overlap after all.
        while apart != 0 {
            let pair = self.batch.pairs[apart.trailing_zeros() as usize];
            if self.work.history.state[pair.slot as usize] != ContactState::Apart {
                self.release_contact(pair);
            }
            apart &= apart - 1;
        }
        for n in BATCH_SIZE..self.batch.count {
            self.batch.copy(n, n - BATCH_SIZE);
        }
        self.batch.count -= count;
    }
}

/// Contact laws of four contacts, whose grains are numbered from grain `first`.
fn pair_laws<'a, const D: usize, const R: usize>(
    input: &ContactInput<'a, D, R>,
    batch: &ContactBatch<D, R>,
    group: usize,
    first: usize,
) -> [&'a PairLaw; WIDTH] {
    let of = |pair: &ActivePair| input.law(first + pair.first as usize, first + pair.second as usize);
    batch.pairs(group).each_ref().map(of)
}

/// Finds the contact geometry of four contacts.
#[inline(always)]
fn contact_geometry<const D: usize, const R: usize, const TURNS: bool>(
    batch: &mut ContactBatch<D, R>,
    group: usize,
    (places, motions): (&[Lanes], &[GrainMotion]),
    (input, periodic): (&ContactInput<'_, D, R>, bool),
) {
    let pairs = batch.pairs(group);
    let drift = periodic.then(|| input.images(pairs)[1]);
    let (apart, square, radii) = input.separations(places, periodic, pairs);
    let one = contact_bodies(pairs.map(|pair| &motions[pair.first as usize]), radii[0]);
    let two = contact_bodies(pairs.map(|pair| &motions[pair.second as usize]), radii[1]);
    let (geometry, arm) =
        ContactGeometry::of_grains([&one, &two], (&apart, square.sqrt()), drift.as_ref(), input.radii);
    let own = &mut batch.groups[group];
    let ContactGeometry {
        overlap,
        normal,
        separation_velocity: separation,
        sliding_velocity: sliding,
        relative_spin: turning,
        spin,
        mass,
        inverse_mass,
        radius,
        min_radius: small,
    } = geometry;
    if TURNS {
        (own.radii, own.geometry.relative_spin) = (radii, turning);
    }
    if periodic || input.growth != 0.0 {
        own.apart = apart;
    }
    (own.geometry.overlap, own.geometry.normal, own.geometry.separation_velocity) =
        (overlap, normal, separation);
    (own.geometry.sliding_velocity, own.geometry.spin) = (sliding, spin);
    (own.geometry.mass, own.geometry.inverse_mass) = (mass, inverse_mass);
    (own.geometry.radius, own.geometry.min_radius, own.lever_arm) = (radius, small, arm);
}

/// Rotates the springs of four contacts with their normals.
#[inline(always)]
fn rotate_springs<const D: usize, const R: usize>(batch: &mut ContactBatch<D, R>, group: usize, dt: f64) {
    let own = &mut batch.groups[group];
    own.shear_displacement = rotate_with_normal(
        &own.shear_displacement,
        &own.geometry.normal,
        own.geometry.spin * Lanes::splat(dt),
    );
}

/// Tangential springs (m) and damping forces (N) of four contacts.
#[inline(always)]
fn load_springs<const R: usize>(
    springs: &[[f64; SPRING_WIDTH]],
    slots: &[usize; WIDTH],
) -> ([Lanes; R], Lanes) {
    let old = Lanes::transpose(slots.map(|slot| Lanes::new(springs[slot])));
    (std::array::from_fn(|c| old[c]), old[SPRING_WIDTH - 1])
}
