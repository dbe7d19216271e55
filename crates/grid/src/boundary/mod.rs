//! Walls on grid nodes: faces, edges and corners where walls meet.
//!
//! A wall removes components of a nodal velocity. The room depends on no point and no material.

pub(crate) mod walls;
