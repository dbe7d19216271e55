//! Solver with its components, and one step.

use std::sync::Arc;

use colluvium_case::{Manufactured, SolverError, TimeStep, limit_step_by_obstacles};
use colluvium_grid::NodeWalls;

use crate::boundary::boundary_conditions::BoundaryConditions;
use crate::boundary::nodal_loads::nodal_load_work;
use crate::boundary::point_loads::update_follower_loads;
use crate::boundary::prescribed_motion;
use crate::boundary::prescribed_motion::DrivenObject;
use crate::boundary::rigid_bodies;
use crate::boundary::rigid_bodies::{move_driven, update_driven_velocities};
use crate::clock::Clock;
use crate::config::StressScheme;
use crate::contact::contact_correction::correct_velocities;
use crate::contact::contact_law::FieldContacts;
use crate::momentum::consistent_mass;
use crate::momentum::consistent_mass::ConsistentMass;
use crate::momentum::small_mass_nodes::rescale_small_mass_forces;
use crate::momentum::velocity_fields::VelocityFields;
use crate::momentum::velocity_fields::VelocitySource::{Remapped, Solved};
use crate::momentum::{EquilibriumAudit, EquilibriumTerms, MomentumSolve, damp};
use crate::obstacles::penetration_limit::{limit_remapped, limit_solved};
use crate::phases::{TwoPhase, step_phases};
use crate::points::bodies::Bodies;
use crate::points::point_update::{UpdateSelection, update_points};
use crate::points::vectors::{first_three, power};
use crate::setup::manufactured::set_body_forces;
use crate::stress::averages::CellAverages;
use crate::stress::free_surface::free_surface_correction;
use crate::stress::volumetric_strain::average_strains_of_one_phase;
use crate::transfer::affine_transfer::g2p_affine;
use crate::transfer::background_grid::BackgroundGrid;
use crate::transfer::p2g::{P2gContent, p2g, remap, start_velocities};
use crate::transfer::xpic::filter_velocities;

/// Steps between re-evaluations of the critical time step.
pub(crate) const STEPS_PER_TIME_STEP: u64 = 10;

/// Largest displacement of an obstacle in a step (cells), so that contact begins before it has passed points.
const MAX_OBSTACLE_MOVE: f64 = 0.25;

/// Explicit MPM in `D` dimensions.
pub struct MpmSolver<const D: usize> {
    pub(crate) clock: Clock,
    pub(crate) background: BackgroundGrid<D>,
    pub(crate) bodies: Bodies<D>,
    pub(crate) nodes: VelocityFields,
    pub(crate) boundary: BoundaryConditions<D>,
    pub(crate) averages: CellAverages<D>,
    pub(crate) consistent: ConsistentMass,
    /// Both phases of the nodes; `None` in a case without pore fluid.
    pub(crate) two_phase: Option<Box<TwoPhase>>,
    /// Manufactured solution for verification, whose body force acts on the points.
    pub(crate) manufactured: Option<Arc<Manufactured>>,
}

impl<const D: usize> MpmSolver<D> {
    /// Advances one step (sheet: mpm §3.3); the numbers are those of the sheet.
    pub(crate) fn advance(&mut self, dt: f64) -> Result<(), SolverError> {
        self.clock.begin(dt)?;
        self.sort_if_moved(); // 0: cells, weights
        let Self {
            clock,
            background,
            bodies,
            nodes,
            boundary,
            averages,
            consistent,
            two_phase,
            manufactured,
        } = self;
        nodes.reset(&background.layout); // 0: empty grid
        boundary.node_obstacles.update_faces((clock.time, clock.dt), background, &mut boundary.walls);
        update_driven_velocities(clock, bodies, &mut boundary.driven);
        if let (Some(solution), None) = (manufactured, &two_phase) {
            set_body_forces(solution, bodies, clock.time);
        }
        let moved = match two_phase {
            Some(phases) => step_phases(clock, background, bodies, nodes, boundary, averages, phases)?,
            None => step(clock, background, bodies, nodes, boundary, averages, consistent)?,
        };
        // 10
        let driven = move_driven(clock, background, bodies, &mut boundary.driven)?;
        bodies.travel += moved.max(driven);
        boundary.walls.set_starts_moving(false);
        if bodies.remove_outside_points() {
            self.sort();
        }
        self.bodies.wrap(&self.background);
        self.clock.end();
        Ok(())
    }

