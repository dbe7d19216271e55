//! The transfers between points and grid, and what happens at the points in between (sheet: snow-mpm §3.5).

use colluvium_case::{Manufactured, spatial};
use colluvium_constitutive::{BLOCK, Material, Motions, StateBlock, SymTensor};
use colluvium_grid::{Affine, Deposit, Gathered, Lanes, Node, Square, Window};
use rayon::prelude::*;

use crate::background::Background;
use crate::bodies::{Bodies, Body, Columns, Failure, places, pull};
use crate::config::{DeformationUpdate, SnowTransfer};
use crate::limit::Bounds;
use crate::motion::{Work, find_motions};
use crate::nodes::Nodes;
use crate::pace::Pace;
use crate::vectors::lanes;
use crate::walls::Boundaries;

/// Blocks that one thread takes at once, at least.
const GRAIN: usize = 4;

/// Points to grid: mass, momentum with its affine part, forces (steps 1 and 2), with those of a manufactured solution at a time (s).
pub fn scatter<const D: usize>(
    background: &Background<D>,
    bodies: &Bodies<D>,
    nodes: &mut Nodes,
    transfer: SnowTransfer,
    push: Option<(&Manufactured, f64)>,
) {
    let ground = background.ground();
    background.layout.scatter(&mut nodes.nodes, |slab, window, first| {
        let mut motion = [Lanes::ZERO; BLOCK];
        let mut columns = [[Lanes::ZERO; D]; BLOCK];
        let mut forces = [Lanes::ZERO; BLOCK];
        for body in &bodies.all {
            let (points, extent) = (&body.points, [body.width; D]);
            for block in body.blocks_of(slab) {
                for (k, p) in block.clone().enumerate() {
                    motion[k] = lanes(&points.velocity[p], points.mass[p], points.mass[p]);
                    columns[k] = pull(&points.stress[p], points.volume[p]);
                }
                let mut pushed = 0;
                if let Some((solution, time)) = push {
                    pushed = block.len();
                    for (force, p) in forces.iter_mut().zip(block.clone()) {
                        let rate = (solution.force)(spatial(&points.origin[p]), time);
                        *force = lanes(&rate, points.mass[p], 0.0);
                    }
                }
                let affine = Affine {
                    moments: true,
                    fields: &points.affine[block.clone()],
                    mass: &points.mass[block.clone()],
                };
                let given = Deposit {
                    motion: &motion[..block.len()],
                    columns: &columns[..block.len()],
                    body: &forces[..pushed],
                    affine: (transfer == SnowTransfer::Apic).then_some(affine),
                };
                let to = Window { nodes: &mut *window, first };
                background.sweeps.deposit(&ground, &places(&points.position[block], &extent), to, &given);
            }
        }
    });
}

/// What an update of the points needs beside them.
pub struct Update<'a, const D: usize> {
    /// Step (s).
    pub dt: f64,
    /// The transfer.
    pub transfer: SnowTransfer,
    /// Share of FLIP.
    pub flip: f64,
    /// How the deformation of the step follows from the velocity gradient.
    pub deformation: DeformationUpdate,
    /// What the next step is measured by.
    pub bounds: Bounds,
    /// The grid.
    pub background: &'a Background<D>,
    /// The solved nodes.
    pub nodes: &'a [Node],
    /// The walls.
    pub boundaries: &'a Boundaries,
}

/// A block of points, borrowed.
struct Block<'a, const D: usize> {
    first: usize,
    position: &'a mut [[f64; D]],
    velocity: &'a mut [[f64; D]],
    affine: &'a mut [Square<D>],
    volume: &'a mut [f64],
    stress: &'a mut [SymTensor],
    work: &'a mut [f64],
    mass: &'a [f64],
    states: &'a mut StateBlock,
}

/// What a thread works with, block after block.
struct Bench<const D: usize> {
    reads: [Gathered<D>; BLOCK],
    motions: Motions,
}

