//! What several benchmarks compute of a run, and closed forms that several compare with.

pub mod bishop;
mod fronts;
pub mod layered;
pub mod log_spiral;
pub mod manufactured;
mod numbers;
pub mod undrained;

pub use fronts::{crest, farthest_held, held_front, lower_boundary, reach_of};
pub use numbers::{Largest, larger, scatter, slope};
