//! Checkpoints of the solver, and its implementation of [`Solver`].

use std::io::{Read, Write};
use std::sync::Arc;

use colluvium_case::description::{Reset, Stage};
use colluvium_case::measure::ScalarOutput;
use colluvium_case::solver::{restore_value, save_value};
use colluvium_case::{
    Advance, Budget, Dataset, Equilibrium, Frame, FrameRequest, ProgramMotion, Reaction, Solver, SolverError,
    TimeStep, check_saved_body_force,
};
use serde::{Deserialize, Serialize};

use crate::boundary::walls::BoundaryConditions;
use crate::momentum::MomentumTerms;
use crate::output::energy_balance::{CutRemoval, EnergyBalance, StoredEnergies};
use crate::output::hazard_rasters::HazardCell;
use crate::points::bodies::{BodyPoints, PointFailure};
use crate::solver::SnowSolver;
use colluvium_case::Warning;

/// Version of the checkpoint format.
const FORMAT: u32 = 10;

/// Penetration of a point into an obstacle above which the run reports it (cells).
const REPORTED_DEPTH: f64 = 0.1;

/// State of the solver besides the columns of the points.
#[derive(Serialize, Deserialize)]
struct CheckpointState {
    format: u32,
    dimension: usize,
    shape: String,
    time: f64,
    step: u64,
    limit: TimeStep,
    sums: MomentumTerms,
    external: f64,
    travel_since_sort: f64,
    next_id: u32,
    energy_balance: EnergyBalance,
    hazard_cells: Option<Vec<HazardCell>>,
    /// Motions of the moving obstacles by the program.
    program_motions: Vec<Option<ProgramMotion>>,
    /// Whether a body force of the program acts.
    has_body_force: bool,
    energies_before_changes: Option<StoredEnergies>,
    /// Number, slabs and serialised law states of each body.
    bodies: Vec<(u32, Vec<usize>, Vec<u8>)>,
}

/// Error of a checkpoint that cannot be read or does not fit the case.
fn checkpoint_error(what: &str) -> SolverError {
    SolverError::Checkpoint(what.to_owned())
}

impl<const D: usize> SnowSolver<D> {
    /// State of the solver for a checkpoint.
    fn checkpoint_state(&self) -> CheckpointState {
        let body = |body: &BodyPoints<D>| (body.number, body.slabs.clone(), body.material.save(&body.states));
        CheckpointState {
            format: FORMAT,
            dimension: D,
            shape: self.background.basis_1d.name.to_owned(),
            time: self.clock.time,
            step: self.clock.step,
            limit: self.clock.limit,
            sums: self.clock.sums,
            external: self.clock.external_work,
            travel_since_sort: self.bodies.travel_since_sort,
            next_id: self.bodies.next_id,
            energy_balance: self.energy_balance.clone(),
            hazard_cells: self.hazard_rasters.as_ref().map(|maps| maps.cells().to_vec()),
            program_motions: self.obstacles.moving().map(|moving| moving.program_motion).collect(),
            has_body_force: self.body_force.is_some(),
            energies_before_changes: self.energies_before_changes,
            bodies: self.bodies.bodies.iter().map(body).collect(),
        }
    }

    /// Reinitialises the states of the laws from the current stresses.
    fn reset_states(&mut self) -> Result<(), SolverError> {
        for number in 0..self.bodies.bodies.len() {
            let body = &self.bodies.bodies[number];
            let begun = body.law_points().restarted_states(|i| body.points.mass[i] / body.points.volume[i]);
            let (stress, states) = begun.map_err(|(index, reason)| {
                self.point_error(number, &PointFailure { index, reason: reason.into() })
            })?;
            self.bodies.bodies[number].points.stress = stress;
            self.bodies.bodies[number].states = states;
        }
        Ok(())
    }
}

impl<const D: usize> Solver for SnowSolver<D> {
    fn time(&self) -> f64 {
        self.clock.time
    }

    fn step_count(&self) -> u64 {
        self.clock.step
    }

    fn point_count(&self) -> usize {
        self.bodies.len()
    }

    fn limit(&mut self) -> TimeStep {
        self.settle_changes();
        self.clock.limit
    }

    fn step(&mut self, at_most: f64) -> Result<Advance, SolverError> {
        let limit = self.limit();
        let dt = limit.limited_to(at_most);
        self.advance(dt)?;
        Ok(Advance { dt, limit: limit.limit })
    }

    fn begin_stage(&mut self, stage: usize, start: f64) -> Result<(), SolverError> {
        let is_new = start == self.clock.time;
        self.resume_stage(stage, start)?;
        if is_new {
            self.clock.external_work = 0.0;
        }
        Ok(())
    }

    fn resume_stage(&mut self, stage: usize, start: f64) -> Result<(), SolverError> {
        (self.clock.stage, self.clock.stage_start) = (stage, start);
        let case = Arc::clone(&self.case);
        self.retain(|body, _| !case.is_removed(&case.bodies[body.number as usize].name, stage));
        let obstacles = self.boundaries.obstacles();
        self.boundaries = BoundaryConditions::new(&self.case, stage, &self.background, obstacles);
        Ok(())
    }

    fn end_stage(&mut self, stage: &Stage) -> Result<(), SolverError> {
        self.check_weak_layers(stage);
        if stage.reset.is_empty() {
            return Ok(());
        }
        let before = self.stored_energies();
        for reset in &stage.reset {
            match reset {
                Reset::Velocity => self.bodies.bodies.iter_mut().for_each(|body| {
                    body.points.velocity.fill([0.0; D]);
                    body.points.affine_velocity.fill([[0.0; D]; D]);
                }),
                Reset::Displacement => {
                    let all = self.bodies.bodies.iter_mut();
                    all.for_each(|body| body.points.origin.clone_from(&body.points.position));
                }
                Reset::State => self.reset_states()?,
            }
        }
        self.energy_balance.add_change(&before, &self.stored_energies());
        self.update_step_bounds();
        Ok(())
    }

