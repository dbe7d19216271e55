//! Points of the bodies, as structures of arrays.

use colluvium_case::FailureReason;
use std::ops::Range;
use std::sync::Arc;

use colluvium_case::bodies::law_points::LawPoints;
use colluvium_constitutive::{BLOCK_SIZE, Material, States, SymTensor};
use colluvium_grid::{
    DomainSlice, FixedDomain, PointSlice as Places, SquareMatrix, Vector4, sort_by_cell, wrap_into_period,
};
use colluvium_points::{ScratchBuffers, struct_of_arrays};

use crate::background_grid::BackgroundGrid;
use crate::points::step_bound::StepBound;

struct_of_arrays! {
    /// State of the points of a body, one column per variable.
    pub struct PointColumns<const D: usize> {
        /// Ids, constant over the run.
        pub id: u32,
        /// Positions (m).
        pub position: [f64; D],
        /// Reference positions of the displacement (m).
        pub origin: [f64; D],
        /// Velocities (m/s).
        pub velocity: [f64; D],
        /// Moments `Σ N v (x_i - x_p)ᵀ` of the velocity field around the point (m²/s), row `i`, column `j`; zero with FLIP.
        pub affine_velocity: SquareMatrix<D>,
        /// Masses (kg).
        pub mass: f64,
        /// Current volumes (m³; m² × 1 m in the plane).
        pub volume: f64,
        /// Cauchy stresses (Pa).
        pub stress: SymTensor as [f64; 6],
        /// Stored energy at the start plus work of the stress since then (J).
        pub work: f64,
        /// Accelerations by the body force of the program (m/s²); empty without.
        pub body_force: [f64; D],
    }
}

/// Points of a body, with their material law.
pub struct BodyPoints<const D: usize> {
    /// Index into `Case::bodies`.
    pub number: u32,
    /// Material law.
    pub material: Arc<dyn Material>,
    /// States of the law.
    pub states: States,
    /// Width of a point (m).
    pub width: f64,
    /// Whether points that leave the domain are removed.
    pub remove_outside: bool,
    /// Points, in the order of the last sort.
    pub points: PointColumns<D>,
    /// Bounds of the grid slabs within the columns.
    pub slabs: Vec<usize>,
    /// Step bound or failure of each group of points in the last update.
    pub(crate) reports: Vec<Result<StepBound, PointFailure>>,
}

/// Failure of a point, with the reason.
#[derive(Clone, Debug)]
pub struct PointFailure {
    /// Index of the point within its body.
    pub index: usize,
    /// Reason of the failure.
    pub reason: FailureReason,
}

/// Domains of points with spline functions, which have no width.
static FIXED_DOMAINS: [FixedDomain; BLOCK_SIZE] = [FixedDomain; BLOCK_SIZE];

/// View of points for a transfer.
#[inline(always)]
pub fn point_slice<'a, const D: usize>(position: &'a [[f64; D]], extent: &'a [f64; D]) -> Places<'a, D> {
    Places { position, domain: DomainSlice::Fixed(&FIXED_DOMAINS[..position.len()]), extent }
}

impl<const D: usize> BodyPoints<D> {
    /// Index ranges of the points of a slab, of at most [`BLOCK_SIZE`] points each.
    #[inline(always)]
    pub fn blocks_of(&self, slab: usize) -> impl Iterator<Item = Range<usize>> {
        let (start, end) = (self.slabs[slab], self.slabs[slab + 1]);
        (start..end).step_by(BLOCK_SIZE).map(move |first| first..(first + BLOCK_SIZE).min(end))
    }

    /// Stresses and states of the points, with their law.
    pub fn law_points(&self) -> LawPoints<'_> {
        LawPoints { material: &*self.material, stress: &self.points.stress, states: &self.states }
    }

    /// Recoverable energies of the points (J), zero where the law defines none.
    pub fn stored_energies(&self) -> Vec<f64> {
        let mut energies = self.law_points().stored_energies();
        energies.iter_mut().zip(&self.points.volume).for_each(|(energy, volume)| *energy *= volume);
        energies
    }

    /// Kinetic energies of the points (J): that of the point velocities, and that of the affine velocity fields around them. `moment` is
    /// the second moment of the shape functions (m²).
    pub fn kinetic_energies(&self, moment: f64) -> [f64; 2] {
        let PointColumns { velocity, affine_velocity, mass, .. } = &self.points;
        let mut sums = [0.0; 2];
        for ((velocity, affine_velocity), mass) in velocity.iter().zip(affine_velocity).zip(mass) {
            sums[0] += 0.5 * mass * crate::points::vectors::square(velocity);
            // Sheet: snow-mpm §2.11.
            sums[1] +=
                0.5 * mass * affine_velocity.as_flattened().iter().map(|b| b * b).sum::<f64>() / moment;
        }
        sums
    }

    /// Memory of the points (bytes), that for sorting included.
    pub fn bytes(&self) -> usize {
        let state = self.material.state_size();
        self.points.bytes() + self.points.len() * (2 * state + 16 + size_of::<SquareMatrix<D>>())
    }

    /// Adds the points of `other`, of the same body, at the end. They are sorted afterwards.
    pub fn append(&mut self, mut other: Self) {
        self.states = self.states.followed_by(&other.states);
        self.points.append(&mut other.points);
    }

    /// Moves point `order[i]` to index `i`; points that `order` does not contain are removed.
    fn reorder(&mut self, order: &[u32], spare: &mut ScratchBuffers) {
        self.points.reorder(order, spare);
        self.states = self.states.permuted(order);
    }
}

