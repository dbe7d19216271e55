//! Pictures of frames: points, contacts and rigid geometry in a plane.

pub(crate) mod animated_gif;
pub(crate) mod force_chains;
pub(crate) mod frame_picture;
pub(crate) mod point_cloud;
pub(crate) mod rigid_geometry;
pub(crate) mod terrain_map;
