//! Flat walls along an axis, mirrors and periodic boundaries, with the images of particles in them.
//!
//! The module reads the case and the particles near a wall (sheet: sph §2.8).

pub(crate) mod build;
pub(crate) mod flat_wall;
pub(crate) mod flat_walls;
pub(crate) mod image_particle;
