//! Facets of obstacles in contact with grains.
//!
//! This module reads surfaces of `colluvium-points` and returns contacts.

pub(crate) mod facet;
pub(crate) mod obstacle_facets;
