//! Forces that act on grains beside contacts: gravity, damping, applied loads.

pub(crate) mod applied_forces;
pub(crate) mod integrate_simd;
pub(crate) mod time_integration;
