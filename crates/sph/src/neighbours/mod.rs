//! Neighbour search: the list of pairs, with a skin, that is made anew when particles have moved.

pub(crate) mod verlet_lists;
