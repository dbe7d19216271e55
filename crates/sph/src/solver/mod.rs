//! The solver: its data, its lists and one step (SPH sheet §3.3).

mod lists;
mod motion;
mod records;
mod schemes;
mod stress;
mod wall_fields;

pub use lists::Listed;
pub use schemes::Kept;

pub(crate) use motion::decay;
pub(crate) use stress::Over;

use std::sync::Arc;

use colluvium_case::{Case, SolverError, TimeStep, spatial};
use colluvium_constitutive::SymTensor;
use colluvium_points::{CellList, NeighbourList, ROWS};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::SphOptions;
use crate::config::{SmoothingLength, WallStress};
use crate::kernel::Smoothing;
use crate::pairs::{Pairs, Shift, SmoothBodies};
use crate::particles::{Group, Particles};
use crate::total::Reference;
use crate::walls::{Image, Walls};

/// Steps between two evaluations of the speeds of sound and the time step.
const STEPS_PER_TIME_STEP: u64 = 10;
/// Least number of particles per task.
pub(crate) const TASK: usize = 512;

/// Distance from equilibrium and its pieces.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Audit {
    /// Square of the sum of the unbalanced forces (N²).
    pub unbalanced: f64,
    /// Square of the external forces (N²).
    pub external: f64,
    /// Kinetic energy (J).
    pub kinetic: f64,
    /// Work of gravity and a confining pressure since the stage began (J).
    pub work: f64,
}

impl Audit {
    /// That of the next step, from what each particle adds to it, in this order: work goes on.
    pub(crate) fn next(self, particles: impl Iterator<Item = Self>) -> Self {
        particles.fold(Self { work: self.work, ..Self::default() }, |sum, own| Self {
            unbalanced: sum.unbalanced + own.unbalanced,
            external: sum.external + own.external,
            kinetic: sum.kinetic + own.kinetic,
            work: sum.work + own.work,
        })
    }
}

/// Explicit SPH in `D` dimensions.
pub struct SphSolver<const D: usize> {
    pub(crate) case: Arc<Case>,
    pub(crate) options: SphOptions,
    pub(crate) smoothing: Smoothing<D>,
    pub(crate) particles: Particles<D>,
    pub(crate) groups: Vec<Group>,
    pub(crate) walls: Walls<D>,
    pub(crate) images: Vec<Image<D>>,
    /// Where the smooth bodies stand.
    pub(crate) smooth: SmoothBodies,
    pub(crate) neighbours: NeighbourList<D>,
    /// Weights of the pairs, block by block as the neighbours.
    pub(crate) weights: Vec<Vec<f64>>,
    /// Whether the weights are those of the positions.
    pub(crate) weighed: bool,
    /// Whether the accelerations are those of the state.
    pub(crate) accelerated: bool,
    pub(crate) cells: CellList<D>,
    pub(crate) listed: Listed<D>,
    /// Step of the last sort.
    pub(crate) sorted: Option<u64>,
    pub(crate) tensors: Vec<SymTensor>,
    pub(crate) scalars: Vec<f64>,
    /// Of the schemes that need more than the state.
    pub(crate) kept: Kept<D>,
    /// Which particles are at a surface, and how the others are shifted; empty without shifting.
    pub(crate) surface: Vec<bool>,
    pub(crate) shifts: Vec<Option<Shift<D>>>,
    pub(crate) gravity: [f64; D],
    pub(crate) stage: usize,
    pub(crate) stage_start: f64,
    pub(crate) time: f64,
    pub(crate) step: u64,
    /// Length of the step before, zero at the start (s).
    pub(crate) last_step: f64,
    pub(crate) limit: Option<TimeStep>,
    pub(crate) limit_age: u64,
    pub(crate) audit: Audit,
    /// `Σ_{j≠i} V_j W`, small at a surface; empty without a confining pressure.
    pub(crate) crowding: Vec<f64>,
    /// Accelerations by a confining pressure (m/s²); empty without.
    pub(crate) pushes: Vec<[f64; D]>,
    /// The initial configuration, of the total-Lagrangian form.
    pub(crate) reference: Option<Box<Reference<D>>>,
    /// Which particles are copies of those of other ranks: neighbours for the others, whose own rates nobody asks for.
    /// Empty where there are none.
    pub(crate) guests: Vec<bool>,
}

pub(crate) fn square<const N: usize>(vector: &[f64; N]) -> f64 {
    vector.iter().map(|c| c * c).sum()
}

/// Calls `visit(particle, neighbours, weights, entry of out)` for every entry of `out`.
pub(crate) fn over_rows<const D: usize, T: Send>(
    neighbours: &NeighbourList<D>,
    weights: &mut [Vec<f64>],
    out: &mut [T],
    visit: impl Fn(usize, &[u32], &mut [f64], &mut T) + Sync,
) {
    let blocks = out.par_chunks_mut(ROWS).zip(weights).zip(neighbours.blocks()).enumerate();
    blocks.for_each(|(number, ((out, weights), rows))| {
        for (k, slot) in out.iter_mut().enumerate() {
            visit(number * ROWS + k, rows.of(k), &mut weights[rows.range(k)], slot);
        }
    });
}

