//! Phases of the flow: solid and fluid nodes, or two layers, with drag and interface friction between them.
//!
//! A phase is a set of nodes with its neighbour lists (sheet: depth-sph §2.5).

pub(crate) mod drag_and_resistance;
pub(crate) mod erosion_and_interface;
pub mod interphase_drag;
pub(crate) mod phase;
pub mod phase_nodes;
