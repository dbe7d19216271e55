//! Options of `methods.sph` in a case file.

mod checks;
mod choices;
mod time_history;

use std::collections::BTreeMap;

use colluvium_case::MethodOptions;
use colluvium_constitutive::with_defaults;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use crate::config::time_history::TimeHistory;
pub use choices::{
    ConfiningPressure, ConfiningPressureTarget, ContinuityEquation, DensityReset, LagrangianFormulation,
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
    /// Initial distance of neighbouring particles (m).
    pub spacing: f64,
    /// Smoothing kernel. The default is `cubic-spline`, or `wendland-c2` where all bodies that move by themselves are Newtonian liquids
    /// (and `formulation` is `updated`): particles of liquids clump with the cubic spline.
    #[serde(default)]
    pub kernel: Kernel,
    /// Smoothing length over `spacing` (-), 0.9 to 3. The default is 1.2, or 1.5 for Newtonian liquids with `kernel` `wendland-c2`.
    #[serde(default = "smoothing")]
    pub smoothing: f64,
    /// Whether a smoothing is allowed at which the kernel is known to make particles clump.
    #[serde(default)]
    pub allow_pairing: bool,
    /// Dependence of the smoothing length on the density.
    #[serde(default)]
    pub smoothing_length: SmoothingLength,
    /// Upper bound of the smoothing length over the initial one (-), 1 to 3.
    #[serde(default = "growth")]
    pub smoothing_growth: f64,
    /// Kernel between particles of different smoothing lengths.
    #[serde(default)]
    pub symmetrisation: Symmetrisation,
    /// Time integration.
    #[serde(default)]
    pub integration: TimeIntegration,
    /// Form of the momentum equation. When absent and bodies differ in density, `rho-rho`, except with `grad-h`.
    #[serde(default)]
    pub momentum: MomentumEquation,
    /// Form of the continuity equation.
    #[serde(default)]
    pub continuity: ContinuityEquation,
    /// Whether density by summation is allowed where supports are not full at the start, or densities differ. Particles at free surfaces
    /// then lose up to half of their density, and jumps of density are smeared.
    #[serde(default)]
    pub allow_summation: bool,
    /// Operator of the velocity gradient of the material law. The default is `compatible` where all moving bodies are liquids, and
    /// `corotated` elsewhere: near a surface `compatible` includes only a part of a rotation, and strains a rotating body until it stops.
    #[serde(default)]
    pub velocity_gradient: VelocityGradientOperator,
    /// Linear artificial viscosity `α` (-), at least 0. It adds about `α h c/8` to the kinematic viscosity. The default is 0.1, or 0
    /// where all bodies are liquids whose own viscosity is at least `ρ c spacing/100`.
    #[serde(default = "viscosity")]
    pub viscosity_linear: f64,
    /// Quadratic artificial viscosity `β` (-), at least 0.
    #[serde(default)]
    pub viscosity_quadratic: f64,
    /// Speed of sound of the artificial viscosity and of the damping.
    #[serde(default)]
    pub sound_speed: SoundSpeed,
    /// Viscous damping `ξ` (-), at least 0: velocities decrease by the factor `exp(-ξ c dt / h)` in a step.
    #[serde(default)]
    pub damping: f64,
    /// Correction against tensile instability.
    #[serde(default)]
    pub tensile: Tensile,
    /// Smoothing of stress, for bodies whose law is in rate form. A law whose stress follows from its elastic strain or the rate of the
    /// motion, such as that of hyperelastic solids and Newtonian fluids, keeps its stress. Refused where no body's law is in rate form. A
    /// step without motion returns the stress to yield; where the law depends on time (relaxation, eigenstrain, user materials) the next
    /// step with motion does.
    #[serde(default)]
    pub regularisation: Regularisation,
    /// Number of steps between two regularisations of stress.
    #[serde(default = "default_regularisation_steps")]
    pub regularisation_steps: u64,
    /// Diffusion of stress `ζ` (-) within each body, 0 to 0.5. The stress difference due to the weight between particles is not diffused.
    /// For bodies whose law is in rate form, as `regularisation`; refused where no body's law is.
    #[serde(default)]
    pub stress_diffusion: f64,
    /// Ratio of horizontal to vertical stress (-) of the weight in `stress_diffusion`.
    #[serde(default = "default_wall_k0")]
    pub stress_diffusion_k0: f64,
    /// Diffusion of density `δ` (-) within each body of fluid, 0 to 0.5.
    #[serde(default)]
    pub density_diffusion: f64,
    /// Reinitialisation of density, for fluids.
    #[serde(default)]
    pub density_reset: DensityReset,
    /// Number of steps between two reinitialisations of density.
    #[serde(default = "default_reset_steps")]
    pub density_reset_steps: u64,
    /// XSPH fraction (-), 0 to 1: weight of the mean neighbour velocity in the motion of particles of bodies that are not `held`.
    #[serde(default)]
    pub xsph: f64,
    /// Viscosity of hourglass (zero-energy) modes, in units of `viscosity_linear`, 0 to 1. It acts on the part of the relative velocity
    /// of neighbours that their velocity gradients do not represent. It does not act on linear velocity fields where `velocity_gradient`
    /// is `corrected`, nor on rotations where it is `corotated`.
    #[serde(default)]
    pub hourglass_viscosity: f64,
    /// Shifting of particles towards even spacing, in smoothing lengths per length moved, at least 0. The default is 10 where all bodies
    /// that move by themselves are Newtonian liquids that fill the domain (no free surface) and there is no obstacle, and 0 elsewhere.
    /// Particles are shifted every four steps (more often with more than 10), in proportion to the distance moved since; this makes steps
    /// 1.7 times as expensive. Velocity, density and stress are transported to first order, density and stress with their gradients
    /// within the body.
    #[serde(default)]
    pub shifting: f64,
    /// Speed in the distance of `shifting`.
    #[serde(default)]
    pub shifting_speed: ShiftingSpeed,
    /// Configuration in which the kernel sums are taken.
    #[serde(default)]
    pub formulation: LagrangianFormulation,
    /// Confining pressure of a flexible membrane; none when absent.
    #[serde(default)]
    pub confining: Option<ConfiningPressure>,
    /// Names of bodies that keep their initial velocity field during the whole run, times the factor of `held_history`. Their stress
    /// follows their law.
    #[serde(default)]
    pub held: Vec<String>,
    /// Time histories of factors on the velocities of `held` bodies, by the name of the body. Bodies not named keep their velocities.
    #[serde(default)]
    pub held_history: BTreeMap<String, TimeHistory>,
    /// Names of `held` bodies along which other bodies slip without friction. Towards each particle beside it, such a body has the
    /// particle's own stress and velocity, mirrored in the plane normal to the direction from the particle to the body: forces act along
    /// that direction only. No force acts on the body, and it keeps its stress.
    #[serde(default)]
    pub smooth_bodies: Vec<String>,
    /// Whether the accuracy of the kernel sums is written. Fields: the plain gradient of a constant, times the smoothing length
    /// (`gradient_of_constant`, 0 where supports are full), and of the position (`gradient_of_position`, 1 there). Measures: the numbers
    /// of pairs of particles at one position and of corrections that fall back. The neighbours are searched anew for every output.
    #[serde(default)]
    pub diagnostics: bool,
    /// Time histories of factors on the velocities of walls, by the name of the wall or, without a name, of its side. The face is at the
    /// integral of the velocity over time. Walls not named keep their velocities.
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
    /// Discretisation of smooth walls. Fluid particles that pass the face are replaced by their images in it; other particles stop the
    /// run.
    #[serde(default)]
    pub smooth_wall: SmoothWall,
    /// Repulsion of particles closer than half a spacing to a particle of a wall, as a share of the square of the speed of sound. It
    /// prevents particles from passing a wall in hard impacts. 0 for none.
    #[serde(default)]
    pub wall_guard: f64,
    /// Repulsion of particles of fluids closer than 0.7 spacings to each other or to their image in a smooth wall, as a share of the
    /// square of the speed of sound, 0 to 0.2. It is needed since the pressure force decreases as particles approach each other. It
    /// conserves momentum and energy; its stored energy counts as elastic energy. 0 for none.
    #[serde(default = "repulsion")]
    pub close_repulsion: f64,
    /// Ratio of horizontal to vertical stress (-) with which `extrapolated` walls continue the weight of the soil.
    #[serde(default = "default_wall_k0")]
    pub wall_k0: f64,
    /// Courant number, up to 1: step times wave speed over smoothing length.
    #[serde(default = "courant")]
    pub courant: f64,
    /// Fixed time step (s); chosen by the solver when absent. A run whose critical step is or becomes shorter is refused or stops.
    /// Elastic waves may cross 1.8 smoothing lengths in the step, whatever the value of `courant`.
    #[serde(default)]
    pub time_step: Option<f64>,
    /// Number of ranks, 1 to 1024. Each rank computes a part of the particles and exchanges copies near its boundaries. Results equal those
    /// of one rank. Only with the leapfrog and current neighbours (`formulation: updated`).
    #[serde(default = "default_ranks")]
    pub ranks: u32,
}

