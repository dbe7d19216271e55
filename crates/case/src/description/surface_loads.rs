//! Loads on the surface of bodies (sheet: mpm §2.11).

use colluvium_points::Shape;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::description::{Axis, Side, Stage};
use crate::files::piecewise_linear;

/// Load on a body, also in later stages, carried by its outermost points at the start of the case. All but `pore-pressure` are total, of
/// skeleton and pore fluid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Load {
    /// Traction (Pa) on a side of a body, constant in direction.
    Traction {
        /// Loaded body, not rigid.
        body: String,
        /// Loaded side of the body's bounding box.
        side: Side,
        /// Traction vector (Pa).
        value: Vec<f64>,
        /// Time of growth from zero (s).
        #[serde(default)]
        ramp: f64,
        /// Ramp shape.
        #[serde(default, skip_serializing_if = "RampShape::is_linear")]
        ramp_shape: RampShape,
        /// Stage of its start; the first when absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        stage: Option<String>,
        /// Variation along the side; uniform when absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        profile: Option<LoadProfile>,
        /// Load carrier.
        #[serde(default, skip_serializing_if = "LoadTarget::is_points")]
        applied_to: LoadTarget,
    },
    /// Pressure (Pa) on a side of a body, by its outermost points: stays normal to the surface and grows with its area.
    Pressure {
        /// Loaded body, not rigid.
        body: String,
        /// Loaded side of the body's bounding box.
        side: Side,
        /// Pressure (Pa), positive towards the body.
        value: f64,
        /// Time of growth from zero (s).
        #[serde(default)]
        ramp: f64,
        /// Ramp shape.
        #[serde(default, skip_serializing_if = "RampShape::is_linear")]
        ramp_shape: RampShape,
        /// Stage of its start; the first when absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        stage: Option<String>,
        /// Variation along the side; uniform when absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        profile: Option<LoadProfile>,
    },
    /// Pressure of the pore fluid (Pa) on a side of a saturated body, as of open water; zero without this load. Pressure on skeleton and
    /// fluid is a further `traction` or `pressure`.
    PorePressure {
        /// Loaded body, not rigid.
        body: String,
        /// Loaded side of the body's bounding box.
        side: Side,
        /// Pressure (Pa), compression-positive.
        value: f64,
        /// Time of growth from zero (s).
        #[serde(default)]
        ramp: f64,
        /// Ramp shape.
        #[serde(default, skip_serializing_if = "RampShape::is_linear")]
        ramp_shape: RampShape,
        /// Stage of its start; the first when absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        stage: Option<String>,
        /// Variation along the side; uniform when absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        profile: Option<LoadProfile>,
        /// Load carrier.
        #[serde(default, skip_serializing_if = "LoadTarget::is_points")]
        applied_to: LoadTarget,
    },
    /// Pressure and shear (Pa) on all or part of a body's surface, by points next to it. Both turn and grow with the surface.
    Surface {
        /// Loaded body, not rigid.
        body: String,
        /// Region of the loaded surface at the start, with holes; all when absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        within: Option<Shape>,
        /// Pressure (Pa), positive towards the body.
        #[serde(default)]
        pressure: f64,
        /// Shear (Pa), not in 1D. In the plane and axisymmetry it is positive counter-clockwise, with the body to its left. In space it is
        /// along `axis` × outward normal, times the sine of their angle.
        #[serde(default)]
        shear: f64,
        /// Axis of shear in space, of any length: a shaft's for torsion.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        axis: Option<[f64; 3]>,
        /// Time of growth from zero (s).
        #[serde(default)]
        ramp: f64,
        /// Ramp shape.
        #[serde(default, skip_serializing_if = "RampShape::is_linear")]
        ramp_shape: RampShape,
        /// Stage of its start; the first when absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        stage: Option<String>,
    },
}

impl Load {
    /// Traction (Pa) on a side of a body from the first stage on, carried by points.
    #[must_use]
    pub fn traction(body: impl Into<String>, side: Side, value: impl Into<Vec<f64>>) -> Self {
        Self::Traction {
            body: body.into(),
            side,
            value: value.into(),
            ramp: 0.0,
            ramp_shape: RampShape::default(),
            stage: None,
            profile: None,
            applied_to: LoadTarget::default(),
        }
    }

