//! Output of a run beside the particles: measures, energy and diagnostics.
//!
//! The module reads the solver and changes nothing.

pub(crate) mod diagnostics;
pub(crate) mod report;
