//! Options of `methods.sph` in a case file.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::kernel::Kernel;

/// Options of smoothed particle hydrodynamics.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphOptions {
    /// Initial distance of the particles (m).
    pub spacing: f64,
    /// Kernel.
    #[serde(default)]
    pub kernel: Kernel,
    /// Smoothing length over `spacing`, 0.9 to 3.
    #[serde(default = "smoothing")]
    pub smoothing: f64,
    /// Allows a smoothing at which the kernel is known to make particles clump.
    #[serde(default)]
    pub allow_pairing: bool,
    /// Form of the momentum equation.
    #[serde(default)]
    pub momentum: Momentum,
    /// Form of the continuity equation.
    #[serde(default)]
    pub continuity: Continuity,
    /// Operator of the velocity gradient that the law gets.
    #[serde(default)]
    pub velocity_gradient: VelocityGradient,
    /// Linear artificial viscosity, at least 0.
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
    /// Smoothing of stress. Only for laws whose stress is free of its history, as elastoplastic laws in
    /// rate form are: a law that keeps its elastic strain puts the old stress back.
    #[serde(default)]
    pub regularisation: Regularisation,
    /// Steps between two regularisations.
    #[serde(default = "ten")]
    pub regularisation_steps: u64,
    /// What rough walls answer with.
    #[serde(default)]
    pub wall_stress: WallStress,
    /// Ratio of horizontal to vertical stress by which `extrapolated` walls carry weight on.
    #[serde(default = "half")]
    pub wall_k0: f64,
    /// Courant number: step times wave speed over smoothing length, up to 1.
    #[serde(default = "courant")]
    pub courant: f64,
    /// Fixed time step (s), which must be below the stable one; chosen by the solver when absent.
    #[serde(default)]
    pub time_step: Option<f64>,
}

/// Form of the momentum equation (sheet §2.6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Momentum {
    /// `Σ m_j (σ_i / ρ_i² + σ_j / ρ_j²) ∇W`.
    #[default]
    Rho2,
    /// `Σ m_j (σ_i + σ_j) / (ρ_i ρ_j) ∇W`.
    RhoRho,
    /// `Σ m_j (σ_j - σ_i) / (ρ_i ρ_j) ∇W`: conserves nothing; to show what that does.
    Difference,
}

/// Form of the continuity equation (sheet §2.6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Continuity {
    /// `Σ m_j (v_i - v_j)·∇W`, for one material.
    #[default]
    Mass,
    /// `ρ_i Σ V_j (v_i - v_j)·∇W`, for jumps in density.
    Volume,
}

/// Operator of the velocity gradient (sheet §2.3).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum VelocityGradient {
    /// The adjoint of the momentum equation, which conserves energy: `density-difference` with `rho2`,
    /// `difference` otherwise.
    #[default]
    Compatible,
    /// `Σ V_j (v_j - v_i) ⊗ ∇W`.
    Difference,
    /// `Σ m_j (v_j - v_i) ⊗ ∇W / ρ_i`.
    DensityDifference,
    /// `difference` times the inverse moment: exact for linear fields, also at surfaces.
    Corrected,
}

/// Speed of sound (sheet §2.8).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SoundSpeed {
    /// That of P waves.
    #[default]
    PWave,
    /// `√(E/ρ)`, for materials with a Young's modulus.
    YoungsModulus,
}

/// Against tensile instability (sheet §2.11).
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

/// Smoothing of stress (sheet §2.10).
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

/// What rough walls answer with (sheet §2.13).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum WallStress {
    /// The stress and the mirrored velocity of each particle that touches them: conserves energy.
    #[default]
    Pairwise,
    /// Stress and velocity interpolated from the soil.
    Interpolated,
    /// The same with the weight between soil and wall.
    Extrapolated,
}

impl SphOptions {
    /// The defaults with particles `spacing` (m) apart.
    pub fn new(spacing: f64) -> Self {
        Self {
            spacing,
            kernel: Kernel::default(),
            smoothing: smoothing(),
            allow_pairing: false,
            momentum: Momentum::default(),
            continuity: Continuity::default(),
            velocity_gradient: VelocityGradient::default(),
            viscosity_linear: viscosity(),
            viscosity_quadratic: 0.0,
            sound_speed: SoundSpeed::default(),
            damping: 0.0,
            tensile: Tensile::default(),
            regularisation: Regularisation::default(),
            regularisation_steps: ten(),
            wall_stress: WallStress::default(),
            wall_k0: half(),
            courant: courant(),
            time_step: None,
        }
    }

