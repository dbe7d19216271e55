//! Particles as structures of arrays.

use std::ops::Range;
use std::sync::Arc;

use colluvium_case::bodies::law_points::LawPoints;
use colluvium_case::description::Velocity;
use colluvium_case::{Case, FailureReason, SolverError, spatial};
use colluvium_constitutive::{Material, States, SymTensor};
use colluvium_points::{ScratchBuffers, struct_of_arrays};

use crate::clock::Clock;
use crate::config::{SmoothingLength, TimeHistory};
use crate::context::SolverContext;
use crate::points::body_loads::BodyLoads;
use crate::points::packed_particles::{PairRecord, pair_record, set_velocity};
use crate::points::rigid_body::RigidBody;

/// Least number of particles per task.
pub(crate) const MIN_PARTICLES_PER_TASK: usize = 512;

/// Square matrix of the space dimension, as an array of rows.
pub type SquareMatrix<const D: usize> = [[f64; D]; D];

/// Particles of one body: their index range, material and states.
pub struct ParticleGroup {
    /// Index into `Case::bodies`.
    pub body: u32,
    /// Index of the first particle.
    pub start: usize,
    /// Index after that of the last particle.
    pub end: usize,
    /// Material law.
    pub material: Arc<dyn Material>,
    /// States of the law.
    pub states: States,
    /// Young's modulus from which the speed of sound is computed (Pa), if it is not that of the wave modulus.
    pub youngs_modulus: Option<f64>,
    /// Initial density (kg/m³).
    pub density: f64,
    /// Prescribed velocities of a body with prescribed motion.
    pub prescribed_velocity: Option<Velocity>,
    /// Time history of the factor on the prescribed velocities; constant if absent.
    pub history: Option<TimeHistory>,
    /// Mean factor over the step.
    pub factor: f64,
    /// Velocity that a program prescribes in place of the motion of the case (m/s), of a rigid body or one with prescribed motion.
    pub program_velocity: Option<[f64; 3]>,
    /// Rigid motion, where the body is rigid.
    pub rigid: Option<RigidBody>,
    /// Whether other bodies slip along the body without friction; only bodies with prescribed motion may be smooth.
    pub is_smooth: bool,
    /// Whether the confining pressure acts on the body.
    pub is_confined: bool,
    /// Whether its law is a fluid law.
    pub fluid: bool,
}

impl ParticleGroup {
    /// Index range in the arrays.
    pub fn range(&self) -> Range<usize> {
        self.start..self.end
    }

    /// Whether the body deforms and moves by itself: neither rigid nor of prescribed motion.
    pub fn is_free(&self) -> bool {
        self.prescribed_velocity.is_none() && self.rigid.is_none()
    }

    /// Whether the body is a fluid that moves by itself.
    pub fn is_free_fluid(&self) -> bool {
        self.fluid && self.is_free()
    }

    /// Returns the body without particles.
    pub fn empty_like(&self) -> Self {
        Self {
            start: 0,
            end: 0,
            material: Arc::clone(&self.material),
            states: States::default(),
            prescribed_velocity: self.prescribed_velocity.clone(),
            history: self.history.clone(),
            ..*self
        }
    }
}

struct_of_arrays! {
    /// State of all particles, one column per variable. The particles are followed by their images and the wall particles, in the columns
    /// used for neighbours: position, velocity, mass, density, stress, speed of sound and smoothing length.
    pub struct Particles<const D: usize> {
        /// Ids, constant during the run.
        pub id: u32,
        /// Positions from which displacement is counted (m).
        pub origin: [f64; D],
        /// Positions (m).
        pub position: [f64; D],
        /// Velocities (m/s).
        pub velocity: [f64; D],
        /// Velocities of the previous step (m/s), for the Verlet scheme; empty for others.
        pub previous: [f64; D],
        /// Delayed pressures for friction on faces (Pa), zero without contact; empty without friction.
        pub delayed_pressure: f64,
        /// Accelerations by the body force of the program (m/s²), zero where it does not act; empty without.
        pub body_force: [f64; D],
        /// Masses (kg).
        pub mass: f64,
        /// Densities (kg/m³).
        pub density: f64,
        /// Cauchy stresses (Pa).
        pub stress: SymTensor as [f64; 6],
        /// Speeds of sound (m/s).
        pub sound: f64,
        /// Smoothing lengths (m).
        pub length: f64,
    }
}

struct_of_arrays! {
    /// Rates of the particles in the last step.
    pub struct Derivatives<const D: usize> {
        /// Accelerations (m/s²).
        pub acceleration: [f64; D],
        /// Velocity gradients `∂v_a/∂x_b` (1/s).
        pub gradient: SquareMatrix<D>,
        /// Divergences of velocity, from the continuity equation (1/s).
        pub divergence: f64,
    }
}