impl MethodOptions for SphOptions {
    const METHOD: &'static str = "sph";
    const REQUIRED: &'static [&'static str] = &["spacing"];

    fn default_options(&self) -> Self {
        Self::new(self.spacing)
    }
}

impl SphOptions {
    /// Options with a spacing of the particles (m) and the defaults of a case file.
    #[must_use]
    pub fn new(spacing: f64) -> Self {
        with_defaults(&[("spacing", spacing)])
    }

    /// Smoothing length (m) of the initial spacing.
    pub fn smoothing_length_value(&self) -> f64 {
        self.smoothing * self.spacing
    }

    /// Whether particles have individual smoothing lengths.
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

    /// Whether strain is measured in a frame that rotates with the particle. The corrected gradient is exact for rotations without it.
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
/// Default number of ranks.
fn default_ranks() -> u32 {
    1
}
/// Default number of steps between two stress regularisations.
fn default_regularisation_steps() -> u64 {
    10
}
/// Default number of steps between two density resets.
fn default_reset_steps() -> u64 {
    30
}
/// Default growth limit of sheet: sph §6.19.
fn growth() -> f64 {
    1.5
}
/// Default ratio of horizontal to vertical stress of the soil weight, `K_0` (-).
fn default_wall_k0() -> f64 {
    0.5
}
/// Default Courant number of sheet: sph §3.4.
fn courant() -> f64 {
    0.25
}
