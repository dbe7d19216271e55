//! Walls on grid nodes: faces, edges and corners of several walls.
//!
//! A wall prescribes components of the nodal velocity. The module depends on no point and no material.

pub(crate) mod walls;
