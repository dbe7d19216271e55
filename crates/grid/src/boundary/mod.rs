//! Walls on grid nodes: faces, edges and corners of several walls; wrapping of points in periodic domains.
//!
//! A wall prescribes components of the nodal velocity. The module depends on no material.

pub(crate) mod periodic_wrap;
pub(crate) mod walls;
