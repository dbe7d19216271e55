//! Update of points between the transfers (sheet: mpm §3.3, steps 5 and 7 to 9).

use std::sync::atomic::Ordering;

use colluvium_case::{FailureReason, SolverError};
use colluvium_constitutive::{BLOCK_SIZE, MotionBlock, SymTensor};
use colluvium_grid::{InterpolatedMotion, PointSlice};

use crate::background_grid::BackgroundGrid;
use crate::boundary::boundary_conditions::BoundaryConditions;
use crate::clock::Clock;
use crate::config::{LagrangianFormulation, VelocityTransfer};
use crate::momentum::velocity_fields::VelocitySource::{EndOfStep, Remapped};
use crate::momentum::velocity_fields::{VelocityFields, VelocitySource};
use crate::points::bodies::Bodies;
use crate::points::point_blocks::{BlockReport, PointBlock, PointFailure, SetProperties, Workspace};
use crate::points::point_set::MIN_VOLUME_RATIO;
use crate::stress::averages::CellAverages;
use crate::stress::dual_domain::{DualDomainNodes, average_velocity_gradients};
use crate::stress::stress_work::PreviousStress;
use crate::stress::volumetric_strain::{CellStrains, own_strain_shares, set_volumetric};

/// Parts of the point state that an update changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UpdateSelection {
    /// Velocities.
    pub velocity: bool,
    /// Deformation, volume, stress and state.
    pub stress: bool,
    /// Whether positions are updated.
    pub position: bool,
}

/// Displacement of a point in a step.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Displacement {
    /// Largest component along an axis (m).
    pub step: f64,
    /// First coordinate before the step (m).
    pub radius: f64,
}

impl UpdateSelection {
    /// Selection without any update.
    pub const NONE: Self = Self { velocity: false, stress: false, position: false };
    /// Selection of the whole state.
    pub const ALL: Self = Self { velocity: true, stress: true, position: true };
    /// Selection of the velocities only.
    pub const VELOCITY: Self = Self { velocity: true, ..Self::NONE };
    /// Update of deformation, volume, stress and state.
    pub const STRESS: Self = Self { stress: true, ..Self::NONE };
}

/// Grid to point (steps 5, 7–9); returns the largest displacement along an axis (m).
pub fn update_points<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &mut Bodies<D>,
    (nodes, read): (&VelocityFields, VelocitySource),
    boundary: &BoundaryConditions<D>,
    averages: &mut CellAverages<D>,
    selection: UpdateSelection,
) -> Result<f64, SolverError> {
    if selection.stress {
        average_velocity_gradients(background, (nodes, read), &mut averages.dual_domain);
    }
    let CellAverages { strains, dual_domain: dual, .. } = &*averages;
    let update = PointUpdater { clock, background, strains, has_wall: &boundary.has_wall };
    let new_workspace = || {
        Workspace::at_rest::<D>(
            InterpolatedMotion::ZERO,
            clock.dt,
            clock.options.band_cells() * background.grid.cell,
        )
    };
    bodies.update_blocks(clock, &new_workspace, |set, block, workspace| {
        update.block((nodes, read, dual), set, block, workspace, selection)
    })
}

/// Input of an update of points.
pub struct PointUpdater<'a, const D: usize> {
    /// Clock of the step.
    pub clock: &'a Clock,
    /// Background grid.
    pub background: &'a BackgroundGrid<D>,
    /// Averaged volumetric strains.
    pub strains: &'a CellStrains,
    /// Whether the domain has a wall at the lower and the upper end of each axis.
    pub has_wall: &'a [[bool; 2]; D],
}

