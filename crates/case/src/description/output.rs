//! Output and measures.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{FactorOfSafety, Side, default_fraction};

/// Output files and their times.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Time between frames (s); none when absent, except the first and the last. Steps are shortened so that they end at
    /// the time of an output.
    pub frames: Option<f64>,
    /// Time between rows of the measures (s), at which steps end too. When absent there is a row about every hundredth of the whole run,
    /// after the first step that reaches its time, and no step is shortened for it.
    pub measures: Option<f64>,
    /// Cell size (m) of a regular grid over the domain for averages of every frame: density in space, and averages of the fields weighted
    /// with mass, for iso-surfaces and volume rendering. It should be two points wide or more. dem instead distributes grains and
    /// contacts by a kernel: density, velocity, stress, and the part of it from velocities.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grid: Option<f64>,
    /// Contacts of grains with every frame; for dem. Each contact is one line, from centre to centre or from the point on a wall, with
    /// force (N, on the first grain), its normal and tangential parts (N), overlap (m) and whether it is one with a wall. Bonds broken so
    /// far are points with time (s) and the ids of the two grains.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub contacts: bool,
    /// Rasters over the plan, written at the end as ESRI ASCII grids and GeoTIFFs with the georeference of the terrain; for methods that
    /// compute a flow over terrain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rasters: Option<Rasters>,
    /// Compression of frames.
    #[serde(skip_serializing_if = "Compression::is_fast")]
    pub compression: Compression,
    /// Wall-clock seconds between checkpoints.
    pub checkpoint: f64,
    /// Fields in the frames; all when absent. Identity, body and extent of each point are always written.
    pub fields: Option<Vec<String>>,
}

impl Default for Output {
    fn default() -> Self {
        Self {
            frames: None,
            measures: None,
            grid: None,
            contacts: false,
            rasters: None,
            compression: Compression::Fast,
            checkpoint: 60.0,
            fields: None,
        }
    }
}

/// Compression of frames; all three contain equal numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Compression {
    /// No compression: files are two to three times as large.
    None,
    /// Level 2 of zlib.
    #[default]
    Fast,
    /// Level 9 of zlib: about five times the time of `fast`, for files that are hardly smaller where numbers have noise.
    Best,
}

impl Compression {
    /// Whether it is [`Compression::Fast`], the default in a case.
    #[allow(clippy::trivially_copy_pass_by_ref, reason = "serde requires a reference")]
    fn is_fast(&self) -> bool {
        *self == Self::Fast
    }

    /// Compression level of zlib; zero without compression.
    #[must_use]
    pub fn level(self) -> u32 {
        match self {
            Self::None => 0,
            // A fifth of the time of level 5 at 1.01 times its size; level 1 makes files 1.15 times as large.
            Self::Fast => 2,
            Self::Best => 9,
        }
    }
}

/// Rasters over the plan: largest thickness, velocity and dynamic pressure `ρ |v|²`, time of arrival, and thickness and velocity at the
/// end. They are updated in every step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rasters {
    /// Width of the cells (m); when absent, that of the cells of the terrain raster, and without a raster the distance of the nodes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cell: Option<f64>,
    /// Thickness from which a cell counts as reached (m). Cells never reached have no data, except in the rasters of the end.
    #[serde(default = "default_threshold")]
    pub threshold: f64,
    /// File with the mapped outline of an event, in metres: GeoJSON (`.geojson`, `.json`) or a shapefile (`.shp`), from the folder of the
    /// case. Each row of the measures then has the area of cells reached within it (`mapped_hit`, m²), not reached (`mapped_missed`),
    /// reached beyond it (`mapped_beyond`), and `mapped_fit`, the first over the sum of all three: 1 where both are equal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[serde(rename = "mapped")]
    pub mapped_outline: Option<String>,
}

/// Default threshold of a measure: 0.05.
const fn default_threshold() -> f64 {
    0.05
}

/// Sheet: snow-mpm §3.11.
const fn default_min_points() -> usize {
    20
}

