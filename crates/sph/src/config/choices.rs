//! Enumerated options.

use colluvium_constitutive::with_defaults;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Momentum equation (sheet: sph §2.6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MomentumEquation {
    /// Symmetric `Σ m_j (σ_i / ρ_i² + σ_j / ρ_j²) ∇W`.
    #[default]
    Rho2,
    /// Symmetric `Σ m_j (σ_i + σ_j) / (ρ_i ρ_j) ∇W`.
    RhoRho,
    /// Corrected `Σ m_j (σ_i L_i + σ_j L_j) / (ρ_i ρ_j) ∇W`, gradient corrections `L`. Conserves energy with the `corrected` velocity
    /// gradient, to which `compatible` and `corotated` resolve; other operators are refused.
    Corrected,
    /// Difference `Σ m_j (σ_j - σ_i) / (ρ_i ρ_j) ∇W`, conserves neither momentum nor energy; for demonstrations.
    Difference,
}

/// Continuity equation (sheet: sph §2.6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ContinuityEquation {
    /// Trace form `-ρ_i tr L` with the law's velocity gradient: density and strain agree, also at surfaces. It is `mass` with
    /// `density-difference`, `volume` with `difference`, and exact for linear fields with `corrected`.
    #[default]
    Trace,
    /// Mass form `Σ m_j (v_i - v_j)·∇W`, for one material.
    Mass,
    /// Volume form `ρ_i Σ V_j (v_i - v_j)·∇W`, for jumps in density.
    Volume,
    /// Density summation `Σ m_j W`, for one density with full supports, as in closed or periodic domains that bodies fill.
    Summation,
}

/// Operator of the velocity gradient (sheet: sph §2.3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VelocityGradientOperator {
    /// Adjoint of the momentum equation, conserves energy: `density-difference` with `rho2`, else `difference`.
    #[default]
    Compatible,
    /// Operator `compatible` in a frame rotating with the particle: exact for rotations, also at surfaces.
    Corotated,
    /// Difference `Σ V_j (v_j - v_i) ⊗ ∇W`.
    Difference,
    /// Difference with densities, `Σ m_j (v_j - v_i) ⊗ ∇W / ρ_i`.
    DensityDifference,
    /// Operator `difference` times the inverse moment matrix: exact for linear fields, also at surfaces.
    Corrected,
}

/// Sound speed (sheet: sph §2.8).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SoundSpeed {
    /// P-wave speed.
    #[default]
    PWave,
    /// Speed `√(E/ρ)`, for materials with a Young's modulus.
    YoungsModulus,
}

/// Correction against tensile instability (sheet: sph §2.11). The kernel ratio is the kernel over that at the initial spacing, which grows
/// with varying smoothing lengths.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Tensile {
    /// No correction, for materials without tensile stress.
    #[default]
    None,
    /// Artificial stress: repulsion along principal tensions.
    ArtificialStress {
        /// Strength `ε₀`, 0 to 1.
        strength: f64,
        /// Exponent `n` of the kernel ratio.
        exponent: f64,
    },
    /// Artificial pressure: repulsion by the mean tension.
    ArtificialPressure {
        /// Strength, 0 to 1.
        strength: f64,
        /// Exponent of the kernel ratio.
        exponent: f64,
    },
}

impl Tensile {
    /// Exponent of the kernel ratio; `None` without artificial repulsion.
    pub(crate) fn exponent(self) -> Option<f64> {
        match self {
            Self::None => None,
            Self::ArtificialStress { exponent, .. } | Self::ArtificialPressure { exponent, .. } => {
                Some(exponent)
            }
        }
    }
}

/// Stress smoothing (sheet: sph §2.10).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Regularisation {
    /// No smoothing.
    #[default]
    None,
    /// Shepard average, exact for constant fields.
    Shepard,
    /// Moving least squares, exact for linear fields.
    Mls,
}

/// Rough wall stress and velocity (sheet: sph §2.13).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WallStress {
    /// Stress and mirrored velocity of each interacting particle: conserves energy.
    #[default]
    Pairwise,
    /// Interpolated from the soil.
    Interpolated,
    /// Extrapolated from the soil, with the weight between.
    Extrapolated,
}

