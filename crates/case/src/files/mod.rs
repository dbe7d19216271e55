//! Formats of files: JSON with paths of errors, tables of columns, units, checksums.
//!
//! The folder knows formats and units, no case.

pub mod checksum;
pub mod column_file;
pub(crate) mod decimal_sum;
pub(crate) mod finite_numbers;
pub mod json;
pub mod piecewise_linear;
pub(crate) mod terrain_files;
pub(crate) mod units;
