//! Options of `methods.depth-sph` in a case file.

mod checks;
pub mod choices;
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
use crate::erosion::Erosion;
use crate::neighbours::kernel::Kernel;
use crate::phases::interphase_drag::InterphaseDrag;
use crate::pore_pressure::pore_pressure_column::{Drainage, LowerBound, PressureProfile};

/// Options of depth-integrated SPH.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DepthOptions {
    /// Initial distance of the nodes (m).
    pub spacing: f64,
    /// Kernel.
    #[serde(default)]
    pub kernel: Kernel,
    /// Smoothing length over `spacing`, 1 to 3; 1.5 along a line and 1.3 in plan when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub smoothing: Option<f64>,
    /// Whether smoothing lengths follow the heights, `ℓ^d h / m` constant, within half of the first one and three times it
    /// (fifty times along a line).
    #[serde(default = "default_true")]
    pub variable_smoothing: bool,
    /// Smoothing length that variable ones do not fall below (m), at most the first one: it bounds the step from below; none when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shortest_smoothing: Option<f64>,
    /// Sums of height per step, each with the smoothing lengths that follow from the one before; 1 to 10. With `momentum`
    /// `variational` they are as many as it takes.
    #[serde(default = "default_passes")]
    pub passes: usize,
    /// How heights follow the nodes.
    #[serde(default)]
    pub continuity: ThicknessEquation,
    /// Form of the pressure force.
    #[serde(default)]
    pub momentum: PressureForceForm,
    /// Whether gradients are those of the free surface, by corrected differences: lakes stay at rest, momentum is not
    /// conserved to round-off.
    #[serde(default)]
    pub surface_gradient: bool,
    /// Time integration.
    #[serde(default)]
    pub integration: TimeScheme,
    /// Linear artificial viscosity, at least 0.
    #[serde(default = "one")]
    pub viscosity_linear: f64,
    /// Quadratic artificial viscosity, at least 0.
    #[serde(default)]
    pub viscosity_quadratic: f64,
    /// Share of the neighbours' velocity with which nodes drift (XSPH), 0 to 1, with `integration` `leapfrog`. Of two phases it parts the sets of nodes.
    #[serde(default)]
    pub xsph: f64,
    /// How the cells lie that neighbours are looked for in: `turned` gains a few per cent where a long flow is oblique. Sums are then added up in another
    /// order. In three dimensions.
    #[serde(default)]
    pub search: SearchOrientation,
    /// Length of a layer before absorbing sides in which waves decay (m): depth and speed along the normal relax to the initial state
    /// there, so that a lasting change of the flow is held back. As long as two waves; none when absent. Of two layers in a profile alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub absorbing_layer: Option<f64>,
    /// Courant number, up to 0.5.
    #[serde(default = "courant")]
    pub courant: f64,
    /// Longest time step (s); none when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_time_step: Option<f64>,
    /// Axes that depth is measured in. Gravity that is tilted over a flat bed is always `bed-fitted`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<DepthFrame>,
    /// How depth gradients act over steep terrain.
    #[serde(default)]
    pub metric: Metric,
    /// Whether curvature of the bed acts on friction and pore pressure: the turning of the velocity over a step, on a bed that is smooth at
    /// the scale of two cells of the terrain. Pressure depends on the slope alone. Velocity turns along the bed in any case.
    #[serde(default = "default_true")]
    pub curvature_in_friction: bool,
    /// Means of the levels of terrain over its neighbouring nodes with weights 1, 2, 1 along each axis, 0 to 20 times, before the bed is made a
    /// cubic spline of them: surveys are noisy, formulas are not. One mean leaves a wave of four cells half of its height. Dams are raised after it.
    #[serde(default = "default_smoothing_passes")]
    pub terrain_smoothing: usize,
    /// Distance of the places at which the highest face of obstacles is looked up, where the bed is no raster of a file and no
    /// plane (m); `spacing` when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub terrain_spacing: Option<f64>,
    /// Resistance of the bed; from the wall below and the material when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub basal: Option<BasalSpec>,
    /// Parts of the bed that differ; the first that holds a place rules there.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub regions: Vec<BedRegion>,
    /// Dams on the terrain, in three dimensions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub dams: Vec<DamOptions>,
    /// Lines that material flows in across in three dimensions, or ends of a profile: of one phase, of grains and fluid at one speed, or of a
    /// layer of two.
    /// With columns of pore pressure what flows in has their `excess_ratio`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub inflows: Vec<InflowOptions>,
    /// Drainage of the pore fluid through the bed.
    #[serde(default)]
    pub drainage: Drainage,
    /// Erosion of the bed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub erosion: Option<Erosion>,
    /// Depth of the bed that can be taken up (m, vertical), at least 0; no limit when absent. The bed must be terrain.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub erodible_depth: Option<f64>,
    /// Erodible depth as a raster (m), ESRI ASCII grid or GeoTIFF, from the folder of the case. Nothing is eroded beyond it
    /// and where it has no data; `erodible_depth` bounds it as well. In three dimensions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub erodible_depth_raster: Option<String>,
    /// Whether the bed is lowered where it is eroded. When not, as by default, flows pass over the bed of the start, so that a
    /// bed that is a plane may erode as well. The bed must be terrain.
    #[serde(default, skip_serializing_if = "is_false")]
    pub lower_bed: bool,
    /// How many phases move on sets of nodes of their own.
    #[serde(default)]
    pub phases: Phases,
    /// Components of the flowing material, where there is pore fluid or a second layer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mixture: Option<MixtureOptions>,
    /// Excess pore pressure along the depth; none when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub column: Option<ColumnOptions>,
    /// Earth-pressure coefficients; isotropic stress when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub earth_pressure: Option<EarthPressureOptions>,
    /// When the flow has come to rest, in the reading `stopped`.
    #[serde(default)]
    pub stop: StopOptions,
    /// Whether nodes that leave the terrain end the run; they are removed and counted otherwise.
    #[serde(default)]
    pub leaving_is_an_error: bool,
}

