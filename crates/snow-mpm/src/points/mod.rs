//! Material points of the bodies: columns of their state.
//!
//! All other modules read them.

pub(crate) mod bodies;
pub(crate) mod step_bound;
pub(crate) mod vectors;
