//! Forces of all contacts: those of the slabs, then those of the periodic pairs. The lists fix the order in which every grain receives
//! its forces: from an even slab before an odd one, on any number of threads.

pub(crate) mod contact_buffers;
pub(crate) mod contact_forces;
mod simd;
mod simd_records;
mod wall_forces;

use std::ops::Range;

use crate::contact::contact_histories::{ContactHistoriesMut, PairListView};
use crate::contact::dashpot::StepLengths;
use crate::contact::{
    ContactBody, ContactEnergies, ContactForce, ContactGeometry, ContactHistory, ContactState, PairLaw,
    Virial, contact_force, release_contact,
};
pub use crate::force_loop::simd::{PlaneContact, PlaneSums};
pub use crate::force_loop::simd_records::{
    ForceKernel, GrainMotion, GrainRecords, GrainRecordsMut, SimdLaws, scatter_forces,
};
use crate::neighbours::VerletLists;
use crate::neighbours::active_pairs::ActivePairs;
use crate::points::grains::GrainView;

use crate::points::vector::{add, difference, dot, from_tangential, moment, scaled};

/// Number of tasks of contact forces per thread, for an even load.
const TASKS_PER_THREAD: usize = 4;

/// Input of the contact forces: state of the grains, laws and steps.
pub struct ContactInput<'a, const D: usize, const R: usize> {
    /// Positions (m).
    pub position: &'a [[f64; D]],
    /// Velocities for the contact forces (m/s).
    pub velocity: &'a [[f64; D]],
    /// Angular velocities (rad/s).
    pub spin: &'a [[f64; R]],
    /// Radii (m).
    pub radius: &'a [f64],
    /// Masses (kg).
    pub mass: &'a [f64],
    /// Whether each grain has a prescribed motion.
    pub is_held: &'a [bool],
    /// Index of the kind of each grain.
    pub kind: &'a [u32],
    /// Contact laws of all pairs of kinds, as a matrix stored row by row.
    pub laws: &'a [PairLaw],
    /// Number of kinds.
    pub kinds: usize,
    /// Shift (m) and velocity (m/s) of each image.
    pub shifts: &'a [([f64; D], [f64; D])],
    /// Time since the last forces (s).
    pub dt: f64,
    /// Time until the next forces (s).
    pub next_step: f64,
    /// Whether lever arms are the radii.
    pub radii: bool,
    /// Rate at which radii grow (1/s).
    pub growth: f64,
    /// Kernel of the contacts between grains.
    pub kernel: ForceKernel,
    /// Kernel of the contacts with planes.
    pub plane_kernel: ForceKernel,
    /// Motions of the grains as records for the contacts with planes.
    pub motions: &'a [GrainMotion],
}

/// Pairs within the slabs, and the first grain of each slab.
#[derive(Clone, Copy)]
struct SlabPairs<'a> {
    pairs: PairListView<'a>,
    slabs: &'a [u32],
    active_pairs: &'a [ActivePairs],
}

/// Accumulators of the contact forces.
pub struct ForceAccumulators<'a, const D: usize, const R: usize> {
    /// First grain of this part.
    pub first: usize,
    /// Records of the grains with their forces and moments.
    pub records: GrainRecordsMut<'a>,
    /// First pair of the contact histories.
    pub pair: usize,
    /// Contact histories.
    pub history: ContactHistoriesMut<'a, R>,
    /// First slab of the sums.
    pub slab: usize,
    /// Energies and virial of each slab.
    pub energies: &'a mut [(ContactEnergies, Virial<D>)],
}

impl<'a, const D: usize, const R: usize> ForceAccumulators<'a, D, R> {
    /// Splits the accumulators before a grain, a pair and a slab.
    fn split_at(self, grain: usize, pair: usize, slab: usize) -> (Self, Self) {
        let (records, more_records) = self.records.split_at(grain - self.first);
        let (history, more_memory) = self.history.split_at(pair - self.pair);
        let (slab_energies, more_tallies) = self.energies.split_at_mut(slab - self.slab);
        (
            Self { records, history, energies: slab_energies, ..self },
            Self {
                first: grain,
                records: more_records,
                pair,
                history: more_memory,
                slab,
                energies: more_tallies,
            },
        )
    }
}