/// Points of all bodies.
#[derive(Default)]
pub struct Bodies<const D: usize> {
    /// Bodies with points.
    pub bodies: Vec<BodyPoints<D>>,
    /// Sum over the steps since the last sort of the largest displacement along an axis (m).
    pub travel_since_sort: f64,
    /// Mean mass of a point (kg).
    pub mean_mass: f64,
    /// Number of the next point that is added.
    pub next_id: u32,
    scratch: ScratchBuffers,
}

impl<const D: usize> Bodies<D> {
    /// Creates the set of bodies.
    pub fn new(bodies: Vec<BodyPoints<D>>) -> Self {
        let count: usize = bodies.iter().map(|body| body.points.len()).sum();
        Self { bodies, next_id: count as u32, ..Self::default() }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.bodies.iter().map(|body| body.points.len()).sum()
    }

    /// Sorts the points by cell and finds the active nodes. The nodes must be empty.
    pub fn sort(&mut self, background: &mut BackgroundGrid<D>) {
        for body in &mut self.bodies {
            let order = sort_by_cell(&background.grid, &body.points.position);
            if order.iter().enumerate().any(|(i, &old)| i != old as usize) {
                body.reorder(&order, &mut self.scratch);
            }
        }
        self.travel_since_sort = 0.0;
        self.find_active_nodes(background);
    }

    /// Finds the active nodes and the bounds of slabs from the sorted points.
    pub fn find_active_nodes(&mut self, background: &mut BackgroundGrid<D>) {
        background.layout.clear();
        let (mut mass, mut count) = (0.0, 0);
        for body in &mut self.bodies {
            body.slabs = background.layout.add_points(&body.points.position);
            body.reports.resize(body.points.len().div_ceil(BLOCK_SIZE), Ok(StepBound::UNBOUNDED));
            mass += body.points.mass.iter().sum::<f64>();
            count += body.points.len();
        }
        self.mean_mass = if count > 0 { mass / count as f64 } else { 0.0 };
    }

    /// Moves points that have left through a periodic boundary to the opposite one.
    pub fn wrap_into_period(&mut self, background: &BackgroundGrid<D>) {
        let BackgroundGrid { low, upper_corner, periodic, .. } = background;
        if *periodic == [false; D] {
            return;
        }
        for body in &mut self.bodies {
            let PointColumns { position, origin, .. } = &mut body.points;
            if wrap_into_period([low, upper_corner], periodic, position, origin) {
                // The points are in other slabs now.
                self.travel_since_sort = f64::INFINITY;
            }
        }
    }

    /// Removes the points for whose body and index the condition is false, and bodies without points. Returns whether any was removed.
    pub fn retain(&mut self, keep: impl Fn(&BodyPoints<D>, usize) -> bool) -> bool {
        let before = self.len();
        for body in &mut self.bodies {
            let order: Vec<u32> = (0..body.points.len() as u32).filter(|&i| keep(body, i as usize)).collect();
            if order.len() < body.points.len() {
                body.reorder(&order, &mut self.scratch);
            }
        }
        self.bodies.retain(|body| !body.points.is_empty());
        self.len() < before
    }
}

/// Columns `columns[j] = -V σ e_j` (J) of the internal force.
#[inline(always)]
pub fn stress_columns<const D: usize>(stress: &SymTensor, volume: f64) -> [Vector4; D] {
    let mut columns = [Vector4::ZERO; D];
    for j in 0..D {
        let mut column = [0.0; 4];
        for i in 0..D {
            column[i] = -volume * stress.component(i, j);
        }
        columns[j] = Vector4::new(column);
    }
    columns
}
