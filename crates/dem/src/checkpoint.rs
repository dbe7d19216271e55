//! Checkpoints of the solver, and its implementation of the `Solver` trait.

use std::collections::BTreeMap;
use std::io::{self, Read, Write};

use colluvium_case::description::{Reset, Stage};
use colluvium_case::measure::ScalarOutput;
use colluvium_case::{
    Advance, Budget, Equilibrium, Frame, FrameRequest, ProgramMotion, Reaction, Solver, SolverError,
    TimeStep, check_saved_body_force, spatial,
};
use colluvium_points::struct_of_arrays::{invalid_data, read_column, write_column};
use serde::{Deserialize, Serialize};

use crate::boundary::walls::RigidWall;
use crate::contact::contact_histories::PairList;
use crate::contact::contact_laws::GrainSizes;
use crate::neighbours::grain_neighbours::{GrainNeighbours, SinceListBuild};
use crate::obstacles::facet::FacetContact;
use crate::output::energy_balance::{BrokenBond, EnergyBalance};
use crate::output::stress_control_check::{ControlledStress, missed_stress_warnings};
use crate::setup::stage_changes::enter_stage;
use crate::solver::DemSolver;
use crate::specimen::pluviation::EnteredGrains;
use crate::specimen::pluviation_entry::full_source_warning;
use colluvium_case::Warning;

/// Version of the layout of a checkpoint.
const FORMAT: u32 = 15;

/// State of the solver in a checkpoint, except the columns.
#[derive(Serialize, Deserialize)]
struct CheckpointState {
    format: u32,
    dimension: usize,
    time: f64,
    step: u64,
    last_step: f64,
    max_speed: f64,
    deep_share: f64,
    energy_balance: EnergyBalance,
    virial: Vec<f64>,
    /// Vectors, rates and mean rates of the cell, and the vectors at the last list build.
    cell: Vec<f64>,
    since_list_build: Option<(Vec<f64>, f64, f64)>,
    walls: Vec<(u32, Vec<f64>)>,
    program: ProgramState,
    broken: Vec<BrokenBond>,
    grain_sizes: GrainSizes,
    entered_grains: Vec<EnteredGrains>,
    next_id: u32,
    controlled_stresses: Vec<ControlledStress>,
}

/// Motions that a program prescribes, and the presence of its body force, in a checkpoint.
#[derive(Serialize, Deserialize)]
struct ProgramState {
    has_body_force: bool,
    /// Velocity of each wall that a program moves (m/s).
    wall_velocities: Vec<Option<Vec<f64>>>,
    /// Motion of each wall that is a moving obstacle, where a program prescribes it.
    obstacle_motions: Vec<Option<ProgramMotion>>,
    /// Velocities of the bodies that a program moves (m/s).
    body_velocities: Vec<(u32, Vec<f64>)>,
    /// Velocity gradient of the cell, where a program prescribes it (1/s).
    cell_gradient: Option<Vec<f64>>,
}

/// Entries of a matrix, one row after another.
fn flattened_matrix<const D: usize>(matrix: &[[f64; D]; D]) -> Vec<f64> {
    matrix.as_flattened().to_vec()
}

/// Matrix of the entries of its rows in sequence; `None` for a wrong number of entries.
fn matrix<const D: usize>(flat: &[f64]) -> Option<[[f64; D]; D]> {
    let mut out = [[0.0; D]; D];
    let entries = out.as_flattened_mut();
    if entries.len() != flat.len() {
        return None;
    }
    entries.copy_from_slice(flat);
    Some(out)
}

/// Writes pairs of grains with their contact histories to a checkpoint.
fn write_pairs<const R: usize>(pairs: &PairList<R>, out: &mut dyn Write) -> io::Result<()> {
    write_column(&pairs.row_offsets, |value| value, out)?;
    write_column(&pairs.second, |value| value, out)?;
    write_column(&pairs.image, |value| value, out)?;
    pairs.histories.write(out)
}

