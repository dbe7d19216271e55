//! Material laws on the grid, and liquids.

mod fracture_energy;
mod free_surface;
mod liquid_defaults;
mod liquids_in_tension;
mod materials;
