//! Extremes of the grains: radii and speed.

use crate::points::grains::Grains;
use crate::points::vector::dot;

/// Smallest and largest radius, and largest speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrainExtremes {
    /// Smallest and largest radius (m).
    pub radii: (f64, f64),
    /// Speed of the fastest grain (m/s).
    pub max_speed: f64,
}

impl GrainExtremes {
    /// Speed of the fastest grain; the radii follow with the first list build.
    pub fn at_start<const D: usize, const R: usize>(grains: &Grains<D, R>) -> Self {
        let max_speed = grains.velocity.iter().map(|v| dot(v, v)).fold(0.0, f64::max).sqrt();
        Self { radii: (0.0, 0.0), max_speed }
    }
}