/// Reads pairs of `count` grains from a checkpoint and checks that their indices are valid.
fn read_pairs<const R: usize>(pairs: &mut PairList<R>, count: usize, input: &mut dyn Read) -> io::Result<()> {
    read_column(&mut pairs.row_offsets, |value: u32| value, input)?;
    read_column(&mut pairs.second, |value: u32| value, input)?;
    read_column(&mut pairs.image, |value: u8| value, input)?;
    pairs.histories.read(input)?;
    let ends = pairs.row_offsets.is_empty() && pairs.second.is_empty()
        || pairs.row_offsets.len() == count + 1 && pairs.row_offsets[count] as usize == pairs.second.len();
    let sorted = pairs.row_offsets.windows(2).all(|pair| pair[0] <= pair[1]);
    let within = pairs.second.iter().all(|&j| (j as usize) < count);
    let images = pairs.image.is_empty() || pairs.image.len() == pairs.second.len();
    if ends && sorted && within && images && pairs.histories.len() == pairs.second.len() {
        Ok(())
    } else {
        Err(invalid_data("the lists of pairs do not match the grains"))
    }
}

impl<const D: usize, const R: usize> DemSolver<D, R> {
    /// Writes the state of the solver to a checkpoint.
    pub(crate) fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let GrainNeighbours { pairs, walls: near, since_build, .. } = &self.neighbours;
        let geometry = &self.cell.geometry;
        let mut cell = flattened_matrix(&geometry.h);
        cell.extend(flattened_matrix(&geometry.velocity_gradient));
        cell.extend(flattened_matrix(&geometry.mean_velocity_gradient));
        let wall = |wall: &RigidWall<D>| {
            let mut numbers = vec![wall.position];
            numbers.extend(wall.velocity);
            numbers.extend(wall.reaction.as_flattened());
            numbers.extend(&wall.moment);
            (wall.boundary as u32, numbers)
        };
        let head = CheckpointState {
            format: FORMAT,
            dimension: D,
            time: self.clock.time,
            step: self.clock.step,
            last_step: self.clock.last_step,
            max_speed: self.extremes.with_changed_velocities(&self.grains).max_speed,
            deep_share: self.clock.deep_contact_factor,
            energy_balance: self.records.energy_balance,
            virial: self.cell.virial.iter().flat_map(flattened_matrix).collect(),
            cell,
            since_list_build: since_build
                .cell
                .map(|then| (flattened_matrix(&then), since_build.grain_travel, since_build.wall_travel)),
            walls: self.boundary.walls.iter().map(wall).collect(),
            program: self.program_state(),
            broken: self.records.broken_bonds.clone(),
            grain_sizes: self.laws.sizes.clone(),
            entered_grains: self.specimen.sources.iter().map(|source| source.entered_grains).collect(),
            next_id: self.specimen.next_id,
            controlled_stresses: self.records.controlled_stresses.clone(),
        };
        let head = postcard::to_stdvec(&head).map_err(io::Error::other)?;
        write_column(&head, |byte| byte, out)?;
        self.grains.write(out)?;
        write_pairs(&pairs.slab_pairs, out)?;
        write_pairs(&pairs.periodic_pairs, out)?;
        write_column(&pairs.slabs, |value| value, out)?;
        write_column(&near.grain, |value| value, out)?;
        write_column(&near.wall, |value| value, out)?;
        write_column(&near.slabs, |value| value, out)?;
        write_column(&near.facet_key, |value| value, out)?;
        let facets: Vec<f64> =
            near.facet.iter().flat_map(|f| [f.distance, f.normal[0], f.normal[1], f.normal[2]]).collect();
        write_column(&facets, |value| value, out)?;
        near.history.write(out)
    }

    /// Actions of a program for a checkpoint.
    fn program_state(&self) -> ProgramState {
        let boundary = &self.boundary;
        let of_wall = |wall: &RigidWall<D>| wall.program_velocity.map(|velocity| velocity.to_vec());
        ProgramState {
            has_body_force: boundary.body_force.acting.is_some(),
            wall_velocities: boundary.walls.iter().map(of_wall).collect(),
            obstacle_motions: boundary.walls.iter().map(RigidWall::program_motion).collect(),
            body_velocities: boundary.body_velocities.iter().map(|(body, v)| (*body, v.to_vec())).collect(),
            cell_gradient: self.cell.program_gradient.as_ref().map(flattened_matrix),
        }
    }

    /// Restores the motions that a program prescribes; `None` if they do not match the case.
    fn restore_program(&mut self, saved: ProgramState) -> Option<()> {
        let vector = |numbers: Vec<f64>| <[f64; D]>::try_from(numbers).ok();
        for (wall, saved) in self.boundary.walls.iter_mut().zip(saved.wall_velocities) {
            wall.program_velocity = saved.map_or(Some(None), |numbers| vector(numbers).map(Some))?;
        }
        let body = |(body, numbers)| Some((body, vector(numbers)?));
        let velocities: Option<BTreeMap<u32, [f64; D]>> =
            saved.body_velocities.into_iter().map(body).collect();
        self.boundary.body_velocities = velocities?;
        self.cell.program_gradient =
            saved.cell_gradient.map_or(Some(None), |flat| matrix(&flat).map(Some))?;
        Some(())
    }

    /// Reads the state of the solver from a checkpoint; an error if it is of another format, dimension or case.
    pub(crate) fn read(&mut self, input: &mut dyn Read) -> io::Result<()> {
        let mut bytes: Vec<u8> = Vec::new();
        read_column(&mut bytes, |byte: u8| byte, input)?;
        let head: CheckpointState = postcard::from_bytes(&bytes).map_err(io::Error::other)?;
        if head.format != FORMAT || head.dimension != D {
            return Err(invalid_data("was written by another version or for another case"));
        }
        check_saved_body_force(head.program.has_body_force, self.boundary.body_force.acting.is_some())
            .map_err(io::Error::other)?;
        self.boundary.membranes.clear();
        self.grains.read(input)?;
        let GrainNeighbours { pairs, walls: near, .. } = &mut self.neighbours;
        let count = self.grains.len();
        self.extremes.radii = self.grains.radii();
        read_pairs(&mut pairs.slab_pairs, count, input)?;
        read_pairs(&mut pairs.periodic_pairs, count, input)?;
        pairs.active_pairs.clear();
        read_column(&mut pairs.slabs, |value: u32| value, input)?;
        read_column(&mut near.grain, |value: u32| value, input)?;
        read_column(&mut near.wall, |value: u32| value, input)?;
        read_column(&mut near.slabs, |value: u32| value, input)?;
        read_column(&mut near.facet_key, |value: u64| value, input)?;
        let mut facets: Vec<f64> = Vec::new();
        read_column(&mut facets, |value: f64| value, input)?;
        let facet = |v: &[f64]| FacetContact { distance: v[0], normal: [v[1], v[2], v[3]] };
        near.facet = facets.chunks_exact(4).map(facet).collect();
        near.history.read(input)?;
        let fits = near.history.len() == near.grain.len()
            && near.wall.len() == near.grain.len()
            && near.slabs.len() == pairs.slabs.len()
            && near.facet_key.len() == near.facet.len()
            && (near.facet_key.is_empty() || near.facet_key.len() == near.grain.len())
            && near.grain.iter().all(|&i| (i as usize) < count);
        if !fits {
            return Err(invalid_data("the lists of walls do not match the grains"));
        }
        self.boundary.membranes.find_grains(&self.clock, &self.grains);
        self.restore_state(head).ok_or_else(|| invalid_data("the cell or the walls do not match the case"))
    }

    /// Restores cell, walls and records from the first part of a checkpoint; `None` if it does not match the case.
    fn restore_state(&mut self, head: CheckpointState) -> Option<()> {
        let third = head.cell.len() / 3;
        self.cell.geometry.h = matrix(&head.cell[..third])?;
        self.cell.geometry.velocity_gradient = matrix(&head.cell[third..2 * third])?;
        self.cell.geometry.mean_velocity_gradient = matrix(&head.cell[2 * third..])?;
        let half = head.virial.len() / 2;
        self.cell.virial = [matrix(&head.virial[..half])?, matrix(&head.virial[half..])?];
        self.neighbours.since_build = SinceListBuild::default();
        if let Some((then, moved, others)) = head.since_list_build {
            self.neighbours.since_build =
                SinceListBuild { cell: Some(matrix(&then)?), grain_travel: moved, wall_travel: others };
        }
        self.boundary
            .walls
            .retain(|wall| head.walls.iter().any(|(boundary, _)| *boundary as usize == wall.boundary));
        if self.boundary.walls.len() != head.walls.len() {
            return None;
        }
        for (wall, motion) in self.boundary.walls.iter_mut().zip(&head.program.obstacle_motions) {
            wall.set_program_motion(*motion);
        }
        for (wall, (_, numbers)) in self.boundary.walls.iter_mut().zip(&head.walls) {
            let ([position], motion) = numbers.split_first_chunk()?;
            let (velocity, reaction) = motion.split_at_checked(D)?;
            wall.position = *position;
            wall.velocity = <[f64; D]>::try_from(velocity).ok()?;
            if let Some(moving) = &mut wall.motion {
                moving.move_to(head.time);
                moving.set_mean_velocity(head.time, head.last_step);
            }
            let (reaction, moment) = reaction.split_at_checked(2 * D)?;
            let (force, impulse) = reaction.split_at(D);
            wall.moment = <[f64; 3]>::try_from(moment).ok()?;
            wall.reaction = [<[f64; D]>::try_from(force).ok()?, <[f64; D]>::try_from(impulse).ok()?];
        }
        self.restore_program(head.program)?;
        self.extremes.is_outdated = false;
        (self.clock.time, self.clock.step, self.clock.last_step, self.extremes.max_speed) =
            (head.time, head.step, head.last_step, head.max_speed);
        (self.clock.deep_contact_factor, self.records.energy_balance) =
            (head.deep_share, head.energy_balance);
        (self.records.broken_bonds, self.specimen.next_id) = (head.broken, head.next_id);
        if self.specimen.sources.len() != head.entered_grains.len()
            || self.laws.kinds.len() != head.grain_sizes.smallest.len()
            || self.records.controlled_stresses.len() != head.controlled_stresses.len()
        {
            return None;
        }
        self.records.controlled_stresses = head.controlled_stresses;
        self.laws.sizes = head.grain_sizes;
        for (source, entered) in self.specimen.sources.iter_mut().zip(head.entered_grains) {
            source.entered_grains = entered;
        }
        Some(())
    }
}