    fn sort_if_moved(&mut self) {
        if self.bodies.travel >= self.background.grid.cell {
            self.sort();
        }
    }

    /// Sorts all points by cell and finds the active nodes.
    pub(crate) fn sort(&mut self) {
        let Self { background, bodies, nodes, averages, consistent, two_phase, .. } = self;
        // Nodes outside the new active region would keep their values.
        nodes.reset(&background.layout);
        nodes.reset_remapped(&background.layout);
        averages.reset(background);
        consistent.reset(&background.layout);
        if let Some(phases) = two_phase {
            phases.reset(&background.layout);
        }
        bodies.sort(background);
        self.find_active_nodes();
    }

    /// Finds active nodes and slab bounds from the sorted points.
    pub(crate) fn find_active_nodes(&mut self) {
        self.bodies.find_active_nodes(&mut self.background);
        if let Some(phases) = &mut self.two_phase {
            phases.find_heaviest(&self.bodies);
        }
    }

    /// Returns the largest stable step from the current state (sheet: mpm §2.10).
    pub(crate) fn critical_step(&mut self) -> TimeStep {
        if self.clock.limit.is_none() || self.clock.limit_age >= STEPS_PER_TIME_STEP {
            let fixed = self.clock.options.time_step;
            let courant = if fixed.is_some() { 1.0 } else { self.clock.options.courant };
            let limit = self.wave_limit(courant);
            let most = courant.min(self.clock.options.surface_courant(D));
            self.clock.courant = fixed.map_or(most, |step| most * (step / limit.dt).min(1.0));
            self.clock.limit = Some(self.limit_by_obstacle_motion(limit).or_fixed(fixed));
            self.clock.limit_age = 0;
        }
        self.clock.limit.expect("set above")
    }

    /// Limits the critical step, so that no obstacle moves farther than [`MAX_OBSTACLE_MOVE`].
    fn limit_by_obstacle_motion(&self, critical: TimeStep) -> TimeStep {
        let BoundaryConditions { penalty_obstacles: rocks, node_obstacles: held, .. } = &self.boundary;
        let moving = rocks.iter().flat_map(|rocks| rocks.moving()).chain(held.moving.iter());
        let most = MAX_OBSTACLE_MOVE * self.clock.options.cell_size;
        limit_step_by_obstacles(critical, moving, (self.clock.time, most, STEPS_PER_TIME_STEP + 1))
    }
}

/// Runs steps 1 to 9 of one phase; returns the largest displacement of a point along an axis (m).
fn step<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &mut Bodies<D>,
    nodes: &mut VelocityFields,
    boundary: &mut BoundaryConditions<D>,
    averages: &mut CellAverages<D>,
    consistent: &mut ConsistentMass,
) -> Result<f64, SolverError> {
    let (all, velocity, stress) = (UpdateSelection::ALL, UpdateSelection::VELOCITY, UpdateSelection::STRESS);
    free_surface_correction(background, bodies, &mut averages.free_surface);
    match clock.options.stress_update {
        StressScheme::Usl => {
            p2g(clock, background, bodies, nodes, boundary, averages, P2gContent::Everything); // 1
            rescale_small_mass_forces(clock, background, bodies, nodes);
            solve_momentum(clock, background, bodies, nodes, boundary, consistent)?; // 2–4
            average_strains_of_one_phase(clock, background, bodies, (nodes, Solved), &mut averages.strains); // 7
            update_follower_loads(clock, background, bodies, (nodes, Solved));
            update_points(clock, background, bodies, (nodes, Solved), boundary, averages, all) // 5, 7–9
        }
        StressScheme::Musl => {
            p2g(clock, background, bodies, nodes, boundary, averages, P2gContent::Everything); // 1
            solve_momentum(clock, background, bodies, nodes, boundary, consistent)?; // 2–4
            update_points(clock, background, bodies, (nodes, Solved), boundary, averages, velocity)?; // 5
            remap(clock, background, bodies, nodes, boundary); // 6
            limit_remapped(
                clock,
                background,
                bodies,
                nodes,
                (&boundary.walls, &mut boundary.penalty_obstacles),
            );
            average_strains_of_one_phase(clock, background, bodies, (nodes, Remapped), &mut averages.strains); // 7
            update_follower_loads(clock, background, bodies, (nodes, Remapped));
            let rest = UpdateSelection { position: true, ..stress };
            update_points(clock, background, bodies, (nodes, Remapped), boundary, averages, rest) // 7–9
        }
        StressScheme::Usf => {
            p2g(clock, background, bodies, nodes, boundary, averages, P2gContent::Motion); // 1, momentum and mass
            start_velocities(clock, background, bodies, nodes, boundary);
            average_strains_of_one_phase(clock, background, bodies, (nodes, Remapped), &mut averages.strains); // 7
            update_points(clock, background, bodies, (nodes, Remapped), boundary, averages, stress)?; // 7–8
            free_surface_correction(background, bodies, &mut averages.free_surface);
            p2g(clock, background, bodies, nodes, boundary, averages, P2gContent::Forces); // 1, forces
            solve_momentum(clock, background, bodies, nodes, boundary, consistent)?; // 2–4
            update_follower_loads(clock, background, bodies, (nodes, Solved));
            let rest = UpdateSelection { position: true, ..velocity };
            update_points(clock, background, bodies, (nodes, Solved), boundary, averages, rest) // 5, 9
        }
    }
}