/// Crack through a body, in bins along a line. A bin is cracked where one of its points has failed. It is cut where the body has been cut
/// and no point is left. Points count in the bin of their initial position.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CrackTip {
    /// Name of the body, the weak layer.
    pub body: String,
    /// Name of a scalar field that marks failure: `collapsed` of a weak layer of `cohesive-cam-clay`.
    pub field: String,
    /// Threshold of failure: a point has failed where the field is at least this.
    #[serde(default = "default_damage")]
    pub threshold: f64,
    /// Whether a point has failed where the field is at most the threshold instead.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub below: bool,
    /// Direction in which the crack propagates, of any length.
    pub direction: Vec<f64>,
    /// Origin of bins and distances (m): the end of the body at which the crack begins.
    pub from: Vec<f64>,
    /// Width of a bin (m), not less than that of a point: a cell of the grid of the method.
    pub bin: f64,
}

/// Criterion for broken points, by a field.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BreakageCriterion {
    /// Name of a field of numbers: `compressive_strength` of `cohesive-cam-clay`, which is zero where the material has broken.
    pub field: String,
    /// Upper bound of the field at a broken point.
    #[serde(default)]
    pub max: f64,
}

/// Default damage at which a point counts as broken: 0.5.
const fn default_damage() -> f64 {
    0.5
}

