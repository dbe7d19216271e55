//! Partitions of points into groups of equal weight for domain decomposition.
//!
//! A partition depends on positions and weights only, so that it is the same on every machine.

pub(crate) mod bisection;
