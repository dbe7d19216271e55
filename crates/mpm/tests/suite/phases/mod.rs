//! Saturated bodies.

mod mesh_phases;
mod two_phase;