impl<const D: usize> SphSolver<D> {
    /// A solver in the same stage of the same case at the same time, without particles.
    pub(crate) fn hollow(&self) -> Self {
        Self {
            case: Arc::clone(&self.case),
            options: self.options.clone(),
            particles: Particles::default(),
            groups: self.groups.iter().map(Group::hollow).collect(),
            walls: self.walls.clone(),
            images: Vec::new(),
            smooth: SmoothBodies::default(),
            neighbours: NeighbourList::new(),
            weights: Vec::new(),
            cells: CellList::new(),
            listed: Listed { positions: Vec::new(), ..self.listed },
            tensors: Vec::new(),
            scalars: Vec::new(),
            kept: Kept::default(),
            surface: Vec::new(),
            shifts: Vec::new(),
            crowding: Vec::new(),
            pushes: Vec::new(),
            reference: None,
            guests: Vec::new(),
            ..*self
        }
    }

    /// One step.
    pub(crate) fn advance(&mut self, dt: f64) -> Result<(), SolverError> {
        if self.limit.is_none() {
            self.critical_step();
        }
        if self.reference.is_none() {
            self.refresh_neighbours(true)?;
        }
        self.advance_listed(dt)?;
        if self.is_audited() {
            self.audit = self.audit.next(self.audits(dt).map(|(_, own)| own));
        }
        self.end_step(dt);
        Ok(())
    }

    /// The state at the end of a step, with the neighbours as they are listed.
    pub(crate) fn advance_listed(&mut self, dt: f64) -> Result<(), SolverError> {
        if let Some(problem) = self.too_long() {
            let reason = format!("methods.sph.time_step: {problem}");
            return Err(SolverError::Step { step: self.step, time: self.time, reason });
        }
        self.follow_histories(dt);
        self.regularise(dt)?;
        self.shift();
        self.integrate(dt)
    }

    /// Counts the step.
    pub(crate) fn end_step(&mut self, dt: f64) {
        self.time += dt;
        self.step += 1;
        self.last_step = dt;
        self.limit_age += 1;
    }

    /// Whether the stage asks how far from rest the particles are.
    pub(crate) fn is_audited(&self) -> bool {
        self.case.stages[self.stage].equilibrium.is_some()
    }

    pub(crate) fn pairs(&self) -> Pairs<'_, D> {
        let first_wall = self.particles.len + self.images.len();
        let answering = match self.options.wall_stress {
            WallStress::Pairwise => first_wall,
            WallStress::Interpolated | WallStress::Extrapolated => usize::MAX,
        };
        Pairs {
            particles: &self.particles,
            smoothing: &self.smoothing,
            options: &self.options,
            walls: &self.walls,
            images: &self.images,
            first_wall,
            answering,
            smooth: &self.smooth,
        }
    }

    /// Smoothing lengths that follow the density in closed form.
    pub(crate) fn follow_density(&mut self) {
        if self.options.smoothing_length != SmoothingLength::Density {
            return;
        }
        for group in &self.groups {
            for i in group.range() {
                self.particles.length[i] = self.length_at(group, self.particles.density[i]);
            }
        }
    }

    /// `h₀ (ρ₀/ρ)^(1/d)`, bounded (m).
    pub(crate) fn length_at(&self, group: &Group, density: f64) -> f64 {
        let ratio = (group.density / density).powf(1.0 / D as f64);
        self.smoothing.length() * ratio.min(self.options.smoothing_growth)
    }

    pub(crate) fn failed(&self, index: usize, reason: String) -> SolverError {
        let position = self.particles.position.get(index).copied().unwrap_or([0.0; D]);
        SolverError::Point {
            step: self.step,
            time: self.time,
            point: u64::from(self.particles.id.get(index).copied().unwrap_or(0)),
            position: spatial(&position),
            reason,
        }
    }

    /// Gravity at the end of a step of `dt` (m/s²).
    pub(crate) fn gravity_at(&self, dt: f64) -> [f64; D] {
        let factor = self.case.stages[self.stage].gravity_factor(self.time + dt - self.stage_start);
        self.gravity.map(|g| g * factor)
    }

    /// The largest stable step from the current state (sheet §3.4).
    pub(crate) fn critical_step(&mut self) -> TimeStep {
        if self.is_limit_due() {
            let limit = self.find_limit();
            self.set_limit(self.time_step_of(limit));
        }
        self.limit.expect("set above")
    }

    pub(crate) fn is_limit_due(&self) -> bool {
        self.limit.is_none() || self.limit_age >= STEPS_PER_TIME_STEP
    }

    /// Takes the critical step, or the one that the case fixes.
    pub(crate) fn set_limit(&mut self, critical: TimeStep) {
        // The first of a stage knows nothing of its forces: it is for one step.
        let age = if self.limit.is_none() { STEPS_PER_TIME_STEP - 1 } else { 0 };
        self.limit = Some(critical.or_fixed(self.options.time_step));
        self.limit_age = age;
    }

    /// What is wrong with the step that the case fixes, where it is longer than the critical one.
    pub(crate) fn too_long(&self) -> Option<String> {
        self.limit.as_ref()?.too_long(self.options.time_step)
    }

    /// The particle that neighbour `j` is, or whose image in a period it is; `None` for images in mirrors and
    /// particles of walls.
    #[inline]
    pub(crate) fn particle_of(&self, j: usize) -> Option<usize> {
        let Some(number) = j.checked_sub(self.particles.len) else { return Some(j) };
        let image = self.images.get(number)?;
        (image.flip == [1.0; D]).then_some(image.source as usize)
    }

    /// The body of particle `i`.
    pub(crate) fn body_of(&self, i: usize) -> Option<&Group> {
        self.groups.iter().find(|group| group.range().contains(&i))
    }

    /// Whether particle `i` is a copy of one of another rank.
    #[inline]
    pub(crate) fn is_guest(&self, i: usize) -> bool {
        self.guests.get(i).is_some_and(|guest| *guest)
    }
}
