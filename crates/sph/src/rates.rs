//! Rates of the particles, and reactions.

use colluvium_case::rigid::{SupportPoints, SupportReaction};
use colluvium_case::spatial;
use colluvium_constitutive::SymTensor;
use serde::{Deserialize, Serialize};

use crate::obstacles::penetration_limit::ObstacleEnergies;
use crate::points::particles::Derivatives;
use crate::points::rigid_body::RigidForces;

/// Reaction on a rigid body or an obstacle.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct ReactionSum {
    /// Force in the step (N).
    pub force: [f64; 3],
    /// Moment of the force about the coordinate origin (N m); of obstacles.
    pub moment: [f64; 3],
    /// Impulse of the force since the start (N s).
    pub impulse: [f64; 3],
}

/// Contribution of a particle to the reaction on an obstacle.
#[derive(Clone, Copy)]
pub struct ReactionSample<const D: usize> {
    /// Index of the particle.
    pub particle: u32,
    /// Index of the reaction sum.
    pub reaction_index: u32,
    /// Position (m).
    pub position: [f64; D],
    /// Force (N).
    pub force: [f64; D],
    /// Impulse of a stopped particle (N s); `None` for forces, which act during the whole step.
    pub impulse: Option<[f64; D]>,
}

/// Rates from the sums over neighbours.
#[derive(Clone, Default)]
pub struct Rates<const D: usize> {
    /// Rates stored with the particles.
    pub derivatives: Derivatives<D>,
    /// Whether the stored accelerations are those of the current state.
    pub is_current: bool,
    /// Difference of the XSPH velocity and the velocity of each particle (m/s); empty without XSPH.
    pub xsph_velocity: Vec<[f64; D]>,
    /// Accelerations by loads, a body force and a confining pressure (m/s²); empty without.
    pub external_accelerations: Vec<[f64; D]>,
    /// Accelerations by obstacles (m/s²); empty without.
    pub obstacle_accelerations: Vec<[f64; D]>,
    /// Power of moving obstacles on each particle, over its mass (W/kg); empty without.
    pub power: Vec<f64>,
    /// Energies that obstacles remove from each particle in the step; empty without obstacles.
    pub obstacle_energies: Vec<ObstacleEnergies>,
    /// Surface index `Σ_{j≠i} V_j W`, small at a surface; empty without a confining pressure.
    pub surface_index: Vec<f64>,
    /// Stress rates of its diffusion, without their factor (Pa/s); empty without.
    pub stress: Vec<SymTensor>,
    /// Rates of the smoothing lengths (m/s); empty without.
    pub length: Vec<f64>,
    /// Reactions of rigid bodies, by body number of the case, and then of obstacles with measured reactions; empty if there are none.
    pub reactions: Vec<ReactionSum>,
    /// Forces on rigid bodies.
    pub rigid_forces: Vec<RigidForces>,
    /// Reactions of obstacles that support rigid bodies, each with the first particle of the body.
    pub support_reactions: Vec<(usize, SupportReaction)>,
    /// Contact points at which walls and obstacles support a rigid body; memory that is reused for each body.
    pub support_points: SupportPoints,
    /// Number of support reactions that did not converge to the last digit.
    pub unconverged_supports: u64,
    /// Contributions to the obstacle reactions: of all particles at the last sums, then of stopped particles.
    pub reaction_samples: Vec<ReactionSample<D>>,
}

impl ReactionSum {
    /// Adds the contribution of a particle.
    pub fn accumulate<const D: usize>(&mut self, sample: &ReactionSample<D>) {
        self.add(sample.force, &sample.position);
        if let Some(impulse) = sample.impulse {
            let impulse = spatial(&impulse);
            (0..3).for_each(|c| self.impulse[c] += impulse[c]);
        }
    }

    /// Adds the impulse of the force in `dt` (s).
    pub fn add_impulse(&mut self, dt: f64) {
        (0..3).for_each(|c| self.impulse[c] += dt * self.force[c]);
    }

    /// Begins a step: sets force and moment to zero; the impulse continues.
    pub fn begin_step(&mut self) {
        (self.force, self.moment) = ([0.0; 3], [0.0; 3]);
    }

    /// Adds a force (N) at a position (m).
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
    /// Rates without particles, at the same point of a step.
    pub fn empty_like(&self) -> Self {
        Self { is_current: self.is_current, ..Self::default() }
    }
}
