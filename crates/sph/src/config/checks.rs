//! Checks of the options (sheet: sph §7), and warnings.

use colluvium_case::CaseErrorKind;

use super::{
    ConfiningPressure, ContinuityEquation, DensityReset, Kernel, LagrangianFormulation, MomentumEquation,
    Regularisation, ShiftingSpeed, SmoothingLength, SphOptions, Symmetrisation, Tensile, TimeIntegration,
    VelocityGradientOperator, WallStress, default_regularisation_steps, default_reset_steps, default_wall_k0,
    growth,
};
use colluvium_case::Warning;

/// Option out of range: its name and the problem.
type OptionError = (&'static str, CaseErrorKind);

/// Checks a value against a rule.
fn check_rule(name: &'static str, value: f64, holds: bool, rule: &str) -> Result<(), OptionError> {
    if holds { Ok(()) } else { Err((name, CaseErrorKind::out_of_range(value, rule))) }
}

/// Whether a number is finite and positive.
fn is_positive(value: f64) -> bool {
    value.is_finite() && value > 0.0
}

/// Whether a number is finite and zero or positive.
fn is_not_negative(value: f64) -> bool {
    value.is_finite() && value >= 0.0
}

/// Warnings about options.
#[derive(Default)]
struct OptionWarnings(Vec<Warning>);

impl OptionWarnings {
    /// Adds a warning about an option if its condition is true.
    fn add(&mut self, holds: bool, warning: Warning) {
        if holds {
            self.0.push(warning.at("methods.sph"));
        }
    }
}

impl SphOptions {
    /// Checks the ranges of the options (sheet: sph §7). The error names the option and the rule.
    ///
    /// # Errors
    /// The first option out of range, as (name, problem).
    pub fn validate(&self) -> Result<(), (&'static str, CaseErrorKind)> {
        self.check_spacing()?;
        self.check_ranges()?;
        self.check_lengths()?;
        self.check_artificial_stress()?;
        self.check_confining()?;
        self.check_steps()
    }

    /// Checks spacing and smoothing length.
    fn check_spacing(&self) -> Result<(), OptionError> {
        check_rule("spacing", self.spacing, is_positive(self.spacing), "must be finite and positive (m)")?;
        let ratio = self.smoothing;
        check_rule("smoothing", ratio, (0.9..=3.0).contains(&ratio), "is not in 0.9..=3")?;
        let largest = self.clumping_from().unwrap_or(f64::INFINITY);
        if ratio > largest && !self.allow_pairing {
            let problem = format!(
                "{ratio} makes particles clump with this kernel: use at most {largest}, or set allow_pairing"
            );
            return Err(("smoothing", problem.into()));
        }
        Ok(())
    }

    /// Checks factors of viscosity, damping, diffusion and shifting.
    fn check_ranges(&self) -> Result<(), OptionError> {
        for (name, value) in [
            ("viscosity_linear", self.viscosity_linear),
            ("viscosity_quadratic", self.viscosity_quadratic),
            ("damping", self.damping),
            ("wall_k0", self.wall_k0),
            ("stress_diffusion_k0", self.stress_diffusion_k0),
            ("shifting", self.shifting),
            ("wall_guard", self.wall_guard),
        ] {
            check_rule(name, value, is_not_negative(value), "must be finite and not negative")?;
        }
        for (name, value, largest) in [
            ("stress_diffusion", self.stress_diffusion, 0.5),
            ("density_diffusion", self.density_diffusion, 0.5),
            ("close_repulsion", self.close_repulsion, 0.2),
            ("xsph", self.xsph, 1.0),
            ("hourglass_viscosity", self.hourglass_viscosity, 1.0),
        ] {
            check_rule(name, value, (0.0..=largest).contains(&value), &format!("is not in 0..={largest}"))?;
        }
        let growth = self.smoothing_growth;
        check_rule("smoothing_growth", growth, (1.0..=3.0).contains(&growth), "is not in 1..=3")
    }

    /// Checks artificial stress and artificial pressure.
    fn check_artificial_stress(&self) -> Result<(), OptionError> {
        if let Tensile::ArtificialStress { strength, exponent }
        | Tensile::ArtificialPressure { strength, exponent } = self.tensile
        {
            check_rule("tensile.strength", strength, (0.0..=1.0).contains(&strength), "is not in 0..=1")?;
            check_rule("tensile.exponent", exponent, is_positive(exponent), "must be finite and positive")?;
        }
        Ok(())
    }

    /// Checks the confining pressure.
    fn check_confining(&self) -> Result<(), OptionError> {
        let Some(ConfiningPressure { pressure, ramp, .. }) = self.confining else { return Ok(()) };
        let text = "must be finite and not negative (Pa)";
        check_rule("confining.pressure", pressure, is_not_negative(pressure), text)?;
        check_rule("confining.ramp", ramp, is_not_negative(ramp), "must be finite and not negative (s)")?;
        let ratio = self.smoothing;
        let text = "is not in 1..=1.5, the range in which confining detects surfaces";
        check_rule("smoothing", ratio, (1.0..=1.5).contains(&ratio), text)
    }

    /// Checks numbers of steps and ranks, and the time step.
    fn check_steps(&self) -> Result<(), OptionError> {
        for (name, steps, off) in [
            ("regularisation_steps", self.regularisation_steps, "regularisation"),
            ("density_reset_steps", self.density_reset_steps, "density_reset"),
        ] {
            let text = format!("must be at least 1; to turn it off, set {off} to none");
            check_rule(name, steps as f64, steps > 0, &text)?;
        }
        let ranks = self.ranks;
        check_rule("ranks", f64::from(ranks), (1..=1024).contains(&ranks), "is not in 1..=1024")?;
        let courant = self.courant;
        check_rule("courant", courant, courant > 0.0 && courant <= 1.0, "is not in 0..=1 (0 excluded)")?;
        if let Some(step) = self.time_step {
            check_rule("time_step", step, is_positive(step), "must be finite and positive (s)")?;
        }
        Ok(())
    }

    /// Checks combinations of the smoothing options.
    fn check_lengths(&self) -> Result<(), OptionError> {
        let clash = |problem: &str| CaseErrorKind::coded("incompatible-options", problem);
        let grad_h = self.symmetrisation == Symmetrisation::GradH;
        if self.is_variable() && self.confining.is_some() {
            return Err(("smoothing_length", clash("must be constant with a confining pressure")));
        }
        if self.is_variable() && self.continuity == ContinuityEquation::Summation {
            return Err(("continuity", clash("summation needs a constant smoothing length")));
        }
        if grad_h && self.smoothing_length != SmoothingLength::Density {
            return Err(("symmetrisation", clash("grad-h needs smoothing_length density")));
        }
        if grad_h && self.momentum != MomentumEquation::Rho2 {
            return Err(("momentum", clash("must be rho2 with grad-h, which is adjoint to it")));
        }
        if grad_h && !matches!(self.continuity, ContinuityEquation::Trace | ContinuityEquation::Mass) {
            return Err(("continuity", clash("must be trace or mass with grad-h")));
        }
        if self.continuity == ContinuityEquation::Summation && self.wall_stress != WallStress::Pairwise {
            return Err(("wall_stress", clash("must be pairwise with density by summation")));
        }
        if self.is_variable() && self.wall_stress != WallStress::Pairwise {
            return Err(("wall_stress", clash("must be pairwise with a smoothing length that varies")));
        }
        let corrects = self.momentum == MomentumEquation::Corrected;
        use VelocityGradientOperator::{Compatible, Corotated, Corrected};
        let fits = matches!(self.velocity_gradient, Compatible | Corotated | Corrected);
        if corrects && !fits {
            return Err(("velocity_gradient", clash("must be corrected if momentum is corrected")));
        }
        if corrects && self.wall_stress != WallStress::Pairwise {
            return Err(("wall_stress", clash("must be pairwise if momentum is corrected")));
        }
        let stages = self.integration != TimeIntegration::Leapfrog;
        if stages && self.ranks > 1 {
            return Err(("integration", clash("must be leapfrog with more than one rank")));
        }
        let shifts = self.shifting > 0.0;
        if !shifts && self.shifting_speed != ShiftingSpeed::Own {
            return Err(("shifting_speed", clash("needs shifting above 0")));
        }
        if shifts && self.shifting_speed == ShiftingSpeed::Largest && self.ranks > 1 {
            return Err((
                "shifting_speed",
                clash("must be own with more than one rank, because a rank has its own particles only"),
            ));
        }
        if self.formulation == LagrangianFormulation::TotalLagrangian && self.ranks > 1 {
            return Err(("formulation", clash("must be updated with more than one rank")));
        }
        if stages && self.smoothing_length == SmoothingLength::Rate {
            return Err(("smoothing_length", clash("rate needs integration leapfrog")));
        }
        Ok(())
    }

    /// Ratio of smoothing length to spacing above which the kernel is known to clump.
    fn clumping_from(&self) -> Option<f64> {
        match self.kernel {
            Kernel::CubicSpline => Some(2.0),
            Kernel::Gaussian => Some(2.4),
            _ => None,
        }
    }

    /// Warnings about permitted options.
    pub fn warnings(&self) -> Vec<Warning> {
        let mut warnings = OptionWarnings::default();
        self.warn_of_instability(&mut warnings);
        self.warn_of_idle_options(&mut warnings);
        let pair = self.velocity_gradient != VelocityGradientOperator::Corrected
            || self.momentum == MomentumEquation::Corrected;
        let viscous = self.viscosity_linear + self.viscosity_quadratic + self.hourglass_viscosity > 0.0;
        let text =
            "velocity_gradient: corrected without viscosity increases the energy: set momentum to corrected";
        warnings.add(!pair && !viscous, Warning::new("energy-growing-form", text));
        warnings.0
    }

    /// Warns of clumping, instability and errors of the momentum equation.
    fn warn_of_instability(&self, warnings: &mut OptionWarnings) {
        let ratio = self.smoothing;
        let (clumps, limit) = match self.kernel {
            Kernel::CubicSpline => (ratio > 1.5, "1.5 or less"),
            Kernel::Gaussian => (ratio >= 2.0, "less than 2"),
            _ => (false, ""),
        };
        let text = format!(
            "smoothing: {ratio}: particles may clump with this kernel. Give {limit}, or use a Wendland kernel"
        );
        warnings.add(clumps, Warning::new("particle-clumping", text));
        let few = matches!(self.kernel, Kernel::WendlandC2 | Kernel::WendlandC4 | Kernel::WendlandC6)
            && ratio < 1.2;
        let text = format!("smoothing: {ratio}: Wendland kernels need at least 1.2");
        warnings.add(few, Warning::new("few-neighbours", text));
        let viscosity = self.viscosity_linear;
        let text = format!("viscosity_linear: {viscosity}: more than 2 shortens run-outs. Give 2 or less");
        warnings.add(viscosity > 2.0, Warning::new("strong-viscosity", text));
        let courant = self.courant;
        let text = format!(
            "courant: {courant}: more than 0.4 may be unstable near walls and surfaces. Give 0.4 or less"
        );
        warnings.add(courant > 0.4, Warning::new("large-courant", text));
        let difference = self.momentum == MomentumEquation::Difference;
        let text = "momentum: this form does not conserve momentum. Use rho2 or rho-rho";
        warnings.add(difference, Warning::new("momentum-not-conserved", text));
        let unlike = self.confining.is_some() && self.momentum != MomentumEquation::RhoRho;
        let text = "momentum: only rho-rho is in equilibrium with a confining pressure: other forms leave \
                    forces where densities or gradients vary";
        warnings.add(unlike, Warning::new("confining-not-balanced", text));
    }

    /// Adds warnings about options that are set without an effect.
    fn warn_of_idle_options(&self, warnings: &mut OptionWarnings) {
        let smooths = self.regularisation != Regularisation::None;
        let renews = self.density_reset != DensityReset::None;
        let extrapolates = self.wall_stress == WallStress::Extrapolated;
        let diffuses = self.stress_diffusion > 0.0;
        let symmetrised = !matches!(self.symmetrisation, Symmetrisation::Arithmetic | Symmetrisation::GradH);
        let (set_steps, set_reset) = (
            self.regularisation_steps != default_regularisation_steps(),
            self.density_reset_steps != default_reset_steps(),
        );
        let (set_diffusion_k0, set_wall_k0) =
            (self.stress_diffusion_k0 != default_wall_k0(), self.wall_k0 != default_wall_k0());
        for (name, is_set, has_effect, what) in [
            ("regularisation_steps", set_steps, smooths, "regularisation"),
            ("density_reset_steps", set_reset, renews, "density_reset"),
            ("stress_diffusion_k0", set_diffusion_k0, diffuses, "stress_diffusion"),
            ("wall_k0", set_wall_k0, extrapolates, "wall_stress extrapolated"),
            ("symmetrisation", symmetrised, self.is_variable(), "a smoothing_length that varies"),
            (
                "smoothing_growth",
                self.smoothing_growth != growth(),
                self.is_variable(),
                "a smoothing_length that varies",
            ),
        ] {
            let text = format!("{name}: has no effect without {what}. Leave it out, or give both");
            warnings.add(is_set && !has_effect, Warning::new("option-without-effect", text));
        }
    }
}
