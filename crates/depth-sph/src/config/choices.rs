//! Choices of the method, as a case file names them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How many phases move on sets of nodes of their own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Phases {
    /// One set: a dry material, a fluid, or a mixture whose phases move together.
    #[default]
    One,
    /// Grains and pore fluid, each with its own height and velocity.
    Two,
    /// Two layers: an avalanche below water.
    Layers,
}

/// How what flows in across a line stands along it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum InflowDistribution {
    /// As deep everywhere.
    #[default]
    Even,
    /// Up to one level, so that it is deeper where the bed is lower, and nothing where that is higher: for a line across a channel.
    Level,
}

/// One of two layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FlowLayer {
    /// The one on the bed.
    Lower,
    /// The one on top of it.
    Upper,
}

/// The axes that depth is measured in (sheet: depth-sph §2.9).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DepthFrame {
    /// Horizontal axes and vertical depth over steep terrain: effective gravity follows slope and curvature.
    #[default]
    Horizontal,
    /// Horizontal axes over gentle slopes: gravity acts on depth in full.
    SmallSlope,
    /// Axes along the bed, which is a plane, and depth normal to it.
    BedFitted,
}

/// How depth gradients act over steep terrain (sheet: depth-sph §2.9).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Metric {
    /// As they are where the free surface is level, along the bed normal where it follows the bed, and between them by its slope.
    #[default]
    Blended,
    /// As they are: a level surface stays level, and sheets on steep slopes spread too fast.
    Vertical,
    /// Projected along the bed normal, for thin sheets on steep slopes: lakes over rough ground do not rest.
    Normal,
}

/// The form of the pressure force (sheet: depth-sph §2.10).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "DepthMomentum")]
pub enum PressureForceForm {
    /// `Σ m (P_I/h_I² + P_J/h_J²) ∇W`; of two phases, corrected differences at nodes whose drag is weak.
    #[default]
    Automatic,
    /// `Σ m (P_I/h_I² + P_J/h_J²) ∇W`, which conserves momentum.
    Symmetric,
    /// `Σ m (P_I + P_J)/(h_I h_J) ∇W`, which does too.
    Product,
    /// Gradients of heights by corrected differences: for phases that move apart.
    Node,
    /// `Σ m (P_I/(Ω_I h_I²) ∇W(ℓ_I) + P_J/(Ω_J h_J²) ∇W(ℓ_J))` with heights and smoothing lengths that are solved for together, whatever
    /// `passes`: the forces of an energy, which is kept as well. One phase, heights by summation.
    Variational,
}

/// How heights follow the nodes (sheet: depth-sph §2.10).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "DepthContinuity")]
pub enum ThicknessEquation {
    /// `h = Σ m W`: mass exact, fronts free.
    #[default]
    Summation,
    /// `h = Σ m W / Σ (m/h) W`: level up to an edge, which a free front is then as well.
    Normalised,
    /// `dh/dt = -h Σ (m/h) v_J · ∇W`.
    RateBasic,
    /// `dh/dt = Σ m v_IJ · ∇W`.
    RateDifference,
    /// `dh/dt = h Σ (m/h) v_IJ · ∇W`.
    RateVolume,
}

impl ThicknessEquation {
    /// Whether heights are integrated in time.
    pub fn is_rate(self) -> bool {
        matches!(self, Self::RateBasic | Self::RateDifference | Self::RateVolume)
    }
}

/// Time integration of positions and velocities (sheet: depth-sph §3.4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "DepthIntegration")]
pub enum TimeScheme {
    /// Half a drift, a kick, half a drift: second order, one evaluation of forces.
    #[default]
    Leapfrog,
    /// Midpoint rule: second order, two evaluations.
    RungeKutta2,
    /// Classical fourth order, four evaluations.
    RungeKutta4,
}

/// How the cells lie that neighbours are looked for in (sheet: depth-sph §3.4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[schemars(rename = "DepthSearch")]
pub enum SearchOrientation {
    /// Along the axes of the plan.
    #[default]
    Axes,
    /// Turned with the flow, in every step: lines of cells follow its longest extent.
    Turned,
}