/// Smoothing length by density (sheet: sph §2.5).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SmoothingLength {
    /// Constant length.
    #[default]
    Constant,
    /// Function `h = h₀ (ρ₀/ρ)^(1/d)`.
    Density,
    /// Rate `ḣ` from two density rates (AL1 36–37); not tested by its authors.
    Rate,
}

/// Kernel of different smoothing lengths (sheet: sph §2.5).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Symmetrisation {
    /// Arithmetic mean `(h_i + h_j) / 2`.
    #[default]
    Arithmetic,
    /// Harmonic mean `2 h_i h_j / (h_i + h_j)`.
    Harmonic,
    /// Geometric mean `√(h_i h_j)`.
    Geometric,
    /// Larger length.
    Max,
    /// Smaller length.
    Min,
    /// Mean of both kernels.
    Kernel,
    /// Each particle's own kernel, with factors of the gradient of `h` in continuity and momentum (BN 52–53).
    GradH,
}

/// Time integration (sheet: sph §3.3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TimeIntegration {
    /// Velocities at half steps, the rest at full steps.
    #[default]
    Leapfrog,
    /// As in the source: velocity, density and stress at half steps, predicted to full ones for rates.
    LeapfrogRates,
    /// Rates at the predicted mid-step.
    PredictorCorrector,
    /// Half position, velocity, half position update.
    PositionVerlet,
    /// Half velocity, position, half velocity update.
    VelocityVerlet,
    /// Velocities over two steps, with simple steps at intervals.
    Verlet,
    /// Four stages; the law is evaluated once, with their mean velocity gradient.
    RungeKutta4,
}

/// Density reinitialisation (sheet: sph §2.10).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DensityReset {
    /// No reinitialisation.
    #[default]
    None,
    /// Shepard summation.
    Shepard,
    /// Moving least squares.
    Mls,
}

/// Velocity of rough walls with `pairwise` stress (sheet: sph §2.13).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WallVelocity {
    /// Mirrored particle velocity: conserves energy.
    #[default]
    Mirrored,
    /// Linear in wall distances, at most half the particle's own.
    Linear,
}

/// Rough wall discretisation (sheet: sph §2.13).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RoughWall {
    /// Fixed particle layers, as in `wall_stress`.
    #[default]
    Particles,
    /// Images with opposite velocity and equal stress: zero velocity at the face, at any particle distance. For viscous flow, with `hourglass_viscosity`, without
    /// which loose particles may pass. Images need not conserve energy.
    Mirror,
}

/// Smooth wall discretisation (sheet: sph §2.13).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SmoothWall {
    /// Mirror images, an exact wall.
    #[default]
    Mirror,
    /// Fixed particle layers that leave the tangential velocity unchanged.
    Particles,
}

/// Speed in shifting (sheet: sph §2.12).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ShiftingSpeed {
    /// Speed of the particle: at rest no shifting.
    #[default]
    Own,
    /// Speed of the fastest of the body, as in δ⁺-SPH (Sun et al. 2017), for even spacing in vortices too.
    Largest,
}

/// Configuration of kernel sums (sheet: sph §2.14).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "SphFormulation")]
pub enum LagrangianFormulation {
    /// Current: neighbours change.
    #[default]
    Updated,
    /// Initial, corrected gradients: for solids that keep their neighbours, without tensile instability.
    TotalLagrangian,
}

/// Confining pressure of a flexible membrane (sheet: sph §2.13 g). Needs a `smoothing` of 1 to 1.5 and constant smoothing length.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConfiningPressure {
    /// Pressure (Pa), non-negative.
    pub pressure: f64,
    /// Time of growth from zero (s).
    #[serde(default)]
    pub ramp: f64,
    /// Bodies under the pressure; all not `held` when absent.
    #[serde(default)]
    pub bodies: Option<Vec<String>>,
    /// Particles under the pressure.
    #[serde(default)]
    pub on: ConfiningPressureTarget,
}

impl ConfiningPressure {
    /// Pressure (Pa) from the start on, on the surfaces of all bodies that are not `held`.
    #[must_use]
    pub fn new(pressure: f64) -> Self {
        with_defaults(&[("pressure", pressure)])
    }
}

/// Particles under confining pressure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ConfiningPressureTarget {
    /// Surface particles and their nearest neighbours.
    #[default]
    Surface,
    /// All; within a body the sum vanishes only for even spacing.
    All,
}