impl<const D: usize> PointUpdater<'_, D> {
    /// Updates a group of points from the grid: velocity, position and stress.
    fn block(
        &self,
        (nodes, read, dual): (&VelocityFields, VelocitySource, &DualDomainNodes),
        set: &SetProperties<'_, D>,
        block: &mut PointBlock<'_, D>,
        Workspace { interpolated_motion: reads, motions }: &mut Workspace<InterpolatedMotion<D>>,
        selection: UpdateSelection,
    ) -> BlockReport {
        let BackgroundGrid { grid, layout, .. } = self.background;
        let (view, extent, dt) = (self.background.grid_view(), &set.extent, self.clock.dt);
        let first = set.field * layout.len();
        let reads = &mut reads[..block.position.len()];
        self.interpolate((nodes, read), set, block, reads, selection);
        if selection.velocity {
            self.update_velocities(set, block.velocity, reads);
        }
        if selection.stress && dual.is_used() {
            for (read, position) in reads.iter_mut().zip(&*block.position) {
                dual.blend(set.field, grid, layout, position, &mut read.gradient);
            }
        }
        if selection.stress {
            self.deform(set, block, reads, motions)?;
        }
        let moved = if selection.position {
            block.apply_pending_domains();
            let velocity = |p: usize| std::array::from_fn(|c| reads[p].velocity.as_array()[c]);
            let of_node = |number: usize| nodes.motion(read, first + number);
            block.domain.advect_corners(&view, block.position, extent, velocity, dt, of_node);
            let mut moves = [Displacement::default(); BLOCK_SIZE];
            for (p, read) in reads.iter().enumerate() {
                moves[p] = self.move_point(block, p, read.velocity.as_array());
            }
            self.check_positions(set, block, &moves)?
        } else {
            0.0
        };
        if selection.stress {
            let before = (!block.stress_work.is_empty()).then(|| PreviousStress::of_block(block.stress));
            set.material.update_block(motions, block.stress, &mut block.states[0]).map_err(|error| {
                PointFailure { index: block.first + error.index, reason: error.source.into() }
            })?;
            if let Some(before) = before {
                before.add_work(motions, block.stress, block.volume, block.stress_work);
            }
            self.cap_volumes(block.volume, block.initial_volume, block.stress);
        }
        Ok(moved)
    }

    /// Interpolates velocity, acceleration and gradient of the grid to a group of points, as far as the update needs them, and the affine
    /// fields with the velocities at the end of the step.
    #[inline(always)]
    fn interpolate(
        &self,
        (nodes, read): (&VelocityFields, VelocitySource),
        set: &SetProperties<'_, D>,
        block: &mut PointBlock<'_, D>,
        reads: &mut [InterpolatedMotion<D>],
        selection: UpdateSelection,
    ) {
        let BackgroundGrid { layout, transfers, .. } = self.background;
        let (view, first) = (self.background.grid_view(), set.field * layout.len());
        let (solved, remapped) = (&nodes.nodal_states[first..], &nodes.remapped_velocities);
        let PointBlock { position, domain, affine_velocity, .. } = block;
        let points = PointSlice { position, domain: domain.as_slice(), extent: &set.extent };
        match (read, selection.stress) {
            (EndOfStep, _) if selection.velocity && set.has_affine_field => {
                let moments = self.clock.options.transfer == VelocityTransfer::Apic;
                transfers.g2p_with_affine(&view, &points, solved, moments, (reads, affine_velocity));
            }
            (EndOfStep, true) => transfers.g2p(&view, &points, solved, reads),
            (EndOfStep, false) => transfers.g2p_motion(&view, &points, solved, reads),
            (Remapped, _) => transfers.g2p_velocity(&view, &points, &remapped[first..], reads),
        }
    }

    /// Velocities of points at the end of the step (step 5): a blend of FLIP and PIC, PIC with an affine field (sheet: mpm §2.6).
    #[inline(always)]
    fn update_velocities(
        &self,
        set: &SetProperties<'_, D>,
        velocities: &mut [[f64; D]],
        reads: &[InterpolatedMotion<D>],
    ) {
        let (flip, dt) = (if set.has_affine_field { 0.0 } else { self.clock.flip_fraction }, self.clock.dt);
        for (own, read) in velocities.iter_mut().zip(reads) {
            let (velocity, acceleration) = (read.velocity.as_array(), read.acceleration.as_array());
            for c in 0..D {
                own[c] = flip * (own[c] + dt * acceleration[c]) + (1.0 - flip) * velocity[c];
            }
        }
    }

    /// Computes motions, volumes and domains of a group of points from interpolated values (steps 7, 8).
    #[inline]
    fn deform(
        &self,
        set: &SetProperties<'_, D>,
        block: &mut PointBlock<'_, D>,
        reads: &[InterpolatedMotion<D>],
        motions: &mut MotionBlock,
    ) -> Result<(), PointFailure> {
        self.find_motions(block, reads.iter(), motions);
        if self.strains.is_shared() {
            let mut kept = [0.0; BLOCK_SIZE];
            if set.is_fluid {
                own_strain_shares(set.material, block.stress, &block.states[0], &mut kept[..reads.len()]);
            }
            let shared = |p: usize| self.shared_strain(set.body, &block.point_slice(&set.extent), p)[0];
            (0..reads.len()).for_each(|p| self.set_dilation(motions, p, shared(p), kept[p]));
        }
        self.change_volumes(set, block, motions, None)
    }

    /// Motions of the step from the interpolated values of a group of points.
    #[inline(always)]
    pub fn find_motions<'a>(
        &self,
        block: &PointBlock<'_, D>,
        reads: impl Iterator<Item = &'a InterpolatedMotion<D>> + Clone,
        motions: &mut MotionBlock,
    ) {
        let dt = motions.dt;
        motions.set_gradients(reads.clone().map(|read| read.gradient.map(|column| (column * dt).to_array())));
        motions.deform_linearly::<D>();
        if self.background.axisymmetric {
            for (p, (read, position)) in reads.zip(&*block.position).enumerate() {
                let hoop = dt * read.velocity.as_array()[0] / position[0];
                (motions.velocity_gradient_dt[8][p], motions.deformation[8][p]) = (hoop, 1.0 + hoop);
            }
        }
        if self.background.is_meshed() {
            for (p, position) in block.position.iter().enumerate() {
                motions.size[p] = self.background.edge(&block.domain.as_slice(), p, position);
            }
        }
    }

    /// Sets the volumetric strain of a point to `dilation`, except for the fraction `kept` of its original one.
    pub fn set_dilation(&self, motions: &mut MotionBlock, p: usize, dilation: f64, kept: f64) {
        let mut motion = motions.motion(p);
        set_volumetric(&mut motion, self.background.normal_strains(), dilation, kept);
        motions.set(p, &motion);
    }

    /// Updates volumes, densities and domains of a group of points. Returns the first point that inverts, has `failed` or has an invalid
    /// domain.
    #[inline(always)]
    pub fn change_volumes(
        &self,
        set: &SetProperties<'_, D>,
        block: &mut PointBlock<'_, D>,
        motions: &mut MotionBlock,
        failed: Option<PointFailure>,
    ) -> Result<(), PointFailure> {
        let ratios = motions.volume_ratios();
        let inverted = motions.change_volumes(&ratios, block.volume, block.mass);
        let inverted =
            inverted.map(|(p, reason)| PointFailure { index: block.first + p, reason: reason.into() });
        let failure = inverted.into_iter().chain(failed).min_by_key(|failure| failure.index);
        block.update_domains(motions);
        block.first_failure(failure, &set.extent, self.background.grid.cell)
    }

    /// Limits the volumes: at most the cap for stress-free points, and at least a tenth of the initial volume (sheet: mpm §2.8, pitfall
    /// P-09).
    #[inline]
    pub fn cap_volumes(&self, volumes: &mut [f64], initial: &[f64], stresses: &[SymTensor]) {
        let cap = self.clock.options.volume_cap;
        for ((volume, initial), stress) in volumes.iter_mut().zip(initial).zip(stresses) {
            let largest = cap * initial;
            if *volume > largest && stress.0 == [0.0; 6] {
                *volume = largest;
            }
            *volume = volume.max(MIN_VOLUME_RATIO * initial);
        }
    }

    /// Moves a point with `velocity` (m/s), or its reference position where points are fixed.
    #[inline(always)]
    pub fn move_point(&self, block: &mut PointBlock<'_, D>, p: usize, velocity: &[f64; 4]) -> Displacement {
        let dt = self.clock.dt;
        let step = velocity[..D].iter().fold(0f64, |step, v| step.max((dt * v).abs()));
        let radius = block.position[p][0];
        if let Some(grid_velocity) = block.grid_velocity.get_mut(p) {
            grid_velocity.copy_from_slice(&velocity[..D]);
        }
        if self.clock.options.formulation == LagrangianFormulation::SmallDisplacement {
            (0..D).for_each(|c| block.origin[p][c] -= dt * velocity[c]);
        } else {
            (0..D).for_each(|c| block.position[p][c] += dt * velocity[c]);
        }
        Displacement { step, radius }
    }

    /// Checks the new positions of a group of points. Displacements that are too large are an error; points are kept off the axis and
    /// inside walls. Points that have left a body that allows it get the position NaN. Returns the largest displacement along an axis (m).
    #[inline(never)]
    pub fn check_positions(
        &self,
        set: &SetProperties<'_, D>,
        block: &mut PointBlock<'_, D>,
        moves: &[Displacement],
    ) -> BlockReport {
        let (view, cell) = (self.background.grid_view(), self.background.grid.cell);
        let mut moved = 0f64;
        for (p, (position, Displacement { step, radius })) in block.position.iter_mut().zip(moves).enumerate()
        {
            let domain = block.domain.as_slice();
            let fail = |reason| PointFailure { index: block.first + p, reason };
            // Written so that NaN counts as a failure.
            if !(*step <= 0.5 * domain.spacing(p, &view)) {
                return Err(fail(FailureReason::Unstable(format!(
                    "it would move {step:.3e} m in one step, more than half a cell or element: the run has become \
                     unstable (reduce courant or time_step)"
                ))));
            }
            if self.background.axisymmetric && !set.reference_configuration {
                // Its domain does not reach over the axis, where its hoop strain has no bound (pitfall P-26).
                let smallest = 0.5 * domain.extent(p, &set.extent, cell)[0];
                position[0] = position[0].max(smallest.min(*radius));
            }
            let settled = if self.background.is_meshed() {
                block.domain.relocate(p, &view, position)
            } else if !set.reference_configuration && !self.background.grid.contains(position) {
                self.project_onto_walls(position)
            } else {
                Ok(())
            };
            match settled {
                Err(_) if set.remove_outside => {
                    position.fill(f64::NAN);
                    set.any_outside.store(true, Ordering::Relaxed);
                }
                settled => settled.map_err(|reason| fail(FailureReason::LeftDomain(reason)))?,
            }
            moved = moved.max(if set.reference_configuration { 0.0 } else { *step });
        }
        Ok(moved)
    }

    /// Moves a point that is outside walls of the domain onto them.
    fn project_onto_walls(&self, position: &mut [f64; D]) -> Result<(), String> {
        for axis in (0..D).filter(|axis| !self.background.periodic[*axis]) {
            let (low, high) = (self.background.grid.origin[axis], self.background.upper_corner[axis]);
            if (position[axis] < low && !self.has_wall[axis][0])
                || (position[axis] > high && !self.has_wall[axis][1])
            {
                let reason = "it left the domain: enlarge the domain, add a wall on that side or set remove_outside of the body";
                return Err(reason.to_owned());
            }
            position[axis] = position[axis].clamp(low, high);
        }
        Ok(())
    }

    /// Averaged volumetric strains of skeleton and liquid at a point of a body.
    #[inline(always)]
    pub fn shared_strain(&self, body: u32, points: &PointSlice<'_, D>, p: usize) -> [f64; 2] {
        let cell = points.domain.cell(p, &self.background.grid_view(), &points.position[p]);
        self.strains.cell_strains(body, self.background.cell_layout().len(), cell)
    }
}
