//! Files of a case: JSON with paths of errors, tables of columns, units, and coordinates of the map.
//!
//! The folder knows formats and units, no method.

pub(crate) mod case_file;
pub mod column_file;
pub(crate) mod decimal_sum;
pub mod json;
pub(crate) mod map_coordinates;
pub mod piecewise_linear;
pub(crate) mod units;