impl<const D: usize> Particles<D> {
    /// Points of a body for its material law.
    pub fn law_points<'a>(&'a self, group: &'a ParticleGroup) -> LawPoints<'a> {
        LawPoints { material: &*group.material, stress: &self.stress[group.range()], states: &group.states }
    }

    /// Resizes the columns to the number of particles, images and wall particles; new entries are zero.
    pub fn resize(&mut self, total: usize) {
        self.position.resize(total, [0.0; D]);
        self.velocity.resize(total, [0.0; D]);
        self.mass.resize(total, 0.0);
        self.density.resize(total, 0.0);
        self.stress.resize(total, SymTensor::ZERO);
        self.sound.resize(total, 0.0);
        self.length.resize(total, 0.0);
    }

    /// Error at particle `index`.
    pub fn particle_error(
        &self,
        clock: &Clock,
        index: usize,
        reason: impl Into<FailureReason>,
    ) -> SolverError {
        let position = self.position.get(index).copied().unwrap_or([0.0; D]);
        SolverError::Point {
            step: clock.step,
            time: clock.time,
            point: u64::from(self.id.get(index).copied().unwrap_or(0)),
            position: spatial(&position),
            reason: reason.into(),
        }
    }

    /// Pair record of particle `i`, with its stress times `scale`.
    #[inline]
    pub fn record(&self, i: usize, scale: f64) -> PairRecord {
        let scalars = [self.mass[i] / self.density[i], self.density[i], self.sound[i], self.length[i]];
        pair_record(&self.position[i], &self.velocity[i], scalars, (self.stress[i] * scale).0)
    }
}

impl<const D: usize> Derivatives<D> {
    /// Resizes the columns to a number of particles; new entries are zero.
    pub fn resize(&mut self, len: usize) {
        self.acceleration.resize(len, [0.0; D]);
        self.gradient.resize(len, [[0.0; D]; D]);
        self.divergence.resize(len, 0.0);
    }
}

/// Pair data of the particles, images and walls for the sums over neighbours. Recomputed in every step.
#[derive(Clone, Default)]
pub struct PairData<const D: usize> {
    /// Records for the pair sums.
    pub records: Vec<PairRecord>,
    /// Factor `1/ϑ` for the gradient of the smoothing length; 1 for constant lengths.
    pub grad_h_factor: Vec<f64>,
    /// Artificial stress over density squared; empty without.
    pub repulsion: Vec<SymTensor>,
    /// Corrections of the gradient, of particles and images; empty without the corrected momentum equation.
    pub correction: Vec<SquareMatrix<D>>,
    /// Densities by summation, before they are assigned to the particles (kg/m³).
    pub summed_density: Vec<f64>,
    /// Stresses extrapolated from the soil, before they are assigned to wall particles (Pa).
    pub wall_stresses: Vec<SymTensor>,
}

/// Bodies and their particles.
#[derive(Default)]
pub struct Bodies<const D: usize> {
    /// Particles of all bodies.
    pub particles: Particles<D>,
    /// Groups of particles, body after body.
    pub groups: Vec<ParticleGroup>,
    /// Pair data of the particles.
    pub pair_data: PairData<D>,
    /// Whether each particle is a ghost: a copy of a particle of another rank that is only a neighbour. Empty where there are none.
    pub ghost_particles: Vec<bool>,
    /// Surface loads.
    pub loads: BodyLoads<D>,
    /// Number of the next particle that is added.
    pub next_id: u32,
}

impl<const D: usize> Bodies<D> {
    /// Returns the bodies without particles.
    pub fn empty_like(&self) -> Self {
        Self {
            groups: self.groups.iter().map(ParticleGroup::empty_like).collect(),
            loads: self.loads.clone(),
            next_id: self.next_id,
            ..Self::default()
        }
    }

    /// Resizes the arrays to the number of particles, images and wall particles.
    pub fn resize(&mut self, total: usize) {
        self.particles.resize(total);
        self.pair_data.grad_h_factor.resize(total, 1.0);
        self.pair_data.records.resize(total, [[0.0; 4]; 4]);
    }

    /// Group to which particle `i` belongs; `None` for a wall particle.
    pub fn group_of(&self, i: usize) -> Option<&ParticleGroup> {
        self.groups.iter().find(|group| group.range().contains(&i))
    }

    /// Whether particle `i` is a copy of a particle of another rank.
    #[inline]
    pub fn is_ghost(&self, i: usize) -> bool {
        self.ghost_particles.get(i).is_some_and(|guest| *guest)
    }

