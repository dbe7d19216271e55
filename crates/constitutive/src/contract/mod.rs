//! Contract between solvers and laws: motion of a step, state of a point, stress update, tangent, errors.
//!
//! Solvers depend on this module, laws implement it.

pub mod component_arrays;
pub(crate) mod elasticity;
pub(crate) mod error;
pub(crate) mod interface;
pub(crate) mod material;
pub(crate) mod maybe_infinite;
pub(crate) mod motion;
pub(crate) mod parameter_checks;
pub(crate) mod stress_update;
pub(crate) mod tangent;
pub(crate) mod warning;