    /// Pressure (Pa, positive towards the body) on a side of a body from the first stage on.
    #[must_use]
    pub fn pressure(body: impl Into<String>, side: Side, value: f64) -> Self {
        let (ramp, ramp_shape) = (0.0, RampShape::default());
        Self::Pressure { body: body.into(), side, value, ramp, ramp_shape, stage: None, profile: None }
    }

    /// Pore pressure (Pa, compression-positive) on a side of a saturated body from the first stage on.
    #[must_use]
    pub fn pore_pressure(body: impl Into<String>, side: Side, value: f64) -> Self {
        Self::PorePressure {
            body: body.into(),
            side,
            value,
            ramp: 0.0,
            ramp_shape: RampShape::default(),
            stage: None,
            profile: None,
            applied_to: LoadTarget::default(),
        }
    }

    /// Pressure (Pa, positive towards the body) on the whole surface of a body from the first stage on.
    #[must_use]
    pub fn surface_pressure(body: impl Into<String>, pressure: f64) -> Self {
        Self::Surface {
            body: body.into(),
            within: None,
            pressure,
            shear: 0.0,
            axis: None,
            ramp: 0.0,
            ramp_shape: RampShape::default(),
            stage: None,
        }
    }

    /// Sets the time over which the load grows from zero (s).
    #[must_use]
    pub fn ramped(mut self, time: f64) -> Self {
        match &mut self {
            Self::Traction { ramp, .. }
            | Self::Pressure { ramp, .. }
            | Self::PorePressure { ramp, .. }
            | Self::Surface { ramp, .. } => *ramp = time,
        }
        self
    }

    /// Sets the stage in which the load begins.
    #[must_use]
    pub fn from_stage(mut self, name: impl Into<String>) -> Self {
        match &mut self {
            Self::Traction { stage, .. }
            | Self::Pressure { stage, .. }
            | Self::PorePressure { stage, .. }
            | Self::Surface { stage, .. } => *stage = Some(name.into()),
        }
        self
    }

    /// Name of the loaded body.
    pub fn body(&self) -> &str {
        match self {
            Self::Traction { body, .. }
            | Self::Pressure { body, .. }
            | Self::PorePressure { body, .. }
            | Self::Surface { body, .. } => body,
        }
    }

    /// Loaded side of the body; `None` for a load that is not bound to a side.
    pub fn loaded_side(&self) -> Option<Side> {
        match self {
            Self::Traction { side, .. } | Self::Pressure { side, .. } | Self::PorePressure { side, .. } => {
                Some(*side)
            }
            Self::Surface { .. } => None,
        }
    }

    /// Name of the stage with which the load begins; `None` for the first.
    pub fn stage(&self) -> Option<&str> {
        match self {
            Self::Traction { stage, .. }
            | Self::Pressure { stage, .. }
            | Self::PorePressure { stage, .. }
            | Self::Surface { stage, .. } => stage.as_deref(),
        }
    }

    /// Profile along its side; `None` for a uniform load.
    pub fn profile(&self) -> Option<&LoadProfile> {
        match self {
            Self::Traction { profile, .. }
            | Self::Pressure { profile, .. }
            | Self::PorePressure { profile, .. } => profile.as_ref(),
            Self::Surface { .. } => None,
        }
    }

    /// Whether it acts on the pore fluid alone.
    pub fn is_of_fluid(&self) -> bool {
        matches!(self, Self::PorePressure { .. })
    }

    /// Whether it is a follower load, which rotates with the surface and grows with its area.
    pub fn is_follower(&self) -> bool {
        !matches!(self, Self::Traction { .. })
    }

    /// Carrier of the load: points for a load that follows the surface.
    pub fn applied_to(&self) -> LoadTarget {
        match self {
            Self::Traction { applied_to: carrier, .. } | Self::PorePressure { applied_to: carrier, .. } => {
                *carrier
            }
            Self::Pressure { .. } | Self::Surface { .. } => LoadTarget::Points,
        }
    }

