//! Particles of the bodies: columns of their state, rigid bodies, small vector algebra.
//!
//! All other modules read them.

pub(crate) mod body_loads;
pub(crate) mod packed_particles;
pub(crate) mod particles;
pub(crate) mod rigid_body;
pub(crate) mod vector_algebra;