    /// Smoothing length (m).
    pub fn length(&self) -> f64 {
        self.smoothing * self.spacing
    }

    /// Checks the ranges (sheet §7); the error names the option and the rule.
    ///
    /// # Errors
    /// The first option out of range, as (name, problem).
    pub fn validate(&self) -> Result<(), (&'static str, String)> {
        let rule = |name, value: f64, holds: bool, rule: &str| {
            if holds { Ok(()) } else { Err((name, format!("{value} {rule}"))) }
        };
        let positive = |value: f64| value.is_finite() && value > 0.0;
        let at_least_zero = |value: f64| value.is_finite() && value >= 0.0;
        rule("spacing", self.spacing, positive(self.spacing), "must be finite and positive (m)")?;
        let ratio = self.smoothing;
        rule("smoothing", ratio, (0.9..=3.0).contains(&ratio), "is not in 0.9..=3")?;
        let most = self.clumping_from().unwrap_or(f64::INFINITY);
        if ratio > most && !self.allow_pairing {
            let problem =
                format!("{ratio} makes particles clump with this kernel; at most {most}, or allow_pairing");
            return Err(("smoothing", problem));
        }
        let (linear, quadratic) = (self.viscosity_linear, self.viscosity_quadratic);
        rule("viscosity_linear", linear, at_least_zero(linear), "must be finite and not negative")?;
        rule("viscosity_quadratic", quadratic, at_least_zero(quadratic), "must be finite and not negative")?;
        rule("damping", self.damping, at_least_zero(self.damping), "must be finite and not negative")?;
        rule("wall_k0", self.wall_k0, at_least_zero(self.wall_k0), "must be finite and not negative")?;
        if let Tensile::ArtificialStress { strength, exponent }
        | Tensile::ArtificialPressure { strength, exponent } = self.tensile
        {
            rule("tensile.strength", strength, (0.0..=1.0).contains(&strength), "is not in 0..=1")?;
            rule("tensile.exponent", exponent, positive(exponent), "must be finite and positive")?;
        }
        let steps = self.regularisation_steps;
        rule("regularisation_steps", steps as f64, steps > 0, "must be at least 1")?;
        let courant = self.courant;
        rule("courant", courant, courant > 0.0 && courant <= 1.0, "is not in 0..=1 (0 excluded)")?;
        if let Some(step) = self.time_step {
            rule("time_step", step, positive(step), "must be finite and positive (s)")?;
        }
        Ok(())
    }

    /// Smoothing over spacing beyond which the kernel is known to clump.
    fn clumping_from(&self) -> Option<f64> {
        match self.kernel {
            Kernel::CubicSpline => Some(2.0),
            Kernel::Gaussian => Some(2.4),
            _ => None,
        }
    }

    /// What is allowed but worth a word.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        let mut warn = |name: &str, holds: bool, text: &str| {
            if holds {
                warnings.push(format!("methods.sph.{name}: {text}"));
            }
        };
        let ratio = self.smoothing;
        let clumps = match self.kernel {
            Kernel::CubicSpline => ratio > 1.5,
            Kernel::Gaussian => ratio >= 2.0,
            _ => false,
        };
        warn("smoothing", clumps, "particles may clump with this kernel");
        let few = self.kernel == Kernel::WendlandC2 && ratio < 1.2;
        warn("smoothing", few, "Wendland kernels need at least 1.2");
        warn("viscosity_linear", self.viscosity_linear > 2.0, "more than 2 shortens run-outs");
        warn("courant", self.courant > 0.4, "more than 0.4 may be unstable near walls and surfaces");
        warn("momentum", self.momentum == Momentum::Difference, "this form does not conserve momentum");
        warnings
    }
}

/// Of the sheet's reference runs.
fn smoothing() -> f64 {
    1.2
}
/// Fitted by the source for granular flow, cubic spline and smoothing 1.2.
fn viscosity() -> f64 {
    0.1
}
fn ten() -> u64 {
    10
}
fn half() -> f64 {
    0.5
}
/// Sheet §3.4.
fn courant() -> f64 {
    0.25
}
