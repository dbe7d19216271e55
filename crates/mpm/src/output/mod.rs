//! Values that a run writes beside the points: measures, energy, reasons for the step, diagnostics.
//!
//! The module reads the solver and changes nothing.

pub(crate) mod budget;
pub(crate) mod liquid_tension;
pub(crate) mod null_space;
pub(crate) mod scalar_output;
pub(crate) mod snapshot;
