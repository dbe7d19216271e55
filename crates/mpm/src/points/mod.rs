//! Material points of a body: columns of their state, blocks for parallel work, update of position and deformation.
//!
//! All other modules read them; `stress` and `transfer` change them.

pub(crate) mod bodies;
pub(crate) mod penalty_state;
pub(crate) mod point_blocks;
pub(crate) mod point_set;
pub(crate) mod pore_contact_state;
pub(crate) mod pore_fluid;
pub(crate) mod right_stretch;
pub(crate) mod surface_load;
pub(crate) mod vectors;
