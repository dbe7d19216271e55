//! Runs and parts of the method against closed forms, conservation, and reproducibility of bits.

mod bed_zones;
mod cases;
mod dam_breaks;
mod erosion;
mod examples;
mod flow_runs;
mod gauges;
mod hand_over;
mod inflow;
mod inflow_layers;
mod inflow_lines;
mod mapped_outline;
mod open_ends;
mod open_sides;
mod point_changes;
mod pore_fluid;
mod program;
mod restarts;
mod small_waves;
mod step_limit;
mod terrain;
mod time_integration;
mod variational;
