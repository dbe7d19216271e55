//! Half-space: the solid behind a plane.

use super::vector::{add_scaled, difference, dot, unit};
use super::{ContactQuery, NearestPoint, Surface, SurfaceError};

/// Half-space behind a plane (3D) or a line (2D).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfSpace<const D: usize> {
    point: [f64; D],
    normal: [f64; D],
}

impl<const D: usize> HalfSpace<D> {
    /// Half-space behind the plane through `point` (m), whose outward `normal` need not be a unit vector.
    ///
    /// # Errors
    /// When the normal has no length or a component is not finite.
    pub fn new(point: [f64; D], normal: [f64; D]) -> Result<Self, SurfaceError> {
        if !point.iter().all(|c| c.is_finite()) {
            return Err(SurfaceError::new("point", "must be finite (m)"));
        }
        match unit(&normal) {
            Some(normal) => Ok(Self { point, normal }),
            None => Err(SurfaceError::new("normal", "must have a finite length above zero")),
        }
    }

    /// Unit normal out of the solid.
    pub fn normal(&self) -> [f64; D] {
        self.normal
    }
}

impl<const D: usize> Surface<D> for HalfSpace<D> {
    fn contains(&self, x: &[f64; D]) -> bool {
        dot(&difference(x, &self.point), &self.normal) <= 0.0
    }

    fn gap(&self, x: &[f64; D], reach: f64) -> Option<NearestPoint<D>> {
        let distance = dot(&difference(x, &self.point), &self.normal);
        let nearest = || NearestPoint {
            distance,
            normal: self.normal,
            position: add_scaled(x, -distance, &self.normal),
            feature_id: 0,
        };
        (distance.abs() <= reach).then(nearest)
    }

    fn query_contacts(&self, x: &[f64; D], radius: f64, found: &mut ContactQuery<D>) {
        found.add_if_outside(self.gap(x, radius));
    }

    fn bounds(&self) -> ([f64; D], [f64; D]) {
        ([f64::NEG_INFINITY; D], [f64::INFINITY; D])
    }
}
