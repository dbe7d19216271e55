//! Outline files: polygons in GeoJSON and shapefiles.
//!
//! Coordinates are checked against the reference system of the terrain.

pub(crate) mod outline_files;
