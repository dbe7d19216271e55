//! Terrain: rasters of heights, smooth surfaces through them, and layers of soil between two of them.
//!
//! A raster keeps its georeference; all coordinates are in metres from its corner.
//! This folder depends on outlines of `plan`. Files are read in `colluvium-terrain`, not here.

pub(crate) mod layer_options;
pub(crate) mod smooth_terrain;
pub(crate) mod terrain_layer;
