//! Blocks of points for parallel updates.

use colluvium_case::FailureReason;
use std::sync::atomic::AtomicBool;

use colluvium_constitutive::{BLOCK_SIZE, MotionBlock, StateBlock, SymTensor};
use colluvium_grid::{DomainsMut, PointSlice, SquareMatrix};

use crate::points::point_set::PointSet;
use crate::points::pore_contact_state::PoreContactState;
use crate::points::pore_fluid::PoreFluidConstants;
use crate::points::right_stretch::right_stretch;

/// Result of the update of a group of points: the largest displacement along an axis (m), or the first failure.
pub type BlockReport = Result<f64, PointFailure>;

/// Failure of a point, with the reason.
pub struct PointFailure {
    /// Index of the point within its set.
    pub index: usize,
    /// Reason of the failure.
    pub reason: FailureReason,
}

/// Consecutive points of a set as mutable slices of its columns, see [`PointSet`]. An update receives at most [`BLOCK`] points.
pub struct PointBlock<'a, const D: usize> {
    /// Index of the first point within its set.
    pub first: usize,
    /// Positions (m).
    pub position: &'a mut [[f64; D]],
    /// Reference positions of displacements (m).
    pub origin: &'a mut [[f64; D]],
    /// Velocities (m/s).
    pub velocity: &'a mut [[f64; D]],
    /// Moments or gradients of the velocities, see [`PointColumns::affine_velocity`](super::point_set::PointColumns); empty without an
    /// affine transfer.
    pub affine_velocity: &'a mut [SquareMatrix<D>],
    /// Grid velocities at the points (m/s); empty if they equal the point velocities.
    pub grid_velocity: &'a mut [[f64; D]],
    /// Volumes of the points (m³).
    pub volume: &'a mut [f64],
    /// Stresses (Pa).
    pub stress: &'a mut [SymTensor],
    /// Material states, one entry per [`BLOCK`] points.
    pub states: &'a mut [StateBlock],
    /// Domains of the points.
    pub domain: DomainsMut<'a, D>,
    /// Masses (kg).
    pub mass: &'a [f64],
    /// Initial volumes.
    pub initial_volume: &'a [f64],
    /// Displacement gradients for the update of domains at the end of the step; empty if domains are updated immediately.
    pub pending_gradient: &'a mut [[[f64; D]; D]],
    /// Work of the stresses (J); empty if it is not recorded.
    pub stress_work: &'a mut [f64],
    /// Velocities of the liquid (m/s); empty without liquid.
    pub liquid_velocity: &'a mut [[f64; D]],
    /// Pore pressures (Pa); empty without liquid.
    pub pressure: &'a mut [f64],
    /// Contact states of the pore fluid; empty unless obstacles act on points.
    pub pore_contact: &'a mut [PoreContactState<D>],
}

/// Least number of groups of points in a parallel task.
const MIN_BLOCKS_PER_TASK: usize = 4;
/// Number of parallel tasks per thread, so that threads with little work take more tasks.
const TASKS_PER_THREAD: usize = 8;

/// Workspace for the update of a group of points: interpolated values (`R`) and motions.
pub struct Workspace<R> {
    /// Values interpolated from the grid.
    pub interpolated_motion: [R; BLOCK_SIZE],
    /// Motions of the points.
    pub motions: MotionBlock,
}

impl<R: Copy> Workspace<R> {
    /// Returns points with the interpolated value `nothing` and no motion, in a step (s), with bands of a length (m), in `D` dimensions.
    pub fn at_rest<const D: usize>(nothing: R, dt: f64, band: f64) -> Self {
        Self { interpolated_motion: [nothing; BLOCK_SIZE], motions: MotionBlock::at_rest(dt, band, D < 3) }
    }
}

