//! Walls, membranes and periodic cells, and the control of their stress or strain.
//!
//! This module reads forces on walls and moves the walls (sheet: dem §2.6).

pub(crate) mod body_force;
pub(crate) mod boundary_conditions;
pub(crate) mod cell_control;
pub(crate) mod controlled_cell;
pub(crate) mod membranes;
pub mod periodic_cell;
pub(crate) mod walls;
