//! Checkpoints of the solver, and its implementation of `Solver`.

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

use crate::clock::Clock;
use crate::config::TimeIntegration;
use crate::momentum::confining_pressure::is_confined;
use crate::neighbours::verlet_lists::ListedPositions;
use crate::points::particles::ParticleGroup;
use crate::points::rigid_body::RigidBody;
use crate::rates::ReactionSum;
use crate::solver::{EquilibriumTerms, SphSolver};
use crate::walls::{ObstacleEnergies, flat_walls};
use colluvium_case::Warning;

/// Version of the checkpoint format.
const FORMAT: u32 = 15;

/// State of the solver in a checkpoint.
#[derive(Serialize, Deserialize)]
struct CheckpointState {
    format: u32,
    dimension: usize,
    next_id: u32,
    clock: Clock,
    equilibrium_terms: EquilibriumTerms,
    obstacle_energies: ObstacleEnergies,
    /// Body, number of particles and states of the law.
    groups: Vec<(u32, usize, Vec<u8>)>,
    /// Rigid bodies of these groups, in this order.
    rigid: Vec<Option<RigidBody>>,
    /// Velocities of these groups by the program (m/s).
    program_velocities: Vec<Option<[f64; 3]>>,
    /// Columns of the particles, and of their rates.
    particles: Vec<u8>,
    rates: Vec<u8>,
    /// Positions of the last neighbour list, with time and reach: the order of sums is that of the list.
    listed_positions: Vec<f64>,
    listed_at: [f64; 2],
    last_sort: Option<u64>,
    is_current: bool,
    /// Start times of loads (s), and the load vectors of particles.
    loads: (Vec<f64>, Vec<Vec<f64>>),
    /// Reactions of rigid bodies and obstacles.
    reactions: Vec<ReactionSum>,
    /// Motions of the moving obstacles by the program.
    program_motions: Vec<Option<ProgramMotion>>,
    /// Whether a body force of the program acts.
    has_body_force: bool,
}

impl<const D: usize> SphSolver<D> {
    /// State of the solver for a checkpoint, without image and wall particles.
    fn checkpoint_state(&self) -> CheckpointState {
        let Self { setting, bodies, lists, rates, .. } = self;
        // Neither images nor walls.
        let mut particles = bodies.particles.clone();
        particles.truncate(particles.len());
        // Computed at the beginning of each step.
        particles.body_force.clear();
        let mut of = rates.derivatives.clone();
        let predicts = setting.options.integration == TimeIntegration::LeapfrogRates
            || setting.options.hourglass_viscosity > 0.0;
        if !predicts {
            (of.gradient, of.divergence) = (Vec::new(), Vec::new());
        }
        let (mut particle_bytes, mut rate_bytes) = (Vec::new(), Vec::new());
        particles.write(&mut particle_bytes).expect("memory takes all bytes");
        of.write(&mut rate_bytes).expect("memory takes all bytes");
        let of_group =
            |group: &ParticleGroup| (group.body, group.end - group.start, group.material.save(&group.states));
        CheckpointState {
            format: FORMAT,
            dimension: D,
            next_id: bodies.next_id,
            clock: self.clock,
            equilibrium_terms: self.equilibrium_terms,
            obstacle_energies: self.obstacle_energies,
            groups: bodies.groups.iter().map(of_group).collect(),
            rigid: bodies.groups.iter().map(|group| group.rigid).collect(),
            program_velocities: bodies.groups.iter().map(|group| group.program_velocity).collect(),
            particles: particle_bytes,
            rates: rate_bytes,
            listed_positions: lists.listed_positions.positions.as_flattened().to_vec(),
            listed_at: [lists.listed_positions.time, lists.listed_positions.list_radius],
            last_sort: lists.last_sort,
            is_current: rates.is_current,
            loads: bodies.loads.checkpoint_state(),
            reactions: rates.reactions.clone(),
            program_motions: self
                .walls
                .obstacles
                .moving_obstacles()
                .map(|moving| moving.program_motion)
                .collect(),
            has_body_force: bodies.loads.body_force.is_some(),
        }
    }

