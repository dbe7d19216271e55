//! Searches for neighbours: cell lists, Verlet lists, overlapping boxes, connected groups.
//!
//! Neighbours come in ascending order, whatever the number of threads.
//! This folder depends on coordinates only.

pub(crate) mod box_overlaps;
pub(crate) mod neighbours;
pub(crate) mod union_find;
