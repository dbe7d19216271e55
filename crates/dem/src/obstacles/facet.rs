//! Facets of obstacles in contact with grains (sheet: dem §2.10).

use colluvium_points::surface::NearestPoint;

/// Largest number of facets in contact with a grain; among more the nearest ones are used.
pub const MAX_FACETS: usize = 6;

/// Key of a contact without a facet.
pub const NO_FACET: u64 = u64::MAX;

/// Contact of a grain with a facet of an obstacle: distance (m) and normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacetContact {
    /// Distance of the grain centre (m).
    pub distance: f64,
    /// Unit normal of the facet, towards the grain.
    pub normal: [f64; 3],
}

impl FacetContact {
    /// Facet farther from the grain than the contact range.
    pub const OUT_OF_REACH: Self = Self { distance: f64::INFINITY, normal: [0.0; 3] };

    /// Returns the facet at a nearest point of a surface.
    pub fn from_nearest_point<const D: usize>(place: &NearestPoint<D>) -> Self {
        let normal = std::array::from_fn(|c| place.normal.get(c).copied().unwrap_or(0.0));
        Self { distance: place.distance, normal }
    }

    /// Distance (m) and normal in `D` dimensions.
    pub fn distance_and_normal<const D: usize>(&self) -> (f64, [f64; D]) {
        (self.distance, std::array::from_fn(|c| self.normal[c]))
    }
}
