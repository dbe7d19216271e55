//! Stress of particles: updates by the material laws, smoothing, tensile instability, total-Lagrangian formulation.
//!
//! The module calls material laws and writes stresses and states (sheet: sph §2.5).

pub(crate) mod regularisation;
pub(crate) mod stress_update;
pub(crate) mod total_lagrangian;
