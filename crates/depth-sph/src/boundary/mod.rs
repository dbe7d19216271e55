//! Boundaries in plan: image nodes at walls, open sides and ends.
//!
//! The module reads nodes near a side and adds or removes nodes beyond it (sheet: depth-sph §3.9).

pub(crate) mod image_nodes;
pub(crate) mod open;
