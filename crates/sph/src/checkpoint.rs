//! Saving and restoring the solver, and the `Solver` face of it.

use colluvium_case::description::{Reset, Stage};
use colluvium_case::measure::Reading;
use colluvium_case::{Budget, Equilibrium, Snapshot, Solver, SolverError, TimeStep};
use colluvium_constitutive::SymTensor;
use serde::{Deserialize, Serialize};

use crate::config::TimeIntegration;
use crate::setup;
use crate::solver::{Audit, Listed, SphSolver};

/// Version of the layout of a checkpoint.
const FORMAT: u32 = 3;

#[derive(Serialize, Deserialize)]
struct Saved {
    format: u32,
    dimension: usize,
    time: f64,
    step: u64,
    last_step: f64,
    limit: Option<TimeStep>,
    limit_age: u64,
    audit: Audit,
    groups: Vec<(u32, usize, Vec<u8>)>,
    id: Vec<u32>,
    origin: Vec<f64>,
    acceleration: Vec<f64>,
    position: Vec<f64>,
    velocity: Vec<f64>,
    mass: Vec<f64>,
    density: Vec<f64>,
    sound: Vec<f64>,
    length: Vec<f64>,
    stress: Vec<SymTensor>,
    /// Of the schemes that need them.
    previous: Vec<f64>,
    gradient: Vec<f64>,
    divergence: Vec<f64>,
    /// Positions for which the neighbours are listed, with time and reach: sums run in the order of the list.
    listed: Vec<f64>,
    listed_at: [f64; 2],
    sorted: Option<u64>,
    accelerated: bool,
}

impl<const D: usize> SphSolver<D> {
    fn to_saved(&self) -> Saved {
        let p = &self.particles;
        let rates = self.options.integration == TimeIntegration::LeapfrogRates
            || self.options.hourglass_viscosity > 0.0;
        let of_group = |group: &crate::particles::Group| {
            (group.body, group.end - group.start, group.material.save(&group.states))
        };
        Saved {
            format: FORMAT,
            dimension: D,
            time: self.time,
            step: self.step,
            last_step: self.last_step,
            limit: self.limit,
            limit_age: self.limit_age,
            audit: self.audit,
            groups: self.groups.iter().map(of_group).collect(),
            id: p.id.clone(),
            origin: p.origin.as_flattened().to_vec(),
            acceleration: p.acceleration.as_flattened().to_vec(),
            position: p.position[..p.len].as_flattened().to_vec(),
            velocity: p.velocity[..p.len].as_flattened().to_vec(),
            mass: p.mass[..p.len].to_vec(),
            density: p.density[..p.len].to_vec(),
            sound: p.sound[..p.len].to_vec(),
            length: p.length[..p.len].to_vec(),
            stress: p.stress[..p.len].to_vec(),
            previous: p.previous.as_flattened().to_vec(),
            gradient: if rates { p.gradient.as_flattened().as_flattened().to_vec() } else { Vec::new() },
            divergence: if rates { p.divergence.clone() } else { Vec::new() },
            listed: self.listed.positions.as_flattened().to_vec(),
            listed_at: [self.listed.time, self.listed.reach],
            sorted: self.sorted,
            accelerated: self.accelerated,
        }
    }

    /// Takes the arrays; `None` where they do not fit together.
    fn take_saved(&mut self, saved: Saved) -> Option<()> {
        let n = saved.id.len();
        let scalars = [&saved.mass, &saved.density, &saved.sound, &saved.length];
        let optional = [&saved.previous, &saved.listed];
        let vectors = [&saved.origin, &saved.acceleration, &saved.position, &saved.velocity];
        let fits = scalars.iter().all(|a| a.len() == n)
            && vectors.iter().all(|a| a.len() == n * D)
            && saved.stress.len() == n
            && optional.iter().all(|a| a.is_empty() || a.len() == n * D)
            && (saved.gradient.is_empty() || saved.gradient.len() == n * D * D)
            && (saved.divergence.is_empty() || saved.divergence.len() == n)
            && saved.groups.iter().map(|(_, count, _)| count).sum::<usize>() == n;
        if !fits {
            return None;
        }
        self.groups.retain(|group| saved.groups.iter().any(|(body, ..)| *body == group.body));
        if self.groups.len() != saved.groups.len() {
            return None;
        }
        let mut start = 0;
        for (group, (body, count, states)) in self.groups.iter_mut().zip(&saved.groups) {
            let states = group.material.load(states)?;
            if group.body != *body || states.len() != *count {
                return None;
            }
            (group.start, group.end, group.states) = (start, start + count, states);
            start += count;
        }
        let vectors = |flat: &[f64]| -> Vec<[f64; D]> { flat.as_chunks().0.to_vec() };
        let p = &mut self.particles;
        p.len = n;
        p.id = saved.id;
        p.origin = vectors(&saved.origin);
        p.acceleration = vectors(&saved.acceleration);
        p.position = vectors(&saved.position);
        p.velocity = vectors(&saved.velocity);
        (p.mass, p.density, p.sound, p.stress) = (saved.mass, saved.density, saved.sound, saved.stress);
        (p.length, p.previous) = (saved.length, vectors(&saved.previous));
        p.gradient.clear();
        p.gradient.extend(saved.gradient.chunks_exact(D * D).map(|entries| {
            let mut matrix = [[0.0; D]; D];
            matrix.as_flattened_mut().copy_from_slice(entries);
            matrix
        }));
        p.divergence = saved.divergence;
        p.spread.clear();
        p.resize(n);
        let [time, reach] = saved.listed_at;
        self.listed = Listed { positions: vectors(&saved.listed), time, reach };
        (self.sorted, self.accelerated) = (saved.sorted, saved.accelerated);
        (self.time, self.step, self.last_step) = (saved.time, saved.step, saved.last_step);
        (self.limit, self.limit_age) = (saved.limit, saved.limit_age);
        self.audit = saved.audit;
        Some(())
    }

