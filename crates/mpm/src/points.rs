//! The material points of one body, as a structure of arrays.

use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;

use colluvium_case::law::LawPoints;
use colluvium_constitutive::{BLOCK, Material, States, SymTensor};
use colluvium_grid::{Domains, Grid, Points};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::pore::{PoreSet, SavedPore};
use crate::pressed::{self, Pressed};
use crate::stretch::right_stretch;
use crate::surface_load::SurfaceLoad;

/// Points handled at once by [`in_chunks`].
pub const CHUNK: usize = 256;

/// Calls `visit` for chunks of points with what `values` has for them, in parallel.
pub fn in_chunks<const D: usize, T: Send>(
    values: &mut [T],
    points: &Points<'_, D>,
    visit: &(dyn Fn(&mut [T], &Points<'_, D>) + Sync),
) {
    values.par_chunks_mut(CHUNK).enumerate().for_each(|(number, values)| {
        let first = number * CHUNK;
        visit(values, &points.range(first..first + values.len()));
    });
}

/// All points of one body. Every array has one entry per point, in the order of the last sort.
pub struct PointSet<const D: usize> {
    /// Index into `Case::bodies`.
    pub body: u32,
    /// Velocity field of the grid that the body has: 0 for all bodies that no contact separates.
    pub field: usize,
    /// Number of the rigid body among what is driven; `None` for a body that deforms.
    pub rigid: Option<usize>,
    /// The law.
    pub material: Arc<dyn Material>,
    /// Initial full width of every point's domain (m).
    pub extent: [f64; D],
    /// Ids, the same for life.
    pub id: Vec<u32>,
    /// Positions (m).
    pub position: Vec<[f64; D]>,
    /// Velocities (m/s).
    pub velocity: Vec<[f64; D]>,
    /// Masses (kg).
    pub mass: Vec<f64>,
    /// Current volumes (m³; m² × 1 m in plane strain, per radian in axisymmetry).
    pub volume: Vec<f64>,
    /// Initial volumes.
    pub initial_volume: Vec<f64>,
    /// Cauchy stresses (Pa).
    pub stress: Vec<SymTensor>,
    /// States of the law.
    pub states: States,
    /// Positions from which displacement is counted (m).
    pub origin: Vec<[f64; D]>,
    /// What the points know of their domains.
    pub domain: Domains<D>,
    /// Loads on the points.
    pub loads: Vec<SurfaceLoad<D>>,
    /// Sum of their forces in this step (N); empty where the body carries none.
    pub traction: Vec<[f64; D]>,
    /// For the affine transfers, empty otherwise: moment `Σ N v (x_i - x_p)ᵀ` of the velocity (APIC, m²/s) or its
    /// gradient (TPIC, 1/s); row `i`, column `j`.
    pub affine: Vec<[[f64; D]; D]>,
    /// Room for a vector a point, where the transfer needs one.
    pub scratch: Vec<[f64; D]>,
    /// Where stress comes before forces and domains stretch: the displacement gradient that the domains follow when
    /// the step is over, so that all its weights are those of its beginning (sheet: mpm P-04); empty otherwise.
    pub pending: Vec<[[f64; D]; D]>,
    /// Energy stored at the start and work of the stress since (J); empty where nothing measures it.
    pub work: Vec<f64>,
    /// What they know of obstacles that act on points; empty without any.
    pub pressed: Vec<Pressed<D>>,
    /// What pore fluid adds; `None` in a case without.
    pub pore: Option<PoreSet<D>>,
    /// Bounds of the slabs within the arrays.
    pub slabs: Vec<usize>,
}

/// The least volume of a point over its initial one (pitfall P-09).
pub const LEAST_VOLUME: f64 = 0.1;

impl<const D: usize> PointSet<D> {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.id.len()
    }

    /// Memory of the arrays (bytes).
    pub fn bytes(&self) -> usize {
        let loads = self.loads.iter().map(|load| size_of_val(&load.force[..])).sum::<usize>();
        let states = self.len() * self.material.state_size();
        let ids = size_of_val(&self.id[..]) + size_of_val(&self.slabs[..]);
        let vectors = [&self.position, &self.velocity, &self.origin, &self.traction, &self.scratch];
        let scalars = [&self.mass, &self.volume, &self.initial_volume, &self.work];
        let matrices =
            size_of_val(&self.pressed[..]) + size_of_val(&self.affine[..]) + size_of_val(&self.pending[..]);
        ids + vectors.iter().map(|v| size_of_val(&v[..])).sum::<usize>()
            + scalars.iter().map(|v| size_of_val(&v[..])).sum::<usize>()
            + matrices
            + loads
            + states
            + self.pore.as_ref().map_or(0, PoreSet::bytes)
            + size_of_val(&self.stress[..])
            + self.domain.bytes()
    }

    /// The points as their law sees them.
    pub fn law_points(&self) -> LawPoints<'_> {
        LawPoints { material: &*self.material, stress: &self.stress, states: &self.states }
    }

    /// How many points have the least volume.
    pub fn crushed(&self) -> usize {
        let least = |(volume, initial): &(&f64, &f64)| **volume <= LEAST_VOLUME * **initial;
        self.volume.iter().zip(&self.initial_volume).filter(least).count()
    }

    /// All points, for a sweep.
    #[inline(always)]
    pub fn points(&self) -> Points<'_, D> {
        Points { position: &self.position, domain: self.domain.as_slice(), extent: &self.extent }
    }

    /// The points of a slab in blocks of [`BLOCK`] or fewer, by their numbers.
    #[inline(always)]
    pub fn blocks_of(&self, slab: usize) -> impl Iterator<Item = Range<usize>> {
        let (start, end) = (self.slabs[slab], self.slabs[slab + 1]);
        (start..end).step_by(BLOCK).map(move |first| first..(first + BLOCK).min(end))
    }

    /// Where the points look at the grid from (m).
    pub fn anchors(&self) -> Cow<'_, [[f64; D]]> {
        self.domain.anchors(&self.position)
    }

    /// Sorts the points by cell of `grid`.
    pub fn sort(&mut self, grid: &Grid<D>) {
        let order = colluvium_grid::sort_by_cell(grid, &self.anchors());
        if order.iter().enumerate().all(|(i, &old)| i == old as usize) {
            return;
        }
        self.reorder(&order);
    }

    /// Keeps the points of which `keep` approves, by their place.
    pub fn retain(&mut self, keep: impl Fn(&[f64; D]) -> bool) {
        let order: Vec<u32> = (0..self.len() as u32).filter(|&i| keep(&self.position[i as usize])).collect();
        if order.len() < self.len() {
            self.reorder(&order);
        }
    }

    /// Point `i` becomes what point `order[i]` was; points that `order` does not name vanish.
    fn reorder(&mut self, order: &[u32]) {
        fn permute<T: Copy>(values: &mut Vec<T>, order: &[u32]) {
            if !values.is_empty() {
                *values = order.iter().map(|&i| values[i as usize]).collect();
            }
        }
        permute(&mut self.id, order);
        permute(&mut self.position, order);
        permute(&mut self.velocity, order);
        permute(&mut self.mass, order);
        permute(&mut self.volume, order);
        permute(&mut self.initial_volume, order);
        permute(&mut self.stress, order);
        permute(&mut self.origin, order);
        self.domain.reorder(order);
        permute(&mut self.traction, order);
        self.loads.iter_mut().for_each(|load| load.permute(order));
        permute(&mut self.affine, order);
        permute(&mut self.scratch, order);
        permute(&mut self.pending, order);
        permute(&mut self.work, order);
        permute(&mut self.pressed, order);
        if let Some(pore) = &mut self.pore {
            pore.permute(order);
        }
        self.states = self.states.permuted(order);
    }

    /// Everything that changes, for a checkpoint.
    pub fn save(&self) -> SavedSet {
        SavedSet {
            body: self.body,
            id: self.id.clone(),
            position: self.position.as_flattened().to_vec(),
            velocity: self.velocity.as_flattened().to_vec(),
            mass: self.mass.clone(),
            volume: self.volume.clone(),
            initial_volume: self.initial_volume.clone(),
            stress: self.stress.clone(),
            states: self.material.save(&self.states),
            origin: self.origin.as_flattened().to_vec(),
            domain: self.domain.numbers(),
            loads: self.loads.iter().map(|load| load.force.as_flattened().to_vec()).collect(),
            affine: self.affine.as_flattened().as_flattened().to_vec(),
            work: self.work.clone(),
            pressed: pressed::saved(&self.pressed),
            pore: self.pore.as_ref().map(PoreSet::save),
            slabs: self.slabs.clone(),
        }
    }

    /// Takes the arrays of [`PointSet::save`]; `None` where they do not fit together.
    pub fn restore(&mut self, saved: SavedSet) -> Option<()> {
        let n = saved.id.len();
        let scalars = [&saved.mass, &saved.volume, &saved.initial_volume];
        let vectors = [&saved.position, &saved.velocity, &saved.origin];
        let fits = scalars.iter().all(|a| a.len() == n)
            && vectors.iter().all(|a| a.len() == n * D)
            && saved.stress.len() == n
            && saved.loads.len() == self.loads.len()
            && saved.loads.iter().all(|force| force.len() == n * D)
            && saved.affine.len() == if self.affine.is_empty() { 0 } else { n * D * D }
            && (self.work.is_empty() || saved.work.len() == n)
            && saved.slabs.last() == Some(&n);
        let states = self.material.load(&saved.states)?;
        if !fits || states.len() != n {
            return None;
        }
        match (&mut self.pore, saved.pore) {
            (Some(pore), Some(saved)) => pore.restore(saved, n)?,
            (None, None) => {}
            _ => return None,
        }
        let vectors = |flat: &[f64]| -> Vec<[f64; D]> { flat.as_chunks().0.to_vec() };
        self.id = saved.id;
        self.position = vectors(&saved.position);
        self.velocity = vectors(&saved.velocity);
        self.mass = saved.mass;
        self.volume = saved.volume;
        self.initial_volume = saved.initial_volume;
        self.stress = saved.stress;
        self.states = states;
        self.origin = vectors(&saved.origin);
        self.domain.restore(&saved.domain, n, right_stretch)?;
        for (load, force) in self.loads.iter_mut().zip(&saved.loads) {
            load.restore(vectors(force));
        }
        // Points may have been removed since the start.
        self.traction.truncate(n);
        self.scratch.truncate(n);
        self.pending.truncate(n);
        self.affine.truncate(n);
        self.affine.as_flattened_mut().as_flattened_mut().copy_from_slice(&saved.affine);
        if !self.work.is_empty() {
            self.work = saved.work;
        }
        pressed::restore(&mut self.pressed, &saved.pressed, n)?;
        self.slabs = saved.slabs;
        Some(())
    }
}

/// The arrays of a [`PointSet`] in a checkpoint.
#[derive(Serialize, Deserialize)]
pub struct SavedSet {
    pub(crate) body: u32,
    id: Vec<u32>,
    position: Vec<f64>,
    velocity: Vec<f64>,
    mass: Vec<f64>,
    volume: Vec<f64>,
    initial_volume: Vec<f64>,
    stress: Vec<SymTensor>,
    states: Vec<u8>,
    origin: Vec<f64>,
    domain: Vec<f64>,
    loads: Vec<Vec<f64>>,
    affine: Vec<f64>,
    work: Vec<f64>,
    pressed: Vec<f64>,
    pore: Option<SavedPore>,
    slabs: Vec<usize>,
}