/// Update of groups of points: a function for each group, and one that creates its workspace.
pub struct BlockUpdateTask<'a, R, const D: usize> {
    /// Returns the initial workspace of a thread.
    pub new_workspace: &'a (dyn Fn() -> Workspace<R> + Sync),
    /// Function that updates a group of points.
    pub block: &'a BlockUpdate<'a, R, D>,
}

/// Function that updates a block.
type BlockUpdate<'a, R, const D: usize> =
    dyn Fn(&mut PointBlock<'_, D>, &mut Workspace<R>) -> BlockReport + Sync + 'a;

impl<'a, const D: usize> PointBlock<'a, D> {
    /// Splits off the first `blocks` groups of points.
    fn split_blocks(&mut self, blocks: usize) -> Self {
        let points = blocks * BLOCK_SIZE;
        // Absent arrays are empty.
        /// Splits off the first `count` values of a slice.
        fn front<'a, T>(values: &mut &'a mut [T], count: usize) -> &'a mut [T] {
            values.split_off_mut(..count).unwrap_or_default()
        }
        let first = self.first;
        self.first += points;
        PointBlock {
            first,
            position: front(&mut self.position, points),
            origin: front(&mut self.origin, points),
            velocity: front(&mut self.velocity, points),
            affine_velocity: front(&mut self.affine_velocity, points),
            grid_velocity: front(&mut self.grid_velocity, points),
            volume: front(&mut self.volume, points),
            stress: front(&mut self.stress, points),
            states: front(&mut self.states, blocks),
            domain: self.domain.split_off_front(points),
            mass: self.mass.split_off(..points).unwrap_or_default(),
            initial_volume: self.initial_volume.split_off(..points).unwrap_or_default(),
            pending_gradient: front(&mut self.pending_gradient, points),
            stress_work: front(&mut self.stress_work, points),
            liquid_velocity: front(&mut self.liquid_velocity, points),
            pressure: front(&mut self.pressure, points),
            pore_contact: front(&mut self.pore_contact, points),
        }
    }

    /// Updates all groups of points in parallel. Returns the largest displacement (m) or the first failure. The cost of a call is small
    /// compared with the update, and the loop is compiled once for all updates with the same interpolated values.
    pub fn update<R>(self, update: &BlockUpdateTask<'_, R, D>) -> BlockReport {
        let (blocks, threads) = (self.states.len(), rayon::current_num_threads());
        // A single thread needs no small tasks.
        let grain = if threads > 1 {
            (blocks / (TASKS_PER_THREAD * threads)).max(MIN_BLOCKS_PER_TASK)
        } else {
            blocks
        };
        self.update_in_tasks(grain, update)
    }

    /// Updates a range of groups in parallel tasks of at most `grain` groups, and combines their results.
    fn update_in_tasks<R>(mut self, grain: usize, update: &BlockUpdateTask<'_, R, D>) -> BlockReport {
        let blocks = self.states.len();
        if blocks > grain {
            let lower = self.split_blocks(blocks.div_ceil(2));
            let (lower, upper) =
                rayon::join(|| lower.update_in_tasks(grain, update), || self.update_in_tasks(grain, update));
            return combine_reports(lower, upper);
        }
        let (mut report, mut workspace) = (Ok(0.0), (update.new_workspace)());
        for _ in 1..blocks {
            report = combine_reports(report, (update.block)(&mut self.split_blocks(1), &mut workspace));
        }
        if blocks > 0 { combine_reports(report, (update.block)(&mut self, &mut workspace)) } else { report }
    }
}

