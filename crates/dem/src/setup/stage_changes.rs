//! Changes at the beginning of a stage.

use colluvium_case::{CaseError, SolverError};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::boundary::boundary_conditions::BoundaryConditions;
use crate::boundary::walls::RigidWall;
use crate::clock::Clock;
use crate::contact::contact_laws::{ContactLaws, GrainSizes};
use crate::neighbours::grain_neighbours::GrainNeighbours;
use crate::output::stress_control_check::ControlledStress;
use crate::points::grain_extremes::GrainExtremes;
use crate::points::grains::Grains;
use crate::setup::pair_laws;
use crate::setup::start_checks::check_step;
use crate::setup::walls::stage_walls;
use crate::solver::DemSolver;

/// Prepares the solver for its stage; `is_new` marks the beginning of the stage.
pub(crate) fn enter_stage<const D: usize, const R: usize>(
    solver: &mut DemSolver<D, R>,
    is_new: bool,
) -> Result<(), SolverError> {
    let DemSolver { clock, laws, grains, extremes, boundary, neighbours, records, .. } = solver;
    let failed = |error: CaseError| SolverError::Step {
        step: clock.step,
        time: clock.time,
        reason: error.to_string().into(),
    };
    if is_new {
        remove_grains(clock, laws, grains, boundary, neighbours);
        laws.sizes = GrainSizes::of_grains(grains, laws.kinds.len());
    }
    laws.stage = pair_laws::laws::<D>(&clock.case, &clock.options, &laws.kinds, &laws.sizes, clock.stage)
        .map_err(failed)?;
    update_walls(clock, laws, grains.len(), boundary, neighbours);
    check_step(clock, laws).map_err(failed)?;
    if !is_new {
        return Ok(());
    }
    let options = clock.stage_options().cloned().unwrap_or_default();
    if options.reset_contacts {
        neighbours.reset_contacts();
    }
    if options.agitation > 0.0 {
        add_random_velocity(clock, grains, extremes, options.agitation);
    }
    records.energy_balance.begin_stage();
    records.controlled_stresses.iter_mut().for_each(ControlledStress::begin_stage);
    // The walls and the largest rupture distance may have changed.
    solver.build_lists()
}

/// Removes the walls that the stage does not have, and sets the contact laws of the others at their current positions.
fn update_walls<const D: usize, const R: usize>(
    clock: &Clock,
    laws: &ContactLaws,
    count: usize,
    boundary: &mut BoundaryConditions<D>,
    neighbours: &mut GrainNeighbours<D, R>,
) {
    let next = stage_walls(&clock.case, &laws.stage, &boundary.obstacles, clock.stage);
    let remains = |wall: &RigidWall<D>| next.iter().any(|other| other.boundary == wall.boundary);
    let mut number = 0;
    let of_wall = |wall: &RigidWall<D>| {
        number += u32::from(remains(wall));
        if remains(wall) { number - 1 } else { u32::MAX }
    };
    let numbers: Vec<u32> = boundary.walls.iter().map(of_wall).collect();
    if numbers.contains(&u32::MAX) {
        let grains: Vec<u32> = (0..count as u32).collect();
        neighbours.walls.remove(&grains, &numbers, laws.columns);
        boundary.walls.retain(remains);
        neighbours.since_build.cell = None;
    }
    for wall in &mut boundary.walls {
        wall.laws.clone_from(&laws.stage.walls[wall.boundary]);
        let Some(own) = next.iter().find(|other| other.boundary == wall.boundary) else { continue };
        wall.regions.clone_from(&own.regions);
        // A wall that was servo-controlled in the last stage takes the velocity of its boundary, unless a program moves it.
        let is_controlled = clock.stage_options().is_some_and(|stage| stage.walls.contains_key(&wall.name));
        if !is_controlled && wall.program_velocity.is_none() {
            wall.velocity = own.velocity;
        }
    }
}

/// Removes the grains of bodies that a stage removes, and those with centres in its excavations.
fn remove_grains<const D: usize, const R: usize>(
    clock: &Clock,
    laws: &ContactLaws,
    grains: &mut Grains<D, R>,
    boundary: &mut BoundaryConditions<D>,
    neighbours: &mut GrainNeighbours<D, R>,
) {
    let case = &clock.case;
    let pits = &case.stages[clock.stage].excavate;
    let removed: Vec<bool> =
        case.bodies.iter().map(|body| case.is_removed(&body.name, clock.stage)).collect();
    let keeps = |body: u32, x: &[f64; D]| !removed[body as usize] && !pits.iter().any(|pit| pit.contains(x));
    if !grains.body.iter().zip(&grains.position).all(|(body, x)| keeps(*body, x)) {
        neighbours.retain_grains(laws, grains, boundary.walls.len(), |grains, i| {
            keeps(grains.body[i], &grains.position[i])
        });
        boundary.membranes.clear();
    }
}

/// Adds a random velocity to all grains, drawn in the order of ids.
fn add_random_velocity<const D: usize, const R: usize>(
    clock: &Clock,
    g: &mut Grains<D, R>,
    extremes: &mut GrainExtremes,
    speed: f64,
) {
    let mut random = ChaCha8Rng::seed_from_u64(clock.options.seed ^ (clock.stage as u64 + 1) << 32);
    let mut order: Vec<usize> = (0..g.len()).collect();
    order.sort_unstable_by_key(|&i| g.id[i]);
    for i in order {
        for c in 0..D {
            let draw = speed * (2.0 * random.random::<f64>() - 1.0);
            if !g.is_held[i] {
                g.velocity[i][c] += draw;
            }
        }
    }
    extremes.max_speed = extremes.max_speed.max(speed * (D as f64).sqrt());
}
