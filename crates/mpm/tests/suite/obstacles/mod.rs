//! Obstacles, on the nodes and on the points (docs/theory/mpm.md, obstacles).

mod moving_obstacles;
mod node_obstacles;
pub mod penalty_obstacles;
mod penetration_limit;
mod program_obstacles;
mod reactions;
mod regions;
mod saturated_bodies;
