//! Searches on surfaces: the nearest place, the contact of a sphere, and the first place that a path meets.

pub(crate) mod bounding_volume_tree;
pub(crate) mod contact_query;
pub(crate) mod nearest_on_facet;
pub(crate) mod path_intersection;
pub(crate) mod triangle_intersection;
