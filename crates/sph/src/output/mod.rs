//! Values that a run writes beside the particles: measures, energy and diagnostics.
//!
//! The room reads the solver and changes nothing.

pub(crate) mod diagnostics;
pub(crate) mod report;
