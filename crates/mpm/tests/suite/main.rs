//! The solver and what it stands on, against closed forms, conservation laws and its promises about bits.

mod boundaries;
mod common;
mod consistent;
mod contact;
mod driven;
mod frames;
mod light;
mod loads;
mod loose;
mod materials;
mod mesh;
mod mesh_contact;
mod mesh_phases;
mod moving;
mod obstacle_regions;
mod obstacles;
mod pressing;
mod sampling;
mod saturated_obstacles;
mod shapes;
mod sheets;
mod solver;
mod stopping;
mod tension;
mod transfers;
mod two_phase;
