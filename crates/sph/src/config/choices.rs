//! Enumerated options.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Form of the momentum equation (sheet: sph §2.6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum MomentumEquation {
    /// `Σ m_j (σ_i / ρ_i² + σ_j / ρ_j²) ∇W`.
    #[default]
    Rho2,
    /// `Σ m_j (σ_i + σ_j) / (ρ_i ρ_j) ∇W`.
    RhoRho,
    /// `Σ m_j (σ_i L_i + σ_j L_j) / (ρ_i ρ_j) ∇W` with the corrections `L` of the gradient: conserves energy with the
    /// `corrected` velocity gradient, which it needs.
    Corrected,
    /// `Σ m_j (σ_j - σ_i) / (ρ_i ρ_j) ∇W`: conserves nothing; to show what that does.
    Difference,
}

/// Form of the continuity equation (sheet: sph §2.6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ContinuityEquation {
    /// `-ρ_i tr L` with the velocity gradient that the law gets, so that density and strain agree, at surfaces too: `mass`
    /// with its operator `density-difference`, `volume` with `difference`, exact for linear fields with `corrected`.
    #[default]
    Trace,
    /// `Σ m_j (v_i - v_j)·∇W`, for one material.
    Mass,
    /// `ρ_i Σ V_j (v_i - v_j)·∇W`, for jumps in density.
    Volume,
    /// `Σ m_j W`: for one density in closed or periodic domains, which the bodies must fill: supports are to be full.
    Summation,
}

/// Operator of the velocity gradient (sheet: sph §2.3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VelocityGradientOperator {
    /// The adjoint of the momentum equation, which conserves energy: `density-difference` with `rho2`,
    /// `difference` otherwise.
    #[default]
    Compatible,
    /// `compatible` of the velocities as seen from what turns with the particle, and that turning: exact for rotations, also at surfaces.
    Corotated,
    /// `Σ V_j (v_j - v_i) ⊗ ∇W`.
    Difference,
    /// `Σ m_j (v_j - v_i) ⊗ ∇W / ρ_i`.
    DensityDifference,
    /// `difference` times the inverse moment: exact for linear fields, also at surfaces.
    Corrected,
}

/// Speed of sound (sheet: sph §2.8).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SoundSpeed {
    /// That of P waves.
    #[default]
    PWave,
    /// `√(E/ρ)`, for materials with a Young's modulus.
    YoungsModulus,
}

/// Against tensile instability (sheet: sph §2.11). The ratio of kernels is that of the kernel between two particles to its
/// value at their spacing: the initial one, times how far the smoothing length has grown where it varies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Tensile {
    /// Nothing: for materials that bear no tension.
    #[default]
    None,
    /// Repulsion along the principal tensions.
    ArtificialStress {
        /// Strength, 0 to 1.
        strength: f64,
        /// Exponent of the ratio of kernels.
        exponent: f64,
    },
    /// Repulsion by the mean tension.
    ArtificialPressure {
        /// Strength, 0 to 1.
        strength: f64,
        /// Exponent of the ratio of kernels.
        exponent: f64,
    },
}

impl Tensile {
    /// Exponent of the ratio of kernels; `None` without artificial repulsion.
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
    /// None.
    #[default]
    None,
    /// Exact for constant fields.
    Shepard,
    /// Moving least squares, exact for linear fields.
    Mls,
}

/// Stress and velocity of rough walls (sheet: sph §2.13).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WallStress {
    /// The stress and the mirrored velocity of each particle that touches them: conserves energy.
    #[default]
    Pairwise,
    /// Stress and velocity interpolated from the soil.
    Interpolated,
    /// Stress and velocity extrapolated from the soil, with the weight between soil and wall.
    Extrapolated,
}

/// How the smoothing length follows the density (sheet: sph §2.5).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SmoothingLength {
    /// Not at all.
    #[default]
    Constant,
    /// `h = h₀ (ρ₀/ρ)^(1/d)`.
    Density,
    /// `ḣ` from the difference between two rates of density (AL1 36–37); not tested by its authors.
    Rate,
}