impl<const D: usize, const R: usize> Solver for DemSolver<D, R> {
    fn time(&self) -> f64 {
        self.clock.time
    }

    fn step_count(&self) -> u64 {
        self.clock.step
    }

    fn point_count(&self) -> usize {
        self.grains.len()
    }

    fn limit(&mut self) -> TimeStep {
        self.present_limit()
    }

    fn step(&mut self, at_most: f64) -> Result<Advance, SolverError> {
        self.take_step(at_most)
    }

    fn begin_stage(&mut self, stage: usize, start: f64) -> Result<(), SolverError> {
        let is_new = start == self.clock.time;
        (self.clock.stage, self.clock.stage_start) = (stage, start);
        enter_stage(self, is_new)
    }

    fn resume_stage(&mut self, stage: usize, start: f64) -> Result<(), SolverError> {
        (self.clock.stage, self.clock.stage_start) = (stage, start);
        enter_stage(self, false)
    }

    fn end_stage(&mut self, stage: &Stage) -> Result<(), SolverError> {
        for reset in &stage.reset {
            match reset {
                Reset::Velocity => {
                    let g = &mut self.grains;
                    for (velocity, _) in g.velocity.iter_mut().zip(&g.is_held).filter(|(_, held)| !**held) {
                        *velocity = [0.0; D];
                    }
                    g.spin.fill([0.0; R]);
                    // The next step starts from rest: its kick lasts half a step.
                    self.clock.last_step = 0.0;
                    for moving in self.boundary.walls.iter_mut().filter_map(|wall| wall.motion.as_mut()) {
                        moving.set_mean_velocity(self.clock.time, 0.0);
                    }
                }
                Reset::Displacement => self.grains.origin.clone_from(&self.grains.position),
                Reset::State => self.neighbours.reset_contacts(),
            }
        }
        Ok(())
    }

