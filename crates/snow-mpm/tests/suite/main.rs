//! Tests of the whole solver, through case files.

mod bodies;
mod cuts;
mod input;
mod motion;
mod obstacles;
mod periodic;
mod rasters;
mod same;
mod sweeps;
