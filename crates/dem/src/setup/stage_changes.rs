//! Changes at the beginning of a stage.

use std::sync::Arc;

use colluvium_case::SolverError;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::boundary::walls::RigidWall;
use crate::setup::{check_step, pair_laws, stage_walls};
use crate::solver::{ControlledStress, DemSolver};

impl<const D: usize, const R: usize> DemSolver<D, R> {
    /// Prepares the solver for its stage; `fresh` marks the beginning of the stage.
    pub(crate) fn enter_stage(&mut self, fresh: bool) -> Result<(), SolverError> {
        let (step, time, stage) = (self.step, self.time, self.stage);
        let failed = |reason: String| SolverError::Step { step, time, reason };
        let laws = pair_laws::laws(&self.case, &self.options, &self.kinds, &self.grains, stage);
        self.laws = laws.map_err(|error| failed(error.to_string()))?;
        // Walls keep their present positions.
        let standing = stage_walls(self, stage);
        let stands = |wall: &RigidWall<D>| standing.iter().any(|other| other.boundary == wall.boundary);
        let mut next = 0;
        let of_wall = |wall: &RigidWall<D>| {
            next += u32::from(stands(wall));
            if stands(wall) { next - 1 } else { u32::MAX }
        };
        let numbers: Vec<u32> = self.walls.iter().map(of_wall).collect();
        if numbers.contains(&u32::MAX) {
            let grains: Vec<u32> = (0..self.grains.len() as u32).collect();
            self.wall_list.remove(&grains, &numbers, self.columns);
            self.walls.retain(stands);
            self.since_list_build.cell = None;
        }
        let options = self.stage_options();
        for wall in &mut self.walls {
            wall.laws.clone_from(&self.laws.walls[wall.boundary]);
            let Some(own) = standing.iter().find(|other| other.boundary == wall.boundary) else { continue };
            wall.regions.clone_from(&own.regions);
            // A wall that was servo-controlled in the last stage takes the velocity of its boundary.
            if !options.walls.contains_key(&wall.name) {
                wall.velocity = own.velocity;
            }
        }
        check_step(self).map_err(|error| failed(error.to_string()))?;
        if !fresh {
            return Ok(());
        }
        remove(self);
        if options.reset_contacts {
            self.reset_contacts();
        }
        if options.agitation > 0.0 {
            agitate(self, options.agitation);
        }
        self.energy_balance.begin_stage();
        self.controlled_stresses.iter_mut().for_each(ControlledStress::begin_stage);
        // The walls and the largest rupture distance may have changed.
        self.build_lists()
    }
}

/// Removes the grains of bodies that a stage removes, and those with centres in its excavations.
fn remove<const D: usize, const R: usize>(solver: &mut DemSolver<D, R>) {
    let case = Arc::clone(&solver.case);
    let pits = &case.stages[solver.stage].excavate;
    let gone: Vec<bool> = case.bodies.iter().map(|body| case.is_removed(&body.name, solver.stage)).collect();
    let keeps = |body: u32, x: &[f64; D]| !gone[body as usize] && !pits.iter().any(|pit| pit.contains(x));
    let g = &solver.grains;
    if !g.body.iter().zip(&g.position).all(|(body, x)| keeps(*body, x)) {
        solver.retain_grains(keeps);
    }
}

/// Adds a random velocity to all grains, drawn in the order of ids.
fn agitate<const D: usize, const R: usize>(solver: &mut DemSolver<D, R>, speed: f64) {
    let mut random = ChaCha8Rng::seed_from_u64(solver.options.seed ^ (solver.stage as u64 + 1) << 32);
    let g = &mut solver.grains;
    let mut order: Vec<usize> = (0..g.len()).collect();
    order.sort_unstable_by_key(|&i| g.id[i]);
    for i in order {
        for c in 0..D {
            let draw = speed * (2.0 * random.random::<f64>() - 1.0);
            if !g.held[i] {
                g.velocity[i][c] += draw;
            }
        }
    }
    solver.max_speed = solver.max_speed.max(speed * (D as f64).sqrt());
}
