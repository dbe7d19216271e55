//! The points of the bodies, as structures of arrays.

use std::ops::Range;
use std::sync::Arc;

use colluvium_case::law::LawPoints;
use colluvium_constitutive::{BLOCK, Material, States, SymTensor};
use colluvium_grid::{DomainSlice, FixedDomain, Lanes, Points as Places, Square, sort_by_cell, wrap};
use colluvium_points::{Spare, columns};

use crate::background::Background;
use crate::pace::Pace;

columns! {
    /// What a point is.
    pub struct Columns<const D: usize> {
        /// Ids, the same for life.
        pub id: u32,
        /// Positions (m).
        pub position: [f64; D],
        /// Positions from which displacement is counted (m).
        pub origin: [f64; D],
        /// Velocities (m/s).
        pub velocity: [f64; D],
        /// Moments `Σ N v (x_i - x_p)ᵀ` of the velocity field around the point (m²/s), row `i`, column `j`; zero with FLIP.
        pub affine: Square<D>,
        /// Masses (kg).
        pub mass: f64,
        /// Current volumes (m³; m² × 1 m in the plane).
        pub volume: f64,
        /// Cauchy stresses (Pa).
        pub stress: SymTensor as [f64; 6],
        /// Energy stored at the start and work of the stress since (J).
        pub work: f64,
    }
}

/// The points of a body, with its law.
pub struct Body<const D: usize> {
    /// Index into `Case::bodies`.
    pub number: u32,
    /// The law.
    pub material: Arc<dyn Material>,
    /// States of the law.
    pub states: States,
    /// Width of a point (m).
    pub width: f64,
    /// Whether points that leave the domain are taken away.
    pub drop_outside: bool,
    /// The points, in the order of the last sort.
    pub points: Columns<D>,
    /// Bounds of the slabs of the grid within the columns.
    pub slabs: Vec<usize>,
    /// What each block of points reports of the last update.
    pub(crate) reports: Vec<Result<Pace, Failure>>,
}

/// A point that failed.
#[derive(Clone, Debug)]
pub struct Failure {
    /// Index within its body.
    pub index: usize,
    /// Why.
    pub reason: String,
}

/// Domains of points of splines: nothing.
static FIXED: [FixedDomain; BLOCK] = [FixedDomain; BLOCK];

/// A block of points at `position`, for a sweep.
#[inline(always)]
pub fn places<'a, const D: usize>(position: &'a [[f64; D]], extent: &'a [f64; D]) -> Places<'a, D> {
    Places { position, domain: DomainSlice::Fixed(&FIXED[..position.len()]), extent }
}

impl<const D: usize> Body<D> {
    /// The points of a slab in blocks of [`BLOCK`] or fewer, by their numbers.
    #[inline(always)]
    pub fn blocks_of(&self, slab: usize) -> impl Iterator<Item = Range<usize>> {
        let (start, end) = (self.slabs[slab], self.slabs[slab + 1]);
        (start..end).step_by(BLOCK).map(move |first| first..(first + BLOCK).min(end))
    }

    /// The points as their law sees them.
    pub fn law_points(&self) -> LawPoints<'_> {
        LawPoints { material: &*self.material, stress: &self.points.stress, states: &self.states }
    }

    /// Recoverable energies of the points (J), zero where the law defines none.
    pub fn stored_energies(&self) -> Vec<f64> {
        let mut energies = self.law_points().stored_energies();
        energies.iter_mut().zip(&self.points.volume).for_each(|(energy, volume)| *energy *= volume);
        energies
    }

    /// Kinetic energies of the points as bodies of their own, and of the velocity fields around them (J), where `moment` is
    /// the second moment of the shape functions (m²).
    pub fn kinetic_energies(&self, moment: f64) -> [f64; 2] {
        let Columns { velocity, affine, mass, .. } = &self.points;
        let mut sums = [0.0; 2];
        for ((velocity, affine), mass) in velocity.iter().zip(affine).zip(mass) {
            sums[0] += 0.5 * mass * crate::vectors::square(velocity);
            // Sheet: snow-mpm §2.11.
            sums[1] += 0.5 * mass * affine.as_flattened().iter().map(|b| b * b).sum::<f64>() / moment;
        }
        sums
    }

    /// Memory of the points (bytes), with what sorting takes.
    pub fn bytes(&self) -> usize {
        let state = self.material.state_size();
        self.points.bytes() + self.points.len() * (2 * state + 16 + size_of::<Square<D>>())
    }

    /// Point `i` becomes what point `order[i]` was; points that `order` does not name vanish.
    fn reorder(&mut self, order: &[u32], spare: &mut Spare) {
        self.points.reorder(order, spare);
        self.states = self.states.permuted(order);
    }
}

