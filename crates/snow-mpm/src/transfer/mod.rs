//! Transfers between points and grid, with the update of the points (sheet: snow-mpm §3.5).

use colluvium_case::{FailureReason, Manufactured, spatial};
use colluvium_constitutive::{BLOCK_SIZE, Material, MotionBlock, StateBlock, SymTensor};
use colluvium_grid::{
    AffineFields, InterpolatedMotion, NodalState, NodeRange, P2gInput, SquareMatrix, Vector4,
};
use rayon::prelude::*;

use crate::background_grid::BackgroundGrid;
use crate::boundary::walls::BoundaryConditions;
use crate::config::{DeformationUpdate, SnowTransfer};
use crate::critical_step::StepCoefficients;
use crate::momentum::GridNodes;
use crate::points::bodies::{Bodies, BodyPoints, PointColumns, PointFailure, point_slice, stress_columns};
use crate::points::step_bound::StepBound;
use crate::points::vectors::vector4;
use crate::stress::step_motion::{StressWork, find_motions};

/// Least number of groups of points in a parallel task.
const BLOCKS_PER_TASK: usize = 4;

/// Transfers mass, momentum and forces of the points to the grid (steps 1 and 2), with affine momentum, the body force of a
/// program, or the force of a manufactured solution at a time (s).
pub fn p2g<const D: usize>(
    background: &BackgroundGrid<D>,
    bodies: &Bodies<D>,
    nodes: &mut GridNodes,
    transfer: SnowTransfer,
    push: Option<(&Manufactured, f64)>,
) {
    let ground = background.grid_view();
    background.layout.for_each_slab(&mut nodes.nodes, |slab, window, first| {
        let mut motion = [Vector4::ZERO; BLOCK_SIZE];
        let mut columns = [[Vector4::ZERO; D]; BLOCK_SIZE];
        let mut forces = [Vector4::ZERO; BLOCK_SIZE];
        for body in &bodies.bodies {
            let (points, extent) = (&body.points, [body.width; D]);
            for block in body.blocks_of(slab) {
                for (k, p) in block.clone().enumerate() {
                    motion[k] = vector4(&points.velocity[p], points.mass[p], points.mass[p]);
                    columns[k] = stress_columns(&points.stress[p], points.volume[p]);
                }
                let mut pushed = 0;
                if let Some((solution, time)) = push {
                    pushed = block.len();
                    for (force, p) in forces.iter_mut().zip(block.clone()) {
                        let rate = (solution.force)(spatial(&points.origin[p]), time);
                        *force = vector4(&rate, points.mass[p], 0.0);
                    }
                } else if !points.body_force.is_empty() {
                    pushed = block.len();
                    for (force, p) in forces.iter_mut().zip(block.clone()) {
                        *force = vector4(&points.body_force[p], points.mass[p], 0.0);
                    }
                }
                let affine = AffineFields {
                    moments: true,
                    fields: &points.affine_velocity[block.clone()],
                    mass: &points.mass[block.clone()],
                };
                let given = P2gInput {
                    momentum_and_mass: &motion[..block.len()],
                    stress_columns: &columns[..block.len()],
                    body_force: &forces[..pushed],
                    affine_fields: (transfer == SnowTransfer::Apic).then_some(affine),
                };
                let to = NodeRange { nodes: &mut *window, first };
                background.transfers.p2g(&ground, &point_slice(&points.position[block], &extent), to, &given);
            }
        }
    });
}

/// Parameters of the update of the points.
pub struct PointUpdater<'a, const D: usize> {
    /// Step (s).
    pub dt: f64,
    /// Transfer of velocities.
    pub transfer: SnowTransfer,
    /// FLIP fraction.
    pub flip_fraction: f64,
    /// Deformation of the step as a function of the velocity gradient.
    pub deformation: DeformationUpdate,
    /// Coefficients for the step bounds of the next step.
    pub bounds: StepCoefficients,
    /// Background grid.
    pub background: &'a BackgroundGrid<D>,
    /// Nodes after the momentum equation.
    pub nodes: &'a [NodalState],
    /// Walls.
    pub boundaries: &'a BoundaryConditions,
}

