//! Accelerations and rates of change: loads, body force, confining pressure, sums of pairs, motion of rigid bodies.
//!
//! The module reads stresses and writes accelerations (sheet: sph §2.4).

pub(crate) mod body_force;
pub(crate) mod confining_pressure;
pub(crate) mod external_forces;
pub(crate) mod rate_sums;
pub(crate) mod rigid_motion;
pub(crate) mod shifting;
