//! Verlet lists of neighbours, and the images and walls in them (sheet: sph §3.3, step 1).

use colluvium_case::SolverError;
use colluvium_points::{CellList, NeighbourList, ScratchBuffers};
use rayon::prelude::*;

use crate::clock::Clock;
use crate::config::WallStress;
use crate::context::SolverContext;
use crate::points::particles::{Bodies, MIN_PARTICLES_PER_TASK, Particles};
use crate::points::vector_algebra::square;
use crate::rates::Rates;
use crate::walls::Walls;
use colluvium_case::FailureReason;

/// Least number of steps between two sorts by cell.
const STEPS_PER_SORT: u64 = 100;
/// Relative margin of the neighbour lists beyond the kernel support. Lists are valid until a particle has moved by half of it.
const SKIN: f64 = 0.1;

/// Positions of the last neighbour list.
#[derive(Clone, Debug, Default)]
pub struct ListedPositions<const D: usize> {
    /// Positions of the particles (m); empty without a list.
    pub positions: Vec<[f64; D]>,
    /// Time of the list, for moving walls (s).
    pub time: f64,
    /// Distance within which neighbours are listed (m).
    pub list_radius: f64,
}

/// Neighbours of each particle, and the weights of the pairs.
pub struct VerletLists<const D: usize> {
    /// Neighbours of each particle.
    pub neighbours: NeighbourList<D>,
    /// Kernel weights of the pairs, stored like the neighbours.
    pub weights: Vec<Vec<f64>>,
    /// Whether the stored weights are those of the current positions.
    pub weights_current: bool,
    /// Positions of the particles when the lists were built.
    pub listed_positions: ListedPositions<D>,
    /// Step of the last sort.
    pub last_sort: Option<u64>,
    cells: CellList<D>,
    scratch: ScratchBuffers,
}

impl<const D: usize> VerletLists<D> {
    /// Returns empty lists for the positions `listed_positions`, after a sort in step `last_sort`.
    pub fn new(listed_positions: ListedPositions<D>, last_sort: Option<u64>) -> Self {
        Self {
            neighbours: NeighbourList::new(),
            weights: Vec::new(),
            weights_current: false,
            listed_positions,
            last_sort,
            cells: CellList::new(),
            scratch: ScratchBuffers::default(),
        }
    }

    /// Returns a copy without lists and positions.
    pub fn empty_like(&self) -> Self {
        let listed = ListedPositions { positions: Vec::new(), ..self.listed_positions };
        Self { weights_current: self.weights_current, ..Self::new(listed, self.last_sort) }
    }

    /// Updates neighbour lists, image particles and wall particles (step 1); lists are rebuilt if particles have moved too far. Particles
    /// may be sorted and moved across periodic boundaries only if `at_step_start` is true.
    pub fn refresh(
        &mut self,
        setting: &SolverContext<D>,
        clock: &Clock,
        bodies: &mut Bodies<D>,
        walls: &mut Walls<D>,
        rates: &mut Rates<D>,
        at_step_start: bool,
    ) -> Result<(), SolverError> {
        bodies.follow_density(setting);
        let support = setting.support(bodies.max_smoothing_length(setting));
        if self.is_outdated(setting, clock, &bodies.particles, walls, support) {
            if at_step_start {
                let p = &mut bodies.particles;
                walls.planes.wrap_into_period(&mut p.position[..p.id.len()], &mut p.origin);
                if self.is_sort_due(clock) {
                    self.sort(setting, clock, bodies, rates)?;
                    self.last_sort = Some(clock.step);
                }
            }
            self.set_list_positions(setting, clock, &bodies.particles, support);
            rates.is_current = false;
            self.build(setting, clock, bodies, walls)?;
        }
        self.place_images_and_walls(setting, clock, bodies, walls, support)
    }

    /// Updates the positions of images and walls, and the obstacle faces close to particles.
    ///
    /// # Errors
    /// When a particle lies deep in an obstacle.
    pub fn place_images_and_walls(
        &mut self,
        setting: &SolverContext<D>,
        clock: &Clock,
        bodies: &mut Bodies<D>,
        walls: &mut Walls<D>,
        support: f64,
    ) -> Result<(), SolverError> {
        walls.place_at_time(clock.time, &mut bodies.particles);
        let p = &bodies.particles;
        walls.obstacles.find_faces(&p.position[..p.len()], support);
        self.weights_current = false;
        match walls.obstacles.first_inside(0.5 * setting.options.spacing) {
            None => Ok(()),
            Some((i, name)) => {
                let reason = FailureReason::coded(
                    "passed-wall",
                    format!(
                        "it passed the surface of the obstacle {name:?}, which stops particles. Check where the \
                     obstacle is thinner or more curved than a spacing"
                    ),
                );
                Err(p.particle_error(clock, i, reason))
            }
        }
    }

    /// Whether neighbours within the radius `support` (m) may be missing.
    fn is_outdated(
        &self,
        setting: &SolverContext<D>,
        clock: &Clock,
        particles: &Particles<D>,
        walls: &Walls<D>,
        support: f64,
    ) -> bool {
        self.listed_positions.positions.len() != particles.len()
            || self.max_approach(setting, clock, particles, walls) + support
                > self.listed_positions.list_radius
    }