/// Consecutive points of a body as slices of its columns.
struct PointBlock<'a, const D: usize> {
    first: usize,
    position: &'a mut [[f64; D]],
    velocity: &'a mut [[f64; D]],
    affine_velocity: &'a mut [SquareMatrix<D>],
    volume: &'a mut [f64],
    stress: &'a mut [SymTensor],
    work: &'a mut [f64],
    mass: &'a [f64],
    states: &'a mut StateBlock,
}

/// Working arrays of a thread.
struct Workspace<const D: usize> {
    interpolated_motion: [InterpolatedMotion<D>; BLOCK_SIZE],
    motions: MotionBlock,
}

impl<const D: usize> PointUpdater<'_, D> {
    /// Workspace for the update of a group of points.
    fn workspace(&self) -> Workspace<D> {
        let motions = MotionBlock::at_rest(self.dt, self.background.grid.cell, D < 3);
        Workspace { interpolated_motion: [InterpolatedMotion::ZERO; BLOCK_SIZE], motions }
    }

    /// Grid to points: velocity, deformation, stress, position (steps 4 to 9), for all points of a body. Each block of points gives a
    /// step bound or a failure.
    pub fn body(&self, body: &mut BodyPoints<D>) {
        let BodyPoints { points, states, material, reports, width, remove_outside, .. } = body;
        let PointColumns { position, velocity, affine_velocity, volume, stress, work, mass, .. } = points;
        let (material, extent, remove_outside) = (&**material, [*width; D], *remove_outside);
        let blocks = (
            position.par_chunks_mut(BLOCK_SIZE),
            velocity.par_chunks_mut(BLOCK_SIZE),
            affine_velocity.par_chunks_mut(BLOCK_SIZE),
            volume.par_chunks_mut(BLOCK_SIZE),
            stress.par_chunks_mut(BLOCK_SIZE),
            work.par_chunks_mut(BLOCK_SIZE),
            mass.par_chunks(BLOCK_SIZE),
            states.blocks_mut().par_iter_mut(),
            reports.par_iter_mut(),
        );
        blocks.into_par_iter().enumerate().with_min_len(BLOCKS_PER_TASK).for_each_init(
            || self.workspace(),
            |bench, (number, (position, velocity, affine_velocity, volume, stress, work, mass, states, report))| {
                let first = number * BLOCK_SIZE;
                let mut block = PointBlock {
                    first,
                    position,
                    velocity,
                    affine_velocity,
                    volume,
                    stress,
                    work,
                    mass,
                    states,
                };
                *report = self.block(&mut block, bench, material, (&extent, remove_outside));
            },
        );
    }

    /// Updates a group of points from the grid: velocity, position and stress. Returns the bound of the next time step.
    fn block(
        &self,
        block: &mut PointBlock<'_, D>,
        bench: &mut Workspace<D>,
        material: &dyn Material,
        (extent, remove_outside): (&[f64; D], bool),
    ) -> Result<StepBound, PointFailure> {
        let (sweeps, ground) = (self.background.transfers, self.background.grid_view());
        let count = block.position.len();
        let (reads, motions) = (&mut bench.interpolated_motion[..count], &mut bench.motions);
        let points = point_slice(block.position, extent);
        if self.transfer == SnowTransfer::Apic {
            sweeps.g2p_with_affine(&ground, &points, self.nodes, true, (reads, block.affine_velocity));
        } else {
            sweeps.g2p(&ground, &points, self.nodes, reads);
        }
        self.blend(block.velocity, reads);
        let stretches = find_motions(reads, self.deformation, motions);
        if let Some((p, reason)) = motions.change_volumes(&stretches, block.volume, block.mass) {
            return Err(PointFailure { index: block.first + p, reason: reason.into() });
        }
        let (moved, left) = self.move_points(block, reads, remove_outside)?;
        let work = StressWork::before_step::<D>(block.stress);
        material.update_block(motions, block.stress, block.states).map_err(|error| {
            let index = block.first + error.index;
            PointFailure { index, reason: error.source.into() }
        })?;
        work.add::<D>(motions, &stretches, (block.volume, block.stress), block.work);
        // The work of a stress that is not finite is not finite either.
        if let Some(p) = block.work.iter().position(|work| !work.is_finite()) {
            return Err(PointFailure {
                index: block.first + p,
                reason: FailureReason::NotFinite("its stress is not finite".to_owned()),
            });
        }
        let points = (&*block.velocity, block.mass, &*block.volume);
        let pace = self.bounds.step_bound(block.first, material, points, (block.stress, block.states));
        Ok(StepBound { max_move: moved, any_outside: left, ..pace })
    }

    /// Blends FLIP and PIC in the new velocities of the points.
    fn blend(&self, velocities: &mut [[f64; D]], reads: &[InterpolatedMotion<D>]) {
        for (own, read) in velocities.iter_mut().zip(reads) {
            let (velocity, acceleration) = (read.velocity.as_array(), read.acceleration.as_array());
            for c in 0..D {
                own[c] = self.flip_fraction * (own[c] + self.dt * acceleration[c])
                    + (1.0 - self.flip_fraction) * velocity[c];
            }
        }
    }

    /// Moves the points with the velocity of the grid (step 9). Returns the largest displacement along an axis (m), and whether a point
    /// left the domain.
    fn move_points(
        &self,
        block: &mut PointBlock<'_, D>,
        reads: &[InterpolatedMotion<D>],
        remove_outside: bool,
    ) -> Result<(f64, bool), PointFailure> {
        let BackgroundGrid { low, upper_corner, .. } = self.background;
        let (mut moved, mut inside) = ([0f64; D], true);
        for (position, read) in block.position.iter_mut().zip(reads) {
            let velocity = read.velocity.as_array();
            for c in 0..D {
                let step = self.dt * velocity[c];
                position[c] += step;
                moved[c] = moved[c].max(step.abs());
                // NaN is not inside either.
                inside &= (position[c] >= low[c]) & (position[c] <= upper_corner[c]);
            }
        }
        let moved = moved.iter().fold(0f64, |largest, step| largest.max(*step));
        if inside && moved <= self.max_move() {
            return Ok((moved, false));
        }
        Ok((moved, self.check_outside(block, reads, remove_outside)?))
    }

    /// Upper bound of the displacement along an axis in a step (m).
    fn max_move(&self) -> f64 {
        0.5 * self.background.grid.cell * (1.0 + 1e-9)
    }

    /// Whether one of the points has left the domain. It is an error if this is not permitted, or if a point has moved too far.
    #[cold]
    fn check_outside(
        &self,
        block: &PointBlock<'_, D>,
        reads: &[InterpolatedMotion<D>],
        remove_outside: bool,
    ) -> Result<bool, PointFailure> {
        let mut left = false;
        for (p, (position, read)) in block.position.iter().zip(reads).enumerate() {
            let velocity = &read.velocity.as_array()[..D];
            let failed = |reason| PointFailure { index: block.first + p, reason };
            let step = velocity.iter().map(|v| (self.dt * v).abs()).fold(0.0, f64::max);
            if !(velocity.iter().all(|v| v.is_finite()) && step <= self.max_move()) {
                return Err(failed(FailureReason::Unstable(format!(
                    "it would move {step:.3e} m in one step, more than half a cell: the run has become unstable (reduce \
                     courant_elastic or time_step)"
                ))));
            }
            let outside = self.background.distance_outside(position);
            if outside > 0.0 && !self.is_held_by_wall(position, outside) {
                if !remove_outside {
                    let reason = "it left the domain: enlarge the domain, add a wall on that side or set remove_outside of the body";
                    return Err(failed(FailureReason::LeftDomain(reason.to_owned())));
                }
                left = true;
            }
        }
        Ok(left)
    }

    /// Whether walls return a point that is at most one cell outside the domain.
    fn is_held_by_wall(&self, position: &[f64; D], outside: f64) -> bool {
        let BackgroundGrid { low, upper_corner, .. } = self.background;
        outside < 1.0
            && (0..D).filter(|axis| !self.background.periodic[*axis]).all(|axis| {
                (position[axis] >= low[axis] || self.boundaries.has_wall(axis, false))
                    && (position[axis] <= upper_corner[axis] || self.boundaries.has_wall(axis, true))
            })
    }
}
