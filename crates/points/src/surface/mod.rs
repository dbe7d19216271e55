//! Surfaces of rigid geometry: signed distance, normal and facets near a position.
//!
//! A surface bounds a solid. Every shape implements [`Surface`]: half-spaces ([`HalfSpace`]), balls ([`BallSurface`]), facets (polygons,
//! ground lines, extruded polygons and triangle meshes: [`FacettedSurface`]), lines with arcs ([`GroundProfile`]), polygons of revolution
//! ([`RevolvedSurface`]), rasters as triangles ([`HeightField`]), and any of them rotated and translated ([`PlacedSurface`]).

mod ball;
mod extruded;
mod facetted;
mod ground_profile;
mod half_space;
mod height_field;
mod placed_surface;
pub(crate) mod queries;
mod revolved;
pub(crate) mod vector;

use std::fmt::Debug;
use std::sync::Arc;

pub use crate::surface::ground_profile::GroundProfile;
pub use crate::surface::placed_surface::{PlacedSurface, RigidTransform};
pub use crate::surface::queries::contact_query::ContactQuery;
pub use crate::surface::queries::nearest_on_facet::distance_to_line;
pub use crate::surface::queries::path_intersection::{path_enters_solid, solid_blocks_path};
pub use ball::BallSurface;
pub use facetted::{FacettedSurface, SurfaceError};
pub use half_space::HalfSpace;
pub use height_field::HeightField;
pub use revolved::RevolvedSurface;
pub use vector::{cross, dot};

/// Point of a surface that is nearest to a given position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestPoint<const D: usize> {
    /// Signed distance of the position from the surface (m), negative in the solid.
    pub distance: f64,
    /// Unit normal out of the solid: the gradient of the distance.
    pub normal: [f64; D],
    /// Position of the surface point (m).
    pub position: [f64; D],
    /// Identifier of the face, edge or corner, constant as long as the surface exists; contact histories are stored under it. The face of a
    /// half-space or of a ball is one feature.
    pub feature_id: u64,
}

/// Boundary of a rigid solid.
///
/// Each shape has one implementation. Methods for many points make one virtual call for all of them.
pub trait Surface<const D: usize>: Debug + Send + Sync {
    /// Whether a position lies in the solid. A position on the surface may count as either.
    fn contains(&self, x: &[f64; D]) -> bool;

    /// Nearest point of the surface to `x` (m); `None` where the distance is more than `reach` (m), inside or outside the solid.
    fn gap(&self, x: &[f64; D], reach: f64) -> Option<NearestPoint<D>>;

    /// Adds the contacts of a ball around `x` with this `radius` (m), nearest first. There is one for each facet that faces `x`, and one
    /// for a convex edge or corner, except an edge at which a facet in contact ends. A centre in the solid has no contacts.
    fn query_contacts(&self, x: &[f64; D], radius: f64, found: &mut ContactQuery<D>);

    /// Lower and upper corner of the bounding box (m); infinite where the surface is unbounded.
    fn bounds(&self) -> ([f64; D], [f64; D]);

    /// Arc length of a ground line or a profile from its start to the point nearest to `x` (m); `None` for other shapes.
    fn arc_length(&self, _x: &[f64; D]) -> Option<f64> {
        None
    }

    /// Result of [`Surface::gap`] for many positions.
    fn gaps(&self, points: &[[f64; D]], reach: f64, gaps: &mut Vec<Option<NearestPoint<D>>>) {
        gaps.clear();
        gaps.extend(points.iter().map(|x| self.gap(x, reach)));
    }

    /// Adds the contacts of many balls, each with its own radius (m), by [`Surface::query_contacts`].
    fn query_contacts_of_all(&self, points: &[[f64; D]], radii: &[f64], found: &mut ContactQuery<D>) {
        found.clear();
        for (x, radius) in points.iter().zip(radii) {
            self.query_contacts(x, *radius, found);
            found.end_ball();
        }
    }
}

/// Surface with shared ownership.
pub type SharedSurface<const D: usize> = Arc<dyn Surface<D>>;

macro_rules! shared_surface {
    ($($surface:ident),*) => {$(
        impl<const D: usize> $surface<D> {
            /// Converts the surface to shared ownership.
            pub fn into_shared(self) -> SharedSurface<D> {
                Arc::new(self)
            }
        }
    )*};
}

shared_surface!(BallSurface, FacettedSurface, HalfSpace, PlacedSurface);

impl GroundProfile {
    /// Converts the surface to shared ownership.
    pub fn into_shared(self) -> SharedSurface<2> {
        Arc::new(self)
    }
}

impl HeightField {
    /// Converts the surface to shared ownership.
    pub fn into_shared(self) -> SharedSurface<3> {
        Arc::new(self)
    }
}

impl RevolvedSurface {
    /// Converts the surface to shared ownership.
    pub fn into_shared(self) -> SharedSurface<3> {
        Arc::new(self)
    }
}
