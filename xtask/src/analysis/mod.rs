//! Evaluations of runs, and closed forms, that several benchmarks share.

pub mod bishop_circle;
pub mod bishop_layered;
pub mod log_spiral;
pub mod manufactured_solution;
mod runout;
mod statistics;
pub mod undrained_slope;

pub use crate::analysis::runout::{
    base_of_moving_mass, connected_front, crest, farthest_connected, mass_quantile_position,
};
pub use crate::analysis::statistics::{MaxOrNan, max_or_nan, mean_and_deviation, regression_slope};
