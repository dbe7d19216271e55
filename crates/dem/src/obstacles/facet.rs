//! Facets of obstacles as grains see them (sheet: dem §2.10).

use colluvium_points::surface::NearestPoint;

/// Facets of an obstacle that a grain can touch at once; of more the nearest count.
pub const MAX_FACETS: usize = 6;

/// Key of a contact that has no facet.
pub const NO_FACET: u64 = u64::MAX;

/// Where an entry of the list sees its facet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Facet {
    /// Distance of the grain's centre (m).
    pub distance: f64,
    /// Normal towards the grain.
    pub normal: [f64; 3],
}

impl Facet {
    /// Out of reach.
    pub const NONE: Self = Self { distance: f64::INFINITY, normal: [0.0; 3] };

    /// What is known of a place.
    pub fn of<const D: usize>(place: &NearestPoint<D>) -> Self {
        let normal = std::array::from_fn(|c| place.normal.get(c).copied().unwrap_or(0.0));
        Self { distance: place.distance, normal }
    }

    /// Distance and normal in space.
    pub fn distance_and_normal<const D: usize>(&self) -> (f64, [f64; D]) {
        (self.distance, std::array::from_fn(|c| self.normal[c]))
    }
}
