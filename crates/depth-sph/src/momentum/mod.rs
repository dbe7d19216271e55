//! Accelerations of nodes: depth pressures, bed resistance, drift on curved terrain, time integration.
//!
//! The module reads thickness and bed and writes velocities (sheet: depth-sph §2.3, §3.3).

mod accelerations;
mod artificial_viscosity;
pub(crate) mod curved_drift;
mod depth_pressures;
mod drag_and_resistance;
pub(crate) mod effective_gravity;
pub(crate) mod entrainment;
mod force_sums;
mod interface_friction;
mod pair_forces;
mod resistance;
mod runge_kutta;
mod set_accelerations;
mod steep_terrain;
mod thickness_rates;
pub(crate) mod time_integration;
mod velocities;