impl<'a, const D: usize, const R: usize> ContactInput<'a, D, R> {
    /// Input for grains outside a periodic cell, without a time step.
    pub fn new(grains: GrainView<'a, D, R>, laws: &'a [PairLaw], kinds: usize) -> Self {
        let GrainView { kind, is_held, radius, mass, position, velocity, spin } = grains;
        Self {
            position,
            velocity,
            spin,
            radius,
            mass,
            is_held,
            kind,
            laws,
            kinds,
            shifts: &[],
            dt: 0.0,
            next_step: 0.0,
            radii: false,
            growth: 0.0,
            kernel: ForceKernel::Scalar,
            plane_kernel: ForceKernel::Scalar,
            motions: &[],
        }
    }

    /// Steps before and after the forces.
    pub fn steps(&self) -> StepLengths {
        StepLengths::from_steps(self.dt, self.next_step)
    }

    /// Contact law of two grains.
    #[inline]
    pub fn law(&self, i: usize, j: usize) -> &'a PairLaw {
        &self.laws[self.kind[i] as usize * self.kinds + self.kind[j] as usize]
    }

    /// Motion and size of a grain.
    #[inline]
    pub fn contact_body(&self, i: usize) -> ContactBody<D, R> {
        let inverse_mass = if self.is_held[i] { 0.0 } else { 1.0 / self.mass[i] };
        ContactBody { velocity: self.velocity[i], spin: self.spin[i], radius: self.radius[i], inverse_mass }
    }

    /// Contact geometry of grain `i` and image `code` of grain `j`, at a distance (m), and their lever arms over their radii.
    #[inline]
    pub fn contact_geometry(
        &self,
        i: usize,
        j: usize,
        apart: &[f64; D],
        distance: f64,
        code: usize,
    ) -> (ContactGeometry<D, R>, f64) {
        let drift = (code > 0).then(|| &self.shifts[code].1);
        ContactGeometry::of_grains(
            [&self.contact_body(i), &self.contact_body(j)],
            (apart, distance),
            drift,
            self.radii,
        )
    }

    /// Adds the contact forces of the active pairs of a range of grains. The forces on the other grains are also added to `accumulators`.
    fn pair_forces(
        &self,
        (pairs, active): (PairListView<'_>, &ActivePairs),
        rows: Range<usize>,
        accumulators: &mut ForceAccumulators<'_, D, R>,
        slab: usize,
    ) {
        match self.kernel {
            ForceKernel::Scalar => self.scalar_pair_forces(pairs, rows, accumulators, slab),
            ForceKernel::SimdLinear(false) => {
                self.simd_forces::<false, false>((pairs, active), &rows, accumulators, slab);
            }
            ForceKernel::SimdLinear(true) => {
                self.simd_forces::<false, true>((pairs, active), &rows, accumulators, slab);
            }
            ForceKernel::SimdHertz(false) => {
                self.simd_forces::<true, false>((pairs, active), &rows, accumulators, slab);
            }
            ForceKernel::SimdHertz(true) => {
                self.simd_forces::<true, true>((pairs, active), &rows, accumulators, slab);
            }
        }
    }

    /// Adds the contact forces of a range of grains, one contact at a time.
    fn scalar_pair_forces(
        &self,
        pairs: PairListView<'_>,
        rows: Range<usize>,
        accumulators: &mut ForceAccumulators<'_, D, R>,
        slab: usize,
    ) {
        let (mut energies, mut virial) = accumulators.energies[slab - accumulators.slab];
        let periodic = !pairs.image.is_empty();
        for i in rows {
            let ends = pairs.row_offsets[i] as usize..pairs.row_offsets[i + 1] as usize;
            if ends.is_empty() {
                continue;
            }
            let (x, r) = (self.position[i], self.radius[i]);
            for k in ends {
                let j = pairs.second[k] as usize;
                let code = if periodic { pairs.image[k] as usize } else { 0 };
                let mut apart = difference(&x, &self.position[j]);
                if code > 0 {
                    apart = difference(&apart, &self.shifts[code].0);
                }
                let (square, sum) = (dot(&apart, &apart), r + self.radius[j]);
                let slot = k - accumulators.pair;
                let bonded =
                    !accumulators.history.bond.is_empty() && accumulators.history.bond[slot].is_intact();
                if square >= sum * sum && accumulators.history.state[slot] == ContactState::Apart && !bonded {
                    continue;
                }
                let (geometry, arm) = self.contact_geometry(i, j, &apart, square.sqrt(), code);
                let Some(contact) =
                    self.contact_force(self.law(i, j), &geometry, slot, bonded, accumulators, &mut energies)
                else {
                    continue;
                };
                let mut on = from_tangential(&contact.tangential, &geometry.normal);
                add(&mut on, contact.normal, &geometry.normal);
                let twisted = scaled(-arm, &moment::<D, R, f64>(&geometry.normal, &contact.tangential));
                let mut levers = [twisted; 2];
                for c in 0..R {
                    levers[0][c] += contact.moment[c] * (1.0 / r);
                    levers[1][c] -= contact.moment[c] * (1.0 / self.radius[j]);
                }
                let forces = &mut *accumulators.records.forces;
                forces[i - accumulators.first].add_force(&on, &levers[0]);
                forces[j - accumulators.first].add_force(&on.map(|f| -f), &levers[1]);
                for a in 0..D {
                    for b in 0..D {
                        virial[a][b] -= on[a] * apart[b];
                    }
                }
                energies.boundary += contact.normal * self.growth * sum * self.dt;
                if code > 0 {
                    energies.boundary += dot(&on, &self.shifts[code].1) * self.dt;
                }
                record_contact(&mut energies, &geometry, &on, i);
            }
        }
        accumulators.energies[slab - accumulators.slab] = (energies, virial);
    }

    /// Contact force and moment of two grains in contact or bonded; `None` if they are neither.
    #[inline]
    fn contact_force(
        &self,
        law: &PairLaw,
        geometry: &ContactGeometry<D, R>,
        slot: usize,
        bonded: bool,
        accumulators: &mut ForceAccumulators<'_, D, R>,
        energies: &mut ContactEnergies,
    ) -> Option<ContactForce<R>> {
        let state = accumulators.history.state[slot];
        let mut history = accumulators.history.get(slot);
        let in_contact =
            geometry.overlap > 0.0 || geometry.overlap > -law.rupture_distance(state, geometry.radius);
        let mut contact = ContactForce { normal: 0.0, tangential: [0.0; R], moment: [0.0; R] };
        if in_contact {
            contact = contact_force(law, geometry, &mut history, &self.steps(), energies);
            accumulators.history.set(slot, &history);
        } else if state != ContactState::Apart {
            release_contact(law, geometry, &mut history, self.dt, energies);
            accumulators.history.set(slot, &history);
        }
        if bonded {
            law.add_bond_force(
                geometry,
                &mut accumulators.history.bond[slot],
                &mut contact,
                self.dt,
                energies,
            );
        }
        (in_contact || bonded).then_some(contact)
    }

    /// Adds the forces of slabs in two passes, between which all threads wait. A grain receives the forces of the pairs of an even slab
    /// first, then those of an odd one. Group `g` consists of the slabs `2 g` and `2 g + 1`, and a task of up to `task` groups. The
    /// first pass, 0, takes all slabs of a task but the last: each even slab, then the odd one before it, while the records of their
    /// grains, which are set just before, are in the cache. The last slab shares grains with the next task, and is taken in the second
    /// pass, 1.
    fn slab_forces(
        &self,
        lists: SlabPairs<'_>,
        (groups, task): (Range<usize>, usize),
        pass: usize,
        mut accumulators: ForceAccumulators<'_, D, R>,
    ) {
        if groups.len() > task {
            let middle = groups.start + groups.len() / 2;
            let slab = 2 * middle + pass;
            let grain = lists.slabs[slab] as usize;
            let (left, right) = accumulators.split_at(grain, lists.pairs.row_offsets[grain] as usize, slab);
            rayon::join(
                || self.slab_forces(lists, (groups.start..middle, task), pass, left),
                || self.slab_forces(lists, (middle..groups.end, task), pass, right),
            );
            return;
        }
        let add = |accumulators: &mut ForceAccumulators<'_, D, R>, slab: usize| {
            let rows = lists.slabs[slab] as usize..lists.slabs[slab + 1] as usize;
            self.pair_forces((lists.pairs, &lists.active_pairs[slab]), rows, accumulators, slab);
        };
        let (last, slabs) = (2 * groups.end - 1, lists.active_pairs.len());
        if pass == 1 {
            (last < slabs).then(|| add(&mut accumulators, last));
            return;
        }
        for group in groups.clone() {
            let ends = [2 * group, (2 * group + 2).min(slabs)].map(|slab| lists.slabs[slab] as usize);
            let [first, end] = ends.map(|grain| grain - accumulators.first);
            let (records, _) = accumulators.records.reborrow().split_at(end);
            self.fill_records(ends[0]..ends[1], records.split_at(first).1);
            add(&mut accumulators, 2 * group);
            (group > groups.start).then(|| add(&mut accumulators, 2 * group - 1));
        }
    }

    /// Adds the contact forces of all pairs. Their sums are added to `slab_energies`, one per slab and one for the periodic pairs.
    pub fn contacts(
        &self,
        lists: &mut VerletLists<D, R>,
        records: &mut GrainRecords,
        slab_energies: &mut [(ContactEnergies, Virial<D>)],
    ) {
        let slabs = lists.slab_count();
        let (pairs, mut histories) = lists.slab_pairs.view_and_histories();
        let (periodic_pairs, periodic_histories) = lists.periodic_pairs.view_and_histories();
        let active = &lists.active_pairs;
        let lists = SlabPairs { pairs, slabs: &lists.slabs, active_pairs: &active.slabs };
        let (of_slabs, of_periodic) = slab_energies.split_at_mut(slabs);
        let groups = slabs.div_ceil(2);
        let threads = rayon::current_num_threads();
        let task = if threads == 1 { groups } else { groups.div_ceil(TASKS_PER_THREAD * threads) };
        for pass in 0..if groups > 0 { 2 } else { 0 } {
            let accumulators = ForceAccumulators {
                first: 0,
                records: records.view(),
                pair: 0,
                history: histories.reborrow(),
                slab: 0,
                energies: &mut *of_slabs,
            };
            self.slab_forces(lists, (0..groups, task), pass, accumulators);
        }
        if !periodic_pairs.second.is_empty() {
            let mut accumulators = ForceAccumulators {
                first: 0,
                records: records.view(),
                pair: 0,
                history: periodic_histories,
                slab: 0,
                energies: of_periodic,
            };
            self.pair_forces(
                (periodic_pairs, &active.periodic_pairs),
                0..self.position.len(),
                &mut accumulators,
                0,
            );
        }
    }
}

