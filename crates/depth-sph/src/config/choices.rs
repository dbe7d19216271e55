//! Enumerated options of `methods.depth-sph`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Number of phases with separate nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Phases {
    /// A dry material, a fluid, or a mixture that moves together.
    #[default]
    One,
    /// Grains and pore fluid, each with its own depth and velocity.
    Two,
    /// Two layers: an avalanche below water.
    Layers,
}

/// Distribution of the discharge along an inflow line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum InflowDistribution {
    /// Equal depth along the line.
    #[default]
    Even,
    /// Level surface along the line, as across a channel: deeper over lower bed, absent where the bed is above it.
    Level,
}

/// Lower or upper layer of two.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FlowLayer {
    /// Layer on the bed.
    Lower,
    /// Layer on top of the lower one.
    Upper,
}

/// Axes of the flow depth (sheet: depth-sph §2.9).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DepthFrame {
    /// Vertical depth over steep terrain: effective gravity follows slope and curvature.
    #[default]
    Horizontal,
    /// Vertical depth over gentle slopes: full gravity acts on the depth.
    SmallSlope,
    /// Axes along the bed, a plane, and depth normal to it.
    BedFitted,
}

/// Effect of depth gradients over steep terrain (sheet: depth-sph §2.9).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Metric {
    /// Blend by the surface slope: `vertical` where level, `normal` where parallel to the bed.
    #[default]
    Blended,
    /// Gradients in plan: a level surface stays level, but thin flows on steep slopes spread too fast.
    Vertical,
    /// Gradients along the bed, for thin flows on steep slopes: lakes over rough terrain do not stay at rest.
    Normal,
}

/// Form of the pressure force (sheet: depth-sph §2.10).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "DepthMomentum")]
pub enum PressureForceForm {
    /// As `symmetric`; for two phases corrected differences where the drag is weak.
    #[default]
    Automatic,
    /// Symmetric form `Σ m (P_I/h_I² + P_J/h_J²) ∇W`, which conserves momentum.
    Symmetric,
    /// Product form `Σ m (P_I + P_J)/(h_I h_J) ∇W`, which conserves momentum too.
    Product,
    /// Gradients of flow depths by corrected differences, for phases that separate.
    Node,
    /// Variational form `Σ m (P_I/(Ω_I h_I²) ∇W(ℓ_I) + P_J/(Ω_J h_J²) ∇W(ℓ_J))`, with depths and smoothing lengths solved together,
    /// whatever `passes`. Conserves energy too. One phase, depths by `summation`.
    Variational,
}

/// Equation of the flow depth (sheet: depth-sph §2.10).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "DepthContinuity")]
pub enum ThicknessEquation {
    /// Summation `h = Σ m W`: exact mass, with free fronts.
    #[default]
    Summation,
    /// Normalised summation `h = Σ m W / Σ (m/h) W`: level up to an edge, also at a free front.
    Normalised,
    /// Rate equation `dh/dt = -h Σ (m/h) v_J · ∇W`.
    RateBasic,
    /// Rate equation `dh/dt = Σ m v_IJ · ∇W`.
    RateDifference,
    /// Rate equation `dh/dt = h Σ (m/h) v_IJ · ∇W`.
    RateVolume,
}

impl ThicknessEquation {
    /// Whether flow depths are integrated in time.
    pub fn is_rate(self) -> bool {
        matches!(self, Self::RateBasic | Self::RateDifference | Self::RateVolume)
    }
}

/// Time integration of positions and velocities (sheet: depth-sph §3.4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "DepthIntegration")]
pub enum TimeScheme {
    /// Half a position, a velocity, half a position update: second order, one evaluation.
    #[default]
    Leapfrog,
    /// Midpoint rule: second order, two evaluations.
    RungeKutta2,
    /// Classical Runge–Kutta scheme: fourth order, four evaluations.
    RungeKutta4,
}

/// Orientation of the cells of the neighbour search (sheet: depth-sph §3.4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "DepthSearch")]
pub enum SearchOrientation {
    /// Cells along the axes of the plan.
    #[default]
    Axes,
    /// Cells turned in every step along the longest extent of the flow.
    Turned,
}
