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
    /// Initial distance of particles (m).
    pub spacing: f64,
    /// Smoothing kernel. Default `wendland-c2` where only Newtonian liquids move freely (`formulation` `updated`): they clump with the
    /// cubic spline.
    #[serde(default)]
    pub kernel: Kernel,
    /// Smoothing length over `spacing`, 0.9 to 3; default 1.5 for Newtonian liquids with `wendland-c2`.
    #[serde(default = "smoothing")]
    pub smoothing: f64,
    /// Whether a smoothing at which particles clump is allowed.
    #[serde(default)]
    pub allow_pairing: bool,
    /// Smoothing length by density.
    #[serde(default)]
    pub smoothing_length: SmoothingLength,
    /// Largest smoothing length over the initial one, 1 to 3.
    #[serde(default = "growth")]
    pub smoothing_growth: f64,
    /// Kernel of different smoothing lengths.
    #[serde(default)]
    pub symmetrisation: Symmetrisation,
    /// Time integration.
    #[serde(default)]
    pub integration: TimeIntegration,
    /// Momentum equation. When absent and densities of bodies differ `rho-rho`, except with `grad-h`.
    #[serde(default)]
    pub momentum: MomentumEquation,
    /// Continuity equation.
    #[serde(default)]
    pub continuity: ContinuityEquation,
    /// Whether density summation is allowed where supports are not full or initial densities differ. Free surfaces then lose up to half
    /// their density, and jumps are smeared.
    #[serde(default)]
    pub allow_summation: bool,
    /// Velocity gradient of the law. Default `corotated` unless all moving bodies are liquids: near surfaces `compatible` strains a
    /// rotating body until it stops.
    #[serde(default)]
    pub velocity_gradient: VelocityGradientOperator,
    /// Linear artificial viscosity `α`, non-negative; adds about `α h c/8` to the kinematic viscosity. Default 0 if all bodies are liquids
    /// of viscosity `ρ c spacing/100` or more.
    #[serde(default = "viscosity")]
    pub viscosity_linear: f64,
    /// Quadratic artificial viscosity `β`, non-negative.
    #[serde(default)]
    pub viscosity_quadratic: f64,
    /// Sound speed of artificial viscosity and damping.
    #[serde(default)]
    pub sound_speed: SoundSpeed,
    /// Viscous damping `ξ`, non-negative: velocities decrease by `exp(-ξ c dt / h)` per step.
    #[serde(default)]
    pub damping: f64,
    /// Correction against tensile instability.
    #[serde(default)]
    pub tensile: Tensile,
    /// Stress smoothing, for laws in rate form; refused without one. Other laws, as of hyperelastic solids and Newtonian fluids, keep their
    /// stress. A step without motion returns it to yield; for time-dependent laws (relaxation, eigenstrain, user materials) the next with
    /// motion does.
    #[serde(default)]
    pub regularisation: Regularisation,
    /// Steps between stress regularisations.
    #[serde(default = "default_regularisation_steps")]
    pub regularisation_steps: u64,
    /// Stress diffusion `ζ` within each body, 0 to 0.5, without the difference due to weight. For laws in rate form; refused without one.
    #[serde(default)]
    pub stress_diffusion: f64,
    /// Horizontal over vertical stress of the weight in `stress_diffusion`.
    #[serde(default = "default_wall_k0")]
    pub stress_diffusion_k0: f64,
    /// Density diffusion `δ` within each fluid body, 0 to 0.5.
    #[serde(default)]
    pub density_diffusion: f64,
    /// Density reinitialisation, for fluids.
    #[serde(default)]
    pub density_reset: DensityReset,
    /// Steps between density reinitialisations.
    #[serde(default = "default_reset_steps")]
    pub density_reset_steps: u64,
    /// XSPH fraction, 0 to 1: weight of mean neighbour velocity in the motion of bodies not `held`.
    #[serde(default)]
    pub xsph: f64,
    /// Viscosity of hourglass (zero-energy) modes, in units of `viscosity_linear`, 0 to 1. It acts on relative velocities outside velocity
    /// gradients: not on linear fields with `velocity_gradient` `corrected`, nor rotations with `corotated`.
    #[serde(default)]
    pub hourglass_viscosity: f64,
    /// Shifting towards even spacing, in smoothing lengths per length moved, non-negative. Default 10 where only Newtonian liquids move
    /// freely, fill the domain (no free surface) and meet no obstacle. It acts every four steps (more often above 10) and makes steps 1.7
    /// times as expensive. Fields are transported to first order, density and stress with gradients within the body.
    #[serde(default)]
    pub shifting: f64,
    /// Speed in `shifting`.
    #[serde(default)]
    pub shifting_speed: ShiftingSpeed,
    /// Configuration of kernel sums.
    #[serde(default)]
    pub formulation: LagrangianFormulation,
    /// Membrane pressure.
    #[serde(default)]
    pub confining: Option<ConfiningPressure>,
    /// Bodies that keep their initial velocity field, times `held_history`; stress follows their law.
    #[serde(default)]
    pub held: Vec<String>,
    /// Factors on velocities of `held` bodies in time.
    #[serde(default)]
    pub held_history: BTreeMap<String, TimeHistory>,
    /// `held` bodies along which others slip without friction. Particles beside them meet their own stress and velocity, mirrored in the
    /// plane normal to their direction to the body. Forces act along that direction, none on the body, which keeps its stress.
    #[serde(default)]
    pub smooth_bodies: Vec<String>,
    /// Whether accuracy of kernel sums is written. Fields: gradients of a constant times smoothing length (`gradient_of_constant`, 0 in
    /// full supports) and of position (`gradient_of_position`, 1 there). Measures: numbers of coincident pairs and of corrections that fall
    /// back. Outputs search neighbours anew.
    #[serde(default)]
    pub diagnostics: bool,
    /// Factors on wall velocities in time, by name or side. The face is at the velocity's integral.
    #[serde(default)]
    pub wall_history: BTreeMap<String, TimeHistory>,
    /// Rough wall stress and velocity.
    #[serde(default)]
    pub wall_stress: WallStress,
    /// Velocity of `pairwise` rough walls.
    #[serde(default)]
    pub wall_velocity: WallVelocity,
    /// Rough wall discretisation.
    #[serde(default)]
    pub rough_wall: RoughWall,
    /// Smooth wall discretisation. Fluid particles past the face are replaced by their images; others stop the run.
    #[serde(default)]
    pub smooth_wall: SmoothWall,
    /// Repulsion from wall particles closer than half a spacing, over squared sound speed, against passage in hard impacts; 0 for none.
    #[serde(default)]
    pub wall_guard: f64,
    /// Repulsion of fluid particles closer than 0.7 spacings to each other or their smooth-wall image, over squared sound speed, 0 to 0.2;
    /// 0 for none. It conserves momentum and energy (stored as elastic).
    #[serde(default = "repulsion")]
    pub close_repulsion: f64,
    /// Horizontal over vertical stress of the weight at `extrapolated` walls.
    #[serde(default = "default_wall_k0")]
    pub wall_k0: f64,
    /// Courant number, up to 1: step times wave speed over smoothing length.
    #[serde(default = "courant")]
    pub courant: f64,
    /// Fixed time step (s); the solver's when absent. A run whose critical step is or becomes shorter is refused or stops; elastic waves
    /// may cross 1.8 smoothing lengths, whatever `courant`.
    #[serde(default)]
    pub time_step: Option<f64>,
    /// Ranks, 1 to 1024, each with a part of the particles; results do not depend on them. Only with `integration` `leapfrog` and
    /// `formulation` `updated`.
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