    fn cell_size(&self) -> Option<f64> {
        Some(self.options.cell_size)
    }

    fn equilibrium(&self) -> Option<Equilibrium> {
        Some(self.measure_equilibrium())
    }

    fn scalar_outputs(&self) -> Vec<ScalarOutput> {
        self.collect_scalar_outputs()
    }

    fn warning(&self) -> Option<Warning> {
        self.rest_warning()
    }

    fn warnings_at_end(&self) -> Vec<Warning> {
        let places: Vec<[f64; D]> =
            self.bodies.bodies.iter().flat_map(|body| &body.points.position).copied().collect();
        let slack = REPORTED_DEPTH * self.background.grid.cell;
        let reason = "obstacles act on the nodes here, and a contact within a cell is not detected (take \
                      smaller cells)";
        let overlap = self.case.overlap_warning(&places, slack, reason);
        let cuts = self.case.removal_shapes.iter().zip(self.energy_balance.removals());
        let idle = cuts.filter(|(_, removal)| removal.cut_displacement > 0.0 && removal.mass == 0.0);
        let idle = idle.map(|(cut, removal)| {
            Warning::new(
                "cut-removed-nothing",
                format!(
                    "removal_shapes.{}: has moved {:.4e} m and removed no material. Check its shape, the direction of \
                     its velocity, and its bodies",
                    cut.name, removal.cut_displacement
                ),
            )
        });
        overlap.into_iter().chain(idle).collect()
    }

    fn products(&self) -> Vec<Dataset> {
        let rasters = self.hazard_rasters.as_ref().map_or_else(Vec::new, |maps| maps.rasters(&self.bodies));
        rasters.into_iter().map(Dataset::of_raster).collect()
    }

    fn removal_shape_travel(&self) -> Vec<Option<f64>> {
        self.energy_balance.removals().iter().map(CutRemoval::travel_if_started).collect()
    }

    fn reaction(&self, name: &str) -> Option<Reaction> {
        let number = self.obstacles.recorded_names().iter().position(|own| own == name)?;
        Some(self.energy_balance.reactions(number))
    }

    fn dissipated(&self) -> Option<f64> {
        self.case.measures_dissipation().then(|| self.energy_balance.law_dissipation(&self.stored_energies()))
    }

    fn frame(&self, wanted: FrameRequest<'_>) -> Frame {
        self.collect_snapshot(wanted).into()
    }

    fn budget(&self) -> Option<Budget> {
        Some(self.collect_budget())
    }

    fn save(&self, out: &mut dyn Write) -> Result<(), SolverError> {
        save_value(&self.checkpoint_state(), out)?;
        for body in &self.bodies.bodies {
            body.points.write(out)?;
        }
        Ok(())
    }

    fn restore(&mut self, input: &mut dyn Read) -> Result<(), SolverError> {
        let head: CheckpointState = restore_value(input)?;
        if head.format != FORMAT || head.dimension != D || head.shape != self.background.basis_1d.name {
            return Err(checkpoint_error("was written by another version or for another case"));
        }
        check_saved_body_force(head.has_body_force, self.body_force.is_some())?;
        self.nodes.reset(&self.background.layout);
        self.bodies.bodies.retain(|body| head.bodies.iter().any(|(number, ..)| *number == body.number));
        if self.bodies.bodies.len() != head.bodies.len() {
            return Err(checkpoint_error("contains bodies that the case does not have"));
        }
        for (body, (number, _, states)) in self.bodies.bodies.iter_mut().zip(&head.bodies) {
            body.points.read(input)?;
            let states = body.material.load(states).filter(|states| states.len() == body.points.len());
            body.states = states
                .filter(|_| body.number == *number)
                .ok_or_else(|| checkpoint_error("its arrays do not fit together"))?;
        }
        self.bodies.find_active_nodes(&mut self.background);
        // Points may have drifted since the sort, and the order of summation must be that of the uninterrupted run.
        for (body, (_, slabs, _)) in self.bodies.bodies.iter_mut().zip(head.bodies) {
            if slabs.len() != body.slabs.len() || slabs.last() != Some(&body.points.len()) {
                return Err(checkpoint_error("its slabs do not fit the case"));
            }
            body.slabs = slabs;
        }
        if head.energy_balance.removals().len() != self.case.removal_shapes.len() {
            return Err(checkpoint_error("has other cuts than the case"));
        }
        let restored = match (&mut self.hazard_rasters, head.hazard_cells) {
            (Some(maps), Some(cells)) => maps.restore(cells).is_some(),
            (None, None) => true,
            _ => false,
        };
        if !restored {
            return Err(checkpoint_error("has rasters with other cells than the case"));
        }
        (self.bodies.travel_since_sort, self.bodies.next_id) = (head.travel_since_sort, head.next_id);
        let moving = self.obstacles.moving_mut();
        moving.zip(&head.program_motions).for_each(|(moving, motion)| moving.program_motion = *motion);
        self.energy_balance = head.energy_balance;
        self.energies_before_changes = head.energies_before_changes;
        let clock = &mut self.clock;
        (clock.time, clock.step, clock.limit) = (head.time, head.step, head.limit);
        (clock.sums, clock.external_work) = (head.sums, head.external);
        Ok(())
    }
}
