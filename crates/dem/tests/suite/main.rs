//! Verification of the discrete element method with whole solvers.

mod bad_input;
mod coarse_graining;
mod collisions;
mod conservation;
mod contact_options;
mod controlled_stress;
mod determinism;
mod examples;
mod fabric;
mod granular_cell;
mod measuring_regions;
mod moving_obstacles;
mod obstacles;
mod piles_and_bonds;
mod pluviation;
mod prescribed_loads;
mod problem_size;
mod program;
mod program_motion;
mod restitution;
mod servo_walls;
mod single_grains;
mod specimen_files;
mod specimens;
mod three_dimensions;
mod time_step;
