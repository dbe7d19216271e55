//! Options of a layer on terrain.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How thick a layer is: a number (m), the file of a raster in metres (ESRI ASCII grid or GeoTIFF, from the folder of the
/// case), or the name of an attribute (m) that each feature of the outline's file has; where features overlap that of the last one in the
/// file counts. Where a raster is zero or has no data, as that of a
/// deposit has none where it is dry, there is nothing; it must reach as far as the outline, where there is one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "is neither a number (m), nor the name of a raster's file, nor an attribute")]
pub enum LayerThickness {
    /// Uniform thickness (m).
    Uniform(f64),
    /// File of a raster (m).
    Raster(String),
    /// As the features of the outline have it.
    Attribute(ThicknessAttribute),
}

/// Attribute of the features of an outline whose value is their thickness.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ThicknessAttribute {
    /// Property of GeoJSON, or field of the `.dbf` beside a shapefile.
    pub attribute: String,
}

/// Along what the thickness of a layer is measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ThicknessDirection {
    /// Vertically.
    #[default]
    Vertical,
    /// Normal to the terrain: the vertical thickness is larger by one over the cosine of its slope.
    Normal,
}

/// How points lie in a layer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LayerRows {
    /// On the lattice of the method, in level rows: the lowest of a place lies anywhere up to a spacing above the terrain.
    #[default]
    Level,
    /// In rows that follow the terrain, as many over a place as spacings fit into its thickness, and one at least: each stands for its
    /// share of the thickness, the lowest half of that above the terrain. Where a layer on a map is thinner than a quarter of a spacing
    /// there are none; along a line places lie as far apart as spacings fit into the length of the layer.
    Terrain,
}

impl LayerRows {
    #[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
    pub(crate) fn are_level(&self) -> bool {
        *self == Self::Level
    }
}
