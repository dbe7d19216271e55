//! Accelerations of nodes: depth pressures, bed resistance, drift on curved terrain, time integration.
//!
//! The module reads thickness and bed and writes velocities (sheet: depth-sph §2.3, §3.3).

pub(crate) mod curved_drift;
pub(crate) mod depth_pressures;
pub mod implicit_resistance;
pub(crate) mod pair_forces;
pub(crate) mod steep_terrain;
pub(crate) mod time_integration;
