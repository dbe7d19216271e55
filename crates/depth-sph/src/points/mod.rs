//! Nodes of a phase, walls and periods of the plan, and the images of nodes there (sheet: depth-sph §3.1, §3.9).

pub mod image_nodes;
pub mod phase_nodes;

/// Least number of nodes per task.
pub const MIN_NODES_PER_TASK: usize = 256;
