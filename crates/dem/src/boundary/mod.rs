//! Walls and periodic cells, and the control of their stress or strain.
//!
//! This module reads forces on walls and moves the walls (sheet: dem §2.6).

pub(crate) mod cell_control;
pub mod periodic_cell;
pub(crate) mod wall_servo;
pub(crate) mod walls;
