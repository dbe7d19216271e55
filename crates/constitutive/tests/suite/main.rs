//! Tests of the laws against the reference values of the sheets, closed forms, and the contract of every law.

mod bad_input;
mod basal_laws;
mod batches;
mod cohesive_cam_clay;
mod cohesive_cam_clay_plane;
mod constructors;
mod contract;
mod critical_state;
mod driver;
mod external_laws;
mod finite_strain;
mod flow_laws;
mod flow_rule;
mod hypoplasticity;
mod initial_state;
mod localisation;
mod reference_materials;
mod reference_values;
mod sand_finite_strain;
mod snow;
mod snow_paths;
mod softening;
mod source_algorithms;
mod wave_modulus;
mod weak_layer;
mod wrappers;
