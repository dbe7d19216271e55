//! Exponential softening of cohesion and friction, common to the frictional laws.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::MaterialError;
use crate::contract::parameter_checks::{check, not_negative};

/// Exponential softening with plastic strain (Bui & Nguyen eqs. 76–77).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Softening {
    /// Residual friction angle (degrees), at most the peak.
    pub residual_friction_angle: f64,
    /// Residual cohesion (Pa), at most the peak.
    pub residual_cohesion: f64,
    /// Decay rate of friction.
    pub friction_rate: f64,
    /// Decay rate of cohesion.
    pub cohesion_rate: f64,
    /// Whether residual values may exceed the peak.
    #[serde(default)]
    pub hardening: bool,
}

impl Softening {
    /// Softening of the cohesion to a residual one (Pa), with an unchanged friction angle.
    pub const fn of_cohesion(residual_cohesion: f64, cohesion_rate: f64) -> Self {
        Self {
            residual_friction_angle: 0.0,
            residual_cohesion,
            friction_rate: 0.0,
            cohesion_rate,
            hardening: false,
        }
    }

    /// Softening of the samples of the models.
    pub(in crate::laws) const EXAMPLE: Self = Self {
        residual_friction_angle: 20.0,
        residual_cohesion: 2e3,
        friction_rate: 3.0,
        cohesion_rate: 5.0,
        hardening: false,
    };

    /// Friction angle (rad) and cohesion (Pa) at the plastic strain `kappa`, from their values at the peak.
    pub(in crate::laws) fn strength(&self, (friction, cohesion): (f64, f64), kappa: f64) -> (f64, f64) {
        let residual = self.residual_friction_angle.to_radians();
        (
            residual + (friction - residual) * (-self.friction_rate * kappa).exp(),
            self.residual_cohesion
                + (cohesion - self.residual_cohesion) * (-self.cohesion_rate * kappa).exp(),
        )
    }

    /// Whether the friction angle keeps its `peak` (rad).
    #[inline]
    pub(in crate::laws) fn keeps_friction(&self, peak: f64) -> bool {
        self.friction_rate == 0.0 || self.residual_friction_angle.to_radians() == peak
    }

    /// Cohesion (Pa) at the plastic strain `kappa`, as in [`Self::strength`].
    #[inline]
    pub(in crate::laws) fn cohesion(&self, peak: f64, kappa: f64) -> f64 {
        self.residual_cohesion + (peak - self.residual_cohesion) * (-self.cohesion_rate * kappa).exp()
    }

    /// Derivatives of [`Self::strength`] with respect to plastic strain.
    pub(in crate::laws) fn rate(&self, (friction, cohesion): (f64, f64), kappa: f64) -> (f64, f64) {
        let residual = self.residual_friction_angle.to_radians();
        (
            -self.friction_rate * (friction - residual) * (-self.friction_rate * kappa).exp(),
            -self.cohesion_rate * (cohesion - self.residual_cohesion) * (-self.cohesion_rate * kappa).exp(),
        )
    }

    /// Softening of a soil with peak and residual cohesion multiplied by `share`.
    pub(in crate::laws) fn scaled_cohesion(self, share: f64) -> Self {
        Self { residual_cohesion: self.residual_cohesion * share, ..self }
    }

    /// Step in plastic strain for differences of a strength with decaying softening and dilatancy.
    pub(in crate::laws) fn difference_step(softening: Option<Self>, dilatancy_decay: f64) -> f64 {
        let fastest = softening.map_or(0.0, |s| s.friction_rate.max(s.cohesion_rate));
        1e-5 / fastest.max(dilatancy_decay).max(1e-3)
    }

    /// Checks the ranges of the strength of a frictional law and of its decay (angles in degrees), sheet: constitutive §7.
    pub(in crate::laws) fn check(
        softening: Option<Self>,
        friction_angle: f64,
        cohesion: f64,
        dilatancy_decay: f64,
    ) -> Result<(), MaterialError> {
        not_negative("cohesion", cohesion, "Pa")?;
        let strong = friction_angle > 0.0 || cohesion > 0.0;
        check("cohesion", cohesion, strong, "must be positive when the friction angle is 0")?;
        not_negative("dilatancy_decay", dilatancy_decay, "")?;
        softening.map_or(Ok(()), |s| s.validate(friction_angle, cohesion))
    }

    /// Checks residual strength and softening rates against the peak friction angle (degrees) and cohesion (Pa).
    fn validate(&self, friction_angle: f64, cohesion: f64) -> Result<(), MaterialError> {
        let residual = self.residual_friction_angle;
        let (holds, rule) = if self.hardening {
            ((0.0..90.0).contains(&residual), "is not in 0..90 degrees (90 excluded)".to_owned())
        } else {
            let rule = format!("is not between 0 and the peak, {friction_angle} degrees");
            ((0.0..=friction_angle).contains(&residual), rule)
        };
        check("softening.residual_friction_angle", residual, holds, &rule)?;
        let residual = self.residual_cohesion;
        if self.hardening {
            not_negative("softening.residual_cohesion", residual, "Pa")?;
        } else {
            let rule = format!("is not between 0 and the peak, {cohesion} Pa");
            check("softening.residual_cohesion", residual, (0.0..=cohesion).contains(&residual), &rule)?;
        }
        for (name, rate) in
            [("softening.friction_rate", self.friction_rate), ("softening.cohesion_rate", self.cohesion_rate)]
        {
            check(name, rate, rate.is_finite() && rate >= 0.0, "must not be negative")?;
        }
        Ok(())
    }
}
