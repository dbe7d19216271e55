//! Options of `methods.depth-sph` in a case file.

mod checks;
pub mod choices;
mod column_checks;
mod constructors;
pub mod settings;

use std::collections::BTreeMap;

use colluvium_case::description::{RasterCellSelection, Side};
use colluvium_constitutive::basal::BasalSpec;
use colluvium_points::Shape;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::config::choices::{
    DepthFrame, FlowLayer, InflowDistribution, Metric, Phases, PressureForceForm, SearchOrientation,
    ThicknessEquation, TimeScheme,
};
use crate::kernel::Kernel;
use crate::laws::erosion::Erosion;
use crate::laws::interphase_drag::InterphaseDrag;
use crate::laws::pore_pressure_column::{Drainage, LowerBound, PressureProfile};

/// Options of depth-integrated SPH.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DepthOptions {
    /// Initial distance of nodes (m).
    pub spacing: f64,
    /// Smoothing kernel.
    #[serde(default)]
    pub kernel: Kernel,
    /// Smoothing length over `spacing`, 1 to 3; by default 1.5 along a line, 1.3 in plan.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub smoothing: Option<f64>,
    /// Whether smoothing lengths vary with depth (`ℓ^d h / m` constant), from half the initial length to three times it (line: fifty).
    #[serde(default = "default_true")]
    pub variable_smoothing: bool,
    /// Lower bound of variable smoothing lengths (m), at most the initial one; none when absent. It bounds the time step from below.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shortest_smoothing: Option<f64>,
    /// Depth summations per step, 1 to 10, each with the smoothing lengths before; with `momentum` `variational` as many as needed.
    #[serde(default = "default_passes")]
    pub passes: usize,
    /// Equation of the flow depth.
    #[serde(default)]
    pub continuity: ThicknessEquation,
    /// Pressure force.
    #[serde(default)]
    pub momentum: PressureForceForm,
    /// Whether the pressure force uses differences of the free surface: lakes stay at rest; momentum is not conserved to round-off.
    #[serde(default)]
    pub surface_gradient: bool,
    /// Time integration.
    #[serde(default)]
    pub integration: TimeScheme,
    /// Linear artificial viscosity, non-negative.
    #[serde(default = "default_factor")]
    pub viscosity_linear: f64,
    /// Quadratic artificial viscosity, non-negative.
    #[serde(default)]
    pub viscosity_quadratic: f64,
    /// XSPH fraction, 0 to 1: share of the neighbours' velocity in the motion, with `integration` `leapfrog`. It separates two phases'
    /// nodes.
    #[serde(default)]
    pub xsph: f64,
    /// Neighbour search, in 3D. `turned` saves a few per cent in long oblique flows and changes round-off.
    #[serde(default)]
    pub search: SearchOrientation,
    /// Layer (m) before absorbing sides in which depth and normal speed relax to the initial state; none when absent. It holds back lasting
    /// changes. Choose about two waves. Two layers: profiles only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub absorbing_layer: Option<f64>,
    /// Courant number, up to 0.5.
    #[serde(default = "courant")]
    pub courant: f64,
    /// Largest time step (s); unlimited when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_time_step: Option<f64>,
    /// Axes of flow depth; always `bed-fitted` with gravity tilted over a flat bed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<DepthFrame>,
    /// Depth gradients over steep terrain.
    #[serde(default)]
    pub metric: Metric,
    /// Whether bed curvature acts on friction and pore pressure, as rotation of the velocity over a step; for beds smooth over two terrain
    /// cells. The pressure force depends on slope alone.
    #[serde(default = "default_true")]
    pub curvature_in_friction: bool,
    /// Averagings of terrain levels with neighbours (weights 1, 2, 1 along each axis), 0 to 20, against survey noise. One halves a
    /// four-cell wave. Dams are raised afterwards.
    #[serde(default = "default_smoothing_passes")]
    pub terrain_smoothing: usize,
    /// Distance (m) at which obstacles are evaluated, unless bed is a raster file or plane; `spacing` when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub terrain_spacing: Option<f64>,
    /// Bed resistance; when absent from the wall below and the material.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub basal: Option<BasalSpec>,
    /// Bed parts with other properties; the first of overlapping ones applies.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub regions: Vec<BedRegion>,
    /// Dams, in 3D.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub dams: Vec<DamOptions>,
    /// Inflows across lines in 3D or profile ends, of one phase, a mixture at one speed, or one layer. Pore-pressure columns have their
    /// `excess_ratio`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub inflows: Vec<InflowOptions>,
    /// Bed drainage.
    #[serde(default)]
    pub drainage: Drainage,
    /// Erosion of the bed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub erosion: Option<Erosion>,
    /// Erodible depth (m, vertical), non-negative; unlimited when absent. The bed must be terrain.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub erodible_depth: Option<f64>,
    /// Erodible depth raster (m), ESRI ASCII grid or GeoTIFF, bounded by `erodible_depth`; none outside or without data. In 3D.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub erodible_depth_raster: Option<String>,
    /// Whether erosion lowers the bed, a terrain.
    #[serde(default, skip_serializing_if = "is_false")]
    pub lower_bed: bool,
    /// Number of phases with separate nodes.
    #[serde(default)]
    pub phases: Phases,
    /// Material components.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mixture: Option<MixtureOptions>,
    /// Excess pore pressure columns.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub column: Option<ColumnOptions>,
    /// Earth-pressure coefficients; isotropic stress when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub earth_pressure: Option<EarthPressureOptions>,
    /// Conditions of output `stopped`.
    #[serde(default)]
    pub stop: StopOptions,
    /// Whether nodes that leave the terrain end the run; otherwise they are removed and counted.
    #[serde(default)]
    pub leaving_is_an_error: bool,
}

