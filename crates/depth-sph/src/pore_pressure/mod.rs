//! Columns of excess pore pressure over the depth of the flow: loading, drainage, bounds.
//!
//! The module reads depths and writes heads (sheet: depth-sph §2.7).

pub(crate) mod pore_pressure_columns;
pub mod pressure_transfer;
