//! Partitions of points into groups of equal weight for domain decomposition.
//!
//! A partition depends on positions and weights only, so that every machine finds the same one.

pub(crate) mod bisection;
