//! Material points of the bodies: columns of their state.
//!
//! Every other room reads them.

pub(crate) mod bodies;
pub(crate) mod vectors;
