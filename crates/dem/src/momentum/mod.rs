//! Motion of grains: gravity, damping, applied forces and time integration.

pub(crate) mod applied_forces;
pub(crate) mod integrate_simd;
pub(crate) mod time_integration;
