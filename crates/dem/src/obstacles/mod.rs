//! Facets of obstacles: nearest points of a surface, with distance and normal.
//!
//! This module reads surfaces of `colluvium-points`.

pub(crate) mod facet;
