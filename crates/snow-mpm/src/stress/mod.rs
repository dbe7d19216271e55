//! Deformation of a step and stress at points.
//!
//! The module calls material laws (sheet: snow-mpm §2).

pub(crate) mod step_motion;
