//! Sums over neighbours in plan: cell-sorted nodes, SIMD lists, averages.
//!
//! The module uses positions and volumes only (sheet: depth-sph §2.2).

pub(crate) mod cell_sorted;
pub(crate) mod kernel_average;
pub(crate) mod kernel_sum;
pub(crate) mod max_smoothing_length;
pub(crate) mod nearby_nodes;
pub(crate) mod search_axes;
pub(crate) mod simd_neighbour_list;
