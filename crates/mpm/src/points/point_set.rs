//! The material points of one body, as a structure of arrays.

use std::borrow::Cow;
use std::io::{self, Read, Write};
use std::ops::Range;
use std::sync::Arc;

use colluvium_case::bodies::law_points::LawPoints;
use colluvium_constitutive::{BLOCK_SIZE, Material, States, SymTensor};
use colluvium_grid::{Domains, Grid, PointSlice, SquareMatrix};
use colluvium_points::struct_of_arrays::{invalid_data, read_column, reorder_entries, write_column};
use colluvium_points::{ScratchBuffers, struct_of_arrays};
use rayon::prelude::*;

use crate::points::penalty_state::PenaltyState;
use crate::points::pore_fluid::PoreSet;
use crate::points::right_stretch::right_stretch;
use crate::points::surface_load::SurfaceLoad;

/// Number of points in a chunk of [`par_for_each_chunk`].
pub const CHUNK_POINTS: usize = 256;

/// Calls `visit` for chunks of points and their `values`, in parallel.
pub fn par_for_each_chunk<const D: usize, T: Send>(
    values: &mut [T],
    points: &PointSlice<'_, D>,
    visit: &(dyn Fn(&mut [T], &PointSlice<'_, D>) + Sync),
) {
    values.par_chunks_mut(CHUNK_POINTS).enumerate().for_each(|(number, values)| {
        let first = number * CHUNK_POINTS;
        visit(values, &points.range(first..first + values.len()));
    });
}

struct_of_arrays! {
    /// State of the points, by column.
    pub struct PointColumns<const D: usize> {
        /// Ids, constant during the run.
        pub id: u32,
        /// Positions (m).
        pub position: [f64; D],
        /// Velocities (m/s).
        pub velocity: [f64; D],
        /// Grid velocities at the points in the last step (m/s), for FLIP and XPIC; empty otherwise.
        pub grid_velocity: [f64; D],
        /// Masses (kg).
        pub mass: f64,
        /// Current volumes (m³; m² × 1 m in plane strain, per radian in axisymmetry).
        pub volume: f64,
        /// Initial volumes.
        pub initial_volume: f64,
        /// Cauchy stresses (Pa).
        pub stress: SymTensor as [f64; 6],
        /// Reference positions of displacements (m).
        pub origin: [f64; D],
        /// Sum of the load forces in the step (N); empty for bodies without loads.
        pub traction: [f64; D],
        /// Body forces of the program in the step (N); empty without them.
        pub body_force: [f64; D],
        /// Moment `Σ N v (x_i - x_p)ᵀ` of the velocity (APIC, m²/s) or its gradient (TPIC, 1/s), row `i`, column `j`; empty without an
        /// affine transfer.
        pub affine_velocity: SquareMatrix<D>,
        /// Vector of each point, as temporary memory of the transfer.
        pub scratch: [f64; D],
        /// Displacement gradient for the update of the domains at the end of the step (sheet: mpm P-04). All weights of the step are then
        /// those of its start. Empty unless stress comes before forces and domains stretch.
        pub pending_gradient: SquareMatrix<D>,
        /// Stored energy at the start plus work of the stress since then (J); empty if it is not recorded.
        pub work: f64,
        /// Contact states with obstacles; empty unless obstacles act on points.
        pub obstacle_contact: PenaltyState<D>,
    }
}

/// Points of one body, in the order of the last sort.
pub struct PointSet<const D: usize> {
    /// Index into `Case::bodies`.
    pub body: u32,
    /// Velocity field of the body on the grid: 0 for all bodies that no contact separates.
    pub field: usize,
    /// Index of the rigid body among the driven objects; `None` for a deformable body.
    pub rigid: Option<usize>,
    /// Material law.
    pub material: Arc<dyn Material>,
    /// Initial full width of every point's domain (m).
    pub extent: [f64; D],
    /// The points.
    pub points: PointColumns<D>,
    /// States of the law.
    pub states: States,
    /// Domains of the points.
    pub domain: Domains<D>,
    /// Loads on the points.
    pub loads: Vec<SurfaceLoad<D>>,
    /// Pore fluid; `None` in a case without.
    pub pore: Option<PoreSet<D>>,
    /// Bounds of the slabs within the columns.
    pub slabs: Vec<usize>,
}

/// Smallest volume of a point over its initial volume (pitfall P-09).
pub const MIN_VOLUME_RATIO: f64 = 0.1;

impl<const D: usize> PointSet<D> {
    /// Number of points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Memory of the arrays (bytes).
    pub fn bytes(&self) -> usize {
        let loads = self.loads.iter().map(|load| size_of_val(&load.vectors[..])).sum::<usize>();
        self.points.bytes()
            + self.len() * self.material.state_size()
            + self.domain.bytes()
            + loads
            + self.pore.as_ref().map_or(0, |pore| pore.points.bytes())
            + size_of_val(&self.slabs[..])
    }

    /// Points as input of their material law.
    pub fn law_points(&self) -> LawPoints<'_> {
        LawPoints { material: &*self.material, stress: &self.points.stress, states: &self.states }
    }

    /// Number of points at the least volume.
    pub fn points_at_min_volume(&self) -> usize {
        let smallest = |(volume, initial): &(&f64, &f64)| **volume <= MIN_VOLUME_RATIO * **initial;
        self.points.volume.iter().zip(&self.points.initial_volume).filter(smallest).count()
    }

    /// Grid velocity at a point in the last step (m/s); the point velocity if it is not stored separately.
    pub fn grid_velocity(&self, point: usize) -> [f64; D] {
        let velocity = self.points.grid_velocity.get(point).filter(|_| self.rigid.is_none());
        velocity.copied().unwrap_or(self.points.velocity[point])
    }

    /// View of all points for a transfer.
    #[inline(always)]
    pub fn point_slice(&self) -> PointSlice<'_, D> {
        PointSlice { position: &self.points.position, domain: self.domain.as_slice(), extent: &self.extent }
    }

    /// Ranges of the points of a slab, of at most [`BLOCK`] points each.
    #[inline(always)]
    pub fn blocks_of(&self, slab: usize) -> impl Iterator<Item = Range<usize>> {
        let (start, end) = (self.slabs[slab], self.slabs[slab + 1]);
        (start..end).step_by(BLOCK_SIZE).map(move |first| first..(first + BLOCK_SIZE).min(end))
    }

    /// Positions (m) at which the points evaluate shape functions.
    pub fn evaluation_positions(&self) -> Cow<'_, [[f64; D]]> {
        self.domain.evaluation_positions(&self.points.position)
    }

    /// Sorts the points by cell of `grid`.
    pub fn sort(&mut self, grid: &Grid<D>, spare: &mut ScratchBuffers) {
        let order = colluvium_grid::sort_by_cell(grid, &self.evaluation_positions());
        if order.iter().enumerate().all(|(i, &old)| i == old as usize) {
            return;
        }
        self.reorder(&order, spare);
    }

    /// Adds the points of `other`, of the same body, at the end.
    pub fn append(&mut self, mut other: Self) {
        self.states = self.states.followed_by(&other.states);
        self.domain.append(&mut other.domain);
        if let (Some(pore), Some(other)) = (&mut self.pore, &mut other.pore) {
            pore.points.append(&mut other.points);
        }
        self.points.append(&mut other.points);
    }

    /// Removes the points for whose index in the columns the condition is false.
    pub fn retain_where(
        &mut self,
        keep: impl Fn(&PointColumns<D>, usize) -> bool,
        spare: &mut ScratchBuffers,
    ) {
        let kept = |i: &u32| keep(&self.points, *i as usize);
        let order: Vec<u32> = (0..self.len() as u32).filter(kept).collect();
        if order.len() < self.len() {
            self.reorder(&order, spare);
        }
    }

    /// Sorts the points, so that point `i` was point `order[i]`; points that are not in `order` are removed.
    fn reorder(&mut self, order: &[u32], spare: &mut ScratchBuffers) {
        let all = 0..self.len();
        self.domain.reorder(order);
        for load in &mut self.loads {
            reorder_entries(&mut load.vectors, all.clone(), order, spare);
        }
        if let Some(pore) = &mut self.pore {
            pore.points.reorder(order, spare);
        }
        self.states = self.states.permuted(order);
        self.points.reorder(order, spare);
    }

    /// Writes the state that changes during a run, for a checkpoint.
    ///
    /// # Errors
    /// When `out` fails.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        self.points.write(out)?;
        write_column(&self.material.save(&self.states), |byte| byte, out)?;
        write_column(&self.domain.checkpoint_numbers(), |number| number, out)?;
        for load in &self.loads {
            write_column(&load.vectors, |vector| vector, out)?;
        }
        if let Some(pore) = &self.pore {
            pore.points.write(out)?;
        }
        write_column(&self.slabs, |bound| bound as u64, out)
    }

    /// Reads the output of [`PointSet::write`].
    ///
    /// # Errors
    /// When the bytes end early or belong to another set; the error names the mismatch.
    pub fn read(&mut self, input: &mut dyn Read) -> io::Result<()> {
        let mut points = PointColumns::default();
        points.read(input)?;
        if self.points.work.is_empty() {
            // No longer recorded.
            points.work.clear();
        }
        if !points.uses_columns_of(&self.points) {
            return Err(invalid_data("points have other columns than the case"));
        }
        self.points = points;
        let count = self.len();
        let fits = |name: &str, fits: bool| if fits { Ok(()) } else { Err(invalid_data(name)) };
        let mut states = Vec::new();
        read_column(&mut states, |byte: u8| byte, input)?;
        let states = self.material.load(&states).filter(|states| states.len() == count);
        self.states = states.ok_or_else(|| invalid_data("states of laws do not fit the points"))?;
        let mut numbers = Vec::new();
        read_column(&mut numbers, |number: f64| number, input)?;
        let domains = self.domain.restore(&numbers, count, right_stretch);
        fits("domains do not fit the points", domains.is_some())?;
        for load in &mut self.loads {
            load.read(input)?;
            fits("loads do not fit the points", load.vectors.len() == count)?;
        }
        if let Some(pore) = &mut self.pore {
            pore.points.read(input)?;
            fits("pore fluid does not fit the points", pore.points.len() == count)?;
        }
        read_column(&mut self.slabs, |bound: u64| bound as usize, input)?;
        fits("slabs do not fit the points", self.slabs.last() == Some(&count))
    }
}
