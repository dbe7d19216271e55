//! The transfers between points and grid, and what happens at the points in between (sheet: snow-mpm §3.5).

use colluvium_constitutive::{BLOCK, Mat3, Material, Motion, StateBlock, SymTensor};
use colluvium_grid::{Affine, Deposit, Gathered, Lanes, Node, Square, Window};
use rayon::prelude::*;

use crate::background::Background;
use crate::bodies::{Bodies, Body, Columns, Failure, places, pull};
use crate::config::{DeformationUpdate, SnowTransfer};
use crate::limit::Bounds;
use crate::nodes::Nodes;
use crate::pace::Pace;
use crate::vectors::lanes;
use crate::walls::Boundaries;

/// Blocks that one thread takes at once, at least.
const GRAIN: usize = 4;

/// Points to grid: mass, momentum with its affine part, forces (steps 1 and 2).
pub fn scatter<const D: usize>(
    background: &Background<D>,
    bodies: &Bodies<D>,
    nodes: &mut Nodes,
    transfer: SnowTransfer,
) {
    let ground = background.ground();
    background.layout.scatter(&mut nodes.nodes, |slab, window, first| {
        let mut motion = [Lanes::ZERO; BLOCK];
        let mut columns = [[Lanes::ZERO; D]; BLOCK];
        for body in &bodies.all {
            let (points, extent) = (&body.points, [body.width; D]);
            for block in body.blocks_of(slab) {
                for (k, p) in block.clone().enumerate() {
                    motion[k] = lanes(&points.velocity[p], points.mass[p], points.mass[p]);
                    columns[k] = pull(&points.stress[p], points.volume[p]);
                }
                let affine = Affine {
                    moments: true,
                    fields: &points.affine[block.clone()],
                    mass: &points.mass[block.clone()],
                };
                let given = Deposit {
                    motion: &motion[..block.len()],
                    columns: &columns[..block.len()],
                    body: &[],
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

impl<const D: usize> Update<'_, D> {
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
        blocks.into_par_iter().with_min_len(GRAIN).enumerate().for_each(
            |(number, (position, velocity, affine, volume, stress, work, mass, states, report))| {
                let first = number * BLOCK;
                let mut block =
                    Block { first, position, velocity, affine, volume, stress, work, mass, states };
                *report = self.block(&mut block, material, &extent, drop_outside);
            },
        );
    }

    fn block(
        &self,
        block: &mut Block<'_, D>,
        material: &dyn Material,
        extent: &[f64; D],
        drop_outside: bool,
    ) -> Result<Pace, Failure> {
        let (sweeps, ground) = (self.background.sweeps, self.background.ground());
        let count = block.position.len();
        let mut all = [Gathered::ZERO; BLOCK];
        let reads = &mut all[..count];
        let points = places(block.position, extent);
        if self.transfer == SnowTransfer::Apic {
            sweeps.gather_both(&ground, &points, self.nodes, true, (reads, block.affine));
        } else {
            sweeps.gather(&ground, &points, self.nodes, reads);
        }
        let cell = self.background.grid.cell;
        let mut motions = [Motion { dt: self.dt, size: cell, ..Motion::STILL }; BLOCK];
        let motions = &mut motions[..count];
        let mut stretches = [1.0; BLOCK];
        for (p, read) in reads.iter().enumerate() {
            let (velocity, acceleration) = (read.velocity.as_array(), read.acceleration.as_array());
            for c in 0..D {
                let own = block.velocity[p][c];
                block.velocity[p][c] =
                    self.flip * (own + self.dt * acceleration[c]) + (1.0 - self.flip) * velocity[c];
            }
            let (gradient, deformation) = self.deform(&read.gradient);
            let stretch = deformation.determinant();
            (motions[p].gradient, motions[p].deformation) = (gradient, deformation);
            // Written so that NaN counts as a failure.
            if !(stretch > 0.0) {
                let reason = format!("the step would turn it inside out (volume ratio {stretch})");
                return Err(Failure { index: block.first + p, reason });
            }
            stretches[p] = stretch;
            block.volume[p] *= stretch;
            motions[p].density = block.mass[p] / block.volume[p];
        }
        let (moved, left) = self.travel(block, reads, drop_outside)?;
        let mut before = [SymTensor::ZERO; BLOCK];
        before[..count].copy_from_slice(block.stress);
        material.update(motions, block.stress, block.states).map_err(|error| {
            let index = block.first + error.index;
            Failure { index, reason: error.source.to_string() }
        })?;
        add_work(motions, &stretches, &before, block);
        let points = (&*block.velocity, block.mass, &*block.volume);
        let pace = self.bounds.pace(block.first, material, points, (block.stress, block.states));
        Ok(Pace { moved, left, ..pace })
    }

    /// Gradient and deformation of the step from the columns of the velocity gradient (step 4).
    #[inline(always)]
    fn deform(&self, columns: &[Lanes; D]) -> (Mat3, Mat3) {
        let mut gradient = Mat3::ZERO;
        for j in 0..D {
            let column = (columns[j] * self.dt).to_array();
            for i in 0..D {
                gradient.0[i][j] = column[i];
            }
        }
        let deformation = match self.deformation {
            DeformationUpdate::Linear => Mat3::IDENTITY + gradient,
            DeformationUpdate::Exponential => exponential(&gradient),
        };
        (gradient, deformation)
    }

    /// Moves the points with the velocity of the grid (step 9); the largest move along an axis (m), and whether a point left.
    fn travel(
        &self,
        block: &mut Block<'_, D>,
        reads: &[Gathered<D>],
        drop_outside: bool,
    ) -> Result<(f64, bool), Failure> {
        let Background { low, high, .. } = self.background;
        let (cell, mut moved, mut left) = (self.background.grid.cell, 0f64, false);
        for (p, (position, read)) in block.position.iter_mut().zip(reads).enumerate() {
            let velocity = read.velocity.as_array();
            let (mut step, mut sum) = (0f64, 0.0);
            for v in &velocity[..D] {
                step = step.max((self.dt * v).abs());
                // NaN and infinity make the product NaN.
                sum += v * 0.0;
            }
            let failed = |reason: String| Failure { index: block.first + p, reason };
            if !(sum == 0.0 && step <= 0.5 * cell * (1.0 + 1e-9)) {
                return Err(failed(format!(
                    "it would move {step:.3e} m in one step, more than half a cell: the run has become unstable (reduce \
                     courant_elastic or time_step)"
                )));
            }
            (0..D).for_each(|c| position[c] += self.dt * velocity[c]);
            moved = moved.max(step);
            let mut inside = true;
            for c in 0..D {
                inside &= (position[c] >= low[c]) & (position[c] <= high[c]);
            }
            if !inside && !self.is_held(position, self.background.outside(position)) {
                if !drop_outside {
                    let reason = "it left the domain: enlarge the domain, add a wall on that side or let the body drop_outside";
                    return Err(failed(reason.to_owned()));
                }
                left = true;
            }
        }
        Ok((moved, left))
    }

    /// Whether a point at most a cell beyond the domain is on its way back from walls there.
    fn is_held(&self, position: &[f64; D], outside: f64) -> bool {
        let Background { low, high, .. } = self.background;
        outside < 1.0
            && (0..D).all(|axis| {
                (position[axis] >= low[axis] || self.boundaries.closes(axis, false))
                    && (position[axis] <= high[axis] || self.boundaries.closes(axis, true))
            })
    }
}

/// Adds the work of the stresses in the step (J): the mean of `V σ` before and after on the strain increment, to the second
/// order in the step.
fn add_work<const D: usize>(
    motions: &[Motion],
    stretches: &[f64; BLOCK],
    before: &[SymTensor; BLOCK],
    block: &mut Block<'_, D>,
) {
    for (p, motion) in motions.iter().enumerate() {
        let volume = block.volume[p];
        let started = volume / stretches[p];
        let mean = before[p] * (0.5 * started) + block.stress[p] * (0.5 * volume);
        // The logarithmic strain of the step, to the third order; nothing outside the axes that there are.
        let (gradient, mut squared) = (&motion.gradient.0, [[0.0; 3]; 3]);
        for i in 0..D {
            for j in 0..D {
                for k in 0..D {
                    squared[i][j] += gradient[i][k] * gradient[k][j];
                }
            }
        }
        block.work[p] += mean.dot(&(motion.gradient - Mat3(squared) * 0.5).sym());
    }
}

/// `exp a`, to the fourth order.
fn exponential(a: &Mat3) -> Mat3 {
    let one = Mat3::IDENTITY;
    one + *a * (one + *a * (one + *a * (one + *a * 0.25) * (1.0 / 3.0)) * 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_without_the_exponential_strain_what_spins() {
        // Sheet: snow-mpm V3: each principal logarithmic strain after a turn, `N/2 ln(1 + (2π/N)²)`.
        for (steps, exact) in [(100, 0.197_003_474_1), (1000, 0.019_738_819_2), (10_000, 0.001_973_920_5)] {
            let angle = 2.0 * std::f64::consts::PI / f64::from(steps);
            let spin = Mat3([[0.0, -angle, 0.0], [angle, 0.0, 0.0], [0.0; 3]]);
            let turned = (0..steps).fold(Mat3::IDENTITY, |f, _| (Mat3::IDENTITY + spin) * f);
            let strain = 0.5 * turned.determinant().ln();
            assert!((strain - exact).abs() < 1e-9, "{steps}: {strain}");
        }
    }

    #[test]
    fn a_thousand_small_spins_make_a_turn_without_strain() {
        let angle = 2.0 * std::f64::consts::PI / 1000.0;
        let spin = Mat3([[0.0, -angle, 0.0], [angle, 0.0, 0.0], [0.0; 3]]);
        let step = exponential(&spin);
        let turned = (0..1000).fold(Mat3::IDENTITY, |f, _| step * f);
        for (i, row) in turned.0.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                assert!((value - if i == j { 1.0 } else { 0.0 }).abs() < 1e-8, "{turned:?}");
            }
        }
    }
}
