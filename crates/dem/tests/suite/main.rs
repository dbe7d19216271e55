//! Verification of the discrete element method with whole solvers.

mod bookkeeping;
mod coarse;
mod collisions;
mod driven;
mod fabric;
mod followed;
mod input;
mod material;
mod moving;
mod obstacles;
mod options;
mod piles;
mod pressed;
mod rain;
mod regions;
mod restitution;
mod rules;
mod same;
mod single_grains;
mod size;
mod space;
mod specimens;
mod store;