    /// Largest smoothing length (m).
    pub fn max_smoothing_length(&self, setting: &SolverContext<D>) -> f64 {
        if !setting.options.is_variable() {
            return setting.smoothing.length();
        }
        self.particles.length[..self.particles.len()].iter().copied().fold(0.0, f64::max)
    }

    /// Updates the smoothing lengths that depend on the density in closed form.
    pub fn follow_density(&mut self, setting: &SolverContext<D>) {
        if setting.options.smoothing_length != SmoothingLength::Density {
            return;
        }
        for group in &self.groups {
            for i in group.range() {
                self.particles.length[i] = setting.length_at(group.density, self.particles.density[i]);
            }
        }
    }

    /// Sets the velocities of bodies with prescribed motion.
    pub fn impose_held_velocities(&mut self) {
        let p = &mut self.particles;
        for group in &self.groups {
            let Some(field) = &group.prescribed_velocity else { continue };
            for i in group.range() {
                let of_case = || field.velocity_at(spatial(&p.position[i])).map(|v| group.factor * v);
                let v = group.program_velocity.unwrap_or_else(of_case);
                p.velocity[i] = std::array::from_fn(|c| v[c]);
                set_velocity(&mut self.pair_data.records[i], &p.velocity[i]);
            }
        }
    }

    /// Sets the mean velocities of bodies with a time history in the step from `start` to `end` (s).
    pub fn update_time_histories(&mut self, start: f64, end: f64) {
        let mut varies = false;
        for group in &mut self.groups {
            let Some(history) = &group.history else { continue };
            group.factor = history.mean(start, end);
            varies = true;
        }
        if varies {
            self.impose_held_velocities();
        }
    }

    /// Removes the bodies that are inactive in the stage, and their entries in `rates`.
    pub fn remove_inactive(&mut self, case: &Case, stage: usize, rates: &mut Derivatives<D>) {
        self.retain_where(|group, _| !case.is_removed(&case.bodies[group.body as usize].name, stage), rates);
    }

    /// Removes the particles for whose body and number the condition is false, bodies without particles, and their entries in `rates`.
    /// Images and wall particles are removed with them. Returns whether there are any.
    pub fn retain_where(
        &mut self,
        keep: impl Fn(&ParticleGroup, u32) -> bool,
        rates: &mut Derivatives<D>,
    ) -> bool {
        let Self { particles, groups, .. } = self;
        let kept_in = |group: &ParticleGroup| -> Vec<u32> {
            let ids = particles.id[group.range()].iter().zip(0u32..);
            ids.filter(|(id, _)| keep(group, **id)).map(|(_, i)| i).collect()
        };
        let kept: Vec<Vec<u32>> = groups.iter().map(kept_in).collect();
        if groups.iter().zip(&kept).all(|(group, kept)| group.range().len() == kept.len()) {
            return false;
        }
        particles.truncate(particles.len());
        let (mut start, mut scratch) = (0, ScratchBuffers::default());
        for (group, kept) in groups.iter_mut().zip(&kept) {
            let range = start..start + group.range().len();
            if kept.len() < range.len() {
                particles.reorder_range(range.clone(), kept, &mut scratch);
                rates.reorder_range(range, kept, &mut scratch);
                group.states = group.states.permuted(kept);
            }
            (group.start, group.end) = (start, start + kept.len());
            start = group.end;
        }
        groups.retain(|group| !group.range().is_empty());
        self.resize(self.particles.len());
        true
    }

    /// Adds the particles of `added` and their states at the end of the group at `index`. Both must use the same columns. Images and wall
    /// particles are removed.
    pub fn insert(
        &mut self,
        index: usize,
        (added, states): (&Particles<D>, &States),
        rates: &mut Derivatives<D>,
    ) {
        let (end, count) = (self.groups[index].end, added.len());
        self.particles.truncate(self.particles.len());
        let picks: Vec<(u32, u32)> = (0..end as u32)
            .map(|i| (0, i))
            .chain((0..count as u32).map(|i| (1, i)))
            .chain((end as u32..self.particles.len() as u32).map(|i| (0, i)))
            .collect();
        let old = std::mem::take(&mut self.particles);
        self.particles.gather(&[&old, added], &picks);
        let (old, mut at_rest) = (std::mem::take(rates), Derivatives::default());
        at_rest.resize(count);
        rates.gather(&[&old, &at_rest], &picks);
        self.groups[index].states = self.groups[index].states.followed_by(states);
        self.groups[index].end += count;
        for group in &mut self.groups[index + 1..] {
            (group.start, group.end) = (group.start + count, group.end + count);
        }
        self.resize(self.particles.len());
    }
}
