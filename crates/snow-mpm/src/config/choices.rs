//! Values of the options.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Shape functions (sheet: snow-mpm §3.2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SplineShape {
    /// Cubic B-splines: 4 nodes an axis.
    #[default]
    Cubic,
    /// Quadratic B-splines: 3 nodes an axis.
    Quadratic,
    /// Hat functions, to compare with only: points that cross cells make noise, which grows as the grid is refined.
    Linear,
}

/// How velocities pass from the grid to the points and back (sheet: snow-mpm §3.5, §3.6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SnowTransfer {
    /// Affine particle-in-cell: points carry the affine velocity field around them. Keeps linear and angular momentum to
    /// round-off and dissipates little, whatever the step.
    #[default]
    Apic,
    /// A blend of FLIP and PIC, by `flip_ratio` or `blend_time`.
    Flip,
}

/// How the deformation `f` of a step follows from the velocity gradient `L`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DeformationUpdate {
    /// `f = 1 + Δt L`. A constant spin strains a point by about `2π² / N` in `N` steps a turn.
    #[default]
    Linear,
    /// `f = exp(Δt L)`, to the fourth order: a spin strains nothing.
    Exponential,
}
