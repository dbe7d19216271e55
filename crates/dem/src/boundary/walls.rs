//! Walls, their contacts with grains, and wall forces (sheet: dem §2.10).

use std::ops::Range;
use std::sync::Arc;

use colluvium_case::{MovingObstacle, ObstacleLaws, spatial};
use colluvium_points::Surface;
use colluvium_points::surface::cross;

use crate::contact::contact_histories::{ContactHistories, ContactHistoriesMut, HistoryColumns};
use crate::contact::{
    CONTACT_APART, ContactEnergies, ContactGeometry, PairLaw, contact_force, release_contact,
};
use crate::force_loop::{
    ContactInput, ForceKernel, PlaneContact, PlaneSums, SimdLaws, Virial, count_contact,
};
use crate::obstacles::facet::{Facet, MAX_FACETS, NO_FACET};
use crate::points::vector::{WIDTH, add, difference, dot, from_tangential, moment, normal_spin};

/// Rigid wall: a plane across an axis, or an obstacle.
#[derive(Clone, Debug)]
pub struct RigidWall<const D: usize> {
    /// Surface of an obstacle at its initial position; `None` for a plane across an axis.
    pub surface: Option<Arc<dyn Surface<D>>>,
    /// Prescribed motion of a moving obstacle.
    pub moving: Option<MovingObstacle<D>>,
    /// Index into the boundaries of the case; obstacles come after them.
    pub boundary: usize,
    /// Name.
    pub name: String,
    /// Axis normal to the plane.
    pub axis: usize,
    /// Whether the wall bounds the grains from above.
    pub upper: bool,
    /// Coordinate of the plane along its axis (m).
    pub position: f64,
    /// Velocity (m/s).
    pub velocity: [f64; D],
    /// Law for each kind of grains; at an obstacle with regions, outside of them.
    pub laws: Vec<PairLaw>,
    /// Regions of an obstacle, which select the law by position.
    pub obstacle_laws: Option<ObstacleLaws>,
    /// Law for each kind in each of the regions.
    pub regions: Vec<Vec<PairLaw>>,
    /// Force on the wall in the last step (N), and impulse since the start (N s).
    pub reaction: [[f64; D]; 2],
    /// Moment of that force about the origin of coordinates (N m), of an obstacle.
    pub moment: [f64; 3],
}

/// Reaction of a wall.
#[derive(Clone, Copy, Debug)]
pub struct WallReaction<const D: usize> {
    /// Force (N).
    pub force: [f64; D],
    /// Moment about the origin of coordinates (N m), of an obstacle.
    pub moment: [f64; 3],
}

impl<const D: usize> WallReaction<D> {
    /// Zero reaction.
    pub const NONE: Self = Self { force: [0.0; D], moment: [0.0; 3] };
}

impl<const D: usize> RigidWall<D> {
    /// Distance of a point from a plane (m), and the normal from the plane towards it.
    #[inline]
    pub fn distance(&self, x: &[f64; D]) -> (f64, [f64; D]) {
        let mut normal = [0.0; D];
        let sign = if self.upper { -1.0 } else { 1.0 };
        normal[self.axis] = sign;
        (sign * (x[self.axis] - self.position), normal)
    }

    /// Surface of an obstacle at its current position; `None` for a plane across an axis.
    pub fn current_surface(&self) -> Option<&dyn Surface<D>> {
        match &self.moving {
            Some(moving) => Some(&moving.placed),
            None => self.surface.as_deref(),
        }
    }

    /// Contact law of the wall for a grain of this kind at `x` (m), at this distance along the normal.
    #[inline]
    pub fn law(&self, kind: usize, x: &[f64; D], (distance, normal): &(f64, [f64; D])) -> &PairLaw {
        let region = self
            .obstacle_laws
            .as_ref()
            .map_or(0, |places| places.region(&contact_position(x, *distance, normal)));
        self.regions.get(region).map_or(&self.laws[kind], |laws| &laws[kind])
    }

