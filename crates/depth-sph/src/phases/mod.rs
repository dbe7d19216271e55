//! Phases of the flow: solid and fluid nodes, or two layers, each a set of nodes with its neighbour lists (sheet: depth-sph §2.5).
//!
//! The folder finds heights, smoothing lengths and depths, and checks the nodes (sheet: depth-sph §3.4, steps 1 and 2).

pub(crate) mod depths;
pub(crate) mod failure;
pub(crate) mod limits;
pub(crate) mod node_checks;
pub(crate) mod phase;
pub(crate) mod thickness;
