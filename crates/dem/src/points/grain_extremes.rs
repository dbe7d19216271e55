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
    /// Whether a program has changed velocities since.
    pub is_outdated: bool,
}

impl GrainExtremes {
    /// Speed of the fastest grain; the radii follow with the first list build.
    pub fn at_start<const D: usize, const R: usize>(grains: &Grains<D, R>) -> Self {
        Self { radii: (0.0, 0.0), max_speed: max_speed(grains), is_outdated: false }
    }

    /// Extremes with the speed after a program has changed velocities.
    #[must_use]
    pub fn with_changed_velocities<const D: usize, const R: usize>(self, grains: &Grains<D, R>) -> Self {
        if self.is_outdated {
            Self { max_speed: max_speed(grains), is_outdated: false, ..self }
        } else {
            self
        }
    }
}

/// Speed of the fastest grain (m/s).
fn max_speed<const D: usize, const R: usize>(grains: &Grains<D, R>) -> f64 {
    grains.velocity.iter().map(|v| dot(v, v)).fold(0.0, f64::max).sqrt()
}
