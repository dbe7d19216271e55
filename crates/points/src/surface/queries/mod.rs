//! Queries of surfaces: nearest points, contacts of balls, and intersections of paths.

pub(crate) mod bounding_volume_tree;
pub(crate) mod contact_query;
pub(crate) mod nearest_on_facet;
pub(crate) mod path_intersection;
pub(crate) mod triangle_intersection;
