//! Verification of the discrete element method with whole solvers.

mod bookkeeping;
mod coarse;
mod collisions;
mod common;
mod input;
mod obstacles;
mod piles;
mod same;