    fn remove_bodies(&mut self, stage: usize) {
        let case = std::sync::Arc::clone(&self.case);
        let is_gone =
            |group: &crate::particles::Group| case.is_removed(&case.bodies[group.body as usize].name, stage);
        while let Some(number) = self.groups.iter().position(is_gone) {
            let range = self.groups.remove(number).range();
            for group in &mut self.groups[number..] {
                group.start -= range.len();
                group.end -= range.len();
            }
            self.particles.remove(range);
        }
    }

    pub(crate) fn reset_states(&mut self) -> Result<(), SolverError> {
        for number in 0..self.groups.len() {
            let (group, p) = (&self.groups[number], &self.particles);
            let begun = p.law_points(group).begun_anew(|k| p.density[group.start + k]);
            let (stress, states) =
                begun.map_err(|(index, reason)| self.failed(group.start + index, reason))?;
            let range = self.groups[number].range();
            self.particles.stress[range].copy_from_slice(&stress);
            self.groups[number].states = states;
        }
        Ok(())
    }
}

impl<const D: usize> Solver for SphSolver<D> {
    fn time(&self) -> f64 {
        self.time
    }

    fn step_count(&self) -> u64 {
        self.step
    }

    fn points(&self) -> usize {
        self.particles.len
    }

    fn time_step(&mut self) -> TimeStep {
        self.critical_step()
    }

    fn step(&mut self, dt: f64) -> Result<(), SolverError> {
        self.advance(dt)
    }

    fn begin_stage(&mut self, stage: usize, start: f64) -> Result<(), SolverError> {
        let fresh = start == self.time;
        (self.stage, self.stage_start) = (stage, start);
        self.walls = setup::walls(&self.case, stage, &self.options, self.smoothing.radius());
        self.remove_bodies(stage);
        if fresh {
            self.accelerated = false;
            self.listed.positions.clear();
            self.audit = Audit::default();
            self.limit = None;
        } else if !self.listed.positions.is_empty() {
            self.make_lists()?;
        }
        Ok(())
    }

    fn end_stage(&mut self, stage: &Stage) -> Result<(), SolverError> {
        for reset in &stage.reset {
            let p = &mut self.particles;
            match reset {
                Reset::Velocity => {
                    p.velocity.fill([0.0; D]);
                    p.acceleration.fill([0.0; D]);
                    p.previous.clear();
                    // Some schemes move what is held before they kick.
                    self.hold();
                    // The next step starts from rest: it kicks by half.
                    self.last_step = 0.0;
                }
                Reset::Displacement => {
                    let len = p.len;
                    p.origin.copy_from_slice(&p.position[..len]);
                }
                Reset::State => self.reset_states()?,
            }
        }
        Ok(())
    }

    fn equilibrium(&self) -> Option<Equilibrium> {
        self.case.stages[self.stage].equilibrium?;
        let scales = self.scales();
        Some(Equilibrium {
            unbalanced_force: scales.force_ratio(self.audit.unbalanced.sqrt(), self.audit.external.sqrt()),
            kinetic_ratio: scales.energy_ratio(self.audit.kinetic, self.audit.work),
            kinetic: self.audit.kinetic,
        })
    }

    fn has_grown(&self) -> bool {
        self.is_confined()
    }

    fn readings(&self) -> Vec<Reading> {
        self.take_readings()
    }

    fn snapshot(&self) -> Snapshot {
        self.take_snapshot()
    }

    fn budget(&self) -> Budget {
        self.take_budget()
    }

    fn save(&self) -> Vec<u8> {
        postcard::to_stdvec(&self.to_saved()).expect("plain numbers always serialise")
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), SolverError> {
        let saved: Saved = postcard::from_bytes(bytes)
            .map_err(|error| SolverError::Checkpoint(format!("cannot be read ({error})")))?;
        if saved.format != FORMAT || saved.dimension != D {
            let problem = "was written by another version or for another case";
            return Err(SolverError::Checkpoint(problem.to_owned()));
        }
        self.take_saved(saved).ok_or_else(|| {
            SolverError::Checkpoint("its arrays do not fit together or the case".to_owned())
        })?;
        if self.listed.positions.is_empty() { Ok(()) } else { self.make_lists() }
    }
}
