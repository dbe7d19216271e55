//! Ball, or the surroundings of a ball.

use super::vector::{add_scaled, difference, dot, unit};
use super::{ContactQuery, NearestPoint, Surface, SurfaceError};

/// Surface of a ball (of a disk in 2D). The solid is the ball or the space around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BallSurface<const D: usize> {
    centre: [f64; D],
    radius: f64,
    is_hollow: bool,
}

impl<const D: usize> BallSurface<D> {
    /// Ball around `centre` with this `radius` (m); with `is_hollow` the solid is the space outside.
    ///
    /// # Errors
    /// When the radius is not a length or the centre is not finite.
    pub fn new(centre: [f64; D], radius: f64, is_hollow: bool) -> Result<Self, SurfaceError> {
        if !centre.iter().all(|c| c.is_finite()) {
            return Err(SurfaceError::new("centre", "must be finite (m)"));
        }
        if !(radius.is_finite() && radius > 0.0) {
            return Err(SurfaceError::new("radius", format!("{radius} must be finite and positive (m)")));
        }
        Ok(Self { centre, radius, is_hollow })
    }
}

impl<const D: usize> Surface<D> for BallSurface<D> {
    fn contains(&self, x: &[f64; D]) -> bool {
        let from = difference(x, &self.centre);
        (dot(&from, &from) <= self.radius * self.radius) != self.is_hollow
    }

    fn gap(&self, x: &[f64; D], reach: f64) -> Option<NearestPoint<D>> {
        let from = difference(x, &self.centre);
        // The centre is equally far from the whole surface: any direction is a normal.
        let out = unit(&from).unwrap_or_else(|| std::array::from_fn(|c| f64::from(u8::from(c + 1 == D))));
        let (sign, height) =
            (if self.is_hollow { -1.0 } else { 1.0 }, dot(&from, &from).sqrt() - self.radius);
        let nearest = || NearestPoint {
            distance: sign * height,
            normal: out.map(|c| sign * c),
            position: add_scaled(&self.centre, self.radius, &out),
            feature_id: 0,
        };
        (height.abs() <= reach).then(nearest)
    }

    fn query_contacts(&self, x: &[f64; D], radius: f64, found: &mut ContactQuery<D>) {
        found.add_if_outside(self.gap(x, radius));
    }

    fn bounds(&self) -> ([f64; D], [f64; D]) {
        (self.centre.map(|c| c - self.radius), self.centre.map(|c| c + self.radius))
    }
}
