//! Loads on the surface of bodies (MPM sheet §2.11).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::description::{Side, Stage};

/// A load.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Load {
    /// A traction (Pa) on one side of a body, carried by its outermost points, unchanged in direction. On a body
    /// with a pore fluid it is the total one, of skeleton and fluid.
    Traction {
        /// Body it acts on, not a rigid one.
        body: String,
        /// Side of the body's bounding box it acts on.
        side: Side,
        /// Traction vector (Pa).
        value: Vec<f64>,
        /// Time over which it grows from zero (s).
        #[serde(default)]
        ramp: f64,
        /// How it grows.
        #[serde(default, skip_serializing_if = "RampShape::is_linear")]
        ramp_shape: RampShape,
        /// Name of the stage with which it begins; the first when absent. It goes on in the stages after, and the points
        /// that carry it are those that are outermost at the start of the case.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        stage: Option<String>,
    },
    /// A pressure (Pa) on one side of a body, carried by its outermost points: it follows the surface, stays normal to
    /// it and grows with its area. On a body with a pore fluid it is the total one.
    Pressure {
        /// Body it acts on, not a rigid one.
        body: String,
        /// Side of the body's bounding box it acts on.
        side: Side,
        /// Pressure (Pa), positive towards the body.
        value: f64,
        /// Time over which it grows from zero (s).
        #[serde(default)]
        ramp: f64,
        /// How it grows.
        #[serde(default, skip_serializing_if = "RampShape::is_linear")]
        ramp_shape: RampShape,
        /// Name of the stage with which it begins; the first when absent. It goes on in the stages after, and the points
        /// that carry it are those that are outermost at the start of the case.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        stage: Option<String>,
    },
    /// A pressure of the pore fluid (Pa) on one side of a saturated body, as next to open water. It acts on the
    /// fluid alone; what presses on skeleton and fluid together is a `traction` or a `pressure` beside it. A side
    /// without it has none.
    PorePressure {
        /// Body it acts on, not a rigid one.
        body: String,
        /// Side of the body's bounding box it acts on.
        side: Side,
        /// Pressure (Pa), compression-positive.
        value: f64,
        /// Time over which it grows from zero (s).
        #[serde(default)]
        ramp: f64,
        /// How it grows.
        #[serde(default, skip_serializing_if = "RampShape::is_linear")]
        ramp_shape: RampShape,
        /// Name of the stage with which it begins; the first when absent. It goes on in the stages after, and the points
        /// that carry it are those that are outermost at the start of the case.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        stage: Option<String>,
    },
}

impl Load {
    /// The body it acts on.
    pub fn body(&self) -> &str {
        match self {
            Self::Traction { body, .. } | Self::Pressure { body, .. } | Self::PorePressure { body, .. } => {
                body
            }
        }
    }

    /// The side of the body it acts on.
    pub fn side(&self) -> Side {
        match self {
            Self::Traction { side, .. } | Self::Pressure { side, .. } | Self::PorePressure { side, .. } => {
                *side
            }
        }
    }

    /// Name of the stage with which it begins; `None` for the first.
    pub fn stage(&self) -> Option<&str> {
        match self {
            Self::Traction { stage, .. }
            | Self::Pressure { stage, .. }
            | Self::PorePressure { stage, .. } => stage.as_deref(),
        }
    }

    /// Number of the stage with which it begins; `None` where no stage has its name.
    pub(crate) fn begins(&self, stages: &[Stage]) -> Option<usize> {
        self.stage().map_or(Some(0), |name| stages.iter().position(|stage| stage.name == name))
    }

    /// Share of the load that acts `elapsed` seconds after it began; none before, where that is negative.
    pub fn factor(&self, elapsed: f64) -> f64 {
        let (ramp, shape) = self.ramp();
        if elapsed < 0.0 { 0.0 } else { shape.factor(elapsed, ramp) }
    }

    /// Time over which it grows (s), and how.
    pub fn ramp(&self) -> (f64, RampShape) {
        match self {
            Self::Traction { ramp, ramp_shape, .. }
            | Self::Pressure { ramp, ramp_shape, .. }
            | Self::PorePressure { ramp, ramp_shape, .. } => (*ramp, *ramp_shape),
        }
    }
}

/// How a load grows over its ramp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RampShape {
    /// In proportion to time.
    #[default]
    Linear,
    /// As half a wave of a cosine, without a kink at either end.
    Cosine,
}

impl RampShape {
    fn is_linear(&self) -> bool {
        *self == Self::Linear
    }

    /// Share of the load at `time` of a ramp of length `ramp` (s).
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
