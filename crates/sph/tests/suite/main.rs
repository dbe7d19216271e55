//! Tests of the solver and its parts against closed forms, conservation laws and bitwise reproducibility.

mod artificial_stress;
mod body_interfaces;
mod diagnostics;
mod examples;
mod free_rigid_bodies;
mod liquids;
mod localisation_bands;
mod moving_obstacles;
mod obstacles;
mod operators;
mod point_changes;
mod program;
mod program_bodies;
mod program_errors;
mod program_obstacles;
mod ranks;
mod regularisation;
mod round_edges;
mod smooth_bodies;
mod solver;
mod surface_loads;
mod thin_obstacles;
mod time_integration;
mod total_lagrangian;
mod viscous_flow;
mod walls;