    fn equilibrium(&self) -> Option<Equilibrium> {
        let kinetic = self.records.energy_balance.kinetic + self.records.energy_balance.rotation;
        let elastic = self.records.energy_balance.recoverable();
        let kinetic_ratio = match (kinetic, elastic) {
            (0.0, _) => 0.0,
            (_, 0.0) => f64::INFINITY,
            _ => kinetic / elastic,
        };
        Some(Equilibrium { unbalanced_force: self.view().unbalanced_ratio(), kinetic_ratio, kinetic })
    }

    fn scalar_outputs(&self) -> Vec<ScalarOutput> {
        self.view().collect_scalar_outputs()
    }

    fn reaction(&self, name: &str) -> Option<Reaction> {
        let Some(wall) = self.boundary.walls.iter().find(|wall| wall.name == name) else {
            return self.view().reaction_of_body(name);
        };
        let [force, impulse] = wall.reaction.map(|of| spatial(&of));
        Some(Reaction { force, impulse, moment: wall.surface.is_some().then_some(wall.moment) })
    }

    fn dissipated(&self) -> Option<f64> {
        Some(self.records.energy_balance.dissipated())
    }

    fn warning(&self) -> Option<Warning> {
        if let Some(full) = full_source_warning(&self.clock, &self.specimen) {
            return Some(full);
        }
        // Sheet: dem §3.5.
        (self.records.energy_balance.overlap > 0.05).then(|| {
            Warning::new("soft-grains", format!(
                "t = {:.4e} s: overlaps reach {:.3} of the smaller radius, more than 0.05: the solid fraction and the \
                 number of contacts are affected by soft grains (make contacts stiffer)",
                self.clock.time, self.records.energy_balance.overlap
            ))
        })
    }

    fn warnings_at_end(&self) -> Vec<Warning> {
        self.specimen
            .source
            .notes
            .iter()
            .cloned()
            .chain(missed_stress_warnings::<D>(&self.clock, &self.records.controlled_stresses))
            .collect()
    }

    fn notes(&self) -> Vec<Warning> {
        self.specimen
            .reports
            .iter()
            .map(|specimen| Warning::new("specimen-state", format!("at the start, {specimen}")))
            .collect()
    }

    fn frame(&self, wanted: FrameRequest<'_>) -> Frame {
        self.view().collect_frame(wanted)
    }

    fn budget(&self) -> Option<Budget> {
        Some(self.view().collect_budget())
    }

    fn specimen(&self) -> Option<String> {
        Some(self.view().specimen_text())
    }

    fn has_specimen(&self) -> bool {
        true
    }

    fn save(&self, out: &mut dyn Write) -> Result<(), SolverError> {
        self.write(out).map_err(|error| SolverError::Checkpoint(error.to_string()))
    }

    fn restore(&mut self, input: &mut dyn Read) -> Result<(), SolverError> {
        self.read(input).map_err(|error| {
            error.downcast().unwrap_or_else(|error| SolverError::Checkpoint(error.to_string()))
        })
    }
}
