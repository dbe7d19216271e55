//! Results of a run: energy balance, gauges, hazard rasters and export of points.
//!
//! The folder reads the flow and changes nothing in it.

pub(crate) mod energy_balance;
pub mod export_points;
pub(crate) mod gauges;
pub mod hazard_rasters;

#[cfg(test)]
pub(crate) mod energy_balance_tests;
