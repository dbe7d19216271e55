//! Motion of grains and servo-controlled walls: gravity, damping, applied forces and time integration.

pub(crate) mod applied_forces;
pub(crate) mod grain_motion;
pub(crate) mod integrate_simd;
pub(crate) mod time_integration;
pub(crate) mod wall_servo;
