//! Output of a run besides the grains: energy balance, fabric, force chains, coarse-grained fields.
//!
//! This module reads grains and contacts and changes nothing.

pub mod coarse_graining;
pub(crate) mod energy_balance;
pub mod fabric;
pub(crate) mod force_chains;
pub mod laguerre_tessellation;
pub(crate) mod measuring_regions;
pub(crate) mod packing_view;
pub(crate) mod records;
pub(crate) mod report;
pub(crate) mod stress_control_check;
pub(crate) mod void_ratio_bands;
