//! Options of `methods.sph` in a case file.

mod choices;
mod history;

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use choices::{
    Confined, Confining, Continuity, DensityReset, Formulation, Momentum, Regularisation, RoughWall,
    SmoothWall, SmoothingLength, SoundSpeed, Symmetrisation, Tensile, TimeIntegration, VelocityGradient,
    WallStress, WallVelocity,
};
pub use history::History;

use crate::kernel::Kernel;

/// Largest shift of a particle, in spacings (sheet §2.12).
pub(crate) const LONGEST_SHIFT: f64 = 0.1;

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
    /// Form of the momentum equation.
    #[serde(default)]
    pub momentum: Momentum,
    /// Form of the continuity equation.
    #[serde(default)]
    pub continuity: Continuity,
    /// Allows density by summation where supports are not full at the start, or densities differ: particles at free
    /// surfaces lose up to half of their density, and jumps of density are smeared.
    #[serde(default)]
    pub allow_summation: bool,
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
    /// Smoothing of stress, of bodies whose law is in rate form: a law that finds its stress from its elastic strain or
    /// the rate of the motion, as hyperelastic laws and Newtonian fluids do, keeps its own. Refused where no body's law
    /// is in rate form. A step without motion takes the stress back to yield; where the law depends on time (relaxation,
    /// eigenstrain, user materials) the next step with motion does.
    #[serde(default)]
    pub regularisation: Regularisation,
    /// Steps between two regularisations.
    #[serde(default = "ten")]
    pub regularisation_steps: u64,
    /// Diffusion of stress `ζ` within each body, 0 to 0.5; what the weight between particles explains is left out. Acts
    /// on bodies whose law is in rate form, as `regularisation`, and is refused where no body's is.
    #[serde(default)]
    pub stress_diffusion: f64,
    /// Ratio of horizontal to vertical stress in that weight.
    #[serde(default = "half")]
    pub stress_diffusion_k0: f64,
    /// Diffusion of density `δ` within each body of fluid, 0 to 0.5.
    #[serde(default)]
    pub density_diffusion: f64,
    /// Renewal of density, for fluids.
    #[serde(default)]
    pub density_reset: DensityReset,
    /// Steps between two renewals.
    #[serde(default = "thirty")]
    pub density_reset_steps: u64,
    /// Share of the neighbours' velocity with which particles of bodies that are not `held` move (XSPH), 0 to 1.
    #[serde(default)]
    pub xsph: f64,
    /// Viscosity, in units of `viscosity_linear`, against the part of the relative velocity of neighbours that their
    /// velocity gradients do not see (hourglass or zero-energy modes), 0 to 1. Linear velocity fields feel nothing of
    /// it where `velocity_gradient` is `corrected`.
    #[serde(default)]
    pub hourglass_viscosity: f64,
    /// Shifting of particles towards even spacing, in smoothing lengths per length moved; at least 0. Velocity,
    /// density and stress are carried along to first order, density and stress with their gradients within the body.
    #[serde(default)]
    pub shifting: f64,
    /// The configuration that the sums are taken over.
    #[serde(default)]
    pub formulation: Formulation,
    /// Confining pressure of a flexible membrane; none when absent.
    #[serde(default)]
    pub confining: Option<Confining>,
    /// Names of bodies that keep their initial field of velocity for good, times the factor that `held_history` gives; their
    /// stress follows their law.
    #[serde(default)]
    pub held: Vec<String>,
    /// Factors on the velocities of bodies that are `held`, over the time of the run, by the name of the body; those that
    /// are not named keep theirs.
    #[serde(default)]
    pub held_history: BTreeMap<String, History>,
    /// Names of bodies that are `held` along which the others slip freely. To each particle beside it such a body answers
    /// with the particle's own stress and velocity, mirrored in the plane across the direction in which the particle sees
    /// it: it pushes and holds along that direction only. It feels nothing itself, and keeps its stress.
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
    pub wall_history: BTreeMap<String, History>,
    /// What rough walls answer with.
    #[serde(default)]
    pub wall_stress: WallStress,
    /// What they oppose to the velocity of a particle, where they answer pairwise.
    #[serde(default)]
    pub wall_velocity: WallVelocity,
    /// What rough walls are made of.
    #[serde(default)]
    pub rough_wall: RoughWall,
    /// What smooth walls are made of.
    #[serde(default)]
    pub smooth_wall: SmoothWall,
    /// Repulsion of particles closer than half a spacing to a particle of a wall, as a share of the square of the
    /// speed of sound: keeps hard impacts from passing a wall. 0 for none.
    #[serde(default)]
    pub wall_guard: f64,
    /// Ratio of horizontal to vertical stress by which `extrapolated` walls carry weight on.
    #[serde(default = "half")]
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
    #[serde(default = "one")]
    pub ranks: u32,
}