    /// Restores a saved state; `None` if its arrays are inconsistent.
    fn restore_state(&mut self, saved: &CheckpointState) -> Option<()> {
        let Self { bodies, lists, rates, .. } = self;
        bodies.particles.read(&mut saved.particles.as_slice()).ok()?;
        rates.derivatives.read(&mut saved.rates.as_slice()).ok()?;
        let p = &bodies.particles;
        let n = p.len();
        let full = [p.origin.len(), p.position.len(), p.velocity.len(), p.mass.len(), p.density.len()];
        let fits =
            full.iter().chain(&[p.stress.len(), p.sound.len(), p.length.len()]).all(|count| *count == n)
                && (p.delayed_pressure.is_empty() || p.delayed_pressure.len() == n)
                && rates.derivatives.len() == n
                && (saved.listed_positions.is_empty() || saved.listed_positions.len() == n * D)
                && saved.groups.iter().map(|(_, count, _)| count).sum::<usize>() == n;
        if !fits {
            return None;
        }
        bodies.groups.retain(|group| saved.groups.iter().any(|(body, ..)| *body == group.body));
        let count = saved.groups.len();
        if [bodies.groups.len(), saved.rigid.len(), saved.program_velocities.len()] != [count; 3] {
            return None;
        }
        let of_groups = saved.rigid.iter().zip(&saved.program_velocities);
        for (group, (rigid, velocity)) in bodies.groups.iter_mut().zip(of_groups) {
            (group.rigid, group.program_velocity) = (*rigid, *velocity);
        }
        let mut start = 0;
        for (group, (body, count, states)) in bodies.groups.iter_mut().zip(&saved.groups) {
            let states = group.material.load(states)?;
            if group.body != *body || states.len() != *count {
                return None;
            }
            (group.start, group.end, group.states) = (start, start + count, states);
            start += count;
        }
        bodies.next_id = saved.next_id;
        let moving = self.walls.obstacles.moving_obstacles_mut();
        moving.zip(&saved.program_motions).for_each(|(moving, motion)| moving.program_motion = *motion);
        bodies.loads.restore_state(&saved.loads)?;
        bodies.pair_data.grad_h_factor.clear();
        bodies.resize(n);
        rates.derivatives.resize(n);
        let [time, list_radius] = saved.listed_at;
        lists.listed_positions =
            ListedPositions { positions: saved.listed_positions.as_chunks().0.to_vec(), time, list_radius };
        (lists.last_sort, rates.is_current) = (saved.last_sort, saved.is_current);
        rates.reactions.clone_from(&saved.reactions);
        (self.clock, self.equilibrium_terms, self.obstacle_energies) =
            (saved.clock, saved.equilibrium_terms, saved.obstacle_energies);
        Some(())
    }

    /// Restarts the material states of all particles from their present stress.
    pub(crate) fn reset_states(&mut self) -> Result<(), SolverError> {
        let Self { clock, bodies, .. } = self;
        let p = &mut bodies.particles;
        for group in &mut bodies.groups {
            let begun = p.law_points(group).restarted_states(|k| p.density[group.start + k]);
            let (stress, states) =
                begun.map_err(|(index, reason)| p.particle_error(clock, group.start + index, reason))?;
            p.stress[group.range()].copy_from_slice(&stress);
            group.states = states;
        }
        Ok(())
    }

    /// Builds the neighbour lists.
    fn make_lists(&mut self) -> Result<(), SolverError> {
        let Self { setting, clock, bodies, walls, lists, .. } = self;
        lists.build(setting, clock, bodies, walls)
    }
}

impl<const D: usize> SphSolver<D> {
    /// Sets the stage with its walls, and removes the bodies that it does not have.
    fn enter_stage(&mut self, stage: usize, start: f64) {
        let Self { setting, clock, bodies, walls, rates, .. } = self;
        (clock.stage, clock.stage_start) = (stage, start);
        walls.planes = flat_walls(&setting.case, stage, &setting.options, setting.smoothing.radius());
        bodies.remove_inactive(&setting.case, stage, &mut rates.derivatives);
    }
}

impl<const D: usize> Solver for SphSolver<D> {
    fn time(&self) -> f64 {
        self.clock.time
    }

    fn step_count(&self) -> u64 {
        self.clock.step
    }

