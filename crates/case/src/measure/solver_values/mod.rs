//! Measures that a solver computes: forces, energies and flows.

pub(crate) mod discharge;
pub(crate) mod dissipation;
pub(crate) mod gauge;
pub(crate) mod impact_pressure;
pub(crate) mod reaction;