impl<const D: usize> Update<'_, D> {
    fn bench(&self) -> Bench<D> {
        let motions = Motions::still(self.dt, self.background.grid.cell, D < 3);
        Bench { reads: [Gathered::ZERO; BLOCK], motions }
    }

    /// Grid to points: velocity, deformation, stress, position (steps 4 to 9), for all points of a body; each block of
    /// points leaves a report.
    pub fn body(&self, body: &mut Body<D>) {
        let Body { points, states, material, reports, width, drop_outside, .. } = body;
        let Columns { position, velocity, affine, volume, stress, work, mass, .. } = points;
        let (material, extent, drop_outside) = (&**material, [*width; D], *drop_outside);
        let blocks = (
            position.par_chunks_mut(BLOCK),
            velocity.par_chunks_mut(BLOCK),
            affine.par_chunks_mut(BLOCK),
            volume.par_chunks_mut(BLOCK),
            stress.par_chunks_mut(BLOCK),
            work.par_chunks_mut(BLOCK),
            mass.par_chunks(BLOCK),
            states.blocks_mut().par_iter_mut(),
            reports.par_iter_mut(),
        );
        blocks.into_par_iter().enumerate().with_min_len(GRAIN).for_each_init(
            || self.bench(),
            |bench, (number, (position, velocity, affine, volume, stress, work, mass, states, report))| {
                let first = number * BLOCK;
                let mut block =
                    Block { first, position, velocity, affine, volume, stress, work, mass, states };
                *report = self.block(&mut block, bench, material, (&extent, drop_outside));
            },
        );
    }

    fn block(
        &self,
        block: &mut Block<'_, D>,
        bench: &mut Bench<D>,
        material: &dyn Material,
        (extent, drop_outside): (&[f64; D], bool),
    ) -> Result<Pace, Failure> {
        let (sweeps, ground) = (self.background.sweeps, self.background.ground());
        let count = block.position.len();
        let (reads, motions) = (&mut bench.reads[..count], &mut bench.motions);
        let points = places(block.position, extent);
        if self.transfer == SnowTransfer::Apic {
            sweeps.gather_both(&ground, &points, self.nodes, true, (reads, block.affine));
        } else {
            sweeps.gather(&ground, &points, self.nodes, reads);
        }
        self.blend(block.velocity, reads);
        let stretches = find_motions(reads, self.deformation, motions);
        if let Some((p, reason)) = motions.change_volumes(&stretches, block.volume, block.mass) {
            return Err(Failure { index: block.first + p, reason });
        }
        let (moved, left) = self.travel(block, reads, drop_outside)?;
        let work = Work::of::<D>(block.stress);
        material.update_block(motions, block.stress, block.states).map_err(|error| {
            let index = block.first + error.index;
            Failure { index, reason: error.source.to_string() }
        })?;
        work.add::<D>(motions, &stretches, (block.volume, block.stress), block.work);
        let points = (&*block.velocity, block.mass, &*block.volume);
        let pace = self.bounds.pace(block.first, material, points, (block.stress, block.states));
        Ok(Pace { moved, left, ..pace })
    }

    /// New velocities of the points: shares of FLIP and PIC.
    fn blend(&self, velocities: &mut [[f64; D]], reads: &[Gathered<D>]) {
        for (own, read) in velocities.iter_mut().zip(reads) {
            let (velocity, acceleration) = (read.velocity.as_array(), read.acceleration.as_array());
            for c in 0..D {
                own[c] = self.flip * (own[c] + self.dt * acceleration[c]) + (1.0 - self.flip) * velocity[c];
            }
        }
    }

    /// Moves the points with the velocity of the grid (step 9); the largest move along an axis (m), and whether a point left.
    fn travel(
        &self,
        block: &mut Block<'_, D>,
        reads: &[Gathered<D>],
        drop_outside: bool,
    ) -> Result<(f64, bool), Failure> {
        let Background { low, high, .. } = self.background;
        let (mut moved, mut inside) = ([0f64; D], true);
        for (position, read) in block.position.iter_mut().zip(reads) {
            let velocity = read.velocity.as_array();
            for c in 0..D {
                let step = self.dt * velocity[c];
                position[c] += step;
                moved[c] = moved[c].max(step.abs());
                // Not where it is no number either.
                inside &= (position[c] >= low[c]) & (position[c] <= high[c]);
            }
        }
        let moved = moved.iter().fold(0f64, |most, step| most.max(*step));
        if inside && moved <= self.longest() {
            return Ok((moved, false));
        }
        Ok((moved, self.look_outside(block, reads, drop_outside)?))
    }

    /// Longest move along an axis in a step (m).
    fn longest(&self) -> f64 {
        0.5 * self.background.grid.cell * (1.0 + 1e-9)
    }

    /// Whether one of the points has left; an error where it must not, or has moved too far.
    #[cold]
    fn look_outside(
        &self,
        block: &Block<'_, D>,
        reads: &[Gathered<D>],
        drop_outside: bool,
    ) -> Result<bool, Failure> {
        let mut left = false;
        for (p, (position, read)) in block.position.iter().zip(reads).enumerate() {
            let velocity = &read.velocity.as_array()[..D];
            let failed = |reason: String| Failure { index: block.first + p, reason };
            let step = velocity.iter().map(|v| (self.dt * v).abs()).fold(0.0, f64::max);
            if !(velocity.iter().all(|v| v.is_finite()) && step <= self.longest()) {
                return Err(failed(format!(
                    "it would move {step:.3e} m in one step, more than half a cell: the run has become unstable (reduce \
                     courant_elastic or time_step)"
                )));
            }
            let outside = self.background.outside(position);
            if outside > 0.0 && !self.is_held(position, outside) {
                if !drop_outside {
                    let reason = "it left the domain: enlarge the domain, add a wall on that side or let the body drop_outside";
                    return Err(failed(reason.to_owned()));
                }
                left = true;
            }
        }
        Ok(left)
    }

    /// Whether a point at most a cell beyond the domain is on its way back from walls there.
    fn is_held(&self, position: &[f64; D], outside: f64) -> bool {
        let Background { low, high, .. } = self.background;
        outside < 1.0
            && (0..D).filter(|axis| !self.background.periodic[*axis]).all(|axis| {
                (position[axis] >= low[axis] || self.boundaries.closes(axis, false))
                    && (position[axis] <= high[axis] || self.boundaries.closes(axis, true))
            })
    }
}
