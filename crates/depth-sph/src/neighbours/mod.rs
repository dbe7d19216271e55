//! Sums over neighbours in plan: kernel, cell-sorted nodes, SIMD lists, thickness.
//!
//! The module uses positions and volumes only (sheet: depth-sph §2.2).

pub(crate) mod cell_sorted;
pub mod kernel;
pub(crate) mod max_smoothing_length;
pub(crate) mod search_axes;
pub(crate) mod simd_neighbour_list;
pub(crate) mod thickness;
