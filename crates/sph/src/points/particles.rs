//! The particles, as structures of arrays.

use std::ops::Range;
use std::sync::Arc;

use colluvium_case::bodies::law_points::LawPoints;
use colluvium_case::description::Velocity;
use colluvium_case::{Case, SolverError, spatial};
use colluvium_constitutive::{Material, States, SymTensor};
use colluvium_points::{ScratchBuffers, struct_of_arrays};

use crate::clock::Clock;
use crate::config::{SmoothingLength, TimeHistory};
use crate::context::SolverContext;
use crate::momentum::body_loads::BodyLoads;
use crate::pairs::simd_pairs::{PairRecord, pair_record, set_velocity};
use crate::points::rigid_body::RigidBody;

/// Least number of particles per task.
pub(crate) const MIN_PARTICLES_PER_TASK: usize = 512;

/// A matrix of the space.
pub type SquareMatrix<const D: usize> = [[f64; D]; D];

/// Particles of one body: a range of the arrays and what its law keeps.
pub struct ParticleGroup {
    /// Index into `Case::bodies`.
    pub body: u32,
    /// First particle.
    pub start: usize,
    /// One past the last.
    pub end: usize,
    /// The law.
    pub material: Arc<dyn Material>,
    /// States of the law.
    pub states: States,
    /// Young's modulus (Pa), where the speed of sound is taken from it.
    pub youngs_modulus: Option<f64>,
    /// Initial density (kg/m³).
    pub density: f64,
    /// The velocities it keeps, where it is held.
    pub held: Option<Velocity>,
    /// The factor on these velocities over time; one without.
    pub history: Option<TimeHistory>,
    /// Its mean over the step.
    pub factor: f64,
    /// How it moves, where it is rigid.
    pub rigid: Option<RigidBody>,
    /// Whether others slip along it; only what is held may be smooth.
    pub smooth: bool,
    /// Whether a confining pressure acts on it.
    pub confined: bool,
    /// Whether its law is one of fluids.
    pub fluid: bool,
}

impl ParticleGroup {
    /// The range in the arrays.
    pub fn range(&self) -> Range<usize> {
        self.start..self.end
    }

    /// Whether it is a fluid that moves by itself.
    pub fn is_free_fluid(&self) -> bool {
        self.fluid && self.held.is_none() && self.rigid.is_none()
    }

    /// The same body without particles.
    pub fn empty_like(&self) -> Self {
        Self {
            start: 0,
            end: 0,
            material: Arc::clone(&self.material),
            states: States::default(),
            held: self.held.clone(),
            history: self.history.clone(),
            ..*self
        }
    }
}

