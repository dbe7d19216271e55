//! Pictures of runs: rigid geometry, snapshots, maps and animations from the files of a run.

pub mod animation;
pub(crate) mod closed_surface;
pub mod raster_maps;
pub mod rigid_geometry;
pub mod run_pictures;