/// A part of the bed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BedRegion {
    /// Where, in plan: a box of one coordinate in plane strain, any shape of two dimensions in three. Give this, `outline` or `raster`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shape: Option<Shape>,
    /// Where, in three dimensions: a file with polygons in metres, GeoJSON (`.geojson`, `.json`) or a shapefile (`.shp`), from the
    /// folder of the case.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub outline: Option<String>,
    /// Where, in three dimensions: cells of a raster, as one of land cover.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub raster: Option<RasterCellSelection>,
    /// Resistance; that of the rest of the bed when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub basal: Option<BasalSpec>,
    /// Drainage of the pore fluid there; as the rest of the bed when absent. A rack is `atmospheric`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub drainage: Option<Drainage>,
    /// Resistance to the pore fluid; that of the rest of the bed, `mixture.fluid_resistance`, when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fluid_resistance: Option<FluidResistanceOptions>,
    /// Erosion there; none when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub erosion: Option<Erosion>,
    /// Depth of it that can be taken up (m, vertical), at least 0; as of the rest of the bed when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub erodible_depth: Option<f64>,
}

/// A dam along a line in plan, which raises the terrain below it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DamOptions {
    /// Corners of the line of its crest (m), in plan; two at least.
    pub line: Vec<[f64; 2]>,
    /// Height of the crest above the ground below it (m, vertical).
    pub height: f64,
    /// Width of the crest (m), not negative.
    #[serde(default)]
    pub width: f64,
    /// Fall of its sides over their width, > 0. Sides steeper than 60° (1.73) hold no flow that comes fast.
    #[serde(default = "one")]
    pub side_slope: f64,
}

/// A line that material flows in across, by a hydrograph.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InflowOptions {
    /// Where the line begins (m), in plan. In three dimensions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<[f64; 2]>,
    /// Where it ends (m). The flow goes to the right of who walks along it, and needs ground for a few `spacing` behind.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub to: Option<[f64; 2]>,
    /// The end that it flows in through, `x-min` or `x-max`. In a profile.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub side: Option<Side>,
    /// Times from the start of the flow (s) and discharges (m³/s; m²/s in a profile), linear between them; none before and after. Give this
    /// or `hydrograph`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub discharge: Vec<[f64; 2]>,
    /// File of them, from the folder of the case: CSV with two columns, time and discharge, in these units or in those that a line of
    /// names has between brackets, as `time (h),discharge (l/s)`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hydrograph: Option<String>,
    /// Froude number `u/√(g h)` at the line, which makes depth and speed of a discharge where nothing stands before it, and where the flow
    /// is faster than its waves. Else they follow from the discharge and what stands there.
    #[serde(default = "one")]
    pub froude: f64,
    /// How it stands along the line, at one speed. In three dimensions.
    #[serde(default)]
    pub across: InflowDistribution,
    /// Which of two layers flows in, for phases that are `layers`: one inflow for each, at one line or at lines of their own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layer: Option<FlowLayer>,
    /// Share of the pore fluid in what flows in, between 0 and 1, for phases that are `two`; that of the mixture when absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub porosity: Option<f64>,
}

/// Grains and fluid, or two layers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MixtureOptions {
    /// Density of the grains, or of the lower layer (kg/m³).
    pub grain_density: f64,
    /// Density of the fluid, or of the upper layer (kg/m³).
    #[serde(default = "water")]
    pub fluid_density: f64,
    /// Porosity at the start, between 0 and 1; of no meaning for two layers.
    #[serde(default = "half")]
    pub porosity: f64,
    /// Porosity at the start of bodies whose own is another one, by name, between 0 and 1: for phases that are `two`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub porosities: BTreeMap<String, f64>,
    /// Drag between grains and fluid that move apart, or the permeability of columns.
    #[serde(default)]
    pub drag: InterphaseDrag,
    /// Resistance of the bed to the fluid, of phases that are `two`. Parts of the bed may have another one, see `regions`.
    #[serde(default)]
    pub fluid_resistance: FluidResistanceOptions,
    /// Names of the bodies that are the upper of two layers.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub upper: Vec<String>,
    /// Coefficient of friction between two layers, 0 to 1.
    #[serde(default)]
    pub interface_friction: f64,
}

