//! Smoothed particle hydrodynamics of solids.
//!
//! [`kernel`] holds the smoothing kernels, [`operators`] what they make of a field: gradients and
//! Laplacians on any set of particles.

pub mod kernel;
pub mod operators;
