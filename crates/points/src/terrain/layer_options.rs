//! Options of a layer on terrain.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Thickness of a layer: a number (m), the file of a raster in metres (ESRI ASCII grid or GeoTIFF, from the folder of the case), or the
/// name of an attribute (m) of each feature in the file of the outline. Where features overlap, the last one in the file applies. Where a
/// raster is zero or has no data, as that of a deposit outside the deposit, there is no layer. The raster must cover the outline, where
/// there is one.
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

/// Attribute of the features of an outline whose value is their thickness.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ThicknessAttribute {
    /// Property of GeoJSON, or field of the `.dbf` beside a shapefile.
    pub attribute: String,
}

/// Direction in which the thickness of a layer is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ThicknessDirection {
    /// Vertical direction.
    #[default]
    Vertical,
    /// Normal to the terrain: the vertical thickness is larger by a factor of one over the cosine of the slope.
    Normal,
}

/// Arrangement of the points in a layer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LayerRows {
    /// Lattice of the method, in level rows: the lowest point of a position lies anywhere up to a spacing above the terrain.
    #[default]
    Level,
    /// Rows that follow the terrain, as many over a position as spacings fit into its thickness, and at least one. Each point represents
    /// its share of the thickness, the lowest at half of that above the terrain. Where a layer on a map is thinner than a quarter of a
    /// spacing there are no points. Along a line, the positions are as far apart as spacings fit into the length of the layer.
    Terrain,
}

impl LayerRows {
    /// Whether the rows are level.
    #[allow(clippy::trivially_copy_pass_by_ref, reason = "serde requires a reference")]
    pub(crate) fn are_level(&self) -> bool {
        *self == Self::Level
    }
}
