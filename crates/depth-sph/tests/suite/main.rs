//! Runs and parts of the method against closed forms, conservation, and reproducibility of bits.

mod cases;
mod dam_breaks;
mod flow_runs;
mod gauges;
mod hand_over;
mod inflow;
mod inflow_layers;
mod inflow_lines;
mod mapped;
mod open_ends;
mod open_sides;
mod orders;
mod parts;
mod pore_fluid;
mod scour;
mod small_waves;
mod terrain;
mod variational;