/// Region of the bed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BedRegion {
    /// Region in plan: a box of one coordinate in 2D, any two-dimensional shape in 3D. Or give `outline` or `raster`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shape: Option<Shape>,
    /// Outline in plan (m), GeoJSON or shapefile, 3D.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outline: Option<String>,
    /// Raster cells in plan, as of land cover, 3D.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub raster: Option<RasterCellSelection>,
    /// Basal resistance; the whole bed's when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub basal: Option<BasalSpec>,
    /// Drainage; the whole bed's when absent. A drainage rack is `atmospheric`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drainage: Option<Drainage>,
    /// Resistance to the pore fluid; `mixture.fluid_resistance` when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fluid_resistance: Option<FluidResistanceOptions>,
    /// Erosion; none when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub erosion: Option<Erosion>,
    /// Erodible depth (m, vertical), non-negative; the whole bed's when absent. Needs `erosion` of the region.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub erodible_depth: Option<f64>,
}

/// Dam along a line in plan, raising the terrain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DamOptions {
    /// Corners of the crest in plan (m), two or more.
    pub line: Vec<[f64; 2]>,
    /// Height above the terrain (m, vertical).
    pub height: f64,
    /// Crest width (m), non-negative.
    #[serde(default)]
    pub width: f64,
    /// Side slope, fall over width, positive. Sides above 1.73 (60°) do not stop fast flows.
    #[serde(default = "default_factor")]
    pub side_slope: f64,
}

/// Inflow across a line, by a hydrograph.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InflowOptions {
    /// Start of the line in plan (m), in 3D.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<[f64; 2]>,
    /// End of the line in plan (m). Flow is to the right from start to end; terrain must reach a few `spacing` behind.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to: Option<[f64; 2]>,
    /// Profile end, `x-min` or `x-max`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub side: Option<Side>,
    /// Hydrograph: pairs of time (s) and discharge (m³/s; m²/s in a profile), linear between, zero outside. Or give `hydrograph`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub discharge: Vec<[f64; 2]>,
    /// CSV file of time and discharge, in units as `discharge` or in a header line, as `time (h),discharge (l/s)`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hydrograph: Option<String>,
    /// Froude number `u/√(g h)` at the line: sets depth and speed of supercritical flow, or of flow onto a dry line. Otherwise discharge
    /// and arriving flow do.
    #[serde(default = "default_factor")]
    pub froude: f64,
    /// Distribution along the line, at one speed, in 3D.
    #[serde(default)]
    pub across: InflowDistribution,
    /// Layer for `phases` `layers`, one inflow each.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layer: Option<FlowLayer>,
    /// Porosity, between 0 and 1, for `phases` `two`; the mixture's when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub porosity: Option<f64>,
}

