//! Enumerated options of `methods.snow-mpm`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Shape functions (sheet: snow-mpm §3.2).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SplineShape {
    /// Cubic B-splines, 4 nodes per axis.
    #[default]
    Cubic,
    /// Quadratic B-splines, 3 nodes per axis.
    Quadratic,
    /// Linear (hat) functions, for comparison only: noise of points that cross cells grows as the grid is refined.
    Linear,
}

/// Transfer of velocities between points and grid (sheet: snow-mpm §3.5, §3.6).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SnowTransfer {
    /// Affine particle-in-cell (APIC): points store the affine velocity field around them. Conserves momenta to round-off and dissipates
    /// little at any step.
    #[default]
    Apic,
    /// Blend of FLIP and PIC, by `flip_ratio` or `blend_time`.
    Flip,
}

/// Deformation `f` of a step from the velocity gradient `L`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DeformationUpdate {
    /// First order: `f = 1 + Δt L`. A constant spin strains a point by about `2π² / N` per revolution of `N` steps.
    #[default]
    Linear,
    /// Exponential: `f = exp(Δt L)`, to the fourth order. A spin causes no strain.
    Exponential,
}
