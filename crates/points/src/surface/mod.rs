//! Surfaces of rigid geometry: how far a place is from them, in which direction, and which of their facets are near.
//!
//! A surface bounds a solid. Every shape implements [`Surface`]: half-spaces ([`HalfSpace`]), balls ([`BallSurface`]), facets
//! (polygons, ground lines, extruded polygons and triangle meshes: [`FacettedSurface`]), lines with arcs ([`GroundProfile`]), turned polygons
//! ([`RevolvedSurface`]), rasters as triangles ([`HeightField`]), and any of them turned and shifted ([`PlacedSurface`]).

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

/// A place of a surface, seen from a point nearby.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestPoint<const D: usize> {
    /// Distance of the point from the surface (m), negative where the point lies in the solid.
    pub distance: f64,
    /// Unit normal at the place, out of the solid: the direction in which the distance grows fastest.
    pub normal: [f64; D],
    /// The place (m).
    pub position: [f64; D],
    /// What part of the surface it is: the same number for the same face, edge or corner as long as the surface lives. A
    /// history of contact is kept under it. The face of a half-space or of a ball is one part.
    pub feature_id: u64,
}

/// The boundary of a rigid solid.
///
/// One implementation a shape. The methods for many points make one virtual call for all of them.
pub trait Surface<const D: usize>: Debug + Send + Sync {
    /// Whether the point lies in the solid. A point on the surface may count as either.
    fn contains(&self, x: &[f64; D]) -> bool;

    /// The place of the surface that is nearest to `x` (m); `None` where the surface is farther away than `reach` (m), in or out
    /// of the solid.
    fn gap(&self, x: &[f64; D], reach: f64) -> Option<NearestPoint<D>>;

    /// Adds the places at which a ball around `x` of this `radius` (m) touches the surface, nearest first: one for each facet
    /// that faces `x`, and one for an edge or a corner that stands out, but none for an edge at which a facet that is touched
    /// goes on. Points in the solid touch nothing.
    fn query_contacts(&self, x: &[f64; D], radius: f64, found: &mut ContactQuery<D>);

    /// Lower and upper corner of a box around the surface (m); infinite where it has no end.
    fn bounds(&self) -> ([f64; D], [f64; D]);

    /// Length along a ground line or a profile from its beginning to the place nearest to `x` (m); `None` of other shapes.
    fn arc_length(&self, _x: &[f64; D]) -> Option<f64> {
        None
    }

    /// [`Surface::gap`] of many points.
    fn gaps(&self, points: &[[f64; D]], reach: f64, gaps: &mut Vec<Option<NearestPoint<D>>>) {
        gaps.clear();
        gaps.extend(points.iter().map(|x| self.gap(x, reach)));
    }

    /// [`Surface::query_contacts`] of many balls, each with its own radius (m).
    fn query_contacts_of_all(&self, points: &[[f64; D]], radii: &[f64], found: &mut ContactQuery<D>) {
        found.clear();
        for (x, radius) in points.iter().zip(radii) {
            self.query_contacts(x, *radius, found);
            found.end_ball();
        }
    }
}

/// A surface that several may hold.
pub type SharedSurface<const D: usize> = Arc<dyn Surface<D>>;

macro_rules! shared_surface {
    ($($surface:ident),*) => {$(
        impl<const D: usize> $surface<D> {
            /// The surface as one that several may hold.
            pub fn shared(self) -> SharedSurface<D> {
                Arc::new(self)
            }
        }
    )*};
}

shared_surface!(BallSurface, FacettedSurface, HalfSpace, PlacedSurface);

impl GroundProfile {
    /// The surface as one that several may hold.
    pub fn into_shared(self) -> SharedSurface<2> {
        Arc::new(self)
    }
}

impl HeightField {
    /// The surface as one that several may hold.
    pub fn into_shared(self) -> SharedSurface<3> {
        Arc::new(self)
    }
}

impl RevolvedSurface {
    /// The surface as one that several may hold.
    pub fn into_shared(self) -> SharedSurface<3> {
        Arc::new(self)
    }
}
