//! Points and initial state of bodies: files of points, layers over terrain, initial stress, laws at points.
//!
//! The folder reads the description of a body and returns points with their state.

pub(crate) mod arc_layer;
pub(crate) mod initial_stress;
pub mod law_points;
pub(crate) mod plan_region;
pub(crate) mod point_changes;
pub mod point_file;
pub(crate) mod point_sampling;
pub(crate) mod terrain_layers;
