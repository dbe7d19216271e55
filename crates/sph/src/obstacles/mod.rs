//! Obstacles: mirror particles behind surfaces, thin obstacles, supports of rigid bodies, penetration limits.
//!
//! The module reads particles near a surface and returns stresses, velocities and forces there (sheet: sph §2.8).

pub(crate) mod obstacle_faces;
pub(crate) mod obstacle_mirror;
pub(crate) mod penetration_limit;
pub(crate) mod rigid_support;
pub(crate) mod smooth_bodies;
pub(crate) mod smooth_body_mirror;
pub(crate) mod thin_obstacles;
