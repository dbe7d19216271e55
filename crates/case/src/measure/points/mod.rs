//! Measures of the points, nodes or cells of a frame.

pub(crate) mod arc_front;
pub(crate) mod crack_tip;
pub(crate) mod fragments;
pub(crate) mod front;
pub(crate) mod probe;
pub(crate) mod profile;
pub(crate) mod run_out;
