//! Results of a run: snapshots, totals, gauges, hazard rasters and export of points.
//!
//! The folder reads the flow and changes nothing in it.

pub(crate) mod budget;
pub(crate) mod export_points;
pub(crate) mod flow_view;
pub(crate) mod gauges;
pub mod hazard_rasters;
pub(crate) mod scalar_outputs;
pub(crate) mod snapshot;
pub(crate) mod totals;
pub(crate) mod warnings;
