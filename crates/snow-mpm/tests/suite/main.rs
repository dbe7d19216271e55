//! Tests of the whole solver, through case files.

mod common;
mod cuts;
mod input;
mod motion;
mod obstacles;
mod periodic;
mod rasters;
mod same;
mod sweeps;
