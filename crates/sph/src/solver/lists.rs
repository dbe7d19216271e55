//! Lists of neighbours, and what stands in them beside the particles: images and walls (SPH sheet §3.3, step 1).

use colluvium_case::SolverError;
use rayon::prelude::*;

use super::{SphSolver, TASK, square};
use crate::config::WallStress;

/// Least number of steps between two sorts by cell.
const STEPS_PER_SORT: u64 = 100;
/// Margin of the neighbour lists over the radius of the support: lists last until a particle has moved by
/// half of it.
const SKIN: f64 = 0.1;

/// For which places the neighbour list was made.
#[derive(Clone, Debug, Default)]
pub struct Listed<const D: usize> {
    /// Positions of the particles; empty where there is no list (m).
    pub positions: Vec<[f64; D]>,
    /// Time, where walls move (s).
    pub time: f64,
    /// Distance within which neighbours are listed (m).
    pub reach: f64,
}

impl<const D: usize> SphSolver<D> {
    /// Step 1: lists where particles have moved too far for the last ones; images and walls in their places.
    /// Particles may change their order, and their period, when a step begins, and not within it.
    pub(crate) fn refresh_neighbours(&mut self, begins: bool) -> Result<(), SolverError> {
        self.follow_density();
        let support = self.smoothing.kernel().support() * self.longest();
        if self.listed.positions.len() != self.particles.len || self.reached() + support > self.listed.reach {
            if begins {
                self.wrap();
                if self.is_sort_due() {
                    self.sort()?;
                    self.sorted = Some(self.step);
                }
            }
            self.list_from_here(support);
            self.make_lists()?;
        }
        self.place();
        Ok(())
    }

    /// Particles that left a periodic domain back into it.
    pub(crate) fn wrap(&mut self) {
        let p = &mut self.particles;
        self.walls.wrap(&mut p.position[..p.len], &mut p.origin);
    }

    pub(crate) fn is_sort_due(&self) -> bool {
        self.sorted.is_none_or(|step| self.step >= step + STEPS_PER_SORT)
    }

    /// Lists are to be made for the places where the particles are now, with a margin over the radius `support` (m).
    pub(crate) fn list_from_here(&mut self, support: f64) {
        let listed = &mut self.listed;
        listed.positions.clear();
        listed.positions.extend_from_slice(&self.particles.position[..self.particles.len]);
        (listed.time, listed.reach) = (self.time, support * (1.0 + SKIN) + self.options.room_to_shift());
        self.accelerated = false;
    }

    /// Images and walls in their places.
    pub(crate) fn place(&mut self) {
        self.walls.go_to(self.time, &mut self.images);
        self.particles.place(&self.images, &self.walls);
        self.weighed = false;
    }

    /// How much closer two particles may be than when they were listed, shifted before the step as they may be (m).
    pub(crate) fn reached(&self) -> f64 {
        let pairs = self.particles.position[..self.particles.len].par_iter().zip(&self.listed.positions);
        let moved = pairs.with_min_len(8 * TASK).map(|(x, old)| {
            let apart: [f64; D] = std::array::from_fn(|c| x[c] - old[c]);
            let square = square(&apart);
            if square.is_finite() { square } else { f64::INFINITY }
        });
        let farthest = moved.reduce(|| 0.0, f64::max).sqrt();
        // A mirror moves its images twice as far.
        let wall = 2.0 * self.walls.moved(self.listed.time, self.time);
        2.0 * farthest + wall + self.options.room_to_shift()
    }

    /// The largest smoothing length (m).
    pub(crate) fn longest(&self) -> f64 {
        if !self.options.is_variable() {
            return self.smoothing.length();
        }
        self.particles.length[..self.particles.len].iter().copied().fold(0.0, f64::max)
    }

    /// Images and neighbours of the listed positions.
    pub(crate) fn make_lists(&mut self) -> Result<(), SolverError> {
        let Listed { positions, time, reach } = &self.listed;
        // Walls that interpolate go on beyond the ends of periods, and ask the soil still further out.
        let asks = self.options.wall_stress != WallStress::Pairwise && !self.walls.periods.is_empty();
        let depth = if asks { 2.0 * reach } else { *reach };
        self.walls.go_to(*time, &mut []);
        self.walls.images(positions, depth, &mut self.images);
        self.smooth.find(&self.groups, self.particles.len, &self.images);
        let p = &mut self.particles;
        let first_wall = p.len + self.images.len();
        let total = first_wall + self.walls.particles.len();
        p.resize(total);
        p.length[p.len..].fill(self.smoothing.length());
        // After a restart particles are no longer where they were listed.
        let current = (p.position[..p.len] != positions[..]).then(|| p.position[..p.len].to_vec());
        p.position[..p.len].copy_from_slice(positions);
        p.place(&self.images, &self.walls);
        let rows = if self.options.wall_stress == WallStress::Pairwise { p.len } else { total };
        let built = self.neighbours.build_first(&p.position, rows, *reach);
        if let Some(current) = current {
            p.position[..current.len()].copy_from_slice(&current);
        }
        built.map_err(|error| self.failed(0, format!("neighbour search: {error}")))?;
        let blocks = self.neighbours.blocks();
        self.weights.resize_with(blocks.len(), Vec::new);
        self.weights.iter_mut().zip(blocks).for_each(|(weights, rows)| {
            weights.resize(rows.indices().len(), 0.0);
        });
        self.weighed = false;
        Ok(())
    }

    /// Sorts the particles of each body by cell.
    fn sort(&mut self) -> Result<(), SolverError> {
        for number in 0..self.groups.len() {
            let range = self.groups[number].range();
            let built = self.cells.build(&self.particles.position[range.clone()], self.smoothing.radius());
            built.map_err(|error| self.failed(range.start, format!("neighbour search: {error}")))?;
            let order = self.cells.order();
            if order.iter().enumerate().all(|(i, &old)| i == old as usize) {
                continue;
            }
            self.particles.permute(range, order);
            let group = &mut self.groups[number];
            group.states = group.states.permuted(order);
        }
        Ok(())
    }
}
