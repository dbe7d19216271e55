//! Obstacles: faces of rigid geometry, smooth bodies, thin obstacles, penetration limits.
//!
//! The module reads particles near a surface and returns stresses, velocities and forces there (sheet: sph §2.8).

pub(crate) mod obstacle_faces;
pub(crate) mod penetration_limit;
pub(crate) mod smooth_bodies;
pub(crate) mod thin_obstacles;