/// Adds a contact to the number of contacts, its squared force (N²) to their sum, and its overlap over radius to their maximum.
#[inline]
pub fn record_contact<const D: usize, const R: usize>(
    energies: &mut ContactEnergies,
    geometry: &ContactGeometry<D, R>,
    force: &[f64; D],
    grain: usize,
) {
    energies.contacts += 1;
    energies.squares += dot(force, force);
    let ratio = geometry.overlap / geometry.min_radius;
    if ratio > energies.overlap {
        (energies.overlap, energies.max_overlap_grain) = (ratio, grain as u32);
    }
}

/// Force and energies of a contact at the end of a step of the length `behind` (s), without a change of its history.
pub fn probe_contact<const D: usize, const R: usize>(
    law: &PairLaw,
    geometry: &ContactGeometry<D, R>,
    mut history: ContactHistory<R>,
    bond: Option<&crate::contact::bond::Bond<R>>,
    behind: f64,
) -> Option<(ContactForce<R>, ContactEnergies)> {
    let mut energies = ContactEnergies::default();
    let mut contact = ContactForce { normal: 0.0, tangential: [0.0; R], moment: [0.0; R] };
    let in_contact =
        geometry.overlap > 0.0 || geometry.overlap > -law.rupture_distance(history.state, geometry.radius);
    let bonded = bond.is_some_and(crate::contact::bond::Bond::is_intact);
    if in_contact {
        contact = contact_force(law, geometry, &mut history, &StepLengths::for_probe(behind), &mut energies);
    }
    if let (true, Some(bond)) = (bonded, bond) {
        law.add_bond_force(geometry, &mut { *bond }, &mut contact, 0.0, &mut energies);
    }
    (in_contact || bonded).then_some((contact, energies))
}
