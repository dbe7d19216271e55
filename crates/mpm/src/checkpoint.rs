//! Checkpoint of the solver, and its implementation of `Solver`.

use std::io::{Read, Write};

use colluvium_case::description::{Reset, Stage};
use colluvium_case::measure::ScalarOutput;
use colluvium_case::rigid::unconverged_warning;
use colluvium_case::solver::{restore_value, save_value};
use colluvium_case::{
    Advance, Budget, Equilibrium, Frame, FrameRequest, ProgramMotion, Reaction, Solver, SolverError,
    TimeStep, check_saved_body_force,
};
use serde::{Deserialize, Serialize};

use crate::boundary::rigid_bodies::stop_free_rigid_bodies;
use crate::momentum::EquilibriumTerms;
use crate::momentum::driven_object::DrivenObjectState;
use crate::obstacles::obstacle_penalty::{penetration_warning, reset_displacements};
use crate::obstacles::reaction::Reactions;
use crate::obstacles::state::{ObstacleHistory, ObstacleReaction};
use crate::phases::PhaseEquilibriumTerms;
use crate::points::bodies::point_error;
use crate::points::point_set::PointSet;
use crate::solver::MpmSolver;
use crate::stress::stress_work::dissipated_energy;
use colluvium_case::Warning;

/// Version of the layout of a checkpoint.
const FORMAT: u32 = 22;

/// Penetration of a point into an obstacle (cells) above which the run reports it.
const REPORTED_DEPTH: f64 = 0.1;

/// State of the solver beside the columns of points.
#[derive(Serialize, Deserialize)]
struct CheckpointState {
    format: u32,
    dimension: usize,
    shape: String,
    time: f64,
    step: u64,
    travel_since_sort: f64,
    next_id: u32,
    limit: Option<TimeStep>,
    courant: f64,
    limit_age: u64,
    external_work: f64,
    sums: EquilibriumTerms,
    driven: Vec<DrivenObjectState>,
    load_starts: Vec<f64>,
    /// Sums of mixture and liquid in a case with pore fluid.
    phase_sums: Option<PhaseEquilibriumTerms>,
    /// Displacements at absorbing boundaries (m), by the number of the boundary.
    absorbing_displacements: Vec<(usize, Vec<[f64; 3]>)>,
    /// Reactions of obstacles on the nodes.
    reactions: Option<Reactions>,
    /// Reactions and energies of obstacles on the points.
    obstacle_reactions: Vec<ObstacleReaction>,
    obstacle_history: ObstacleHistory,
    /// Motions of the moving obstacles by the program.
    program_motions: Vec<Option<ProgramMotion>>,
    /// Whether a body force of the program acts.
    has_body_force: bool,
    /// Index of the body of each set of points.
    bodies: Vec<u32>,
}

impl<const D: usize> MpmSolver<D> {
    /// Prepares a stage; `is_new` marks its beginning.
    fn enter_stage(&mut self, stage: usize, start: f64, is_new: bool) -> Result<(), SolverError> {
        self.clock.stage = stage;
        self.clock.stage_start = start;
        self.clock.flip_fraction = self.clock.options.flip_share(&self.clock.case.stages[stage]);
        let case = self.clock.case.clone();
        let points = self.point_count();
        self.bodies.sets.retain(|set| !case.is_removed(&case.bodies[set.body as usize].name, stage));
        if is_new {
            let pits = &case.stages[stage].excavate;
            self.bodies.retain(|x| !pits.iter().any(|pit| pit.contains(x)));
        }
        self.set_stage_walls(stage).map_err(|error| SolverError::Checkpoint(error.to_string()))?;
        if is_new {
            self.nodes.external_work = 0.0;
            self.clock.limit = None;
            self.clock.case.begin_loads(&mut self.boundary.load_starts, stage, start);
        }
        if self.point_count() != points {
            self.sort();
        }
        Ok(())
    }
}

impl<const D: usize> Solver for MpmSolver<D> {
    fn time(&self) -> f64 {
        self.clock.time
    }

    fn step_count(&self) -> u64 {
        self.clock.step
    }

    fn point_count(&self) -> usize {
        self.bodies.sets.iter().map(PointSet::len).sum()
    }

    fn limit(&mut self) -> TimeStep {
        self.critical_step()
    }

    fn step(&mut self, at_most: f64) -> Result<Advance, SolverError> {
        let limit = self.critical_step();
        let dt = limit.limited_to(at_most);
        self.advance(dt)?;
        Ok(Advance { dt, limit: limit.limit })
    }

    fn begin_stage(&mut self, stage: usize, start: f64) -> Result<(), SolverError> {
        self.enter_stage(stage, start, start == self.clock.time)
    }

    fn resume_stage(&mut self, stage: usize, start: f64) -> Result<(), SolverError> {
        self.enter_stage(stage, start, false)
    }