/// The kernel between particles of different smoothing lengths (sheet: sph §2.5).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Symmetrisation {
    /// `(h_i + h_j) / 2`.
    #[default]
    Arithmetic,
    /// `2 h_i h_j / (h_i + h_j)`.
    Harmonic,
    /// `√(h_i h_j)`.
    Geometric,
    /// The larger one.
    Max,
    /// The smaller one.
    Min,
    /// The mean of the two kernels.
    Kernel,
    /// Each particle its own kernel, with the factors of the gradient of `h` in the continuity and the momentum
    /// equation (BN 52–53).
    GradH,
}

/// Time integration (sheet: sph §3.3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum TimeIntegration {
    /// Velocities at half steps, everything else at full steps.
    #[default]
    Leapfrog,
    /// The source's leapfrog: velocity, density and stress at half steps, predicted to full steps for the rates.
    LeapfrogRates,
    /// Rates at the middle of the step, predicted.
    PredictorCorrector,
    /// Half a drift, a whole kick, half a drift.
    PositionVerlet,
    /// Half a kick, a whole drift, half a kick.
    VelocityVerlet,
    /// Velocities over two steps, with a plain step now and then.
    Verlet,
    /// Four stages; the law is called once with the mean of their velocity gradients.
    RungeKutta4,
}

/// Renewal of density (sheet: sph §2.10).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DensityReset {
    /// None.
    #[default]
    None,
    /// Shepard's sum.
    Shepard,
    /// Moving least squares.
    Mls,
}

/// Velocity of rough walls that mirror the particle state pairwise (sheet: sph §2.13).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WallVelocity {
    /// The mirrored velocity: conserves energy.
    #[default]
    Mirrored,
    /// Linear in the distances from the wall, at most half of the particle's own.
    Linear,
}

/// Discretisation of rough walls (sheet: sph §2.13).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RoughWall {
    /// Layers of fixed particles, which answer as `wall_stress` says.
    #[default]
    Particles,
    /// Images of the particles with opposite velocity and the same stress: nothing moves along the face itself,
    /// whatever the distance. For viscous flow, with `hourglass_viscosity`, without which particles of loose material may
    /// pass; it need not conserve energy as `pairwise` particles do.
    Mirror,
}

/// Discretisation of smooth walls (sheet: sph §2.13).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SmoothWall {
    /// Mirror images of the particles: exact.
    #[default]
    Mirror,
    /// Layers of fixed particles that keep the tangential velocity.
    Particles,
}

/// The speed that goes into the way over which particles are shifted (sheet: sph §2.12).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ShiftingSpeed {
    /// The particle's own: what rests is not shifted, however uneven it lies.
    #[default]
    Own,
    /// That of the fastest particle of the body, as in the δ⁺ scheme (Sun et al. 2017): the middle of a vortex, which
    /// hardly moves, is kept even too.
    Largest,
}

/// The configuration that the sums are taken over (sheet: sph §2.14).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "SphFormulation")]
pub enum LagrangianFormulation {
    /// The present one: neighbours change.
    #[default]
    Updated,
    /// The initial one, with corrected gradients: solids that keep their neighbours, free of tensile instability.
    TotalLagrangian,
}

/// Confining pressure of a flexible membrane (sheet: sph §2.13 g).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConfiningPressure {
    /// Pressure (Pa), at least 0.
    pub pressure: f64,
    /// Time over which it grows from zero (s).
    #[serde(default)]
    pub ramp: f64,
    /// Names of the bodies it acts on; all that are not held when absent.
    #[serde(default)]
    pub bodies: Option<Vec<String>>,
    /// The particles it acts on.
    #[serde(default)]
    pub on: ConfinedParticles,
}

/// Particles that a confining pressure acts on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ConfinedParticles {
    /// Those at the surface and their nearest neighbours.
    #[default]
    Surface,
    /// All: within a body the sum vanishes on even arrangements only.
    All,
}
