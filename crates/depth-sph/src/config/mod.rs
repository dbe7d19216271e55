//! Options of `methods.depth-sph` in a case file.

mod checks;
pub mod choices;
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
    /// Initial distance of neighbouring nodes (m).
    pub spacing: f64,
    /// Smoothing kernel.
    #[serde(default)]
    pub kernel: Kernel,
    /// Smoothing length over `spacing` (-), 1 to 3. When absent 1.5 along a line and 1.3 in plan.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub smoothing: Option<f64>,
    /// Whether smoothing lengths vary with the flow depth, so that `ℓ^d h / m` is constant. They are between half the initial length and
    /// three times it (fifty times along a line).
    #[serde(default = "default_true")]
    pub variable_smoothing: bool,
    /// Lower bound of variable smoothing lengths (m), at most the first one; none when absent. It bounds the time step from below.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shortest_smoothing: Option<f64>,
    /// Number of summations of flow depth per step, 1 to 10, each with the smoothing lengths that follow from the one before. With
    /// `momentum` `variational` the number is as large as needed.
    #[serde(default = "default_passes")]
    pub passes: usize,
    /// Equation of the flow depth.
    #[serde(default)]
    pub continuity: ThicknessEquation,
    /// Form of the pressure force.
    #[serde(default)]
    pub momentum: PressureForceForm,
    /// Whether the pressure force uses the gradient of the free surface, by corrected differences. Lakes stay at rest; momentum is not
    /// conserved to round-off.
    #[serde(default)]
    pub surface_gradient: bool,
    /// Time integration.
    #[serde(default)]
    pub integration: TimeScheme,
    /// Linear artificial viscosity (-), at least 0.
    #[serde(default = "default_factor")]
    pub viscosity_linear: f64,
    /// Quadratic artificial viscosity (-), at least 0.
    #[serde(default)]
    pub viscosity_quadratic: f64,
    /// XSPH fraction (-), 0 to 1: share of the neighbours' velocity in the motion of nodes. With `integration` `leapfrog`. In two phases
    /// it separates the sets of nodes.
    #[serde(default)]
    pub xsph: f64,
    /// Orientation of the cells of the neighbour search. In three dimensions. `turned` gains a few per cent where a long flow is oblique;
    /// kernel sums are then added in another order.
    #[serde(default)]
    pub search: SearchOrientation,
    /// Length (m) of a layer before absorbing sides in which waves decay; none when absent. Depth and normal speed relax to the initial
    /// state in it, so that lasting changes of the flow are held back. A suitable length is that of two waves. With two layers only in a
    /// profile.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub absorbing_layer: Option<f64>,
    /// Courant number (-), up to 0.5.
    #[serde(default = "courant")]
    pub courant: f64,
    /// Upper bound of the time step (s); none when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_time_step: Option<f64>,
    /// Axes of the flow depth. With gravity tilted over a flat bed always `bed-fitted`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<DepthFrame>,
    /// Effect of depth gradients over steep terrain.
    #[serde(default)]
    pub metric: Metric,
    /// Whether the curvature of the bed acts on friction and pore pressure, as the rotation of the velocity over a step on a bed that is
    /// smooth at the scale of two cells of the terrain. The pressure force depends on the slope alone. The velocity rotates along the bed
    /// in any case.
    #[serde(default = "default_true")]
    pub curvature_in_friction: bool,
    /// Number of averagings of the terrain levels, 0 to 20, over neighbouring nodes with weights 1, 2, 1 along each axis, before a cubic
    /// spline of the bed is made. For the noise of surveys; formulas have none. One averaging halves the height of a wave of four cells.
    /// Dams are raised afterwards.
    #[serde(default = "default_smoothing_passes")]
    pub terrain_smoothing: usize,
    /// Distance (m) of the positions at which the highest face of obstacles is evaluated, where the bed is no raster of a file and no
    /// plane; `spacing` when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub terrain_spacing: Option<f64>,
    /// Resistance of the bed; from the wall below and the material when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub basal: Option<BasalSpec>,
    /// Parts of the bed with other properties. At a position in several parts the first one applies.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub regions: Vec<BedRegion>,
    /// Dams on the terrain, in three dimensions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub dams: Vec<DamOptions>,
    /// Inflows of material, across lines in three dimensions or through the ends of a profile. The material is one phase, a mixture of
    /// grains and fluid at one speed, or one of two layers. With pore-pressure columns the inflow has their `excess_ratio`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub inflows: Vec<InflowOptions>,
    /// Drainage of the pore fluid through the bed.
    #[serde(default)]
    pub drainage: Drainage,
    /// Erosion of the bed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub erosion: Option<Erosion>,
    /// Erodible depth of the bed (m, vertical), at least 0; no limit when absent. The bed must be terrain.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub erodible_depth: Option<f64>,
    /// Path of a raster of the erodible depth (m), ESRI ASCII grid or GeoTIFF, relative to the folder of the case. Nothing is eroded
    /// outside it and where it has no data; `erodible_depth` bounds it too. In three dimensions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub erodible_depth_raster: Option<String>,
    /// Whether erosion lowers the bed. By default flows move over the initial bed, so that a plane bed may erode too. The bed must be
    /// terrain.
    #[serde(default, skip_serializing_if = "is_false")]
    pub lower_bed: bool,
    /// Number of phases with separate nodes.
    #[serde(default)]
    pub phases: Phases,
    /// Components of the flowing material, with pore fluid or a second layer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mixture: Option<MixtureOptions>,
    /// Columns of excess pore pressure over the depth; none when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub column: Option<ColumnOptions>,
    /// Earth-pressure coefficients; isotropic stress when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub earth_pressure: Option<EarthPressureOptions>,
    /// Conditions under which the scalar output `stopped` reports that the flow has stopped.
    #[serde(default)]
    pub stop: StopOptions,
    /// Whether a node that leaves the terrain ends the run with an error; if not, such nodes are removed and counted.
    #[serde(default)]
    pub leaving_is_an_error: bool,
}