/// Computes velocities at the end of the step and accelerations of the nodes (steps 2 to 4), and the affine parts of the transfer.
fn solve_momentum<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &mut Bodies<D>,
    nodes: &mut VelocityFields,
    boundary: &mut BoundaryConditions<D>,
    consistent: &mut ConsistentMass,
) -> Result<(), SolverError> {
    if consistent.is_used() {
        return consistent_mass::solve_momentum(
            clock,
            background,
            bodies,
            &mut nodes.solved,
            &boundary.walls,
            consistent,
        );
    }
    let light = bodies.mass_cutoff(clock);
    let BoundaryConditions { walls, driven, contacts, absorbing, reaction_recorder: bearing, .. } =
        &mut *boundary;
    let solve = MomentumSolve {
        dt: clock.dt,
        gravity: clock.gravity_at_end(),
        rayleigh: clock.stage().rayleigh_damping,
        keep_initial_velocity: clock.keeps_initial_velocity(),
        inertia: clock.options.mass_scaling,
        mass_cutoff: light,
        walls,
        layout: &background.layout,
    };
    if let Some(bearing) = bearing {
        bearing.record(&solve, background, &nodes.solved);
    }
    for nodes in nodes.solved.chunks_exact_mut(background.layout.len()) {
        background.layout.for_each_active_node_range(nodes, |row, active, line| solve.row(row, active, line));
    }
    absorbing.apply(clock, &mut nodes.solved, walls);
    rigid_bodies::impose_velocity_of_all_rigid(background, driven, contacts, &mut nodes.solved);
    correct_velocities(clock, background, bodies, &mut nodes.solved, boundary);
    let BoundaryConditions { driven, contacts, .. } = &mut *boundary;
    prescribed_motion::impose_patch_velocity(clock, background, driven, contacts, &mut nodes.solved, true);
    damp_nodes(clock, background, bodies, nodes, boundary);
    let BoundaryConditions { walls, driven, contacts, penalty_obstacles: rocks, .. } = &mut *boundary;
    rigid_bodies::integrate_rigid(clock, driven);
    rigid_bodies::impose_rigid_velocity(background, driven, contacts, &mut nodes.solved);
    limit_solved(clock, background, bodies, &mut nodes.solved, (walls, rocks));
    if clock.stage().equilibrium.is_some() {
        let sums = update_equilibrium(clock, background, bodies, nodes, boundary);
        nodes.external_work += sums.work;
        nodes.sums = sums;
    }
    if clock.options.filters_velocities() {
        filter_velocities(clock, background, bodies, nodes, boundary);
    } else {
        // Bodies with affine fields: all, liquids, or none.
        g2p_affine(clock, background, bodies, nodes);
    }
    Ok(())
}

