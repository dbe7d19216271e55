//! Shapes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A region of space. In two dimensions the third coordinate is not looked at.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Shape {
    /// Axis-aligned box (interval in 1D, rectangle in 2D).
    Box {
        /// Lower corner (m).
        min: Vec<f64>,
        /// Upper corner (m).
        max: Vec<f64>,
    },
    /// Ball (disk in 2D).
    Ball {
        /// Centre (m).
        centre: Vec<f64>,
        /// Radius (m).
        radius: f64,
    },
}
