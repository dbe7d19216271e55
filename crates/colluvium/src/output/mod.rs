//! Pictures of runs: rigid geometry, snapshots, maps and animations from the files of a run.

#[cfg(feature = "reports")]
pub mod animation;
pub(crate) mod closed_surface;
#[cfg(feature = "reports")]
pub mod raster_maps;
#[cfg(feature = "reports")]
pub mod rigid_geometry;
#[cfg(feature = "reports")]
pub mod run_pictures;