    fn point_count(&self) -> usize {
        self.bodies.particles.len()
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
        if start != self.clock.time {
            return self.resume_stage(stage, start);
        }
        self.enter_stage(stage, start);
        let Self { setting, clock, bodies, lists, rates, equilibrium_terms, .. } = self;
        bodies.loads.begin_stage(&setting.case, stage, start);
        rates.is_current = false;
        lists.listed_positions.positions.clear();
        *equilibrium_terms = EquilibriumTerms::default();
        clock.limit = None;
        Ok(())
    }

    fn resume_stage(&mut self, stage: usize, start: f64) -> Result<(), SolverError> {
        self.enter_stage(stage, start);
        if self.lists.listed_positions.positions.is_empty() { Ok(()) } else { self.make_lists() }
    }

    fn end_stage(&mut self, stage: &Stage) -> Result<(), SolverError> {
        for reset in &stage.reset {
            let p = &mut self.bodies.particles;
            match reset {
                Reset::Velocity => {
                    p.velocity.fill([0.0; D]);
                    p.previous.clear();
                    self.bodies
                        .groups
                        .iter_mut()
                        .filter_map(|group| group.rigid.as_mut())
                        .for_each(RigidBody::set_at_rest);
                    self.rates.derivatives.acceleration.fill([0.0; D]);
                    // Some schemes move held bodies before the kick.
                    self.bodies.impose_held_velocities();
                    // The next step starts from rest, with a kick by half a step.
                    self.clock.last_step = 0.0;
                }
                Reset::Displacement => {
                    let len = p.len();
                    p.origin.copy_from_slice(&p.position[..len]);
                }
                Reset::State => self.reset_states()?,
            }
        }
        Ok(())
    }

    fn equilibrium(&self) -> Option<Equilibrium> {
        self.setting.case.stages[self.clock.stage].equilibrium?;
        let scales = self.equilibrium_scales();
        Some(Equilibrium {
            unbalanced_force: scales.force_ratio(
                self.equilibrium_terms.unbalanced.sqrt(),
                self.equilibrium_terms.external.sqrt(),
            ),
            kinetic_ratio: scales.energy_ratio(self.equilibrium_terms.kinetic, self.equilibrium_terms.work),
            kinetic: self.equilibrium_terms.kinetic,
        })
    }

    fn ramps_are_complete(&self) -> bool {
        is_confined(&self.setting, &self.clock)
    }

    fn scalar_outputs(&self) -> Vec<ScalarOutput> {
        self.collect_scalar_outputs()
    }

    fn reaction(&self, name: &str) -> Option<Reaction> {
        let case = &self.setting.case;
        let reaction = |number: usize| self.rates.reactions.get(number).copied().unwrap_or_default();
        if let Some(number) = case.bodies.iter().position(|body| body.rigid && body.name == name) {
            let ReactionSum { force, impulse, .. } = reaction(number);
            return Some(Reaction { force, impulse, moment: None });
        }
        let number = self.walls.obstacles.recorded_obstacles().find(|(_, own)| *own == name)?.0;
        let ReactionSum { force, impulse, moment } = reaction(case.bodies.len() + number);
        Some(Reaction { force, impulse, moment: Some(moment) })
    }

    fn warnings_at_end(&self) -> Vec<Warning> {
        unconverged_warning(self.rates.unconverged_supports).into_iter().collect()
    }

    fn is_isolated(&self) -> bool {
        self.is_energetically_closed()
    }

    fn frame(&self, wanted: FrameRequest<'_>) -> Frame {
        self.collect_snapshot(wanted).into()
    }

    fn budget(&self) -> Option<Budget> {
        Some(self.collect_budget())
    }

    fn save(&self, out: &mut dyn Write) -> Result<(), SolverError> {
        save_value(&self.checkpoint_state(), out)
    }

    fn restore(&mut self, input: &mut dyn Read) -> Result<(), SolverError> {
        let saved: CheckpointState = restore_value(input)?;
        if saved.format != FORMAT || saved.dimension != D {
            let problem = "was written by another version or for another case";
            return Err(SolverError::Checkpoint(problem.to_owned()));
        }
        check_saved_body_force(saved.has_body_force, self.bodies.loads.body_force.is_some())?;
        self.restore_state(&saved).ok_or_else(|| {
            SolverError::Checkpoint("its arrays do not fit together or the case".to_owned())
        })?;
        if self.lists.listed_positions.positions.is_empty() { Ok(()) } else { self.make_lists() }
    }
}