/// Material components: grains and fluid, or two layers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MixtureOptions {
    /// Density of the grains or lower layer (kg/m³).
    pub grain_density: f64,
    /// Density of the fluid or upper layer (kg/m³).
    #[serde(default = "water")]
    pub fluid_density: f64,
    /// Initial porosity, between 0 and 1; not for two layers.
    #[serde(default = "default_porosity")]
    pub porosity: f64,
    /// Initial porosities of bodies, for `phases` `two`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub porosities: BTreeMap<String, f64>,
    /// Drag of grains and fluid, or permeability of columns.
    #[serde(default)]
    pub drag: InterphaseDrag,
    /// Bed resistance to the fluid, for `phases` `two`; see also `regions`.
    #[serde(default)]
    pub fluid_resistance: FluidResistanceOptions,
    /// Bodies of the upper layer.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub upper: Vec<String>,
    /// Friction coefficient between layers, 0 to 1.
    #[serde(default)]
    pub interface_friction: f64,
}

/// Bed resistance to the pore fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "law", rename_all = "kebab-case", deny_unknown_fields)]
pub enum FluidResistanceOptions {
    /// No resistance.
    #[default]
    None,
    /// Laminar, `3 μ v / h`.
    Laminar {
        /// Viscosity `μ` (Pa s), non-negative.
        viscosity: f64,
    },
    /// Manning, `ρ g n² v² / h^⅓`.
    Manning {
        /// Manning's coefficient `n` (s/m^⅓), non-negative.
        coefficient: f64,
    },
    /// Turbulent, `ρ g v² / ξ`.
    Turbulent {
        /// Turbulence coefficient `ξ` (m/s²), positive.
        turbulence: f64,
    },
}

/// Excess pore pressure columns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ColumnOptions {
    /// Depth intervals, 4 to 1000.
    #[serde(default = "default_column_cells")]
    pub cells: usize,
    /// Weight of the new time level: 1 backward Euler, 0.5 Crank–Nicolson.
    #[serde(default = "default_factor")]
    pub weight: f64,
    /// Pressure discretisation over depth.
    #[serde(default)]
    pub profile: PressureProfile,
    /// Consolidation coefficient (m²/s), non-negative; 0 without drainage. Or give `skeleton`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub consolidation: Option<f64>,
    /// Skeleton stiffness, which with the drag law's permeability gives the consolidation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub skeleton: Option<SkeletonOptions>,
    /// Lower pressure bound.
    #[serde(default)]
    pub lower_bound: LowerBound,
    /// Initial excess pressure at the base over full liquefaction, 0 to 1.
    #[serde(default)]
    pub excess_ratio: f64,
    /// Dilatancy under shear; none when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dilatancy: Option<DilatancyOptions>,
}

/// Skeleton stiffness `K_v/α` with `K_v = E/(3(1 - 2ν))`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SkeletonOptions {
    /// Young's modulus (Pa), positive.
    pub youngs_modulus: f64,
    /// Poisson's ratio, 0 to 0.5 (excluded).
    pub poissons_ratio: f64,
    /// State of stress, which gives `α`.
    #[serde(default)]
    pub confinement: SkeletonConfinement,
}

/// Factor `α` of the stress state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(rename = "DepthConfinement")]
pub enum SkeletonConfinement {
    /// No lateral strain: `α = (1 + 2 k₀)/3`, `k₀ = ν/(1 - ν)`.
    #[default]
    OneDimensional,
    /// No lateral strain, given `k₀`: `α = (1 + 2 k₀)/3`.
    Lateral {
        /// Lateral stress coefficient `k₀`, non-negative.
        k0: f64,
    },
    /// Isotropic stress: `α = 1`.
    Isotropic,
    /// As printed in the source: `α = k₀`.
    Source {
        /// Lateral stress coefficient `k₀`, positive.
        k0: f64,
    },
    /// Given `α`.
    Value {
        /// Factor `α`, positive.
        alpha: f64,
    },
}

