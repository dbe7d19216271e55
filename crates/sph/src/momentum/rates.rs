//! Rates of the particles.

use colluvium_case::rigid::{SupportPoints, SupportReaction};
use colluvium_case::spatial;
use colluvium_constitutive::SymTensor;
use serde::{Deserialize, Serialize};

use crate::boundary::walls::ObstacleEnergies;
use crate::points::particles::Derivatives;
use crate::points::rigid_body::RigidForces;

/// What a rigid body or an obstacle bears of the others.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct ReactionSum {
    /// Force in the step (N).
    pub force: [f64; 3],
    /// Its moment about the zero of the coordinates (N m); of obstacles.
    pub moment: [f64; 3],
    /// Its impulse since the start (N s).
    pub impulse: [f64; 3],
}

/// What an obstacle whose reaction is measured bears of one particle.
#[derive(Clone, Copy)]
pub struct ReactionSample<const D: usize> {
    /// The particle.
    pub particle: u32,
    /// Number of the obstacle in what is felt.
    pub reaction_index: u32,
    /// Where (m).
    pub place: [f64; D],
    /// Force (N).
    pub force: [f64; D],
    /// Impulse (N s) where the particle was stopped; the forces of the sums last for the whole step.
    pub impulse: Option<[f64; D]>,
}

/// What the sums over neighbours give.
#[derive(Clone, Default)]
pub struct Rates<const D: usize> {
    /// What goes with the particles.
    pub derivatives: Derivatives<D>,
    /// Whether the accelerations are those of the state.
    pub current: bool,
    /// Velocity by which a particle moves beyond its own, by XSPH (m/s); empty without.
    pub xsph_velocity: Vec<[f64; D]>,
    /// Accelerations by loads and a confining pressure (m/s²); empty without.
    pub external_accelerations: Vec<[f64; D]>,
    /// Accelerations by obstacles (m/s²); empty without.
    pub obstacle_accelerations: Vec<[f64; D]>,
    /// Power of obstacles that move on each particle, over its mass (W/kg); empty without.
    pub power: Vec<f64>,
    /// What obstacles have taken of each particle in the step; empty without.
    pub obstacle_energies: Vec<ObstacleEnergies>,
    /// `Σ_{j≠i} V_j W`, small at a surface; empty without a confining pressure.
    pub surface_index: Vec<f64>,
    /// Rates of stress by its diffusion over their factor (Pa/s); empty without.
    pub stress: Vec<SymTensor>,
    /// Rates of the smoothing lengths (m/s); empty without.
    pub length: Vec<f64>,
    /// What bodies bear that are rigid, by their number in the case, and behind the bodies obstacles whose reaction is measured; empty
    /// without any.
    pub reactions: Vec<ReactionSum>,
    /// What acts on rigid bodies.
    pub rigid_forces: Vec<RigidForces>,
    /// What obstacles get of rigid bodies that stand on them, each with the first particle of the body.
    pub support_reactions: Vec<(usize, SupportReaction)>,
    /// Room for where a rigid body stands.
    pub support_points: SupportPoints,
    /// How often what bears a rigid body was not found to the last digit.
    pub unconverged_supports: u64,
    /// What `felt` of obstacles is summed up from, particle by particle: at the last sums, and behind them of those that were stopped.
    pub reaction_samples: Vec<ReactionSample<D>>,
}

impl ReactionSum {
    /// Adds what one particle does.
    pub fn accumulate<const D: usize>(&mut self, told: &ReactionSample<D>) {
        self.add(told.force, &told.place);
        if let Some(impulse) = told.impulse {
            let impulse = spatial(&impulse);
            (0..3).for_each(|c| self.impulse[c] += impulse[c]);
        }
    }

    /// Adds what its force makes in `dt` (s).
    pub fn add_impulse(&mut self, dt: f64) {
        (0..3).for_each(|c| self.impulse[c] += dt * self.force[c]);
    }

    /// Begins a step: nothing but the impulse of before.
    pub fn begin(&mut self) {
        (self.force, self.moment) = ([0.0; 3], [0.0; 3]);
    }

    /// Adds a force (N) at a place (m).
    fn add<const D: usize>(&mut self, force: [f64; D], place: &[f64; D]) {
        let (f, x) = (spatial(&force), spatial(place));
        for c in 0..3 {
            let (a, b) = ((c + 1) % 3, (c + 2) % 3);
            self.force[c] += f[c];
            self.moment[c] += x[a] * f[b] - x[b] * f[a];
        }
    }
}

impl<const D: usize> Rates<D> {
    /// Those of no particles, at the same point of a step.
    pub fn empty_like(&self) -> Self {
        Self { current: self.current, ..Self::default() }
    }
}