/// Quantity recorded in time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Measure {
    /// Front of the mass along an axis (m). Columns of cells start at the base; those with a point at any height, counted without a gap
    /// from the wall behind the mass, are the connected region, and the front is the farthest end of a point domain in it. Points beyond
    /// a gap are detached and do not count. Where no column at the wall is occupied, counting begins at the rearmost occupied column.
    /// With a quantile below 1, the front is the position behind which that fraction of the mass lies, which stray points do not change.
    /// Rigid bodies do not count, unless `bodies` names them.
    Front {
        /// Direction in which the front moves.
        side: Side,
        /// Fraction of the mass behind the front.
        #[serde(default = "default_fraction")]
        quantile: f64,
        /// Width of the columns (m), for a quantile of 1; by default the cells of the grid of the method, or two point widths for a
        /// method without a grid.
        #[serde(default)]
        cell: Option<f64>,
        /// Names of the bodies whose points count; all bodies that are not rigid when absent, including those that a method fixes
        /// (`held`).
        #[serde(default, skip_serializing_if = "Option::is_none")]
        bodies: Option<Vec<String>>,
    },
    /// Relative run-out `(front - initial) / initial`, both measured from `origin`; the front is that of the measure `front`.
    RunOut {
        /// Direction in which the front moves.
        side: Side,
        /// Coordinate of the wall behind the mass (m).
        origin: f64,
        /// Initial length (m).
        initial_length: f64,
        /// Fraction of the mass behind the front.
        #[serde(default = "default_fraction")]
        quantile: f64,
        /// Width of the columns (m), as in `front`.
        #[serde(default)]
        cell: Option<f64>,
        /// Names of the bodies whose points count; all bodies that are not rigid when absent, including those that a method fixes
        /// (`held`).
        #[serde(default, skip_serializing_if = "Option::is_none")]
        bodies: Option<Vec<String>>,
    },
    /// Height of the surface in bins along an axis, written at each frame. Rigid bodies do not count, unless `bodies` names
    /// them.
    Profile {
        /// Axis along which the bins lie: 0 is x.
        axis: usize,
        /// Axis of height.
        height: usize,
        /// Width of a bin (m).
        bin: f64,
        /// Names of the bodies whose points count; all bodies that are not rigid when absent, including those that a method fixes
        /// (`held`).
        #[serde(default, skip_serializing_if = "Option::is_none")]
        bodies: Option<Vec<String>>,
    },
    /// Fields averaged over the points within `radius` of a position.
    Probe {
        /// Position of the probe (m).
        position: Vec<f64>,
        /// Radius of the probe (m).
        radius: f64,
        /// Names of fields.
        fields: Vec<String>,
    },
    /// Length of a crack through a body (m): columns `NAME`, the end of the part that is cracked or cut without a gap from the origin,
    /// and `NAME.farthest`, the end of the farthest cracked or cut part, as of a crack that has opened ahead.
    CrackTip(CrackTip),
    /// Front of a flow along the line of an obstacle in the plane, slope, arcs and all (m): the position on the line behind which a
    /// fraction of the mass lies, each point at its nearest position on the line. Rigid bodies do not count, unless `bodies` names them.
    ArcFront {
        /// Name of the obstacle, a `profile` or a `ground-line`.
        obstacle: String,
        /// Fraction of the mass behind the front: 1 gives the foremost point, and with 0.99 stray points do not change the front.
        #[serde(default = "default_fraction")]
        quantile: f64,
        /// Length of the line from its beginning to the zero of the front (m).
        #[serde(default)]
        zero: f64,
        /// Names of the bodies whose points count; all bodies that are not rigid when absent, including those that a method fixes
        /// (`held`).
        #[serde(default, skip_serializing_if = "Option::is_none")]
        bodies: Option<Vec<String>>,
    },
    /// Number of fragments of broken bodies: columns `NAME.count`, `NAME.largest` and `NAME.second` (kg), and `NAME.loose`, the mass of
    /// fragments too small to count (kg). Rigid bodies do not count, unless `bodies` names them.
    Fragments {
        /// Largest distance of connected points (m): 1 to 1.5 cells of the grid of the method.
        link: f64,
        /// Number of points of the smallest fragment that counts.
        #[serde(default = "default_min_points")]
        least: usize,
        /// Criterion for broken points, which connect no fragments: crumbled points in a crack would bridge it. All points count when
        /// absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        broken: Option<BreakageCriterion>,
        /// Names of the bodies whose points count; all bodies that are not rigid when absent, including those that a method fixes
        /// (`held`).
        #[serde(default, skip_serializing_if = "Option::is_none")]
        bodies: Option<Vec<String>>,
    },
    /// Depth of a flow at a position in plan (m), along the vertical, and its velocity in plan (m/s): columns `NAME.depth`,
    /// `NAME.velocity.x`, …; no velocity where it is dry. For methods that compute a flow over terrain.
    Gauge {
        /// Position of the gauge (m), without the coordinate of height.
        position: Vec<f64>,
    },
    /// Discharge of a flow across a line in plan (m³/s), positive to the right, seen along the line from `from` to `to`. In 3D, for
    /// methods that compute a flow over terrain.
    Discharge {
        /// First end of the line (m).
        from: [f64; 2],
        /// Second end of the line (m).
        to: [f64; 2],
    },
    /// Force of the material on a rigid body, a patch or an obstacle in the last step (N; per metre in plane strain, per radian in
    /// axisymmetry), and its impulse since the start (N s), whose slope is the mean force: columns `NAME.x`, `NAME.impulse.x`, ….
    Reaction {
        /// Name of the rigid body, patch or obstacle.
        target: String,
        /// Reference point (m) of the moment of the force of the last step, also written (N m; in plane strain N m per metre,
        /// anticlockwise): columns `NAME.moment.x`, …, in the plane `NAME.moment`. For obstacles, in the plane and in space.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        about: Vec<f64>,
    },
    /// Pressure of the material on a rigid body, a patch or an obstacle (Pa): the component of the force of the last step along a
    /// direction, divided by an area. The column `NAME.impulse` (Pa s) is that of its impulse since the start, whose slope is the mean
    /// pressure.
    ImpactPressure {
        /// Name of the rigid body, patch or obstacle.
        target: String,
        /// Direction of the force component, a vector of any length.
        direction: Vec<f64>,
        /// Area by which the force is divided (m²; in plane strain a length, in m), for example that of the obstacle across the flow.
        area: f64,
    },
    /// Energy dissipated by the materials since the start (J; per metre in plane strain, per radian in axisymmetry): the work of their
    /// stresses minus the stored energy. For a law without a defined stored energy, all work counts as dissipated.
    Dissipation {},
    /// Factor of safety: the factor by which strength may be divided before the bodies no longer come to rest, by trials from the state
    /// at the end of a stage. Computed after the run.
    FactorOfSafety(FactorOfSafety),
}

impl Measure {
    /// Name of the rigid body, patch or obstacle on which the force of the material is measured.
    pub fn reaction_target(&self) -> Option<&str> {
        match self {
            Self::Reaction { target: of, .. } | Self::ImpactPressure { target: of, .. } => Some(of),
            _ => None,
        }
    }
}
