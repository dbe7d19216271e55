//! Tests of the laws against the reference values of the sheets, closed forms, and the contract of every law.

mod bad_input;
mod basal;
mod cohesive_cam_clay;
mod cohesive_cam_clay_plane;
mod contract;
mod critical_state;
mod driver;
mod finite_strain;
mod flow;
mod flow_rule;
mod hypoplasticity;
mod initial_state;
mod lanes;
mod localisation;
mod outside;
mod reference_materials;
mod reference_values;
mod sand;
mod snow;
mod snow_paths;
mod softening;
mod source_algorithms;
mod waves;
mod weak_layer;
mod wrappers;
