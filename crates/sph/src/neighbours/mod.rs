//! Neighbour search: Verlet lists with a margin, rebuilt when particles have moved.

pub(crate) mod verlet_lists;