    /// Velocity of the wall at `x` (m/s).
    #[inline]
    fn velocity_at(&self, x: &[f64; D]) -> [f64; D] {
        self.moving.as_ref().map_or(self.velocity, |moving| moving.velocity(x))
    }

    /// Whether a point is nearer to the wall than `reach` (m).
    fn is_near(&self, x: &[f64; D], reach: f64) -> bool {
        match self.current_surface() {
            None => self.distance(x).0 < reach,
            Some(surface) => surface.gap(x, reach).is_some(),
        }
    }
}

/// List of grains near walls.
#[derive(Clone, Debug, Default)]
pub struct WallList<const R: usize> {
    /// Grain of each entry, ascending.
    pub grain: Vec<u32>,
    /// Wall of each entry.
    pub wall: Vec<u32>,
    /// First entry of each slab, and the number of entries.
    pub slabs: Vec<u32>,
    /// Contact histories.
    pub memory: ContactHistories<R>,
    /// Facet key of each entry at an obstacle, which has several entries in a row; empty without obstacles.
    pub key: Vec<u64>,
    /// Distance and normal of the facet of each entry at an obstacle.
    pub facet: Vec<Facet>,
    kept: Vec<(u32, u32, u64)>,
    /// Normals of the contacts whose histories are stored.
    normals: Vec<Facet>,
    carried: ContactHistories<R>,
}

impl<const R: usize> WallList<R> {
    /// Stores the contact histories by the ids of their grains, before grains are sorted.
    pub fn store_histories(&mut self, ids: &[u32], columns: HistoryColumns) {
        self.kept.clear();
        self.normals.clear();
        self.carried.clear(0, columns);
        for k in 0..self.grain.len() {
            if self.memory.is_kept(k) {
                let key = self.key.get(k).copied().unwrap_or(NO_FACET);
                self.kept.push((ids[self.grain[k] as usize], self.wall[k], key));
                self.normals.extend(self.facet.get(k));
                self.carried.push(&self.memory, k);
            }
        }
    }

    /// Removes the entries of removed grains and walls, whose new number is `u32::MAX`; the list must be rebuilt afterwards.
    pub fn remove(&mut self, grains: &[u32], walls: &[u32], columns: HistoryColumns) {
        let mut left = Self::default();
        left.memory.clear(0, columns);
        for k in 0..self.grain.len() {
            let (grain, wall) = (grains[self.grain[k] as usize], walls[self.wall[k] as usize]);
            if grain != u32::MAX && wall != u32::MAX {
                left.grain.push(grain);
                left.wall.push(wall);
                left.key.extend(self.key.get(k));
                left.facet.extend(self.facet.get(k));
                left.memory.push(&self.memory, k);
            }
        }
        *self = left;
    }

