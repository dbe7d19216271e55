//! Sums over neighbours: kernels, neighbour lists, pair data, gradients and their corrections.
//!
//! The room knows positions, masses and fields, no material law (sheet: sph §2.2, §2.3).

pub(crate) mod corrected_momentum;
pub(crate) mod diffusion;
pub mod kernel;
pub mod operators;
pub(crate) mod pair_data;
pub(crate) mod short_range_repulsion;
pub(crate) mod simd_pairs;
pub(crate) mod velocity_gradient;
pub(crate) mod verlet_lists;
