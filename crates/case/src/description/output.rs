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
    /// Time between rows of the measures (s), at which steps end too. When absent there is a row about every hundredth of the
    /// whole run, after the first step that has got there, and no step is shortened for it.
    pub measures: Option<f64>,
    /// Cell size (m) of a regular grid over the domain on which every frame is averaged as well: density in space, and averages
    /// of the fields weighted with mass, for iso-surfaces and volume rendering. It should be two points wide or more. dem spreads
    /// grains and contacts by a kernel in their place: density, velocity, stress, and what of it is of velocities.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grid: Option<f64>,
    /// Contacts of grains with every frame: one line each, from centre to centre or from the place on a wall, with force (N, on the
    /// first grain), its parts along and across the normal (N), overlap (m) and whether it is one with a wall; and the bonds that have
    /// broken so far, as points with time (s) and the ids of the two grains; for dem.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub contacts: bool,
    /// Rasters over the plan, written at the end as ESRI ASCII grids and GeoTIFFs with the georeference of the terrain: for
    /// methods that follow a flow over terrain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rasters: Option<Rasters>,
    /// Compression of frames.
    #[serde(skip_serializing_if = "Compression::is_fast")]
    pub compression: Compression,
    /// Wall-clock seconds between checkpoints.
    pub checkpoint: f64,
    /// Fields in the frames; all when absent. Identity, body and extent of each point are always there.
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

/// Compression of frames: all three hold equal numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Compression {
    /// None: files are two to three times as large.
    None,
    /// Level 2 of zlib.
    #[default]
    Fast,
    /// Level 9 of zlib: about five times the time of `fast`, for files that are hardly smaller where numbers have noise.
    Best,
}

impl Compression {
    /// Whether it is [`Compression::Fast`], the default in a case.
    #[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
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

/// Rasters over the plan: largest thickness, velocity and dynamic pressure `ρ |v|²`, time of arrival, and thickness and velocity
/// at the end. They are followed in every step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rasters {
    /// Width of the cells (m); the cells of the terrain's raster when absent, and without one the distance of the nodes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cell: Option<f64>,
    /// Thickness from which on a cell counts as reached (m). Cells that never are hold no data but in the rasters of the end.
    #[serde(default = "default_threshold")]
    pub threshold: f64,
    /// File of the outline of an event that was mapped, in metres: GeoJSON (`.geojson`, `.json`) or a shapefile (`.shp`), from the folder of
    /// the case. Each row of the measures then has the area of cells reached within it (`mapped_hit`, m²), not reached (`mapped_missed`), reached
    /// beyond it (`mapped_beyond`), and `mapped_fit`, the first over the sum of all three: 1 where both are the same.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[serde(rename = "mapped")]
    pub mapped_outline: Option<String>,
}

const fn default_threshold() -> f64 {
    0.05
}

/// Sheet: snow-mpm §3.11.
const fn default_min_points() -> usize {
    20
}

/// A crack through a body, in bins along a line. A bin is cracked where one of its points has failed, and cut where a cut of the body has
/// been and no point is left; points count in the bin in which they were at the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CrackTip {
    /// Name of the body: the weak layer.
    pub body: String,
    /// Name of a scalar field that marks failure: `collapsed` of a weak layer of `cohesive-cam-clay`.
    pub field: String,
    /// A point has failed where the field is at least this.
    #[serde(default = "default_damage")]
    pub threshold: f64,
    /// Whether a point has failed where the field is at most the threshold instead.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub below: bool,
    /// Direction in which the crack runs, of any length.
    pub direction: Vec<f64>,
    /// Where it begins (m): an end of the body. Bins and distances are counted from here.
    pub from: Vec<f64>,
    /// Width of a bin (m), not less than that of a point: a cell of the method's grid.
    pub bin: f64,
}

/// Points that have broken, by a field.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BreakageCriterion {
    /// Name of a field of numbers: `compressive_strength` of `cohesive-cam-clay`, which is zero where it has broken.
    pub field: String,
    /// A point has broken where the field is at most this.
    #[serde(default)]
    pub max: f64,
}

const fn default_damage() -> f64 {
    0.5
}