/// The points of all bodies.
#[derive(Default)]
pub struct Bodies<const D: usize> {
    /// The bodies that there are.
    pub all: Vec<Body<D>>,
    /// Sum over the steps since the last sort of the largest move along an axis (m).
    pub travel: f64,
    /// Mean mass of a point (kg).
    pub mean_mass: f64,
    spare: Spare,
}

impl<const D: usize> Bodies<D> {
    /// Of these bodies.
    pub fn new(all: Vec<Body<D>>) -> Self {
        Self { all, ..Self::default() }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.all.iter().map(|body| body.points.len()).sum()
    }

    /// Sorts the points by cell and finds the active nodes. Nodes must be empty.
    pub fn sort(&mut self, background: &mut Background<D>) {
        for body in &mut self.all {
            let order = sort_by_cell(&background.grid, &body.points.position);
            if order.iter().enumerate().any(|(i, &old)| i != old as usize) {
                body.reorder(&order, &mut self.spare);
            }
        }
        self.travel = 0.0;
        self.find_active_nodes(background);
    }

    /// Active nodes and bounds of slabs from the sorted points.
    pub fn find_active_nodes(&mut self, background: &mut Background<D>) {
        background.layout.clear();
        let (mut mass, mut count) = (0.0, 0);
        for body in &mut self.all {
            body.slabs = background.layout.add_points(&body.points.position);
            body.reports.resize(body.points.len().div_ceil(BLOCK), Ok(Pace::NONE));
            mass += body.points.mass.iter().sum::<f64>();
            count += body.points.len();
        }
        self.mean_mass = if count > 0 { mass / count as f64 } else { 0.0 };
    }

    /// Brings points back that left through a periodic side, on the other one.
    pub fn wrap(&mut self, background: &Background<D>) {
        let Background { low, high, periodic, .. } = background;
        if *periodic == [false; D] {
            return;
        }
        for body in &mut self.all {
            let Columns { position, origin, .. } = &mut body.points;
            if wrap([low, high], periodic, position, origin) {
                // They are in other slabs now.
                self.travel = f64::INFINITY;
            }
        }
    }

    /// Keeps the points of which `keep` approves, by body and index, and the bodies that have any; whether any is gone.
    pub fn keep(&mut self, keep: impl Fn(&Body<D>, usize) -> bool) -> bool {
        let before = self.len();
        for body in &mut self.all {
            let order: Vec<u32> = (0..body.points.len() as u32).filter(|&i| keep(body, i as usize)).collect();
            if order.len() < body.points.len() {
                body.reorder(&order, &mut self.spare);
            }
        }
        self.all.retain(|body| !body.points.is_empty());
        self.len() < before
    }
}

/// `columns[j] = -V σ e_j`.
#[inline(always)]
pub fn pull<const D: usize>(stress: &SymTensor, volume: f64) -> [Lanes; D] {
    let mut columns = [Lanes::ZERO; D];
    for j in 0..D {
        let mut column = [0.0; 4];
        for i in 0..D {
            column[i] = -volume * stress.at(i, j);
        }
        columns[j] = Lanes::new(column);
    }
    columns
}
