//! Enumeration of the features of a case.

mod names;

use std::fmt;

pub use crate::feature_list::names::Feature;

/// Defines [`Feature`] from a list of its variants with their names.
macro_rules! feature_enum {
    ($($variant:ident = $name:literal,)*) => {
        /// Feature of a case: an optional key, or a variant of a value, named by the keys from the top: `bodies.rigid`,
        /// `obstacles.wall=frictional`. A required key such as `bodies.shape` is in the list for its variants and the keys below it.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[non_exhaustive]
        pub enum Feature {
            $(#[doc = concat!("`", $name, "`")] $variant,)*
        }

        impl Feature {
            /// All features, in the order of their names.
            pub const ALL: &[Self] = &[$(Self::$variant,)*];

            /// Keys from the top, without names and numbers of entries, and the variant: `bodies.velocity=sine`.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }
        }
    };
}

use feature_enum;

impl Feature {
    /// Feature with a name; `None` for a name that is not in the list.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.binary_search_by(|feature| feature.name().cmp(name)).ok().map(|number| Self::ALL[number])
    }

    /// Variant of the value of a key: `frictional` of `obstacles.wall=frictional`; `None` for a key.
    #[must_use]
    pub fn variant(self) -> Option<&'static str> {
        self.name().rsplit_once('=').map(|(_, variant)| variant)
    }

    /// Whether another feature is this one, one of its variants, or a key below it or a variant of such a key.
    #[must_use]
    pub fn contains(self, other: Self) -> bool {
        self == other || self.has_key(other) || self.rest_of(other).is_some_and(|rest| rest.starts_with('='))
    }

    /// Whether another feature is a key below this one, or a variant of such a key.
    #[must_use]
    pub fn has_key(self, other: Self) -> bool {
        self.rest_of(other).is_some_and(|rest| rest.starts_with('.'))
    }

    /// Rest of the name of another feature after the name of this one.
    fn rest_of(self, other: Self) -> Option<&'static str> {
        other.name().strip_prefix(self.name())
    }
}

impl fmt::Display for Feature {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_feature_contains_its_variants_and_the_keys_below_it() {
        let wall = Feature::ObstaclesWall;
        for part in [wall, Feature::ObstaclesWallAdhesion, Feature::ObstaclesWallFrictional] {
            assert!(wall.contains(part), "{part}");
        }
        assert!(Feature::Obstacles.contains(Feature::ObstaclesRegionsWallAdhesion));
        assert!(!wall.contains(Feature::ObstaclesRegionsWallAdhesion));
        // Another key with the same beginning.
        assert!(!Feature::BodiesSampling.contains(Feature::BodiesSamplingSeed));
        assert!(Feature::Measures.has_key(Feature::MeasuresSideXMin));
        assert!(!Feature::Measures.has_key(Feature::MeasuresFront));
    }

    #[test]
    fn features_are_found_by_name_and_display_it() {
        assert_eq!(Feature::named("space=3d"), Some(Feature::SpaceThreeD));
        assert_eq!(Feature::named("bodies.sampling_seed"), Some(Feature::BodiesSamplingSeed));
        assert_eq!(Feature::named("bodies.samplin"), None);
        assert_eq!(Feature::BoundariesWallFrictional.to_string(), "boundaries.wall=frictional");
        assert_eq!(Feature::BoundariesWallFrictional.variant(), Some("frictional"));
        assert_eq!(Feature::BoundariesWallBilateral.variant(), None);
    }
}
