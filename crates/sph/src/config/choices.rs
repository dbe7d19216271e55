//! Enumerated options.

use colluvium_constitutive::with_defaults;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Form of the momentum equation (sheet: sph §2.6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MomentumEquation {
    /// Symmetric form `Σ m_j (σ_i / ρ_i² + σ_j / ρ_j²) ∇W`.
    #[default]
    Rho2,
    /// Symmetric form `Σ m_j (σ_i + σ_j) / (ρ_i ρ_j) ∇W`.
    RhoRho,
    /// Corrected form `Σ m_j (σ_i L_i + σ_j L_j) / (ρ_i ρ_j) ∇W` with gradient corrections `L`. Conserves energy with the `corrected`
    /// velocity gradient, to which `compatible` and `corotated` then resolve; the other operators are refused.
    Corrected,
    /// Difference form `Σ m_j (σ_j - σ_i) / (ρ_i ρ_j) ∇W`, which conserves neither momentum nor energy; for demonstrations.
    Difference,
}

/// Form of the continuity equation (sheet: sph §2.6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ContinuityEquation {
    /// Trace form `-ρ_i tr L` with the velocity gradient of the law, so that density and strain agree, also at surfaces. It is `mass` with
    /// `density-difference`, `volume` with `difference`, and exact for linear fields with `corrected`.
    #[default]
    Trace,
    /// Mass form `Σ m_j (v_i - v_j)·∇W`, for one material.
    Mass,
    /// Volume form `ρ_i Σ V_j (v_i - v_j)·∇W`, for jumps in density.
    Volume,
    /// Density summation `Σ m_j W`, for one density with full supports, as in closed or periodic domains that the bodies fill.
    Summation,
}

/// Operator of the velocity gradient (sheet: sph §2.3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VelocityGradientOperator {
    /// Adjoint of the momentum equation, which conserves energy: `density-difference` with `rho2`, else `difference`.
    #[default]
    Compatible,
    /// Operator `compatible` in a frame that rotates with the particle: exact for rotations, also at surfaces.
    Corotated,
    /// Difference operator `Σ V_j (v_j - v_i) ⊗ ∇W`.
    Difference,
    /// Difference operator with densities, `Σ m_j (v_j - v_i) ⊗ ∇W / ρ_i`.
    DensityDifference,
    /// `difference` times the inverse moment matrix: exact for linear fields, also at surfaces.
    Corrected,
}

/// Speed of sound (sheet: sph §2.8).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SoundSpeed {
    /// Speed of P waves.
    #[default]
    PWave,
    /// Speed `√(E/ρ)`, for materials with a Young's modulus.
    YoungsModulus,
}

/// Correction against tensile instability (sheet: sph §2.11). The kernel ratio is the kernel over its value at the initial spacing, which
/// grows with a varying smoothing length.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Tensile {
    /// No correction, for materials without tensile stress.
    #[default]
    None,
    /// Artificial stress: repulsion along the principal tensions.
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

/// Smoothing of stress (sheet: sph §2.10).
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

/// Stress and velocity of rough walls (sheet: sph §2.13).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WallStress {
    /// Stress and mirrored velocity of each interacting particle: conserves energy.
    #[default]
    Pairwise,
    /// Stress and velocity interpolated from the soil.
    Interpolated,
    /// Stress and velocity extrapolated from the soil, with the weight between.
    Extrapolated,
}

/// Dependence of the smoothing length on the density (sheet: sph §2.5).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SmoothingLength {
    /// Constant smoothing length.
    #[default]
    Constant,
    /// Function of the density, `h = h₀ (ρ₀/ρ)^(1/d)`.
    Density,
    /// Rate `ḣ` from two density rates (AL1 36–37); not tested by its authors.
    Rate,
}

/// Kernel between particles of different smoothing lengths (sheet: sph §2.5).
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
    /// Larger smoothing length.
    Max,
    /// Smaller smoothing length.
    Min,
    /// Mean of the two kernels.
    Kernel,
    /// Each particle's own kernel, with factors of the gradient of `h` in continuity and momentum (BN 52–53).
    GradH,
}

/// Time integration (sheet: sph §3.3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TimeIntegration {
    /// Velocities at half steps, all else at full steps.
    #[default]
    Leapfrog,
    /// As in the source: velocity, density and stress at half steps, predicted to full ones for the rates.
    LeapfrogRates,
    /// Rates at the predicted middle of the step.
    PredictorCorrector,
    /// Half a position, a whole velocity, half a position update.
    PositionVerlet,
    /// Half a velocity, a whole position, half a velocity update.
    VelocityVerlet,
    /// Velocities over two steps, with a simple step at intervals.
    Verlet,
    /// Four stages; the law is evaluated once, with the mean of their velocity gradients.
    RungeKutta4,
}

/// Reinitialisation of density (sheet: sph §2.10).
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
    /// Mirrored velocity of the particle: conserves energy.
    #[default]
    Mirrored,
    /// Velocity linear in the distances from the wall, at most half of the particle's own.
    Linear,
}

/// Discretisation of rough walls (sheet: sph §2.13).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RoughWall {
    /// Layers of fixed particles, as in `wall_stress`.
    #[default]
    Particles,
    /// Images with opposite velocity and equal stress: zero velocity at the face, at any particle distance. For viscous flow, with
    /// `hourglass_viscosity`, without which loose particles may pass the wall. Images need not conserve energy.
    Mirror,
}

/// Discretisation of smooth walls (sheet: sph §2.13).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SmoothWall {
    /// Mirror images of the particles, an exact wall.
    #[default]
    Mirror,
    /// Layers of fixed particles that leave the tangential velocity unchanged.
    Particles,
}

/// Speed in the distance of shifting (sheet: sph §2.12).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ShiftingSpeed {
    /// Speed of the particle itself: particles at rest are not shifted.
    #[default]
    Own,
    /// Speed of the fastest particle of the body, as in δ⁺-SPH (Sun et al. 2017), for even spacing in vortices too.
    Largest,
}

/// Configuration in which the kernel sums are taken (sheet: sph §2.14).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "SphFormulation")]
pub enum LagrangianFormulation {
    /// Current configuration: neighbours change.
    #[default]
    Updated,
    /// Initial configuration, corrected gradients: for solids that keep their neighbours, without tensile instability.
    TotalLagrangian,
}

/// Confining pressure of a flexible membrane (sheet: sph §2.13 g). It needs a `smoothing` of 1 to 1.5 and a constant smoothing length.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConfiningPressure {
    /// Pressure (Pa), not negative.
    pub pressure: f64,
    /// Time (s) over which the pressure grows from zero.
    #[serde(default)]
    pub ramp: f64,
    /// Bodies under the pressure; when absent all that are not `held`.
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

/// Particles under a confining pressure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ConfiningPressureTarget {
    /// Particles at the surface and their nearest neighbours.
    #[default]
    Surface,
    /// All particles; within a body the sum vanishes only for even spacing.
    All,
}
