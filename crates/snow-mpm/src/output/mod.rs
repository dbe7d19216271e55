//! Values that a run writes besides the points: energy balance, hazard rasters, measures.
//!
//! The module reads the solver and changes nothing.

pub(crate) mod energy_balance;
pub(crate) mod hazard_rasters;
