//! Motions of rigid bodies and patches.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Prescribed velocity of a rigid body or patch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PrescribedMotion {
    /// Rigid body or patch.
    pub target: String,
    /// Velocity (m/s), one number per dimension. Null leaves a component free: patch nodes move by themselves, a rigid body by mass,
    /// weight, `force` and contact forces from its current velocity.
    pub velocity: Vec<Option<f64>>,
    /// Force on a rigid body's free components (N; per metre in plane strain, per radian in axisymmetry).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub force: Vec<f64>,
    /// Moment about the mass centre of a body that `turns` (N m; per metre in plane strain). One number in the plane, positive from x to y;
    /// three in space.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub moment: Vec<f64>,
    /// Whether a rigid body rotates under `moment` and contact forces.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    #[serde(rename = "turns")]
    pub rotates: bool,
    /// Time from the start of the stage (s) over which velocity, force and moment grow from zero.
    #[serde(default)]
    pub ramp: f64,
}

impl PrescribedMotion {
    /// Ramp factor of velocity, force and moment after `elapsed` seconds of the stage, 0 to 1.
    fn ramp_factor(&self, elapsed: f64) -> f64 {
        if self.ramp > 0.0 { (elapsed / self.ramp).clamp(0.0, 1.0) } else { 1.0 }
    }

    /// Velocity after `elapsed` seconds of the stage (m/s); `None` for a free component.
    pub fn velocity_at(&self, elapsed: f64) -> [Option<f64>; 3] {
        let factor = self.ramp_factor(elapsed);
        std::array::from_fn(|c| self.velocity.get(c).copied().flatten().map(|v| factor * v))
    }

    /// Force after `elapsed` seconds of the stage (N).
    pub fn force_at(&self, elapsed: f64) -> [f64; 3] {
        let factor = self.ramp_factor(elapsed);
        std::array::from_fn(|c| factor * self.force.get(c).copied().unwrap_or(0.0))
    }

    /// Moment about the centre of mass after `elapsed` seconds of the stage (N m); in the plane only the last component is used.
    pub fn moment_at(&self, elapsed: f64) -> [f64; 3] {
        let factor = self.ramp_factor(elapsed);
        match self.moment[..] {
            [about] => [0.0, 0.0, factor * about],
            [x, y, z] => [x, y, z].map(|c| factor * c),
            _ => [0.0; 3],
        }
    }

    /// Whether a component of the motion of a rigid body follows from forces.
    pub fn is_free(&self) -> bool {
        self.rotates || self.velocity.contains(&None)
    }
}