    /// Share of the load at a position (m) on its side.
    pub fn profile_factor(&self, place: &[f64]) -> f64 {
        self.profile().map_or(1.0, |profile| profile.factor_at(place))
    }

    /// Number of the stage with which it begins; `None` where no stage has that name.
    pub(crate) fn first_stage(&self, stages: &[Stage]) -> Option<usize> {
        self.stage().map_or(Some(0), |name| stages.iter().position(|stage| stage.name == name))
    }

    /// Share of the load at `elapsed` seconds after its start; zero for negative values.
    pub fn factor(&self, elapsed: f64) -> f64 {
        let (ramp, shape) = self.ramp();
        if elapsed < 0.0 { 0.0 } else { shape.factor(elapsed, ramp) }
    }

    /// Duration of its ramp (s), and the shape of the ramp.
    pub fn ramp(&self) -> (f64, RampShape) {
        match self {
            Self::Traction { ramp, ramp_shape, .. }
            | Self::Pressure { ramp, ramp_shape, .. }
            | Self::PorePressure { ramp, ramp_shape, .. }
            | Self::Surface { ramp, ramp_shape, .. } => (*ramp, *ramp_shape),
        }
    }
}

/// Variation along the side of a load: `[[0, 1], [10, 0]]` along y is water up to y = 10 m, with the `value` at y = 0. Parts keep their
/// size as they move with the body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LoadProfile {
    /// Axis of variation, not normal to the side.
    pub axis: Axis,
    /// Coordinates (m), ascending, and shares of the `value` at the start, of either sign; linear between, constant beyond. Two entries at
    /// one coordinate make a jump.
    pub shares: Vec<[f64; 2]>,
}

impl LoadProfile {
    /// Share of the load at a position (m). At a jump of the profile it is the value above.
    fn factor_at(&self, place: &[f64]) -> f64 {
        let Some(&x) = place.get(self.axis.number()) else { return 1.0 };
        piecewise_linear::value_at(&self.shares, |[at, _]| *at, |number| self.shares[number][1], x)
            .unwrap_or(1.0)
    }
}

/// Carrier of a load (sheet: mpm §2.11).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LoadTarget {
    /// Outermost points, which move the load; it is smeared over the cells next to the side.
    #[default]
    Points,
    /// Nodes on the side, as in finite elements, exact up to it; for methods with a grid. The side must stay on a grid line (mesh: facets):
    /// nodes that the body leaves have no load.
    Nodes,
}

impl LoadTarget {
    /// Whether the load acts on material points, its default.
    fn is_points(&self) -> bool {
        *self == Self::Points
    }
}

/// Growth over the ramp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RampShape {
    /// Linear in time.
    #[default]
    Linear,
    /// Half a cosine wave, without kinks.
    Cosine,
}

impl RampShape {
    /// Whether the ramp is linear, its default.
    fn is_linear(&self) -> bool {
        *self == Self::Linear
    }

    /// Share of the load at `time` of a ramp of duration `ramp` (s).
    pub fn factor(self, time: f64, ramp: f64) -> f64 {
        if time >= ramp {
            return 1.0;
        }
        match self {
            Self::Linear => time / ramp,
            Self::Cosine => 0.5 * (1.0 - (std::f64::consts::PI * time / ramp).cos()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn load_factors_are_interpolated_linearly() {
        let strip = LoadProfile {
            axis: Axis::Y,
            shares: vec![[1.0, 0.0], [1.0, 2.0], [3.0, 1.0], [5.0, 0.0], [6.0, -4.0]],
        };
        for (y, share) in [
            (0.0, 0.0),
            (0.999, 0.0),
            (1.0, 2.0),
            (2.0, 1.5),
            (4.5, 0.25),
            (5.5, -2.0),
            (6.0, -4.0),
            (9.0, -4.0),
        ] {
            assert_eq!(strip.factor_at(&[7.0, y]), share, "at {y}");
        }
    }
}
