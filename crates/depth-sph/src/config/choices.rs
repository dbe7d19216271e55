//! Enumerated options of `methods.depth-sph`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Number of phases with separate nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Phases {
    /// Dry material, fluid, or mixture that moves together.
    #[default]
    One,
    /// Grains and pore fluid, with own depths and velocities.
    Two,
    /// Two layers: avalanche below water.
    Layers,
}

/// Discharge along an inflow line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum InflowDistribution {
    /// Equal depth.
    #[default]
    Even,
    /// Level surface, as across a channel: deeper over lower bed, absent where the bed is above it.
    Level,
}

/// One of two layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FlowLayer {
    /// Layer on the bed.
    Lower,
    /// Layer above.
    Upper,
}

/// Axes of flow depth (sheet: depth-sph §2.9).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DepthFrame {
    /// Vertical depth, steep terrain: effective gravity follows slope and curvature.
    #[default]
    Horizontal,
    /// Vertical depth, gentle slopes: full gravity acts on depth.
    SmallSlope,
    /// Depth normal to the bed, a plane.
    BedFitted,
}

/// Depth gradients over steep terrain (sheet: depth-sph §2.9).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Metric {
    /// Blend by surface slope: `vertical` where level, `normal` where parallel to the bed.
    #[default]
    Blended,
    /// Gradients in plan: level surfaces stay level, but thin flows on steep slopes spread too fast.
    Vertical,
    /// Gradients along the bed, for thin flows on steep slopes: lakes over rough terrain do not rest.
    Normal,
}

/// Pressure force (sheet: depth-sph §2.10).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "DepthMomentum")]
pub enum PressureForceForm {
    /// As `symmetric`; corrected differences for two weakly dragged phases.
    #[default]
    Automatic,
    /// Symmetric `Σ m (P_I/h_I² + P_J/h_J²) ∇W`, conserves momentum.
    Symmetric,
    /// Product `Σ m (P_I + P_J)/(h_I h_J) ∇W`, conserves momentum.
    Product,
    /// Corrected differences of flow depths, for phases that separate.
    Node,
    /// Variational `Σ m (P_I/(Ω_I h_I²) ∇W(ℓ_I) + P_J/(Ω_J h_J²) ∇W(ℓ_J))`, depths and smoothing lengths solved together, whatever
    /// `passes`. Conserves momentum and energy. One phase, depths by `summation`.
    Variational,
}

/// Equation of the flow depth (sheet: depth-sph §2.10).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "DepthContinuity")]
pub enum ThicknessEquation {
    /// Summation `h = Σ m W`: exact mass, free fronts.
    #[default]
    Summation,
    /// Normalised summation `h = Σ m W / Σ (m/h) W`: level up to edges and free fronts.
    Normalised,
    /// Rate `dh/dt = -h Σ (m/h) v_J · ∇W`.
    RateBasic,
    /// Rate `dh/dt = Σ m v_IJ · ∇W`.
    RateDifference,
    /// Rate `dh/dt = h Σ (m/h) v_IJ · ∇W`.
    RateVolume,
}

impl ThicknessEquation {
    /// Whether flow depths are integrated in time.
    pub fn is_rate(self) -> bool {
        matches!(self, Self::RateBasic | Self::RateDifference | Self::RateVolume)
    }
}

/// Time integration (sheet: depth-sph §3.4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "DepthIntegration")]
pub enum TimeScheme {
    /// Half position, velocity, half position update: second order, one evaluation.
    #[default]
    Leapfrog,
    /// Midpoint rule: second order, two evaluations.
    RungeKutta2,
    /// Classical scheme: fourth order, four evaluations.
    RungeKutta4,
}

/// Orientation of search cells (sheet: depth-sph §3.4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "DepthSearch")]
pub enum SearchOrientation {
    /// Cells along the plan axes.
    #[default]
    Axes,
    /// Cells along the longest extent of the flow, in every step.
    Turned,
}
