//! Raster files: ESRI ASCII grids and GeoTIFFs, with world files and bands.
//!
//! A file becomes a `colluvium_points::Raster`. Missing values must be declared by the file.

pub(crate) mod ascii_grid;
pub(crate) mod geotiff;
pub(crate) mod world_file;