/// Region of the bed with its own properties.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BedRegion {
    /// Region in plan: a box of one coordinate in plane strain, any shape of two dimensions in three. Give this, `outline` or `raster`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shape: Option<Shape>,
    /// Path of a file of the region's polygons (m), relative to the folder of the case: GeoJSON (`.geojson`, `.json`) or a shapefile
    /// (`.shp`). In three dimensions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outline: Option<String>,
    /// Region as cells of a raster, for example of land cover. In three dimensions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub raster: Option<RasterCellSelection>,
    /// Basal resistance in the region; when absent that of the whole bed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub basal: Option<BasalSpec>,
    /// Drainage of pore fluid through the bed in the region; when absent that of the whole bed. A drainage rack is `atmospheric`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drainage: Option<Drainage>,
    /// Resistance of the bed to the pore fluid in the region; when absent `mixture.fluid_resistance`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fluid_resistance: Option<FluidResistanceOptions>,
    /// Erosion of the region; none when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub erosion: Option<Erosion>,
    /// Erodible depth in the region (m, vertical), at least 0; when absent that of the whole bed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub erodible_depth: Option<f64>,
}

/// Dam along a line in plan, which raises the terrain below it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DamOptions {
    /// Corners of the crest line (m) in plan, at least two.
    pub line: Vec<[f64; 2]>,
    /// Height of the crest above the terrain below it (m, vertical).
    pub height: f64,
    /// Width of the crest (m), not negative.
    #[serde(default)]
    pub width: f64,
    /// Slope of the sides (-), fall over width, > 0. Sides steeper than 60° (1.73) do not stop a fast flow.
    #[serde(default = "default_factor")]
    pub side_slope: f64,
}

/// Inflow of material across a line, by a hydrograph.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InflowOptions {
    /// Start of the line (m) in plan. In three dimensions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<[f64; 2]>,
    /// End of the line (m) in plan. The flow is to the right of the direction from start to end, and needs terrain for a few `spacing`
    /// behind the line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to: Option<[f64; 2]>,
    /// End of the profile through which the material flows in, `x-min` or `x-max`. In a profile.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub side: Option<Side>,
    /// Hydrograph: pairs of time from the start of the flow (s) and discharge (m³/s; m²/s in a profile), linear between them and zero
    /// before and after. Give this or `hydrograph`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub discharge: Vec<[f64; 2]>,
    /// Path of a file of the hydrograph, relative to the folder of the case: CSV with two columns, time and discharge, in the units of
    /// `discharge` or in those in brackets in a header line, such as `time (h),discharge (l/s)`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hydrograph: Option<String>,
    /// Froude number `u/√(g h)` at the line (-). It determines depth and speed of a discharge where there is no flow before the line, and
    /// where the flow is faster than its waves. Otherwise they follow from the discharge and the flow before the line.
    #[serde(default = "default_factor")]
    pub froude: f64,
    /// Distribution of the inflow along the line, at one speed. In three dimensions.
    #[serde(default)]
    pub across: InflowDistribution,
    /// Layer of the inflow, for phases that are `layers`: one inflow for each layer, at one line or at two lines.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layer: Option<FlowLayer>,
    /// Porosity of the inflow (volume fraction of the pore fluid), between 0 and 1, for `phases` `two`; when absent that of the mixture.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub porosity: Option<f64>,
}