    /// Builds the list of grains within `gap` (m) of walls, slab by slab.
    pub fn build<const D: usize>(
        &mut self,
        scene: &ContactInput<'_, D, R>,
        ids: &[u32],
        walls: &[RigidWall<D>],
        gap: f64,
        slabs: &[u32],
        columns: HistoryColumns,
    ) {
        self.grain.clear();
        self.wall.clear();
        self.slabs.clear();
        for ends in slabs.windows(2) {
            self.slabs.push(self.grain.len() as u32);
            for i in ends[0] as usize..ends[1] as usize {
                for (number, wall) in walls.iter().enumerate() {
                    if scene.held[i] || !wall.is_near(&scene.position[i], scene.radius[i] + gap) {
                        continue;
                    }
                    for _ in 0..if wall.surface.is_some() { MAX_FACETS } else { 1 } {
                        self.grain.push(i as u32);
                        self.wall.push(number as u32);
                    }
                }
            }
        }
        self.slabs.push(self.grain.len() as u32);
        self.memory.clear(self.grain.len(), columns);
        let facetted = walls.iter().any(|wall| wall.surface.is_some());
        let entries = if facetted { self.grain.len() } else { 0 };
        self.key.clear();
        self.key.resize(entries, NO_FACET);
        self.facet.clear();
        self.facet.resize(entries, Facet::NONE);
        if self.kept.is_empty() {
            return;
        }
        let mut order: Vec<usize> = (0..self.kept.len()).collect();
        order.sort_unstable_by_key(|&entry| self.kept[entry]);
        let mut slot = 0;
        for k in 0..self.grain.len() {
            let (id, wall) = (ids[self.grain[k] as usize], self.wall[k]);
            // The slots of a grain at an obstacle receive its stored contacts one after another.
            let again = k > 0 && self.grain[k - 1] == self.grain[k] && self.wall[k - 1] == wall;
            slot = if again { slot + 1 } else { 0 };
            let first = order.partition_point(|&entry| (self.kept[entry].0, self.kept[entry].1) < (id, wall));
            let Some(&entry) = order.get(first + slot) else { continue };
            if (self.kept[entry].0, self.kept[entry].1) == (id, wall) {
                self.memory.take(k, &self.carried, entry, false);
                if let (Some(key), Some(facet)) = (self.key.get_mut(k), self.facet.get_mut(k)) {
                    *key = self.kept[entry].2;
                    self.normals.get(entry).inspect(|known| *facet = **known);
                }
            }
        }
    }
}

/// Accumulators of wall contact forces, slab by slab.
struct WallForceAccumulators<'a, const D: usize, const R: usize> {
    first: usize,
    force: &'a mut [[f64; D]],
    torque: &'a mut [[f64; R]],
    entry: usize,
    memory: ContactHistoriesMut<'a, R>,
    slab: usize,
    tallies: &'a mut [(ContactEnergies, Virial<D>)],
    /// Forces on the walls, ordered by slab and then by wall.
    reactions: &'a mut [WallReaction<D>],
}