/// A quantity to follow in time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Measure {
    /// Where the mass ends along an axis (m). Columns of cells stand on the base; those that hold a point, at any height,
    /// counted without a gap from the wall behind the mass, are the connected region, and the front is the farthest end
    /// of a point's domain in it. Points beyond a gap are detached and do not count. Where no column at the wall is
    /// occupied, counting begins at the rearmost that is. With a quantile below 1, the place behind which that fraction
    /// of the mass lies, which stray points do not move. Rigid bodies do not count, unless `bodies` names them.
    Front {
        /// Direction in which the front moves.
        side: Side,
        /// Fraction of the mass behind the front.
        #[serde(default = "default_fraction")]
        quantile: f64,
        /// Width of the columns (m), for a quantile of 1; by default the cells of the method's grid, or two
        /// point widths for a method without a grid.
        #[serde(default)]
        cell: Option<f64>,
        /// Names of the bodies whose points count; all that are not rigid when absent, those that a method holds (`held`)
        /// included.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        bodies: Option<Vec<String>>,
    },
    /// `(front - initial) / initial`, both counted from `origin`; the front is that of the measure `front`.
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
        /// Names of the bodies whose points count; all that are not rigid when absent, those that a method holds (`held`)
        /// included.
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
        /// Names of the bodies whose points count; all that are not rigid when absent, those that a method holds (`held`)
        /// included.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        bodies: Option<Vec<String>>,
    },
    /// Fields averaged over the points within `radius` of a place.
    Probe {
        /// Where (m).
        position: Vec<f64>,
        /// Radius (m).
        radius: f64,
        /// Names of fields.
        fields: Vec<String>,
    },
    /// Length of a crack through a body: columns `NAME`, the end of the part that is cracked or cut away without a gap from where it
    /// begins, and `NAME.farthest`, the end of the farthest part that is (m), as of a crack that has opened ahead.
    CrackTip(CrackTip),
    /// How far a flow has come along the line of an obstacle in the plane, slope, arcs and all (m): the place along it behind which a
    /// fraction of the mass lies, by where each point is nearest to it. Rigid bodies do not count, unless `bodies` names them.
    ArcFront {
        /// Name of the obstacle, a `profile` or a `ground-line`.
        obstacle: String,
        /// Fraction of the mass behind the front; with 1 it is that of the foremost point, with 0.99 stray points do not move it.
        #[serde(default = "default_fraction")]
        quantile: f64,
        /// Length of the line from its beginning to where the front is counted as zero (m).
        #[serde(default)]
        zero: f64,
        /// Names of the bodies whose points count; all that are not rigid when absent, those that a method holds (`held`)
        /// included.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        bodies: Option<Vec<String>>,
    },
    /// Number of pieces into which bodies have broken: columns `NAME.count`, `NAME.largest` and `NAME.second` (kg), and `NAME.loose`,
    /// the mass of pieces that are too small to count (kg). Rigid bodies do not count, unless `bodies` names them.
    Fragments {
        /// Points not farther apart than this (m) hang together: 1 to 1.5 cells of the method's grid.
        link: f64,
        /// Points of the smallest piece that counts.
        #[serde(default = "default_min_points")]
        least: usize,
        /// Broken points, which connect no pieces: points that crumble in a crack bridge it. All points count when absent.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        broken: Option<BreakageCriterion>,
        /// Names of the bodies whose points count; all that are not rigid when absent, those that a method holds (`held`)
        /// included.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        bodies: Option<Vec<String>>,
    },
    /// Depth of a flow over a place in plan (m), along the vertical, and its velocity in plan (m/s): columns `NAME.depth`,
    /// `NAME.velocity.x`, …; no velocity where it is dry. For methods that follow a flow over terrain.
    Gauge {
        /// Where, without the coordinate of height (m).
        position: Vec<f64>,
    },
    /// Volume of a flow that crosses a line in plan per time (m³/s), positive to the right of who walks from one end to the
    /// other. In 3D, for methods that follow a flow over terrain.
    Discharge {
        /// Where the line begins (m).
        from: [f64; 2],
        /// Where it ends (m).
        to: [f64; 2],
    },
    /// Force of the material on a rigid body, a patch or an obstacle (N; per metre in plane strain, per radian in axisymmetry): in
    /// the last step, and its impulse since the start (N s), whose slope is the mean force: columns `NAME.x`, `NAME.impulse.x`, ….
    Reaction {
        /// Name of the rigid body, patch or obstacle.
        target: String,
        /// Reference point (m) of the moment of the force of the last step, output too (N m; in plane strain N m per metre, anticlockwise):
        /// columns `NAME.moment.x`, …, in the plane `NAME.moment`. Of obstacles, in the plane and in space.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        about: Vec<f64>,
    },
    /// Pressure of the material on a rigid body, a patch or an obstacle (Pa): the component of the force of the last step along a
    /// direction over an area; and in the column `NAME.impulse` (Pa s) that of its impulse since the start, whose slope is the mean
    /// pressure.
    ImpactPressure {
        /// Name of the rigid body, patch or obstacle.
        target: String,
        /// Direction of the force component, a vector of any length.
        direction: Vec<f64>,
        /// Area that the force is taken over (m²; in plane strain a length, in m), as that of the obstacle across the flow.
        area: f64,
    },
    /// Energy that the materials have dissipated since the start (J; per metre in plane strain, per radian in
    /// axisymmetry): the work of their stresses less what they store. A law that stores no energy that can be told
    /// counts all work as dissipated.
    Dissipation {},
    /// The factor by which strength may be divided before the bodies no longer come to rest, by trials from
    /// the state at the end of a stage. Found after the run.
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
