//! Solver with its components, and one step.
//!
//! The step hands each owner to the functions that read or change it. The module also limits the step and measures the distance from
//! equilibrium. It knows all modules of the method; `setup`, `output` and `checkpoint` may know it.

mod critical_step;
mod equilibrium;
mod grid_nodes;
mod program_access;

use std::sync::Arc;

use colluvium_case::{Manufactured, SolverError};

use crate::background_grid::BackgroundGrid;
use crate::boundary::body_force::update_body_forces;
use crate::boundary::boundary_conditions::BoundaryConditions;
use crate::boundary::point_loads::set_manufactured_forces;
use crate::boundary::rigid_bodies::{move_driven, update_driven_velocities};
use crate::clock::Clock;
use crate::config::StressScheme;
use crate::momentum::consistent_mass::ConsistentMass;
use crate::momentum::velocity_fields::VelocityFields;
use crate::momentum::velocity_fields::VelocitySource::{EndOfStep, Remapped};
use crate::obstacles::obstacle_penalty::fit_workspaces;
use crate::phases::nodal_phases::NodalPhases;
use crate::phases::one_phase::OnePhase;
use crate::phases::{SkeletonAndFluid, TwoPhase};
use crate::points::bodies::Bodies;
use crate::points::point_set::PointSet;
use crate::stress::averages::CellAverages;
use crate::transfer::p2g::P2gContent;
use crate::transfer::point_update::UpdateSelection;

pub use crate::solver::grid_nodes::MpmNode;
pub use crate::solver::program_access::MpmPoints;

/// Explicit MPM in `D` dimensions.
pub struct MpmSolver<const D: usize> {
    /// Time, step, stage and options of the run.
    pub(crate) clock: Clock,
    /// Grid or mesh with its transfers.
    pub(crate) background: BackgroundGrid<D>,
    /// Points of all bodies.
    pub(crate) bodies: Bodies<D>,
    /// Nodal momenta, forces and masses of the velocity fields.
    pub(crate) nodes: VelocityFields,
    /// Walls, loads, contacts and other boundary conditions.
    pub(crate) boundary: BoundaryConditions<D>,
    /// Averages over cells and nodes.
    pub(crate) averages: CellAverages<D>,
    /// Consistent mass matrix, where the case selects it.
    pub(crate) consistent: ConsistentMass,
    /// Both phases of the nodes; `None` in a case without pore fluid.
    pub(crate) two_phase: Option<Box<TwoPhase>>,
    /// Manufactured solution for verification, whose body force acts on the points.
    pub(crate) manufactured_solution: Option<Arc<Manufactured>>,
}

