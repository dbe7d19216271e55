//! Options of a layer on terrain.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Layer thickness: a number (m), raster (m), or attribute (m) of outline features, the last where they overlap. Rasters must cover the
/// outline; zero or no data is no layer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "is neither a number (m), nor the name of a raster's file, nor an attribute")]
pub enum LayerThickness {
    /// Uniform thickness (m).
    Uniform(f64),
    /// File of a raster (m).
    Raster(String),
    /// Attribute of the features of the outline (m).
    Attribute(ThicknessAttribute),
}

/// Attribute of the features with their thickness.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ThicknessAttribute {
    /// GeoJSON property, or field of the shapefile's `.dbf`.
    pub attribute: String,
}

/// Direction of a layer's thickness.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ThicknessDirection {
    /// Vertical direction.
    #[default]
    Vertical,
    /// Normal to the terrain: vertical thickness is that over the cosine of the slope.
    Normal,
}

/// Rows of points in a layer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LayerRows {
    /// Lattice of the method in level rows: the lowest point is up to a spacing above the terrain.
    #[default]
    Level,
    /// Rows along the terrain, as many as spacings fit into the thickness, at least one. Points have their share of it, the lowest half of
    /// that above the terrain. Map layers under a quarter spacing have no points. Along a line, positions are as far apart as spacings fit
    /// into its length.
    Terrain,
}

impl LayerRows {
    /// Whether the rows are level.
    #[allow(clippy::trivially_copy_pass_by_ref, reason = "serde requires a reference")]
    pub(crate) fn are_level(&self) -> bool {
        *self == Self::Level
    }
}