    /// Whether particles are to be sorted by cell when they are next listed.
    pub fn is_sort_due(&self, clock: &Clock) -> bool {
        self.last_sort.is_none_or(|step| clock.step >= step + STEPS_PER_SORT)
    }

    /// Sets the reference positions of the next lists to the current ones, with a margin on the radius `support` (m).
    pub fn set_list_positions(
        &mut self,
        setting: &SolverContext<D>,
        clock: &Clock,
        particles: &Particles<D>,
        support: f64,
    ) {
        let listed = &mut self.listed_positions;
        listed.positions.clear();
        listed.positions.extend_from_slice(&particles.position[..particles.len()]);
        (listed.time, listed.list_radius) =
            (clock.time, support * (1.0 + SKIN) + setting.options.max_shift_approach());
    }

    /// Largest approach of two particles since they were listed, with the shift before the step (m).
    pub fn max_approach(
        &self,
        setting: &SolverContext<D>,
        clock: &Clock,
        particles: &Particles<D>,
        walls: &Walls<D>,
    ) -> f64 {
        let pairs = particles.position[..particles.len()].par_iter().zip(&self.listed_positions.positions);
        let of_pair = |(x, old): (&[f64; D], &[f64; D])| {
            let apart: [f64; D] = std::array::from_fn(|c| x[c] - old[c]);
            let square = square(&apart);
            if square.is_finite() { square } else { f64::INFINITY }
        };
        let farthest =
            pairs.with_min_len(8 * MIN_PARTICLES_PER_TASK).map(of_pair).reduce(|| 0.0, f64::max).sqrt();
        // A mirror moves its images twice as far.
        let wall = 2.0 * walls.planes.max_displacement(self.listed_positions.time, clock.time);
        let wall = wall.max(walls.obstacles.max_displacement(self.listed_positions.time, clock.time));
        2.0 * farthest + wall + setting.options.max_shift_approach()
    }

    /// Builds images and neighbour lists at the listed positions.
    pub fn build(
        &mut self,
        setting: &SolverContext<D>,
        clock: &Clock,
        bodies: &mut Bodies<D>,
        walls: &mut Walls<D>,
    ) -> Result<(), SolverError> {
        let ListedPositions { positions, time, list_radius } = &self.listed_positions;
        let pairwise = setting.options.wall_stress == WallStress::Pairwise;
        // Extrapolated walls extend beyond periodic boundaries, and use the soil further out.
        let asks = !pairwise && !walls.planes.periods.is_empty();
        walls.find_images(positions, *time, if asks { 2.0 * list_radius } else { *list_radius });
        walls.obstacles.list_candidates(positions, *list_radius);
        let len = bodies.particles.len();
        walls.smooth_bodies.find_ranges(&bodies.groups, len, &walls.images);
        let total = walls.first(len) + walls.planes.particles.len();
        bodies.resize(total);
        let p = &mut bodies.particles;
        p.length[len..].fill(setting.smoothing.length());
        // After a restart particles are not at their listed positions.
        let current = (p.position[..len] != positions[..]).then(|| p.position[..len].to_vec());
        p.position[..len].copy_from_slice(positions);
        walls.place_all(p);
        let (x, count, first) = (&p.position, if pairwise { len } else { total }, walls.first(len));
        let parts = |i: usize, j: usize| {
            let other = (Some(j).filter(|j| *j < len), &x[j]);
            j < first && walls.obstacles.separates((i, &x[i]), other, setting.options.spacing)
        };
        let keeps = |i: u32, j: u32| !parts(i as usize, j as usize);
        let built = self.neighbours.build_first(x, count, *list_radius, keeps);
        if let Some(current) = current {
            p.position[..current.len()].copy_from_slice(&current);
        }
        built.map_err(|error| p.particle_error(clock, 0, format!("neighbour search: {error}")))?;
        let blocks = self.neighbours.blocks();
        self.weights.resize_with(blocks.len(), Vec::new);
        self.weights.iter_mut().zip(blocks).for_each(|(weights, rows)| {
            weights.resize(rows.indices().len(), 0.0);
        });
        self.weights_current = false;
        Ok(())
    }

    /// Sorts the particles of each body by cell.
    fn sort(
        &mut self,
        setting: &SolverContext<D>,
        clock: &Clock,
        bodies: &mut Bodies<D>,
        rates: &mut Rates<D>,
    ) -> Result<(), SolverError> {
        for group in &mut bodies.groups {
            let (range, p) = (group.range(), &mut bodies.particles);
            let built = self.cells.build(&p.position[range.clone()], setting.smoothing.radius());
            built.map_err(|error| {
                p.particle_error(clock, range.start, format!("neighbour search: {error}"))
            })?;
            let order = self.cells.order();
            if order.iter().enumerate().all(|(i, &old)| i == old as usize) {
                continue;
            }
            p.reorder_range(range.clone(), order, &mut self.scratch);
            // Rates of the previous step, used by one of the schemes for prediction.
            rates.derivatives.reorder_range(range, order, &mut self.scratch);
            group.states = group.states.permuted(order);
        }
        Ok(())
    }
}