/// Components of the flowing material: grains and fluid, or two layers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MixtureOptions {
    /// Density of the grains, or of the lower layer (kg/m³).
    pub grain_density: f64,
    /// Density of the fluid, or of the upper layer (kg/m³).
    #[serde(default = "water")]
    pub fluid_density: f64,
    /// Initial porosity, between 0 and 1; without effect for two layers.
    #[serde(default = "default_porosity")]
    pub porosity: f64,
    /// Initial porosities of bodies that differ, by name, between 0 and 1; for phases that are `two`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub porosities: BTreeMap<String, f64>,
    /// Drag law between grains and fluid in relative motion, or the permeability of columns.
    #[serde(default)]
    pub drag: InterphaseDrag,
    /// Resistance of the bed to the fluid, for phases that are `two`. Parts of the bed may have another one, see `regions`.
    #[serde(default)]
    pub fluid_resistance: FluidResistanceOptions,
    /// Names of the bodies of the upper layer of two.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub upper: Vec<String>,
    /// Friction coefficient between two layers (-), 0 to 1.
    #[serde(default)]
    pub interface_friction: f64,
}

/// Resistance of the bed to the pore fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "law", rename_all = "kebab-case", deny_unknown_fields)]
pub enum FluidResistanceOptions {
    /// No resistance.
    #[default]
    None,
    /// Laminar flow, `3 μ v / h`.
    Laminar {
        /// Viscosity `μ` (Pa s), not negative.
        viscosity: f64,
    },
    /// Manning's law, `ρ g n² v² / h^⅓`.
    Manning {
        /// Manning's coefficient `n` (s/m^⅓), not negative.
        coefficient: f64,
    },
    /// Turbulent flow, `ρ g v² / ξ`.
    Turbulent {
        /// Turbulence coefficient `ξ` (m/s²), > 0.
        turbulence: f64,
    },
}

/// Columns of excess pore pressure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ColumnOptions {
    /// Number of intervals over the depth, 4 to 1000.
    #[serde(default = "default_column_cells")]
    pub cells: usize,
    /// Weight of the new time level (-): 1 is backward Euler, 0.5 Crank–Nicolson.
    #[serde(default = "default_factor")]
    pub weight: f64,
    /// Discretisation of the pressure over the depth.
    #[serde(default)]
    pub profile: PressureProfile,
    /// Coefficient of consolidation (m²/s), not negative; 0 without drainage. Give this or `skeleton`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub consolidation: Option<f64>,
    /// Stiffness of the skeleton, which with the permeability of the drag law gives the coefficient of consolidation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub skeleton: Option<SkeletonOptions>,
    /// Lower bound of the pressure.
    #[serde(default)]
    pub lower_bound: LowerBound,
    /// Initial liquefaction ratio (-), 0 to 1: excess pressure at the base over that of full liquefaction, with a linear profile over the
    /// depth.
    #[serde(default)]
    pub excess_ratio: f64,
    /// Dilatancy under shear; none when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dilatancy: Option<DilatancyOptions>,
}

/// Stiffness of the skeleton, `K_v/α` with `K_v = E/(3(1 - 2ν))`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SkeletonOptions {
    /// Young's modulus (Pa), > 0.
    pub youngs_modulus: f64,
    /// Poisson's ratio, 0 to 0.5 (excluded).
    pub poissons_ratio: f64,
    /// State of stress, which gives the factor `α`.
    #[serde(default)]
    pub confinement: SkeletonConfinement,
}

/// Factor `α` of the state of stress (-).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(rename = "DepthConfinement")]
pub enum SkeletonConfinement {
    /// No lateral strain: `α = (1 + 2 k₀)/3`, `k₀ = ν/(1 - ν)`.
    #[default]
    OneDimensional,
    /// No lateral strain, with a given coefficient of lateral stress: `α = (1 + 2 k₀)/3`.
    Lateral {
        /// Coefficient of lateral stress `k₀` (-), not negative.
        k0: f64,
    },
    /// Isotropic stress: `α = 1`.
    Isotropic,
    /// Form printed in the source: `α = k₀`.
    Source {
        /// Coefficient of lateral stress `k₀` (-), > 0.
        k0: f64,
    },
    /// Given value of `α`.
    Value {
        /// Factor `α` (-), > 0.
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

/// Dilatancy of Iverson and George: `tan ψ = slope (critical_porosity - n)`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DilatancyOptions {
    /// Slope of `tan ψ` over porosity (-), not negative.
    pub slope: f64,
    /// Porosity at which shear changes no volume, between 0 and 1.
    pub critical_porosity: f64,
}

/// Earth pressure of Savage and Hutter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EarthPressureOptions {
    /// Internal friction angle (degrees), 0 to 90 (excluded), not below the basal one.
    pub internal_friction_angle: f64,
    /// Friction angle at the bed (degrees).
    pub basal_friction_angle: f64,
}

/// Conditions under which a flow is regarded as stopped.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct StopOptions {
    /// Speed (m/s) below which a node is at rest.
    pub speed: f64,
    /// Share of the volume (-) that must be at rest.
    pub share: f64,
    /// Upper bound of the kinetic energy over its largest value (-).
    pub kinetic_ratio: f64,
    /// Time (s) for which all conditions must be fulfilled.
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