impl<const D: usize> MpmSolver<D> {
    /// Advances the solver by a step (sheet: mpm §3.3); step numbers in the code are those of the sheet.
    pub(crate) fn advance(&mut self, dt: f64) -> Result<(), SolverError> {
        update_body_forces(&self.clock, &mut self.bodies, &self.boundary)?;
        self.clock.begin_step(dt)?;
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
            manufactured_solution,
        } = self;
        nodes.reset(&background.layout); // 0: empty grid
        boundary.node_obstacles.update_faces((clock.time, clock.dt), background, &mut boundary.walls);
        update_driven_velocities(clock, bodies, &mut boundary.driven);
        if let (Some(solution), None) = (manufactured_solution, &two_phase) {
            set_manufactured_forces(solution, bodies, clock.time);
        }
        let moved = match two_phase {
            Some(phases) => {
                let mut phases = SkeletonAndFluid::cleared(background, nodes, phases);
                step(clock, background, bodies, &mut phases, boundary, averages)?
            }
            None => step(clock, background, bodies, &mut OnePhase { nodes, consistent }, boundary, averages)?,
        };
        // 10
        let driven = move_driven(clock, background, bodies, &mut boundary.driven)?;
        bodies.travel_since_sort += moved.max(driven);
        boundary.walls.set_starts_moving(false);
        if bodies.remove_outside_points() {
            self.sort();
        }
        self.bodies.wrap_into_period(&self.background);
        self.clock.end();
        Ok(())
    }

    /// Sorts the points by their cells if they may have moved by more than a cell since the last sort.
    fn sort_if_moved(&mut self) {
        if self.bodies.travel_since_sort >= self.background.grid.cell {
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

    /// Resizes the buffers of obstacles and of the free surface to the number of points.
    pub(crate) fn resize_point_buffers(&mut self) {
        let Self { bodies, boundary, averages, .. } = self;
        if let Some(obstacles) = &mut boundary.penalty_obstacles {
            fit_workspaces(bodies, obstacles);
        }
        if let Some(surface) = &mut averages.free_surface {
            surface.resize_point_buffers(bodies.sets.iter().map(PointSet::len).max().unwrap_or(0));
        }
    }

    /// Finds active nodes and slab bounds from the sorted points.
    pub(crate) fn find_active_nodes(&mut self) {
        self.bodies.find_active_nodes(&mut self.background);
        if let Some(phases) = &mut self.two_phase {
            phases.find_heaviest(&self.bodies);
        }
    }
}

/// Runs steps 1 to 9 for all phases (sheet: mpm §3.3, §3.4); step numbers in the code are those of the sheet. Returns the largest
/// displacement of a point along an axis (m).
fn step<const D: usize>(
    clock: &Clock,
    background: &BackgroundGrid<D>,
    bodies: &mut Bodies<D>,
    phases: &mut impl NodalPhases<D>,
    boundary: &mut BoundaryConditions<D>,
    averages: &mut CellAverages<D>,
) -> Result<f64, SolverError> {
    let (all, velocity, stress) = (UpdateSelection::ALL, UpdateSelection::VELOCITY, UpdateSelection::STRESS);
    phases.correct_free_surface(background, bodies, averages);
    match clock.options.stress_update {
        StressScheme::Usl => {
            phases.p2g(clock, background, bodies, boundary, averages, P2gContent::MassMomentumForces); // 1
            phases.rescale_small_mass_forces(clock, background, bodies);
            phases.solve_momentum(clock, background, bodies, boundary)?; // 2–4
            phases.average_strains(clock, background, bodies, averages, EndOfStep); // 7
            phases.update_follower_loads(clock, background, bodies, EndOfStep);
            phases.update_points(clock, background, bodies, boundary, averages, (EndOfStep, all)) // 5, 7–9
        }
        StressScheme::Musl => {
            phases.p2g(clock, background, bodies, boundary, averages, P2gContent::MassMomentumForces); // 1
            phases.solve_momentum(clock, background, bodies, boundary)?; // 2–4
            phases.update_points(clock, background, bodies, boundary, averages, (EndOfStep, velocity))?; // 5
            phases.remap(clock, background, bodies, boundary); // 6
            phases.limit_remapped(clock, background, bodies, boundary);
            phases.average_strains(clock, background, bodies, averages, Remapped); // 7
            phases.update_follower_loads(clock, background, bodies, Remapped);
            let rest = UpdateSelection { position: true, ..stress };
            phases.update_points(clock, background, bodies, boundary, averages, (Remapped, rest)) // 7–9
        }
        StressScheme::Usf => {
            phases.start_velocities(clock, background, bodies, boundary, averages); // 1, momentum and mass
            phases.average_strains(clock, background, bodies, averages, Remapped); // 7
            phases.update_points(clock, background, bodies, boundary, averages, (Remapped, stress))?; // 7–8
            phases.correct_free_surface(background, bodies, averages);
            phases.p2g(clock, background, bodies, boundary, averages, P2gContent::Forces); // 1, forces
            phases.solve_momentum(clock, background, bodies, boundary)?; // 2–4
            phases.update_follower_loads(clock, background, bodies, EndOfStep);
            let rest = UpdateSelection { position: true, ..velocity };
            phases.update_points(clock, background, bodies, boundary, averages, (EndOfStep, rest)) // 5, 9
        }
    }
}

#[cfg(test)]
impl<const D: usize> MpmSolver<D> {
    /// Point to grid in a step of a millisecond, for tests.
    pub(crate) fn p2g_for_tests(&mut self) {
        let Self { clock, background, bodies, nodes, boundary, averages, consistent, .. } = self;
        clock.dt = 1e-3;
        let content = P2gContent::MassMomentumForces;
        OnePhase { nodes, consistent }.p2g(clock, background, bodies, boundary, averages, content);
    }
}
