//! Results of a run: fields of frames, budget of mass, momentum and energy, scalar outputs, warnings on the state.
//!
//! The module reads the whole solver and changes nothing. Only `checkpoint`, which implements the solver interface, may know it.

pub(crate) mod budget;
pub(crate) mod liquid_tension;
pub(crate) mod null_space;
pub(crate) mod scalar_output;
pub(crate) mod snapshot;