impl<const D: usize> PointBlock<'_, D> {
    /// View of the points for a transfer.
    #[inline(always)]
    pub fn point_slice<'b>(&'b self, extent: &'b [f64; D]) -> PointSlice<'b, D> {
        PointSlice { position: self.position, domain: self.domain.as_slice(), extent }
    }

    /// Updates the point domains with the motions of the step, or stores the motions for the end of the step.
    pub fn update_domains(&mut self, motions: &MotionBlock) {
        let (later, count) = (!self.pending_gradient.is_empty(), self.position.len());
        if !later && !self.domain.are_deformable() {
            return;
        }
        let mut own = [[[0.0; D]; D]; BLOCK_SIZE];
        let gradients = if later { &mut self.pending_gradient[..count] } else { &mut own[..count] };
        for (p, gradient) in gradients.iter_mut().enumerate() {
            for i in 0..D {
                for j in 0..D {
                    gradient[i][j] = motions.velocity_gradient_dt[3 * i + j][p];
                }
            }
        }
        if !later {
            self.domain.update_deformation(&own[..count], right_stretch);
        }
    }

    /// Failure of the first point with one: `failure`, or an invalid domain.
    pub fn first_failure(
        &self,
        failure: Option<PointFailure>,
        extent: &[f64; D],
        cell: f64,
    ) -> Result<(), PointFailure> {
        let fault = self.domain.as_slice().first_invalid(extent, cell);
        let fault = fault.map(|(p, reason)| PointFailure {
            index: self.first + p,
            reason: FailureReason::coded("cpdi-domain-torn", reason),
        });
        match (failure, fault) {
            (None, None) => Ok(()),
            (Some(failure), Some(fault)) if fault.index < failure.index => Err(fault),
            (Some(failure), _) | (None, Some(failure)) => Err(failure),
        }
    }

    /// Updates the domains with the motions that [`PointBlock::update_domains`] has stored.
    pub fn apply_pending_domains(&mut self) {
        self.domain.update_deformation(self.pending_gradient, right_stretch);
    }
}

impl<const D: usize> PointSet<D> {
    /// View of all points of the set as one group.
    pub fn as_block(&mut self) -> PointBlock<'_, D> {
        let (liquid_velocity, pressure, pore_contact) = match &mut self.pore {
            Some(pore) => {
                let points = &mut pore.points;
                (&mut points.velocity[..], &mut points.pressure[..], &mut points.obstacle_contact[..])
            }
            None => Default::default(),
        };
        PointBlock {
            first: 0,
            position: &mut self.points.position,
            origin: &mut self.points.origin,
            velocity: &mut self.points.velocity,
            affine_velocity: &mut self.points.affine_velocity,
            grid_velocity: &mut self.points.grid_velocity,
            volume: &mut self.points.volume,
            stress: &mut self.points.stress,
            states: self.states.blocks_mut(),
            domain: self.domain.as_mut(),
            mass: &self.points.mass,
            initial_volume: &self.points.initial_volume,
            pending_gradient: &mut self.points.pending_gradient,
            stress_work: &mut self.points.work,
            liquid_velocity,
            pressure,
            pore_contact,
        }
    }
}

/// Properties that all points of a set have in common.
pub struct SetProperties<'a, const D: usize> {
    /// Material law.
    pub material: &'a dyn colluvium_constitutive::Material,
    /// Initial full widths of the points (m).
    pub extent: [f64; D],
    /// Index into `Case::bodies`.
    pub body: u32,
    /// Velocity field of the grid.
    pub field: usize,
    /// Whether points carry an affine velocity field.
    pub has_affine_field: bool,
    /// Whether points use their initial positions on the grid.
    pub reference_configuration: bool,
    /// The pore fluid, if any.
    pub fluid: Option<PoreFluidConstants>,
    /// Whether the material is a fluid.
    pub is_fluid: bool,
    /// Whether points that leave the domain are removed.
    pub remove_outside: bool,
    /// Flag that points have left.
    pub any_outside: &'a AtomicBool,
}

/// Returns the larger displacement, or the failure with the lowest index.
fn combine_reports(a: BlockReport, b: BlockReport) -> BlockReport {
    match (a, b) {
        (Ok(a), Ok(b)) => Ok(a.max(b)),
        (Err(a), Err(b)) => Err(if a.index <= b.index { a } else { b }),
        (Err(a), Ok(_)) | (Ok(_), Err(a)) => Err(a),
    }
}
