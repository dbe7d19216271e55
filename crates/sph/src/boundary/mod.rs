//! Walls along an axis: image particles, mirrored and extrapolated stresses, friction.
//!
//! The module reads the case and the particles near a wall (sheet: sph §2.8).

pub(crate) mod build;
pub(crate) mod delayed_friction;
pub(crate) mod extrapolated_walls;
pub(crate) mod flat_wall;
pub(crate) mod flat_walls;
pub(crate) mod image_particle;
pub(crate) mod walls;