impl SkeletonOptions {
    /// Stiffness `K_v/α` (Pa).
    pub fn stiffness(&self) -> f64 {
        let nu = self.poissons_ratio;
        let alpha = match self.confinement {
            SkeletonConfinement::OneDimensional => (1.0 + 2.0 * nu / (1.0 - nu)) / 3.0,
            SkeletonConfinement::Lateral { k0 } => (1.0 + 2.0 * k0) / 3.0,
            SkeletonConfinement::Isotropic => 1.0,
            SkeletonConfinement::Source { k0 } => k0,
            SkeletonConfinement::Value { alpha } => alpha,
        };
        self.youngs_modulus / (3.0 * (1.0 - 2.0 * nu)) / alpha
    }
}

/// Dilatancy (Iverson and George): `tan ψ = slope (critical_porosity - n)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DilatancyOptions {
    /// Slope of `tan ψ` over porosity, non-negative.
    pub slope: f64,
    /// Porosity without volume change in shear, between 0 and 1.
    pub critical_porosity: f64,
}

/// Earth pressure of Savage and Hutter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EarthPressureOptions {
    /// Internal friction angle (degrees), non-negative, below 90, at least the basal one.
    pub internal_friction_angle: f64,
    /// Bed friction angle (degrees).
    pub basal_friction_angle: f64,
}

/// Conditions of a stopped flow.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct StopOptions {
    /// Speed (m/s) below which a node is at rest.
    pub speed: f64,
    /// Volume share that must be at rest.
    pub share: f64,
    /// Upper bound of kinetic energy over its maximum.
    pub kinetic_ratio: f64,
    /// Time (s) for which all conditions must hold.
    pub hold: f64,
}

/// Default value of an option that is on unless the case turns it off.
const fn default_true() -> bool {
    true
}
/// Whether an option is off, so that output files omit it.
#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
const fn is_false(value: &bool) -> bool {
    !*value
}
/// Default number of passes of the depth summation.
const fn default_passes() -> usize {
    2
}
/// Default number of cells of a pore-pressure column.
const fn default_column_cells() -> usize {
    20
}
/// Default number of smoothing passes.
const fn default_smoothing_passes() -> usize {
    1
}

/// Default value 1 of factors, slopes, weights and Froude numbers.
const fn default_factor() -> f64 {
    1.0
}
/// Default porosity of the mixture (-).
const fn default_porosity() -> f64 {
    0.4
}
/// Default density of the pore fluid: water (kg/m³).
const fn water() -> f64 {
    1000.0
}
/// Default Courant number of the time step (-).
const fn courant() -> f64 {
    0.3
}

impl MixtureOptions {
    /// Initial porosity of the body of that name.
    pub fn porosity_of(&self, body: &str) -> f64 {
        self.porosities.get(body).copied().unwrap_or(self.porosity)
    }
}

impl DepthOptions {
    /// Whether the erosion of each position of the bed is recorded.
    pub fn records_erosion(&self) -> bool {
        let limited = self.regions.iter().any(|region| region.erodible_depth.is_some());
        self.lower_bed || self.erodible_depth.is_some() || self.erodible_depth_raster.is_some() || limited
    }

    /// Smoothing length over spacing in a plan of `dimension` axes (sheet: depth-sph §0, defaults).
    pub fn smoothing_ratio(&self, dimension: usize) -> f64 {
        self.smoothing.unwrap_or(if dimension == 1 { 1.5 } else { 1.3 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn confined_stiffness_is_that_of_the_oedometer() {
        let (e, nu) = (2e7, 0.3);
        let skeleton = SkeletonOptions {
            youngs_modulus: e,
            poissons_ratio: nu,
            confinement: SkeletonConfinement::OneDimensional,
        };
        let oedometer = e * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu));
        assert!((skeleton.stiffness() / oedometer - 1.0).abs() < 1e-12);
    }

    #[test]
    fn options_require_a_spacing_and_refuse_unknown_keys() {
        let options: DepthOptions = serde_json::from_str(r#"{ "spacing": 0.5 }"#).unwrap();
        assert_eq!((options.smoothing_ratio(1), options.smoothing_ratio(2)), (1.5, 1.3));
        assert!(options.validate().is_ok());
        assert!(serde_json::from_str::<DepthOptions>(r#"{ "spacing": 0.5, "courants": 1 }"#).is_err());
    }
}
