//! Forces of the contacts of grains and walls (sheet: dem §2.10).

use std::ops::Range;

use colluvium_case::spatial;
use colluvium_points::surface::cross;

use crate::boundary::walls::{RigidWall, WallReaction, contact_position};
use crate::contact::contact_histories::ContactHistoriesMut;
use crate::contact::{
    ContactEnergies, ContactGeometry, ContactState, NormalForceLaw, Virial, contact_force, release_contact,
};
use crate::force_loop::{ContactInput, ForceKernel, PlaneContact, PlaneSums, SimdLaws, record_contact};
use crate::neighbours::wall_list::{WallList, WallListView};
use crate::points::vector::{WIDTH, add, difference, dot, from_tangential, moment, normal_spin};

/// Accumulators of wall contact forces, slab by slab.
struct WallForceAccumulators<'a, const D: usize, const R: usize> {
    first: usize,
    force: &'a mut [[f64; D]],
    torque: &'a mut [[f64; R]],
    entry: usize,
    history: ContactHistoriesMut<'a, R>,
    slab: usize,
    slab_energies: &'a mut [(ContactEnergies, Virial<D>)],
    /// Forces on the walls, ordered by slab and then by wall.
    reactions: &'a mut [WallReaction<D>],
}

impl<'a, const D: usize, const R: usize> WallForceAccumulators<'a, D, R> {
    /// Splits the accumulators at a grain, list entry and slab, so that two threads can write to them.
    fn split_at(self, grain: usize, entry: usize, slab: usize, walls: usize) -> (Self, Self) {
        let (force, more_force) = self.force.split_at_mut(grain - self.first);
        let (torque, more_torque) = self.torque.split_at_mut(grain - self.first);
        let (history, more_memory) = self.history.split_at(entry - self.entry);
        let (slab_energies, more_tallies) = self.slab_energies.split_at_mut(slab - self.slab);
        let (reactions, more_reactions) = self.reactions.split_at_mut((slab - self.slab) * walls);
        (
            Self { force, torque, history, slab_energies, reactions, ..self },
            Self {
                first: grain,
                force: more_force,
                torque: more_torque,
                entry,
                history: more_memory,
                slab,
                slab_energies: more_tallies,
                reactions: more_reactions,
            },
        )
    }
}

impl<'a, const D: usize, const R: usize> ContactInput<'a, D, R> {
    /// Contact geometry of a grain and a wall, and the lever arm (m).
    pub fn wall_contact_geometry(
        &self,
        i: usize,
        wall: &RigidWall<D>,
        (distance, normal): (f64, [f64; D]),
    ) -> (ContactGeometry<D, R>, f64) {
        let arm = if self.radii { self.radius[i] } else { distance };
        let of_wall = wall.velocity_at(&contact_position(&self.position[i], arm, &normal));
        let (mut geometry, arm) = ContactGeometry::with_wall(
            (&self.contact_body(i), self.mass[i]),
            (distance, &normal),
            &of_wall,
            self.radii,
        );
        if let Some(moving) = &wall.motion {
            geometry.relative_spin = difference(&self.spin[i], &moving.angular_velocity());
            geometry.spin += 0.5 * normal_spin(&moving.angular_velocity::<R>(), &normal);
        }
        (geometry, arm)
    }

    /// Contact sums of wall `number`: normal stiffness (N/m), normal dashpots (N s/m), and stiffness times the inward velocity of the grain
    /// (N/s).
    pub fn wall_stiffness_sums(&self, number: usize, wall: &RigidWall<D>, list: &WallList<R>) -> [f64; 3] {
        let (axis, inward) = wall.inward_normal();
        let touching = (0..list.grain.len())
            .filter(|&k| list.wall[k] as usize == number && list.history.state[k] != ContactState::Apart);
        let of_contact = |k: usize| {
            let i = list.grain[k] as usize;
            let (geometry, _) = self.wall_contact_geometry(i, wall, wall.distance(&self.position[i]));
            let [stiffness, dashpot] = match &wall.laws[self.kind[i] as usize].normal {
                NormalForceLaw::Linear(law) => {
                    [law.stiffness(geometry.radius), law.response(&geometry).damping]
                }
                // The Hertz force is proportional to the overlap to the power 3/2.
                NormalForceLaw::Hertz(law) if geometry.overlap > 0.0 => {
                    let base = law.response(&geometry);
                    [1.5 * base.force / geometry.overlap, base.damping]
                }
                NormalForceLaw::Hertz(_) => [0.0; 2],
            };
            [stiffness, dashpot, stiffness * inward * self.velocity[i][axis]]
        };
        touching.map(of_contact).fold([0.0; 3], |sums, own| std::array::from_fn(|c| sums[c] + own[c]))
    }