impl SphOptions {
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
        for (name, value) in [
            ("viscosity_linear", self.viscosity_linear),
            ("viscosity_quadratic", self.viscosity_quadratic),
            ("damping", self.damping),
            ("wall_k0", self.wall_k0),
            ("stress_diffusion_k0", self.stress_diffusion_k0),
            ("shifting", self.shifting),
            ("wall_guard", self.wall_guard),
        ] {
            rule(name, value, at_least_zero(value), "must be finite and not negative")?;
        }
        for (name, value, most) in [
            ("stress_diffusion", self.stress_diffusion, 0.5),
            ("density_diffusion", self.density_diffusion, 0.5),
            ("xsph", self.xsph, 1.0),
            ("hourglass_viscosity", self.hourglass_viscosity, 1.0),
        ] {
            rule(name, value, (0.0..=most).contains(&value), &format!("is not in 0..={most}"))?;
        }
        let growth = self.smoothing_growth;
        rule("smoothing_growth", growth, (1.0..=3.0).contains(&growth), "is not in 1..=3")?;
        self.check_lengths()?;
        if let Tensile::ArtificialStress { strength, exponent }
        | Tensile::ArtificialPressure { strength, exponent } = self.tensile
        {
            rule("tensile.strength", strength, (0.0..=1.0).contains(&strength), "is not in 0..=1")?;
            rule("tensile.exponent", exponent, positive(exponent), "must be finite and positive")?;
        }
        if let Some(Confining { pressure, ramp, .. }) = self.confining {
            rule(
                "confining.pressure",
                pressure,
                at_least_zero(pressure),
                "must be finite and not negative (Pa)",
            )?;
            rule("confining.ramp", ramp, at_least_zero(ramp), "must be finite and not negative (s)")?;
            let ratio = self.smoothing;
            rule(
                "smoothing",
                ratio,
                (1.0..=1.5).contains(&ratio),
                "is not in 1..=1.5, for which confining finds surfaces",
            )?;
        }
        for (name, steps, off) in [
            ("regularisation_steps", self.regularisation_steps, "regularisation"),
            ("density_reset_steps", self.density_reset_steps, "density_reset"),
        ] {
            rule(name, steps as f64, steps > 0, &format!("must be at least 1; {off}: none turns it off"))?;
        }
        let ranks = self.ranks;
        rule("ranks", f64::from(ranks), (1..=1024).contains(&ranks), "is not in 1..=1024")?;
        let courant = self.courant;
        rule("courant", courant, courant > 0.0 && courant <= 1.0, "is not in 0..=1 (0 excluded)")?;
        if let Some(step) = self.time_step {
            rule("time_step", step, positive(step), "must be finite and positive (s)")?;
        }
        Ok(())
    }

    /// Whether particles have smoothing lengths of their own.
    pub fn is_variable(&self) -> bool {
        self.smoothing_length != SmoothingLength::Constant
    }

    /// How much closer shifting may bring two particles (m).
    pub(crate) fn room_to_shift(&self) -> f64 {
        if self.shifting > 0.0 { 2.0 * LONGEST_SHIFT * self.spacing } else { 0.0 }
    }

    /// The operator of the velocity gradient, `compatible` resolved.
    #[inline]
    pub(crate) fn gradient_operator(&self) -> VelocityGradient {
        match (self.velocity_gradient, self.momentum) {
            (VelocityGradient::Compatible, Momentum::Rho2) => VelocityGradient::DensityDifference,
            (VelocityGradient::Compatible, Momentum::Corrected) => VelocityGradient::Corrected,
            (VelocityGradient::Compatible, _) => VelocityGradient::Difference,
            (operator, _) => operator,
        }
    }

    /// Whether density follows the continuity equation in its form for masses (BN 50).
    pub(crate) fn weighs_masses(&self) -> bool {
        match self.continuity {
            Continuity::Trace => self.gradient_operator() == VelocityGradient::DensityDifference,
            form => form == Continuity::Mass,
        }
    }

    /// Whether some gradient is corrected.
    pub(crate) fn has_corrected_gradients(&self) -> bool {
        self.momentum == Momentum::Corrected || self.velocity_gradient == VelocityGradient::Corrected
    }

    /// Whether something is averaged by moving least squares.
    pub(crate) fn has_linear_averages(&self) -> bool {
        self.regularisation == Regularisation::Mls || self.density_reset == DensityReset::Mls
    }

    /// Choices that do not go together.
    fn check_lengths(&self) -> Result<(), (&'static str, String)> {
        let grad_h = self.symmetrisation == Symmetrisation::GradH;
        if self.is_variable() && self.confining.is_some() {
            return Err(("smoothing_length", "must be constant where a pressure confines".to_owned()));
        }
        if self.is_variable() && self.continuity == Continuity::Summation {
            return Err(("continuity", "summation needs a constant smoothing length".to_owned()));
        }
        if grad_h && self.smoothing_length != SmoothingLength::Density {
            return Err(("symmetrisation", "grad-h needs smoothing_length density".to_owned()));
        }
        if grad_h && self.momentum != Momentum::Rho2 {
            return Err(("momentum", "must be rho2 with grad-h, its adjoint".to_owned()));
        }
        if grad_h && !matches!(self.continuity, Continuity::Trace | Continuity::Mass) {
            return Err(("continuity", "must be trace or mass with grad-h".to_owned()));
        }
        if self.continuity == Continuity::Summation && self.wall_stress != WallStress::Pairwise {
            return Err(("wall_stress", "must be pairwise where density is summed".to_owned()));
        }
        if self.is_variable() && self.wall_stress != WallStress::Pairwise {
            return Err(("wall_stress", "must be pairwise where the smoothing length varies".to_owned()));
        }
        let corrects = self.momentum == Momentum::Corrected;
        let fits =
            matches!(self.velocity_gradient, VelocityGradient::Compatible | VelocityGradient::Corrected);
        if corrects && !fits {
            return Err(("velocity_gradient", "must be corrected where momentum is".to_owned()));
        }
        if corrects && self.wall_stress != WallStress::Pairwise {
            return Err(("wall_stress", "must be pairwise where momentum is corrected".to_owned()));
        }
        let stages = self.integration != TimeIntegration::Leapfrog;
        if stages && self.ranks > 1 {
            return Err(("integration", "must be leapfrog with more than one of ranks".to_owned()));
        }
        if self.formulation == Formulation::TotalLagrangian && self.ranks > 1 {
            return Err(("formulation", "must be updated with more than one of ranks".to_owned()));
        }
        if stages && self.smoothing_length == SmoothingLength::Rate {
            return Err(("smoothing_length", "rate goes with the leapfrog only".to_owned()));
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
        let few = matches!(self.kernel, Kernel::WendlandC2 | Kernel::WendlandC4 | Kernel::WendlandC6)
            && ratio < 1.2;
        warn("smoothing", few, "Wendland kernels need at least 1.2");
        warn("viscosity_linear", self.viscosity_linear > 2.0, "more than 2 shortens run-outs");
        warn("courant", self.courant > 0.4, "more than 0.4 may be unstable near walls and surfaces");
        warn("momentum", self.momentum == Momentum::Difference, "this form does not conserve momentum");
        let unlike = self.confining.is_some() && self.momentum != Momentum::RhoRho;
        let text = "only rho-rho balances a confining pressure: others leave forces where densities or gradients vary";
        warn("momentum", unlike, text);
        let smooths = self.regularisation != Regularisation::None;
        let renews = self.density_reset != DensityReset::None;
        let extrapolates = self.wall_stress == WallStress::Extrapolated;
        let diffuses = self.stress_diffusion > 0.0;
        for (name, is_set, has_effect, what) in [
            ("regularisation_steps", self.regularisation_steps != ten(), smooths, "regularisation"),
            ("density_reset_steps", self.density_reset_steps != thirty(), renews, "density_reset"),
            ("stress_diffusion_k0", self.stress_diffusion_k0 != half(), diffuses, "stress_diffusion"),
            ("wall_k0", self.wall_k0 != half(), extrapolates, "wall_stress extrapolated"),
            (
                "symmetrisation",
                !matches!(self.symmetrisation, Symmetrisation::Arithmetic | Symmetrisation::GradH),
                self.is_variable(),
                "a smoothing_length that varies",
            ),
            (
                "smoothing_growth",
                self.smoothing_growth != growth(),
                self.is_variable(),
                "a smoothing_length that varies",
            ),
        ] {
            warn(name, is_set && !has_effect, &format!("has no effect without {what}"));
        }
        let pair =
            self.velocity_gradient != VelocityGradient::Corrected || self.momentum == Momentum::Corrected;
        let viscous = self.viscosity_linear + self.viscosity_quadratic + self.hourglass_viscosity > 0.0;
        warn(
            "velocity_gradient",
            !pair && !viscous,
            "corrected makes energy without viscosity: set momentum to corrected",
        );
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
fn one() -> u32 {
    1
}
fn ten() -> u64 {
    10
}
fn thirty() -> u64 {
    30
}
/// Sheet §6.19.
fn growth() -> f64 {
    1.5
}
fn half() -> f64 {
    0.5
}
/// Sheet §3.4.
fn courant() -> f64 {
    0.25
}