/// Updates the measures of equilibrium of the step, with the work of loads and motions and the terms of free rigid bodies.
fn update_equilibrium<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &Bodies<D>,
    nodes: &mut VelocityFields,
    boundary: &BoundaryConditions<D>,
) -> EquilibriumTerms {
    let BoundaryConditions { walls, driven, contacts, nodal_loads: nodal, load_starts, .. } = boundary;
    let mut sums = equilibrium_terms(clock, background, bodies.mass_cutoff(clock), nodes, walls, contacts);
    sums.work += work_of_loads(bodies, driven, clock.dt);
    for loose in driven.iter().filter_map(|driven| driven.free_rigid_body.as_ref()) {
        let stage = clock.stage();
        sums.add(&rigid_bodies::equilibrium_terms(
            loose,
            clock.dt,
            &stage.damping_of_axes(),
            stage.rayleigh_damping,
        ));
    }
    sums.work += nodal_load_work(clock, background, bodies, &nodes.solved, nodal, load_starts);
    sums
}

/// Applies local damping. It depends on the unbalanced forces. Forces of walls, of contact, of driven bodies and of the penetration limit
/// are in balance with others, so that damping follows them. Prescribed components are not damped.
fn damp_nodes<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &Bodies<D>,
    nodes: &mut VelocityFields,
    boundary: &mut BoundaryConditions<D>,
) {
    let damping = clock.stage().damping_of_axes();
    if damping == [0.0; 3] {
        return;
    }
    let BoundaryConditions { walls, driven, contacts, penalty_obstacles: rocks, .. } = boundary;
    limit_solved(clock, background, bodies, &mut nodes.solved, (walls, rocks));
    let layout = &background.layout;
    for nodes in nodes.solved.chunks_exact_mut(layout.len()) {
        layout.for_each_active_node_range(nodes, |row, active, line| {
            for number in active {
                let node = &mut line[number];
                let held = walls
                    .constrained_components(&layout.index(row, number), &first_three(node.momentum_and_mass));
                damp(node, &damping, held, clock.dt);
            }
        });
    }
    prescribed_motion::impose_patch_velocity(clock, background, driven, contacts, &mut nodes.solved, false);
}

/// Returns the measures of equilibrium from the solved nodes, contacts included (sheet: mpm §2.14).
fn equilibrium_terms<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    light: f64,
    nodes: &mut VelocityFields,
    walls: &NodeWalls,
    contacts: &FieldContacts,
) -> EquilibriumTerms {
    let stage = clock.stage();
    let audit = EquilibriumAudit {
        dt: clock.dt,
        gravity: clock.gravity_at_end(),
        damping: stage.damping_of_axes(),
        rayleigh: stage.rayleigh_damping,
        inertia: clock.options.mass_scaling,
        mass_cutoff: light,
        walls,
        layout: &background.layout,
    };
    let mut sums = EquilibriumTerms::default();
    let VelocityFields { solved, row_sums, .. } = nodes;
    for (field, nodes) in solved.chunks_exact_mut(background.layout.len()).enumerate() {
        if contacts.is_rigid(field) {
            continue;
        }
        background.layout.for_each_row(nodes, row_sums, |row, active, line| audit.row(row, active, line));
        row_sums.iter().for_each(|row| sums.add(row));
    }
    sums
}

/// Work of tractions and prescribed motions in the step (J).
pub(crate) fn work_of_loads<const D: usize>(bodies: &Bodies<D>, driven: &[DrivenObject], dt: f64) -> f64 {
    let mut work = 0.0;
    for set in &bodies.sets {
        work += dt * power(&set.points.traction, &set.points.velocity);
    }
    for driven in driven {
        let free = driven.free_rigid_body.as_ref().map_or([false; 6], |loose| loose.free);
        let velocity: [f64; 3] = std::array::from_fn(|c| if free[c] { 0.0 } else { driven.velocity()[c] });
        work -= (0..3).map(|c| driven.state.force[c] * velocity[c] * dt).sum::<f64>();
    }
    work
}

#[cfg(test)]
impl<const D: usize> MpmSolver<D> {
    /// Point to grid in a step of a millisecond, for tests.
    pub(crate) fn p2g_for_tests(&mut self) {
        let Self { clock, background, bodies, nodes, boundary, averages, .. } = self;
        clock.dt = 1e-3;
        p2g(clock, background, bodies, nodes, boundary, averages, P2gContent::Everything);
    }
}