struct_of_arrays! {
    /// What a particle is. Behind the particles come their images and the particles of walls, in the columns of what acts on
    /// neighbours: position, velocity, mass, density, stress, speed of sound and smoothing length.
    pub struct Particles<const D: usize> {
        /// Ids, the same for life.
        pub id: u32,
        /// Positions from which displacement is counted (m).
        pub origin: [f64; D],
        /// Positions (m).
        pub position: [f64; D],
        /// Velocities (m/s).
        pub velocity: [f64; D],
        /// Velocities of the step before, of the scheme that needs them (m/s); empty without.
        pub previous: [f64; D],
        /// Pressures on faces that friction counts with (Pa), zero where there is none; empty without friction.
        pub pressed: f64,
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
    /// How a particle changes, of the last step.
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
    /// The particles of a body as their law sees them.
    pub fn law_points<'a>(&'a self, group: &'a ParticleGroup) -> LawPoints<'a> {
        LawPoints { material: &*group.material, stress: &self.stress[group.range()], states: &group.states }
    }

    /// Makes room for so many particles, images and walls; what is new is zero.
    pub fn resize(&mut self, total: usize) {
        self.position.resize(total, [0.0; D]);
        self.velocity.resize(total, [0.0; D]);
        self.mass.resize(total, 0.0);
        self.density.resize(total, 0.0);
        self.stress.resize(total, SymTensor::ZERO);
        self.sound.resize(total, 0.0);
        self.length.resize(total, 0.0);
    }

    /// The error of particle `index`.
    pub fn particle_error(&self, clock: &Clock, index: usize, reason: String) -> SolverError {
        let position = self.position.get(index).copied().unwrap_or([0.0; D]);
        SolverError::Point {
            step: clock.step,
            time: clock.time,
            point: u64::from(self.id.get(index).copied().unwrap_or(0)),
            position: spatial(&position),
            reason,
        }
    }

    /// The record of particle `i`, its stress times `scale`.
    #[inline]
    pub fn record(&self, i: usize, scale: f64) -> PairRecord {
        let scalars = [self.mass[i] / self.density[i], self.density[i], self.sound[i], self.length[i]];
        pair_record(&self.position[i], &self.velocity[i], scalars, (self.stress[i] * scale).0)
    }
}

impl<const D: usize> Derivatives<D> {
    /// Makes room for so many particles; what is new is zero.
    pub fn resize(&mut self, len: usize) {
        self.acceleration.resize(len, [0.0; D]);
        self.gradient.resize(len, [[0.0; D]; D]);
        self.divergence.resize(len, 0.0);
    }
}

/// What the particles, with images and walls, show each other. Found anew in every step.
#[derive(Clone, Default)]
pub struct PairData<const D: usize> {
    /// What the pair sums read.
    pub records: Vec<PairRecord>,
    /// `1/ϑ` of the gradient of the smoothing length; one without.
    pub grad_h_factor: Vec<f64>,
    /// Artificial stress over density squared; empty without.
    pub repulsion: Vec<SymTensor>,
    /// Corrections of the gradient, of particles and images; empty where the momentum equation does without.
    pub correction: Vec<SquareMatrix<D>>,
    /// Densities by summation, before the particles have them (kg/m³).
    pub summed: Vec<f64>,
    /// Stresses that walls take from the soil, before their particles have them (Pa).
    pub wall_stresses: Vec<SymTensor>,
}

/// The bodies and their particles.
#[derive(Default)]
pub struct Bodies<const D: usize> {
    /// The particles of all of them.
    pub particles: Particles<D>,
    /// Body after body.
    pub groups: Vec<ParticleGroup>,
    /// What the particles show each other.
    pub pair_data: PairData<D>,
    /// Which particles are copies of those of other ranks: neighbours for the others, whose own rates nobody asks for.
    /// Empty where there are none.
    pub ghost_particles: Vec<bool>,
    /// Loads on their surfaces.
    pub loads: BodyLoads<D>,
}

impl<const D: usize> Bodies<D> {
    /// The same bodies without particles.
    pub fn empty_like(&self) -> Self {
        Self {
            groups: self.groups.iter().map(ParticleGroup::empty_like).collect(),
            loads: self.loads.clone(),
            ..Self::default()
        }
    }

    /// Makes room for so many particles, images and walls.
    pub fn resize(&mut self, total: usize) {
        self.particles.resize(total);
        self.pair_data.grad_h_factor.resize(total, 1.0);
        self.pair_data.records.resize(total, [[0.0; 4]; 4]);
    }

    /// The body of particle `i`.
    pub fn group_of(&self, i: usize) -> Option<&ParticleGroup> {
        self.groups.iter().find(|group| group.range().contains(&i))
    }

    /// Whether particle `i` is a copy of one of another rank.
    #[inline]
    pub fn is_ghost(&self, i: usize) -> bool {
        self.ghost_particles.get(i).is_some_and(|guest| *guest)
    }

    /// The largest smoothing length (m).
    pub fn max_smoothing_length(&self, setting: &SolverContext<D>) -> f64 {
        if !setting.options.is_variable() {
            return setting.smoothing.length();
        }
        self.particles.length[..self.particles.len()].iter().copied().fold(0.0, f64::max)
    }

    /// Smoothing lengths that follow the density in closed form.
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

    /// Gives bodies that are held their velocities.
    pub fn impose_held_velocities(&mut self) {
        let p = &mut self.particles;
        for group in &self.groups {
            let Some(field) = &group.held else { continue };
            for i in group.range() {
                let v = field.at(spatial(&p.position[i]));
                p.velocity[i] = std::array::from_fn(|c| group.factor * v[c]);
                set_velocity(&mut self.pair_data.records[i], &p.velocity[i]);
            }
        }
    }

    /// Bodies whose velocities vary in time get those of the step from `start` to `end` (s).
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

    /// Takes out the bodies that are gone in the stage, and what `rates` holds of them.
    pub fn remove_inactive(&mut self, case: &Case, stage: usize, rates: &mut Derivatives<D>) {
        let is_gone = |group: &ParticleGroup| case.is_removed(&case.bodies[group.body as usize].name, stage);
        while let Some(number) = self.groups.iter().position(is_gone) {
            let range = self.groups.remove(number).range();
            for group in &mut self.groups[number..] {
                group.start -= range.len();
                group.end -= range.len();
            }
            // Neither images nor walls follow.
            self.resize(self.particles.len());
            self.particles.reorder_range(range.clone(), &[], &mut ScratchBuffers::default());
            rates.reorder_range(range, &[], &mut ScratchBuffers::default());
            self.resize(self.particles.len());
        }
    }
}
