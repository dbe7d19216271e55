//! Forces that act on grains beside contacts: gravity, damping, applied loads.

pub(crate) mod applied_forces;