    fn end_stage(&mut self, stage: &Stage) -> Result<(), SolverError> {
        for reset in &stage.reset {
            match reset {
                Reset::Velocity => {
                    stop_free_rigid_bodies(&mut self.boundary.driven);
                    self.bodies.sets.iter_mut().for_each(|set| {
                        set.points.velocity.fill([0.0; D]);
                        set.points.grid_velocity.fill([0.0; D]);
                        set.points.affine_velocity.fill([[0.0; D]; D]);
                        if let Some(pore) = &mut set.pore {
                            pore.points.velocity.fill([0.0; D]);
                        }
                    });
                }
                Reset::Displacement => {
                    reset_displacements(&mut self.bodies);
                    self.bodies
                        .sets
                        .iter_mut()
                        .for_each(|set| set.points.origin.clone_from(&set.points.position));
                }
                Reset::State => self.reset_states()?,
            }
        }
        Ok(())
    }

    fn cell_size(&self) -> Option<f64> {
        Some(self.clock.options.cell_size)
    }

    fn equilibrium(&self) -> Option<Equilibrium> {
        self.measure_equilibrium()
    }

    fn scalar_outputs(&self) -> Vec<ScalarOutput> {
        self.collect_scalar_outputs()
    }

    fn reaction(&self, name: &str) -> Option<Reaction> {
        if let Some(obstacle) = self
            .boundary
            .penalty_obstacles
            .iter()
            .flat_map(|all| &all.obstacles)
            .find(|obstacle| obstacle.name == name)
        {
            let ObstacleReaction { force, impulse, moment, .. } = obstacle.state;
            return Some(Reaction { force, impulse, moment: Some(moment) });
        }
        if let Some(reaction) =
            self.boundary.reaction_recorder.as_ref().and_then(|recorder| recorder.reaction(name))
        {
            return Some(reaction);
        }
        let driven = self.boundary.driven.iter().find(|driven| driven.name == name)?;
        Some(Reaction { force: driven.state.force, impulse: driven.state.impulse, moment: None })
    }

    fn dissipated(&self) -> Option<f64> {
        self.clock.case.measures_dissipation().then(|| dissipated_energy(&self.bodies))
    }

    fn is_isolated(&self) -> bool {
        self.is_energetically_closed()
    }

    fn warning(&self) -> Option<Warning> {
        self.tension_warning()
    }

    fn warnings_at_end(&self) -> Vec<Warning> {
        let crushed: usize = self.bodies.deformable_sets().map(PointSet::points_at_min_volume).sum();
        let remark = Warning::new(
            "crushed-points",
            format!(
                "{crushed} of {} points are compressed to a tenth of their initial volume, the least that is \
             allowed. Their material is far outside the range of its law: check its stiffness, the loads and \
             the constraints",
                self.point_count()
            ),
        );
        (crushed > 0)
            .then_some(remark)
            .into_iter()
            .chain(penetration_warning(self.boundary.penalty_obstacles.as_deref()))
            .chain(self.node_obstacle_warning())
            .chain(unconverged_warning(self.boundary.rigid_contacts.unconverged_steps))
            .chain(self.null_space_warning())
            .chain(self.detached_points_warning())
            .collect()
    }

    fn frame(&self, wanted: FrameRequest<'_>) -> Frame {
        self.collect_snapshot(wanted).into()
    }

    fn budget(&self) -> Option<Budget> {
        Some(self.collect_budget())
    }

    fn save(&self, out: &mut dyn Write) -> Result<(), SolverError> {
        let saved = CheckpointState {
            format: FORMAT,
            dimension: D,
            shape: self.background.basis_1d.name.to_owned(),
            time: self.clock.time,
            step: self.clock.step,
            travel_since_sort: self.bodies.travel_since_sort,
            next_id: self.bodies.next_id,
            limit: self.clock.limit,
            courant: self.clock.courant,
            limit_age: self.clock.limit_age,
            external_work: self.nodes.external_work,
            driven: self.boundary.driven.iter().map(|driven| driven.state).collect(),
            load_starts: self.boundary.load_starts.clone(),
            sums: self.nodes.sums,
            phase_sums: self.two_phase.as_ref().map(|phases| phases.sums),
            absorbing_displacements: self.boundary.absorbing.displacements.clone().into_iter().collect(),
            reactions: self.boundary.reaction_recorder.as_ref().map(|recorder| recorder.state.clone()),
            obstacle_reactions: self
                .boundary
                .penalty_obstacles
                .iter()
                .flat_map(|all| &all.obstacles)
                .map(|obstacle| obstacle.state)
                .collect(),
            obstacle_history: self
                .boundary
                .penalty_obstacles
                .as_ref()
                .map_or(ObstacleHistory::default(), |all| all.history),
            program_motions: self.boundary.moving_obstacles().map(|moving| moving.program_motion).collect(),
            has_body_force: self.boundary.body_force.is_some(),
            bodies: self.bodies.sets.iter().map(|set| set.body).collect(),
        };
        save_value(&saved, out)?;
        self.bodies.sets.iter().try_for_each(|set| set.write(out))?;
        Ok(())
    }

