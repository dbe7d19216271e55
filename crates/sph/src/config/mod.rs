//! Options of `methods.sph` in a case file.

mod checks;
mod choices;
mod time_history;

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use crate::config::time_history::TimeHistory;
pub use choices::{
    ConfinedParticles, ConfiningPressure, ContinuityEquation, DensityReset, LagrangianFormulation,
    MomentumEquation, Regularisation, RoughWall, ShiftingSpeed, SmoothWall, SmoothingLength, SoundSpeed,
    Symmetrisation, Tensile, TimeIntegration, VelocityGradientOperator, WallStress, WallVelocity,
};

use crate::kernel::Kernel;

/// Largest shift of a particle, in spacings (sheet: sph §2.12).
pub(crate) const MAX_SHIFT: f64 = 0.1;

/// Options of smoothed particle hydrodynamics.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphOptions {
    /// Initial distance of the particles (m).
    pub spacing: f64,
    /// Kernel. Without an entry `cubic-spline`, and `wendland-c2` where all bodies that move by themselves are Newtonian liquids (and
    /// `formulation` is `updated`): particles of liquids clump with the cubic spline.
    #[serde(default)]
    pub kernel: Kernel,
    /// Smoothing length over `spacing`, 0.9 to 3. Without an entry 1.2, and 1.5 for Newtonian liquids with `kernel` `wendland-c2`.
    #[serde(default = "smoothing")]
    pub smoothing: f64,
    /// Allows a smoothing at which the kernel is known to make particles clump.
    #[serde(default)]
    pub allow_pairing: bool,
    /// How the smoothing length follows the density.
    #[serde(default)]
    pub smoothing_length: SmoothingLength,
    /// Largest smoothing length over the initial one, 1 to 3.
    #[serde(default = "growth")]
    pub smoothing_growth: f64,
    /// The kernel between particles of different smoothing lengths.
    #[serde(default)]
    pub symmetrisation: Symmetrisation,
    /// Time integration.
    #[serde(default)]
    pub integration: TimeIntegration,
    /// Form of the momentum equation. Where it is left out and bodies differ in density, `rho-rho`, but for `grad-h`.
    #[serde(default)]
    pub momentum: MomentumEquation,
    /// Form of the continuity equation.
    #[serde(default)]
    pub continuity: ContinuityEquation,
    /// Allows density by summation where supports are not full at the start, or densities differ: particles at free
    /// surfaces lose up to half of their density, and jumps of density are smeared.
    #[serde(default)]
    pub allow_summation: bool,
    /// Operator of the velocity gradient that the law gets. Without an entry `compatible` where all that moves are liquids, and
    /// `corotated` elsewhere: near a surface `compatible` includes a part of a rotation only, and strains a rotating body until it stops.
    #[serde(default)]
    pub velocity_gradient: VelocityGradientOperator,
    /// Linear artificial viscosity `α`, at least 0; it adds about `α h c/8` to the kinematic viscosity. 0.1 without an entry, and 0 where
    /// all bodies are liquids whose own viscosity is at least `ρ c spacing/100`.
    #[serde(default = "viscosity")]
    pub viscosity_linear: f64,
    /// Quadratic artificial viscosity, at least 0.
    #[serde(default)]
    pub viscosity_quadratic: f64,
    /// Speed of sound of the artificial viscosity and of the damping.
    #[serde(default)]
    pub sound_speed: SoundSpeed,
    /// Viscous damping `ξ`, at least 0: velocities fall by `exp(-ξ c dt / h)` in a step.
    #[serde(default)]
    pub damping: f64,
    /// Against tensile instability.
    #[serde(default)]
    pub tensile: Tensile,
    /// Smoothing of stress, of bodies whose law is in rate form: a law that finds its stress from its elastic strain or
    /// the rate of the motion, as hyperelastic laws and Newtonian fluids do, keeps its own. Refused where no body's law
    /// is in rate form. A step without motion takes the stress back to yield; where the law depends on time (relaxation,
    /// eigenstrain, user materials) the next step with motion does.
    #[serde(default)]
    pub regularisation: Regularisation,
    /// Steps between two regularisations.
    #[serde(default = "default_regularisation_steps")]
    pub regularisation_steps: u64,
    /// Diffusion of stress `ζ` within each body, 0 to 0.5; what the weight between particles explains is left out. Acts
    /// on bodies whose law is in rate form, as `regularisation`, and is refused where no body's is.
    #[serde(default)]
    pub stress_diffusion: f64,
    /// Ratio of horizontal to vertical stress in that weight.
    #[serde(default = "default_wall_k0")]
    pub stress_diffusion_k0: f64,
    /// Diffusion of density `δ` within each body of fluid, 0 to 0.5.
    #[serde(default)]
    pub density_diffusion: f64,
    /// Renewal of density, for fluids.
    #[serde(default)]
    pub density_reset: DensityReset,
    /// Steps between two renewals.
    #[serde(default = "default_reset_steps")]
    pub density_reset_steps: u64,
    /// Share of the neighbours' velocity with which particles of bodies that are not `held` move (XSPH), 0 to 1.
    #[serde(default)]
    pub xsph: f64,
    /// Viscosity, in units of `viscosity_linear`, against the part of the relative velocity of neighbours that their
    /// velocity gradients do not see (hourglass or zero-energy modes), 0 to 1. Linear velocity fields feel nothing of
    /// it where `velocity_gradient` is `corrected`, and rotations nothing where it is `corotated`.
    #[serde(default)]
    pub hourglass_viscosity: f64,
    /// Shifting of particles towards even spacing, in smoothing lengths per length moved; at least 0. Without an entry 10 where all bodies that
    /// move by themselves are Newtonian liquids that fill the domain (no free surface) and there is no obstacle, and 0 elsewhere. Particles are
    /// shifted every four steps, by their way since (more often with more than 10), which makes steps 1.7 times as expensive. Velocity,
    /// density and stress are carried along to first order, density and stress with their gradients within the body.
    #[serde(default)]
    pub shifting: f64,
    /// The speed over which `shifting` counts the way.
    #[serde(default)]
    pub shifting_speed: ShiftingSpeed,
    /// The configuration that the sums are taken over.
    #[serde(default)]
    pub formulation: LagrangianFormulation,
    /// Confining pressure of a flexible membrane; none when absent.
    #[serde(default)]
    pub confining: Option<ConfiningPressure>,
    /// Names of bodies that keep their initial velocity field during the whole run, times the factor that `held_history` gives; their
    /// stress follows their law.
    #[serde(default)]
    pub held: Vec<String>,
    /// Factors on the velocities of bodies that are `held`, over the time of the run, by the name of the body; those that
    /// are not named keep theirs.
    #[serde(default)]
    pub held_history: BTreeMap<String, TimeHistory>,
    /// Names of bodies that are `held` along which the others slip freely. For each particle beside it such a body has the particle's own
    /// stress and velocity, mirrored in the plane normal to the direction from the particle to the body: forces act along that direction
    /// only. No force acts on the body, and it keeps its stress.
    #[serde(default)]
    pub smooth_bodies: Vec<String>,
    /// Writes how well the sums over neighbours hold: as fields what the plain gradient makes of a constant, times the
    /// smoothing length (`gradient_of_constant`, nothing where supports are full), and of the position
    /// (`gradient_of_position`, one there); in the measures how many pairs of particles lie in one place and how many
    /// corrections fall back. Takes the neighbours anew for every output.
    #[serde(default)]
    pub diagnostics: bool,
    /// Factors on the velocities of walls, over the time of the run, by the name of the wall (that of its side where it
    /// has none): its face stands where the integral of the velocity takes it. Those that are not named keep theirs.
    #[serde(default)]
    pub wall_history: BTreeMap<String, TimeHistory>,
    /// Stress and velocity of rough walls.
    #[serde(default)]
    pub wall_stress: WallStress,
    /// Velocity of rough walls that mirror the particle state pairwise.
    #[serde(default)]
    pub wall_velocity: WallVelocity,
    /// Discretisation of rough walls.
    #[serde(default)]
    pub rough_wall: RoughWall,
    /// Discretisation of smooth walls. Fluid particles that pass the face are replaced by their images in it; others stop the run.
    #[serde(default)]
    pub smooth_wall: SmoothWall,
    /// Repulsion of particles closer than half a spacing to a particle of a wall, as a share of the square of the
    /// speed of sound: keeps hard impacts from passing a wall. 0 for none.
    #[serde(default)]
    pub wall_guard: f64,
    /// Repulsion of particles of fluids closer than 0.7 spacings to each other or to their image in a smooth wall, as a share of the
    /// square of the speed of sound, 0 to 0.2: pressure pushes the less the closer they are. Conserves momentum and energy; what
    /// it stores counts as elastic energy. 0 for none.
    #[serde(default = "repulsion")]
    pub close_repulsion: f64,
    /// Ratio of horizontal to vertical stress by which `extrapolated` walls carry weight on.
    #[serde(default = "default_wall_k0")]
    pub wall_k0: f64,
    /// Courant number: step times wave speed over smoothing length, up to 1.
    #[serde(default = "courant")]
    pub courant: f64,
    /// Fixed time step (s); chosen by the solver when absent. A run whose critical step is or comes to be shorter is refused
    /// or stops: elastic waves may cross 1.8 smoothing lengths in it, whatever `courant` says.
    #[serde(default)]
    pub time_step: Option<f64>,
    /// Number of ranks that share the particles out and exchange copies of those near each other, 1 to 1024. Results
    /// are those of one rank. With the leapfrog and present neighbours (`formulation: updated`) only.
    #[serde(default = "default_ranks")]
    pub ranks: u32,
}

