//! Output and measures.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Output files and their times.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Time between frames (s), at which steps end; only the first and last frame when absent.
    pub frames: Option<f64>,
    /// Time between rows of the measures (s), at which steps end. When absent a run has about a hundred rows, without shorter steps.
    pub measures: Option<f64>,
    /// Cell size (m) of a regular grid of averages in every frame, for iso-surfaces and volume rendering; best two point widths or more. It
    /// has density, and mass-weighted fields; dem averages density, velocity and stress by a kernel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grid: Option<f64>,
    /// Grain contacts in every frame; for dem. Lines between centres, or from a wall, have force (N, on the first grain), normal and
    /// tangential parts (N), overlap (m) and whether with a wall. Broken bonds are points with time (s) and both ids.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub contacts: bool,
    /// Rasters in plan at the end (ESRI ASCII grid and GeoTIFF), with the terrain's georeference; for flows over terrain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rasters: Option<Rasters>,
    /// Compression of frames.
    #[serde(skip_serializing_if = "Compression::is_fast")]
    pub compression: Compression,
    /// Wall-clock seconds between checkpoints.
    pub checkpoint: f64,
    /// Fields in the frames; all when absent. Identity, body and extent are always written.
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

/// Lossless compression of frames.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Compression {
    /// None: files are two to three times as large.
    None,
    /// Level 2 of zlib.
    #[default]
    Fast,
    /// Level 9 of zlib: five times the time of `fast`, for hardly smaller files where numbers have noise.
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

/// Rasters in plan: largest thickness, velocity and dynamic pressure `ρ |v|²`, time of arrival, final thickness and velocity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Rasters {
    /// Cell width (m); the terrain raster's when absent, else the distance of nodes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cell: Option<f64>,
    /// Thickness (m) from which a cell counts as reached; others have no data, except in final rasters.
    #[serde(default = "default_threshold")]
    pub threshold: f64,
    /// Mapped outline of an event, in metres: GeoJSON (`.geojson`, `.json`) or shapefile (`.shp`), from the case's folder. Measures then
    /// have the areas (m²) reached within it (`mapped_hit`), not reached (`mapped_missed`) and reached beyond it (`mapped_beyond`).
    /// `mapped_fit` is the first over the sum of all three, at best 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[serde(rename = "mapped")]
    pub mapped_outline: Option<String>,
}

/// Default threshold of a measure: 0.05.
const fn default_threshold() -> f64 {
    0.05
}
