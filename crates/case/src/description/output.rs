//! Output and measures.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

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

impl Default for Rasters {
    fn default() -> Self {
        Self { cell: None, threshold: default_threshold(), mapped_outline: None }
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