impl SphOptions {
    /// Smoothing length (m) of the initial spacing.
    pub fn smoothing_length_value(&self) -> f64 {
        self.smoothing * self.spacing
    }

    /// Whether particles have smoothing lengths of their own.
    pub fn is_variable(&self) -> bool {
        self.smoothing_length != SmoothingLength::Constant
    }

    /// Largest approach of two particles by shifting (m).
    pub(crate) fn max_shift_approach(&self) -> f64 {
        if self.shifting > 0.0 { 2.0 * MAX_SHIFT * self.spacing } else { 0.0 }
    }

    /// Operator of the velocity gradient, with `compatible` and `corotated` resolved.
    #[inline]
    pub(crate) fn gradient_operator(&self) -> VelocityGradientOperator {
        use VelocityGradientOperator::{Compatible, Corotated, Corrected, DensityDifference, Difference};
        match (self.velocity_gradient, self.momentum) {
            (Compatible | Corotated, MomentumEquation::Rho2) => DensityDifference,
            (Compatible | Corotated, MomentumEquation::Corrected) => Corrected,
            (Compatible | Corotated, _) => Difference,
            (operator, _) => operator,
        }
    }

    /// Whether strain is that in a frame that rotates with the particle. The corrected gradient is exact for rotations without it.
    #[inline]
    pub(crate) fn is_corotated(&self) -> bool {
        self.velocity_gradient == VelocityGradientOperator::Corotated
            && self.momentum != MomentumEquation::Corrected
    }

    /// Whether a gradient is corrected.
    pub(crate) fn has_corrected_gradients(&self) -> bool {
        self.momentum == MomentumEquation::Corrected
            || self.velocity_gradient == VelocityGradientOperator::Corrected
    }

    /// Whether an average uses moving least squares.
    pub(crate) fn has_linear_averages(&self) -> bool {
        self.regularisation == Regularisation::Mls || self.density_reset == DensityReset::Mls
    }
}

/// Smoothing length over spacing of the sheet's reference runs.
fn smoothing() -> f64 {
    1.2
}
/// Artificial viscosity fitted by the source for granular flow, cubic spline and smoothing 1.2.
fn viscosity() -> f64 {
    0.1
}
/// Strength that stops approaches at a tenth of the speed of sound at half a spacing.
fn repulsion() -> f64 {
    0.05
}
fn default_ranks() -> u32 {
    1
}
fn default_regularisation_steps() -> u64 {
    10
}
fn default_reset_steps() -> u64 {
    30
}
/// Default growth limit of sheet: sph §6.19.
fn growth() -> f64 {
    1.5
}
fn default_wall_k0() -> f64 {
    0.5
}
/// Default Courant number of sheet: sph §3.4.
fn courant() -> f64 {
    0.25
}
