//! What several benchmarks compute of a run, and closed forms that several compare with.

pub mod bishop;
mod fronts;
pub mod layered;
pub mod log_spiral;
pub mod manufactured;
mod numbers;
pub mod undrained;

pub use fronts::{base_of_moving_mass, connected_front, crest, farthest_connected, mass_quantile_position};
pub use numbers::{MaxOrNan, max_or_nan, mean_and_deviation, regression_slope};
