//! State of a grid node: mass, momentum and forces in four lanes.

pub(crate) mod nodal_state;