impl<'a, const D: usize, const R: usize> WallForceAccumulators<'a, D, R> {
    fn split_at(self, grain: usize, entry: usize, slab: usize, walls: usize) -> (Self, Self) {
        let (force, more_force) = self.force.split_at_mut(grain - self.first);
        let (torque, more_torque) = self.torque.split_at_mut(grain - self.first);
        let (memory, more_memory) = self.memory.split_at(entry - self.entry);
        let (tallies, more_tallies) = self.tallies.split_at_mut(slab - self.slab);
        let (reactions, more_reactions) = self.reactions.split_at_mut((slab - self.slab) * walls);
        (
            Self { force, torque, memory, tallies, reactions, ..self },
            Self {
                first: grain,
                force: more_force,
                torque: more_torque,
                entry,
                memory: more_memory,
                slab,
                tallies: more_tallies,
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
        let (mut touch, arm) = ContactGeometry::with_wall(
            (&self.contact_body(i), self.mass[i]),
            (distance, &normal),
            &of_wall,
            self.radii,
        );
        if let Some(moving) = &wall.moving {
            touch.relative_spin = difference(&self.spin[i], &moving.angular_velocity());
            touch.spin += 0.5 * normal_spin(&moving.angular_velocity::<R>(), &normal);
        }
        (touch, arm)
    }

    /// Adds the forces of all walls; `reactions` are those on each wall, slab after slab.
    pub fn wall_forces(
        &self,
        walls: &[RigidWall<D>],
        list: (&WallListView<'_>, &[u32]),
        memory: ContactHistoriesMut<'_, R>,
        (force, torque): (&mut [[f64; D]], &mut [[f64; R]]),
        tallies: &mut [(ContactEnergies, Virial<D>)],
        reactions: &mut [WallReaction<D>],
    ) {
        let slabs = list.1.len() - 1;
        let shares =
            WallForceAccumulators { first: 0, force, torque, entry: 0, memory, slab: 0, tallies, reactions };
        self.wall_slabs(walls, list, 0..slabs, shares);
    }

    fn wall_slabs(
        &self,
        walls: &[RigidWall<D>],
        list: (&WallListView<'_>, &[u32]),
        slabs: Range<usize>,
        mut shares: WallForceAccumulators<'_, D, R>,
    ) {
        if slabs.len() > 1 {
            let middle = slabs.start + slabs.len() / 2;
            let entry = list.0.slabs[middle] as usize;
            let (left, right) = shares.split_at(list.1[middle] as usize, entry, middle, walls.len());
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
                    self.wall_contact(walls, list.0, k, slab, &mut shares);
                }
            }
            ForceKernel::SimdLinear(false) => {
                self.simd_wall_forces::<false, false>(walls, list.0, slab, &mut shares);
            }
            ForceKernel::SimdLinear(true) => {
                self.simd_wall_forces::<false, true>(walls, list.0, slab, &mut shares);
            }
            ForceKernel::SimdHertz(false) => {
                self.simd_wall_forces::<true, false>(walls, list.0, slab, &mut shares);
            }
            ForceKernel::SimdHertz(true) => {
                self.simd_wall_forces::<true, true>(walls, list.0, slab, &mut shares);
            }
        }
    }

    /// Adds the forces of the walls on the grains of a slab: plane contacts four at a time, other contacts between them in list order.
    fn simd_wall_forces<const HERTZ: bool, const TURNS: bool>(
        &self,
        walls: &[RigidWall<D>],
        list: &WallListView<'_>,
        slab: usize,
        shares: &mut WallForceAccumulators<'_, D, R>,
    ) {
        let mut laws = walls.iter().flat_map(|wall| &wall.laws);
        let first = laws.next();
        let common =
            first.filter(|first| laws.all(|law| law == *first)).map(|law| SimdLaws::of([law; WIDTH]));
        let (mut waiting, mut count, mut sums) = ([0; WIDTH], 0, PlaneSums::default());
        for k in list.slabs[slab] as usize..list.slabs[slab + 1] as usize {
            let (i, wall) = (list.grain[k] as usize, &walls[list.wall[k] as usize]);
            let plane = wall.surface.is_none();
            if plane && wall.distance(&self.position[i]).0 < self.radius[i] {
                waiting[count] = k;
                count += 1;
                if count == WIDTH {
                    let of = (slab, common.as_ref());
                    self.planes::<HERTZ, TURNS>(walls, list, &waiting, of, (&mut *shares, &mut sums));
                    count = 0;
                }
            } else if !plane || shares.memory.state[k - shares.entry] != CONTACT_APART {
                waiting[..count].iter().for_each(|&k| self.wall_contact(walls, list, k, slab, shares));
                count = 0;
                self.wall_contact(walls, list, k, slab, shares);
            }
        }
        waiting[..count].iter().for_each(|&k| self.wall_contact(walls, list, k, slab, shares));
        shares.tallies[slab - shares.slab].0.add(&sums.tally(self.dt));
    }

    /// Adds the forces of planes on four grains in contact with them.
    fn planes<const HERTZ: bool, const TURNS: bool>(
        &self,
        walls: &[RigidWall<D>],
        list: &WallListView<'_>,
        entries: &[usize; WIDTH],
        (slab, common): (usize, Option<&SimdLaws>),
        (shares, sums): (&mut WallForceAccumulators<'_, D, R>, &mut PlaneSums<D>),
    ) {
        let four = entries.map(|k| {
            let (i, wall) = (list.grain[k] as usize, &walls[list.wall[k] as usize]);
            let law = &wall.laws[self.kind[i] as usize];
            let seen = wall.distance(&self.position[i]);
            PlaneContact { grain: i, slot: k - shares.entry, seen, velocity: wall.velocity, law }
        });
        let forces = self.plane_forces::<HERTZ, TURNS>(&four, common, shares.memory.reborrow(), sums);
        for ((own, k), (on, moments)) in four.iter().zip(entries).zip(&forces) {
            let at = own.grain - shares.first;
            add(&mut shares.force[at], 1.0, on);
            moments.iter().for_each(|moment| add(&mut shares.torque[at], 1.0, moment));
            let wall = (slab - shares.slab) * walls.len() + list.wall[*k] as usize;
            add(&mut shares.reactions[wall].force, -1.0, on);
        }
    }

    fn wall_contact(
        &self,
        walls: &[RigidWall<D>],
        list: &WallListView<'_>,
        k: usize,
        slab: usize,
        shares: &mut WallForceAccumulators<'_, D, R>,
    ) {
        let (i, number) = (list.grain[k] as usize, list.wall[k] as usize);
        let wall = &walls[number];
        let slot = k - shares.entry;
        let state = shares.memory.state[slot];
        let seen = match &wall.surface {
            None => wall.distance(&self.position[i]),
            Some(_) => list.facet[k].distance_and_normal(),
        };
        if seen.0 - self.radius[i] >= 0.0 && state == CONTACT_APART {
            return;
        }
        let (touch, arm) = self.wall_contact_geometry(i, wall, seen);
        let law = wall.law(self.kind[i] as usize, &self.position[i], &seen);
        let tally = &mut shares.tallies[slab - shares.slab].0;
        let mut memory = shares.memory.get(slot);
        if touch.overlap > 0.0 || touch.overlap > -law.rupture_distance(state, touch.radius) {
            let push = contact_force(law, &touch, &mut memory, &self.steps(), tally);
            let mut on = from_tangential(&push.tangential, &touch.normal);
            add(&mut on, push.normal, &touch.normal);
            let at = i - shares.first;
            add(&mut shares.force[at], 1.0, &on);
            add(&mut shares.torque[at], -arm, &moment(&touch.normal, &push.tangential));
            add(&mut shares.torque[at], 1.0, &push.moment);
            let borne = &mut shares.reactions[(slab - shares.slab) * walls.len() + number];
            add(&mut borne.force, -1.0, &on);
            // The work of planes follows from their total force; their moment is not reported.
            if wall.surface.is_some() {
                let at = contact_position(&self.position[i], arm, &touch.normal);
                let (turn, own) = (cross(&spatial(&at), &spatial(&on)), moment_in_space(&push.moment));
                (0..3).for_each(|c| borne.moment[c] -= turn[c] + own[c]);
                if let Some(moving) = &wall.moving {
                    tally.boundary += (dot(&on, &moving.velocity(&at))
                        + dot(&push.moment, &moving.angular_velocity()))
                        * self.dt;
                }
            }
            count_contact(tally, &touch, &on, i);
        } else {
            release_contact(law, &touch, &mut memory, self.dt, tally);
        }
        shares.memory.set(slot, &memory);
    }
}

/// Moment as a spatial vector (N m); in the plane along the out-of-plane axis.
fn moment_in_space<const R: usize>(moment: &[f64; R]) -> [f64; 3] {
    if R == 1 { [0.0, 0.0, moment[0]] } else { std::array::from_fn(|c| moment[c]) }
}

/// Contact point on a wall with this normal, at a lever arm (m) from a grain at `x` (m).
#[inline]
fn contact_position<const D: usize>(x: &[f64; D], arm: f64, normal: &[f64; D]) -> [f64; D] {
    std::array::from_fn(|c| x[c] - arm * normal[c])
}

/// View of a wall list, without the contact histories.
#[derive(Clone, Copy)]
pub struct WallListView<'a> {
    /// Grain of each entry, ascending.
    pub grain: &'a [u32],
    /// Wall of each entry.
    pub wall: &'a [u32],
    /// First entry of each slab, and the number of entries.
    pub slabs: &'a [u32],
    /// Distances and normals of the facets of entries at obstacles.
    pub facet: &'a [Facet],
}
