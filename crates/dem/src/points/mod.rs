//! Grains: columns of position, velocity, spin, radius and mass, and small vector algebra.
//!
//! Every other module reads them.

pub(crate) mod grain_extremes;
pub(crate) mod grains;
pub(crate) mod vector;
