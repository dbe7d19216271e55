//! Tests of the whole solver, through case files.

mod affine_transfers;
mod bad_input;
mod bodies;
mod determinism;
mod examples;
mod hazard_rasters;
mod motion;
mod obstacles;
mod periodic_domain;
mod point_changes;
mod program;
mod program_obstacles;
mod removal_shapes;
