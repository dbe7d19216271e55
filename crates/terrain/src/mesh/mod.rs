//! Files of closed triangle surfaces: STL and OBJ.
//!
//! A surface that is not closed is an error that names the edge.

pub(crate) mod mesh_files;
pub(crate) mod triangulation;