    fn restore(&mut self, input: &mut dyn Read) -> Result<(), SolverError> {
        let wrong = |what: &str| SolverError::Checkpoint(what.to_owned());
        let saved: CheckpointState = restore_value(input)?;
        if saved.format != FORMAT || saved.dimension != D || saved.shape != self.background.basis_1d.name {
            return Err(wrong("was written by another version or for another case"));
        }
        check_saved_body_force(saved.has_body_force, self.boundary.body_force.is_some())?;
        self.bodies.sets.retain(|set| saved.bodies.contains(&set.body));
        if !self.bodies.sets.iter().map(|set| set.body).eq(saved.bodies) {
            return Err(wrong("contains bodies that the case does not have"));
        }
        self.bodies.sets.iter_mut().try_for_each(|set| set.read(input))?;
        if saved.driven.len() != self.boundary.driven.len() {
            return Err(wrong("contains rigid bodies or patches that the case does not have"));
        }
        if saved.load_starts.len() != self.boundary.load_starts.len() {
            return Err(wrong("contains loads that the case does not have"));
        }
        if saved.obstacle_reactions.len()
            != self.boundary.penalty_obstacles.as_ref().map_or(0, |all| all.obstacles.len())
        {
            return Err(wrong("contains obstacles that the case does not have"));
        }
        if let Some(all) = &mut self.boundary.penalty_obstacles {
            all.obstacles
                .iter_mut()
                .zip(saved.obstacle_reactions)
                .for_each(|(obstacle, state)| obstacle.state = state);
            all.history = saved.obstacle_history;
        }
        let moving = self.boundary.moving_obstacles_mut();
        moving.zip(&saved.program_motions).for_each(|(moving, motion)| moving.program_motion = *motion);
        if let (Some(recorder), Some(reactions)) = (&mut self.boundary.reaction_recorder, saved.reactions) {
            recorder.state = reactions;
        }
        self.boundary.load_starts = saved.load_starts;
        self.boundary.driven.iter_mut().zip(saved.driven).for_each(|(driven, state)| driven.state = state);
        self.clock.time = saved.time;
        self.clock.step = saved.step;
        self.nodes.external_work = saved.external_work;
        self.nodes.sums = saved.sums;
        if let (Some(phases), Some(sums)) = (&mut self.two_phase, saved.phase_sums) {
            phases.sums = sums;
        }
        (self.clock.limit, self.clock.limit_age) = (saved.limit, saved.limit_age);
        self.clock.courant = saved.courant;
        self.boundary.absorbing.displacements = saved.absorbing_displacements.into_iter().collect();
        self.bodies.next_id = saved.next_id;
        self.resize_point_buffers();
        self.restore_layout(saved.travel_since_sort);
        Ok(())
    }
}

impl<const D: usize> MpmSolver<D> {
    /// Warning on points within obstacles that act on the nodes.
    fn node_obstacle_warning(&self) -> Option<Warning> {
        if self.clock.case.obstacles.is_empty() || self.boundary.penalty_obstacles.is_some() {
            return None;
        }
        let places: Vec<[f64; D]> =
            self.bodies.deformable_sets().flat_map(|set| &set.points.position).copied().collect();
        let reason = "obstacles act on the nodes here, and a contact within a cell is not detected (take \
                      smaller cells, or `methods.mpm.obstacles` `points`, which keeps points out)";
        self.clock.case.overlap_warning(&places, REPORTED_DEPTH * self.background.grid.cell, reason)
    }

    /// Restores active nodes and slabs after a restart. The bounds of the slabs come from the checkpoint, so that the order of summation is
    /// that of the uninterrupted run.
    fn restore_layout(&mut self, travel: f64) {
        let slabs: Vec<Vec<usize>> = self.bodies.sets.iter().map(|set| set.slabs.clone()).collect();
        self.find_active_nodes();
        for (set, slabs) in self.bodies.sets.iter_mut().zip(slabs) {
            set.slabs = slabs;
        }
        self.bodies.travel_since_sort = travel;
    }

    /// Restarts the material states of all points from their present stress.
    fn reset_states(&mut self) -> Result<(), SolverError> {
        for number in 0..self.bodies.sets.len() {
            let set = &self.bodies.sets[number];
            let begun = set.law_points().restarted_states(|i| set.points.mass[i] / set.points.volume[i]);
            let (stress, states) =
                begun.map_err(|(index, reason)| point_error(&self.clock, set, index, reason))?;
            self.bodies.sets[number].points.stress = stress;
            self.bodies.sets[number].states = states;
        }
        Ok(())
    }
}
