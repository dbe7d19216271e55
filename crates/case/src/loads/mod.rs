//! Loads on bodies: ramps in time, damping, load vectors of points.
//!
//! Forces are in N, pressures in Pa with compression positive.

pub mod damping;
pub mod load_vectors;
pub(crate) mod time_ramps;
