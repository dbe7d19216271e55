//! Solver: its components and one step.

mod program_access;
mod removal_shapes;
pub(crate) mod report;
mod rest_checks;
pub(crate) mod saw_test;

use std::sync::Arc;

use colluvium_case::{BodyForce, Case, FailureReason, Manufactured, SolverError, TimeStep, spatial};

use crate::background_grid::BackgroundGrid;
use crate::boundary::walls::BoundaryConditions;
use crate::config::SnowOptions;
use crate::critical_step::{StepCoefficients, time_step};
use crate::momentum::body_force::{body_force_potential, update_body_forces};
use crate::momentum::{GridNodes, MomentumSolve, MomentumTerms};
use crate::obstacles::node_obstacles::NodeObstacles;
use crate::output::energy_balance::{EnergyBalance, StoredEnergies};
use crate::output::hazard_rasters::HazardRasters;
use crate::points::bodies::{Bodies, BodyPoints, PointFailure};
use crate::transfer::{PointUpdater, p2g};

pub use crate::solver::program_access::SnowPoints;
pub(crate) use crate::solver::rest_checks::RestChecks;

/// Time and stage of a run, with the momentum sums of the last step.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    /// Index of the stage.
    pub stage: usize,
    /// Start time of the stage (s).
    pub stage_start: f64,
    /// Time (s).
    pub time: f64,
    /// Number of completed steps.
    pub step: u64,
    /// Longest next step, safety factors included.
    pub limit: TimeStep,
    /// Sums over the nodes of the last step.
    pub sums: MomentumTerms,
    /// Work of gravity, walls and a body force since the start of the stage (J).
    pub external_work: f64,
    /// Results of the checks of rest.
    pub rest_checks: RestChecks,
}

/// Solver of the finite-strain MPM in `D` dimensions.
pub struct SnowSolver<const D: usize> {
    /// Case of the run.
    pub(crate) case: Arc<Case>,
    /// Options of the method.
    pub(crate) options: SnowOptions,
    /// Grid with its transfers.
    pub(crate) background: BackgroundGrid<D>,
    /// Points of all bodies.
    pub(crate) bodies: Bodies<D>,
    /// Nodal momenta, forces and masses.
    pub(crate) nodes: GridNodes,
    /// Walls of the domain.
    pub(crate) boundaries: BoundaryConditions,
    /// Obstacles that constrain nodes.
    pub(crate) obstacles: NodeObstacles<D>,
    /// Energy balance of the run.
    pub(crate) energy_balance: EnergyBalance,
    /// Hazard rasters, if the case has them.
    pub(crate) hazard_rasters: Option<HazardRasters>,
    /// Bounds of the shapes of the cuts (m).
    pub(crate) cut_bounds: Vec<colluvium_case::description::AxisBounds>,
    /// Manufactured solution for verification, whose force acts on the points.
    pub(crate) manufactured_solution: Option<Manufactured>,
    /// Body force of the program.
    pub(crate) body_force: Option<BodyForce<D>>,
    /// Energies before changes by the program since the last step; `None` without changes.
    pub(crate) energies_before_changes: Option<StoredEnergies>,
    /// Time, step and stage of the run.
    pub(crate) clock: Clock,
}

impl<const D: usize> SnowSolver<D> {
    /// Advances the solver by a step of `dt` (s); step numbers in the code are those of `sheet: snow-mpm §3.5`.
    pub(crate) fn advance(&mut self, dt: f64) -> Result<(), SolverError> {
        self.check_fixed_step()?;
        self.update_body_forces()?;
        let (gravity, damping) = self.body_forces(dt);
        let Self {
            options,
            background,
            bodies,
            nodes,
            boundaries,
            obstacles,
            energy_balance: ledger,
            clock,
            manufactured_solution,
            ..
        } = self;
        if bodies.travel_since_sort >= background.grid.cell {
            nodes.reset(&background.layout);
            bodies.sort(background);
        }
        nodes.reset(&background.layout);
        boundaries.move_to(clock.time, background);
        if obstacles.are_moving() {
            obstacles.update_faces((clock.time, dt), background, boundaries.obstacles_mut());
        }
        // 1, 2
        let push = manufactured_solution.as_ref().map(|solution| (solution, clock.time));
        p2g(background, bodies, nodes, options.transfer, push);
        background.sum_periodic_images(&mut nodes.nodes);
        // 3
        let light = options.node_mass_cutoff * bodies.mean_mass;
        let sums = nodes.solve(&MomentumSolve {
            dt,
            gravity,
            damping,
            mass_cutoff: light,
            walls: boundaries.walls(),
            background,
        });
        // 4 to 9
        let update = PointUpdater {
            dt,
            transfer: options.transfer,
            flip_fraction: options.flip_share(dt),
            deformation: options.deformation,
            bounds: StepCoefficients::of_options(options, D),
            background,
            nodes: &nodes.nodes,
            boundaries,
        };
        let start = body_force_potential(bodies);
        bodies.bodies.iter_mut().for_each(|body| update.body(body));
        ledger.add(&sums, dt);
        let work = body_force_potential(bodies) - start;
        ledger.add_body_force_work(work);
        clock.external_work += work;
        self.end_step(dt, sums)
    }

    /// Computes the body force of the program on the points at the start of a step.
    fn update_body_forces(&mut self) -> Result<(), SolverError> {
        let Some(force) = &self.body_force else { return Ok(()) };
        let updated = update_body_forces(force, &mut self.bodies, self.clock.time);
        updated.map_err(|(number, failure)| self.point_error(number, &failure))
    }

