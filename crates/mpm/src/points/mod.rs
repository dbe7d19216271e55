//! Material points of the bodies: columns of their state, and blocks for parallel work.
//!
//! The module holds all data of a point, those of its pore fluid, its loads and its contact with obstacles among them. It knows the
//! background grid, by whose cells points are sorted, and no physics. All other modules read points; `obstacles`, `stress`, `boundary` and
//! `transfer` change them.

pub(crate) mod bodies;
pub(crate) mod penalty_state;
pub(crate) mod point_blocks;
pub(crate) mod point_set;
pub(crate) mod pore_contact_state;
pub(crate) mod pore_fluid;
pub(crate) mod right_stretch;
pub(crate) mod surface_load;
pub(crate) mod vectors;