    /// Adds the contact forces of all walls. `reactions` are those on each wall, slab by slab.
    pub fn wall_forces(
        &self,
        walls: &[RigidWall<D>],
        list: (&WallListView<'_>, &[u32]),
        history: ContactHistoriesMut<'_, R>,
        (force, torque): (&mut [[f64; D]], &mut [[f64; R]]),
        slab_energies: &mut [(ContactEnergies, Virial<D>)],
        reactions: &mut [WallReaction<D>],
    ) {
        let slabs = list.1.len() - 1;
        let accumulators = WallForceAccumulators {
            first: 0,
            force,
            torque,
            entry: 0,
            history,
            slab: 0,
            slab_energies,
            reactions,
        };
        self.wall_slabs(walls, list, 0..slabs, accumulators);
    }

    /// Forces of the wall contacts in a range of slabs, halved recursively among threads.
    fn wall_slabs(
        &self,
        walls: &[RigidWall<D>],
        list: (&WallListView<'_>, &[u32]),
        slabs: Range<usize>,
        mut accumulators: WallForceAccumulators<'_, D, R>,
    ) {
        if slabs.len() > 1 {
            let middle = slabs.start + slabs.len() / 2;
            let entry = list.0.slabs[middle] as usize;
            let (left, right) = accumulators.split_at(list.1[middle] as usize, entry, middle, walls.len());
            rayon::join(
                || self.wall_slabs(walls, list, slabs.start..middle, left),
                || self.wall_slabs(walls, list, middle..slabs.end, right),
            );
            return;
        }
        let slab = slabs.start;
        match self.plane_kernel {
            ForceKernel::Scalar => {
                for k in list.0.slabs[slab] as usize..list.0.slabs[slab + 1] as usize {
                    self.wall_contact(walls, list.0, k, slab, &mut accumulators);
                }
            }
            ForceKernel::SimdLinear(false) => {
                self.simd_wall_forces::<false, false>(walls, list.0, slab, &mut accumulators);
            }
            ForceKernel::SimdLinear(true) => {
                self.simd_wall_forces::<false, true>(walls, list.0, slab, &mut accumulators);
            }
            ForceKernel::SimdHertz(false) => {
                self.simd_wall_forces::<true, false>(walls, list.0, slab, &mut accumulators);
            }
            ForceKernel::SimdHertz(true) => {
                self.simd_wall_forces::<true, true>(walls, list.0, slab, &mut accumulators);
            }
        }
    }

    /// Adds the wall forces on the grains of a slab, for contacts with planes four at a time. The order of contacts is that of the list.
    fn simd_wall_forces<const HERTZ: bool, const TURNS: bool>(
        &self,
        walls: &[RigidWall<D>],
        list: &WallListView<'_>,
        slab: usize,
        accumulators: &mut WallForceAccumulators<'_, D, R>,
    ) {
        let mut laws = walls.iter().flat_map(|wall| &wall.laws);
        let first = laws.next();
        let common =
            first.filter(|first| laws.all(|law| law == *first)).map(|law| SimdLaws::gather([law; WIDTH]));
        let (mut waiting, mut count, mut sums) = ([0; WIDTH], 0, PlaneSums::default());
        for k in list.slabs[slab] as usize..list.slabs[slab + 1] as usize {
            let (i, wall) = (list.grain[k] as usize, &walls[list.wall[k] as usize]);
            let plane = wall.surface.is_none();
            if plane && wall.distance(&self.position[i]).0 < self.radius[i] {
                waiting[count] = k;
                count += 1;
                if count == WIDTH {
                    let of = (slab, common.as_ref());
                    self.planes::<HERTZ, TURNS>(walls, list, &waiting, of, (&mut *accumulators, &mut sums));
                    count = 0;
                }
            } else if !plane || accumulators.history.state[k - accumulators.entry] != ContactState::Apart {
                waiting[..count].iter().for_each(|&k| self.wall_contact(walls, list, k, slab, accumulators));
                count = 0;
                self.wall_contact(walls, list, k, slab, accumulators);
            }
        }
        waiting[..count].iter().for_each(|&k| self.wall_contact(walls, list, k, slab, accumulators));
        accumulators.slab_energies[slab - accumulators.slab].0.add(&sums.energies(self.dt));
    }

    /// Adds the forces of planes on up to four grains in contact with them.
    fn planes<const HERTZ: bool, const TURNS: bool>(
        &self,
        walls: &[RigidWall<D>],
        list: &WallListView<'_>,
        entries: &[usize; WIDTH],
        (slab, common): (usize, Option<&SimdLaws>),
        (accumulators, sums): (&mut WallForceAccumulators<'_, D, R>, &mut PlaneSums<D>),
    ) {
        let four = entries.map(|k| {
            let (i, wall) = (list.grain[k] as usize, &walls[list.wall[k] as usize]);
            let law = &wall.laws[self.kind[i] as usize];
            let nearest = wall.distance(&self.position[i]);
            PlaneContact { grain: i, slot: k - accumulators.entry, nearest, velocity: wall.velocity, law }
        });
        let forces = self.plane_forces::<HERTZ, TURNS>(&four, common, accumulators.history.reborrow(), sums);
        for ((own, k), (on, moments)) in four.iter().zip(entries).zip(&forces) {
            let at = own.grain - accumulators.first;
            add(&mut accumulators.force[at], 1.0, on);
            moments.iter().for_each(|moment| add(&mut accumulators.torque[at], 1.0, moment));
            let wall = (slab - accumulators.slab) * walls.len() + list.wall[*k] as usize;
            add(&mut accumulators.reactions[wall].force, -1.0, on);
        }
    }

    /// Force of the contact `k` of the list, added to the grain and to the reaction of the wall.
    fn wall_contact(
        &self,
        walls: &[RigidWall<D>],
        list: &WallListView<'_>,
        k: usize,
        slab: usize,
        accumulators: &mut WallForceAccumulators<'_, D, R>,
    ) {
        let (i, number) = (list.grain[k] as usize, list.wall[k] as usize);
        let wall = &walls[number];
        let slot = k - accumulators.entry;
        let state = accumulators.history.state[slot];
        let nearest = match &wall.surface {
            None => wall.distance(&self.position[i]),
            Some(_) => list.facet[k].distance_and_normal(),
        };
        if nearest.0 - self.radius[i] >= 0.0 && state == ContactState::Apart {
            return;
        }
        let (geometry, arm) = self.wall_contact_geometry(i, wall, nearest);
        let law = wall.law(self.kind[i] as usize, &self.position[i], &nearest);
        let energies = &mut accumulators.slab_energies[slab - accumulators.slab].0;
        let mut history = accumulators.history.get(slot);
        if geometry.overlap > 0.0 || geometry.overlap > -law.rupture_distance(state, geometry.radius) {
            let contact = contact_force(law, &geometry, &mut history, &self.steps(), energies);
            let mut on = from_tangential(&contact.tangential, &geometry.normal);
            add(&mut on, contact.normal, &geometry.normal);
            let at = i - accumulators.first;
            add(&mut accumulators.force[at], 1.0, &on);
            add(&mut accumulators.torque[at], -arm, &moment(&geometry.normal, &contact.tangential));
            add(&mut accumulators.torque[at], 1.0, &contact.moment);
            let reaction = &mut accumulators.reactions[(slab - accumulators.slab) * walls.len() + number];
            add(&mut reaction.force, -1.0, &on);
            // The work of planes follows from their total force; their moment is not reported.
            if wall.surface.is_some() {
                let at = contact_position(&self.position[i], arm, &geometry.normal);
                let (turn, own) = (cross(&spatial(&at), &spatial(&on)), moment_in_space(&contact.moment));
                (0..3).for_each(|c| reaction.moment[c] -= turn[c] + own[c]);
                if let Some(moving) = &wall.motion {
                    energies.boundary += (dot(&on, &moving.velocity(&at))
                        + dot(&contact.moment, &moving.angular_velocity()))
                        * self.dt;
                }
            }
            record_contact(energies, &geometry, &on, i);
        } else {
            release_contact(law, &geometry, &mut history, self.dt, energies);
        }
        accumulators.history.set(slot, &history);
    }
}

/// Moment as a spatial vector (N m); in the plane along the out-of-plane axis.
fn moment_in_space<const R: usize>(moment: &[f64; R]) -> [f64; 3] {
    if R == 1 { [0.0, 0.0, moment[0]] } else { std::array::from_fn(|c| moment[c]) }
}