    /// Evaluates the reports of the points and advances the clock.
    fn end_step(&mut self, dt: f64, sums: MomentumTerms) -> Result<(), SolverError> {
        let (mut moved, mut left) = (0f64, false);
        for (number, body) in self.bodies.bodies.iter().enumerate() {
            for report in &body.reports {
                match report {
                    Ok(pace) => (moved, left) = (moved.max(pace.max_move), left | pace.any_outside),
                    Err(failure) => return Err(self.point_error(number, failure)),
                }
            }
        }
        self.bodies.travel_since_sort += moved;
        self.bodies.wrap_into_period(&self.background);
        self.clock.time += dt;
        self.clock.step += 1;
        self.clock.sums = sums;
        self.clock.external_work += sums.gravity + sums.boundary;
        if left {
            self.remove_outside_points();
        }
        self.apply_removal_shapes(dt)?;
        if let Some(maps) = &mut self.hazard_rasters {
            maps.update(&self.bodies, self.clock.time);
        }
        self.set_limit();
        Ok(())
    }

    /// Removes the points outside the domain, of bodies with `remove_outside`.
    fn remove_outside_points(&mut self) {
        let BackgroundGrid { low, upper_corner, .. } = self.background;
        let inside = |x: &[f64; D]| (0..D).all(|axis| x[axis] >= low[axis] && x[axis] <= upper_corner[axis]);
        self.retain(|body, i| !body.remove_outside || inside(&body.points.position[i]));
    }

    /// Removes the points for whose body and index the condition is false. Records the energy of the others as removed and returns it (J).
    pub(crate) fn retain(&mut self, keep: impl Fn(&BodyPoints<D>, usize) -> bool) -> f64 {
        let before = self.stored_energies();
        self.nodes.reset(&self.background.layout);
        if !self.bodies.retain(keep) {
            return 0.0;
        }
        let removed = self.energy_balance.add_removed(&before, &self.stored_energies());
        self.bodies.sort(&mut self.background);
        self.update_step_bounds();
        removed
    }

    /// Current energies (J).
    pub(crate) fn stored_energies(&self) -> StoredEnergies {
        StoredEnergies::of_bodies(&self.bodies, self.second_moment())
    }

    /// Second moment of the shape functions about any position (m²), which is constant (sheet: snow-mpm §3.6).
    pub(crate) fn second_moment(&self) -> f64 {
        let degrees = match self.options.shape {
            crate::SplineShape::Cubic => 4.0,
            crate::SplineShape::Quadratic => 3.0,
            crate::SplineShape::Linear => 2.0,
        };
        // A B-spline is a sum of this number of uniform numbers of variance 1/12.
        degrees / 12.0 * self.options.cell_size.powi(2)
    }

    /// Computes the step bounds of all points and the next time step.
    pub(crate) fn update_step_bounds(&mut self) {
        use colluvium_constitutive::BLOCK_SIZE;

        let bounds = StepCoefficients::of_options(&self.options, D);
        for body in &mut self.bodies.bodies {
            let points = &body.points;
            for (number, (report, states)) in body.reports.iter_mut().zip(body.states.blocks()).enumerate() {
                let first = number * BLOCK_SIZE;
                let range = first..(first + BLOCK_SIZE).min(points.len());
                let moving = (
                    &points.velocity[range.clone()],
                    &points.mass[range.clone()],
                    &points.volume[range.clone()],
                );
                *report =
                    Ok(bounds.step_bound(first, &*body.material, moving, (&points.stress[range], states)));
            }
        }
        self.set_limit();
    }

    /// Sets the next time step from the bounds of points and obstacles, or to the fixed step of the case.
    fn set_limit(&mut self) {
        let Self { bodies, obstacles, clock, options, .. } = self;
        let critical = obstacles.limit_by_obstacle_motion(time_step(bodies), clock.time, options.cell_size);
        clock.limit = critical.or_fixed(options.time_step);
    }

    /// Gravity at the end of a step of `dt` (m/s²), and damping factors of the stage.
    fn body_forces(&self, dt: f64) -> ([f64; 3], [f64; 3]) {
        let stage = &self.case.stages[self.clock.stage];
        let factor = stage.gravity_factor(self.clock.time + dt - self.clock.stage_start);
        (self.case.gravity3().map(|g| g * factor), stage.damping_of_axes())
    }

    /// Returns an error if the fixed step of the case exceeds the critical one.
    fn check_fixed_step(&self) -> Result<(), SolverError> {
        match self.clock.limit.fixed_step_problem(self.options.time_step) {
            Some(problem) => {
                let reason = format!("methods.{}.time_step: {problem}", crate::config::NAME);
                let reason = FailureReason::FixedStep(reason);
                Err(SolverError::Step { step: self.clock.step, time: self.clock.time, reason })
            }
            None => Ok(()),
        }
    }

    /// Error of a failed point.
    pub(crate) fn point_error(&self, body: usize, failure: &PointFailure) -> SolverError {
        let BodyPoints { points, number, .. } = &self.bodies.bodies[body];
        let material = &self.case.bodies[*number as usize].material;
        SolverError::Point {
            step: self.clock.step,
            time: self.clock.time,
            point: u64::from(points.id[failure.index]),
            position: spatial(&points.position[failure.index]),
            reason: failure.reason.clone().of_material(material),
        }
    }
}