/// Resistance of the bed to the pore fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "law", rename_all = "kebab-case", deny_unknown_fields)]
pub enum FluidResistanceOptions {
    /// None.
    #[default]
    None,
    /// `3 μ v / h`.
    Laminar {
        /// Viscosity (Pa s), not negative.
        viscosity: f64,
    },
    /// `ρ g n² v² / h^⅓`.
    Manning {
        /// Manning's coefficient (s/m^⅓), not negative.
        coefficient: f64,
    },
    /// `ρ g v² / ξ`.
    Turbulent {
        /// Coefficient `ξ` (m/s²), > 0.
        turbulence: f64,
    },
}

/// Columns of excess pore pressure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ColumnOptions {
    /// Intervals over the depth, 4 to 1000.
    #[serde(default = "default_column_cells")]
    pub cells: usize,
    /// Weight of the new time level: 1 is backward Euler, 0.5 Crank–Nicolson.
    #[serde(default = "one")]
    pub weight: f64,
    /// How a column carries its pressure.
    #[serde(default)]
    pub profile: PressureProfile,
    /// Coefficient of consolidation (m²/s), not negative; 0 without drainage. Give this or `skeleton`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub consolidation: Option<f64>,
    /// Stiffness of the skeleton, which with the permeability of the drag law gives the coefficient of consolidation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub skeleton: Option<SkeletonOptions>,
    /// How low the pressure may fall.
    #[serde(default)]
    pub lower_bound: LowerBound,
    /// Excess pressure at the base over that of full liquefaction, at the start; 0 to 1, linear over the depth.
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
    /// State of stress.
    #[serde(default)]
    pub confinement: SkeletonConfinement,
}

/// The factor `α` of the state of stress.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
#[schemars(rename = "DepthConfinement")]
pub enum SkeletonConfinement {
    /// No lateral strain: `α = (1 + 2 k₀)/3`, `k₀ = ν/(1 - ν)`.
    #[default]
    OneDimensional,
    /// No lateral strain with a coefficient of its own: `α = (1 + 2 k₀)/3`.
    Lateral {
        /// Coefficient of lateral stress `k₀`, not negative.
        k0: f64,
    },
    /// Equal stress: `α = 1`.
    Isotropic,
    /// As the source prints it: `α = k₀`.
    Source {
        /// Coefficient of lateral stress `k₀`, > 0.
        k0: f64,
    },
    /// A value.
    Value {
        /// `α`, > 0.
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
    /// Slope, not negative.
    pub slope: f64,
    /// Porosity at which shear changes no volume, between 0 and 1.
    pub critical_porosity: f64,
}

/// Savage–Hutter's earth pressure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EarthPressureOptions {
    /// Internal friction angle (degrees), 0 to 90 (excluded), not below the basal one.
    pub internal_friction_angle: f64,
    /// Friction angle at the bed (degrees).
    pub basal_friction_angle: f64,
}

/// When a flow counts as stopped.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct StopOptions {
    /// Speed below which a node rests (m/s).
    pub speed: f64,
    /// Share of the volume that must rest.
    pub share: f64,
    /// Kinetic energy over its largest value that must be fallen below.
    pub kinetic_ratio: f64,
    /// Time for which all of it must hold (s).
    pub hold: f64,
}

impl Default for StopOptions {
    fn default() -> Self {
        Self { speed: 0.05, share: 0.99, kinetic_ratio: 0.01, hold: 1.0 }
    }
}

const fn default_true() -> bool {
    true
}
#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks with a reference")]
const fn is_false(value: &bool) -> bool {
    !*value
}
const fn default_passes() -> usize {
    2
}
const fn default_column_cells() -> usize {
    20
}
const fn default_smoothing_passes() -> usize {
    1
}

const fn one() -> f64 {
    1.0
}
const fn half() -> f64 {
    0.4
}
const fn water() -> f64 {
    1000.0
}
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
    fn options_need_a_spacing_and_refuse_strangers() {
        let options: DepthOptions = serde_json::from_str(r#"{ "spacing": 0.5 }"#).unwrap();
        assert_eq!((options.smoothing_ratio(1), options.smoothing_ratio(2)), (1.5, 1.3));
        assert!(options.validate().is_ok());
        assert!(serde_json::from_str::<DepthOptions>(r#"{ "spacing": 0.5, "courants": 1 }"#).is_err());
    }
}
