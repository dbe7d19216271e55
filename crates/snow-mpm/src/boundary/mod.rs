//! Walls across an axis, as conditions on nodal velocities.

pub(crate) mod walls;
