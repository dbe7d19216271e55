//! Contract between solvers and laws: motion of a step, state of a point, stress update, parameters of a case.
//!
//! Solvers depend on this module, laws implement it.

pub mod component_arrays;
pub(crate) mod interface;
pub(crate) mod material;
pub(crate) mod maybe_infinite;
pub(crate) mod model;
pub(crate) mod motion;
pub(crate) mod spec;
pub(crate) mod stress_update;
