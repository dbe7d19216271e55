//! Material points of a body: columns of their state, blocks for parallel work, update of position and deformation.
//!
//! All other modules read them; `stress` and `transfer` change them.

pub(crate) mod bodies;
pub(crate) mod point_blocks;
pub(crate) mod point_set;
pub(crate) mod point_update;
pub(crate) mod right_stretch;
pub(crate) mod vectors;
