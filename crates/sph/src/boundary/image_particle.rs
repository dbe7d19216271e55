//! Image particles in mirrors and across periodic boundaries.

use crate::boundary::flat_wall::{FlatWall, WallContact};
use crate::points::particles::SquareMatrix;

/// Image of a particle in mirrors and periods: `x' = flip x + shift`, `v' = velocity_sign v + velocity_shift`, `σ' = B σ B` with
/// `B = diag stress_sign`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageParticle<const D: usize> {
    /// Index of the particle of which it is an image.
    pub source: u32,
    /// -1 along the axes that are mirrored.
    pub axis_sign: [f64; D],
    /// Twice the coordinate of the mirror, or a period.
    pub shift: [f64; D],
    /// Factor on each velocity component of the image: `axis_sign` for smooth mirrors, -1 for rough ones.
    pub velocity_sign: [f64; D],
    /// Twice the velocity of the mirror (m/s).
    pub velocity_shift: [f64; D],
    /// Factor on each axis of the stress of the image: `axis_sign` for smooth mirrors, 1 for rough ones.
    pub stress_sign: [f64; D],
    /// Number of the mirror across each axis that is mirrored.
    pub(crate) mirrors: [Option<u32>; D],
}

impl<const D: usize> ImageParticle<D> {
    /// Velocity gradient of the image of a particle with the gradient `l` (1/s).
    #[inline]
    pub fn gradient(&self, l: &SquareMatrix<D>) -> SquareMatrix<D> {
        std::array::from_fn(|a| std::array::from_fn(|b| self.velocity_sign[a] * l[a][b] * self.axis_sign[b]))
    }

    /// Identity image of a particle.
    pub(crate) fn of_particle(source: u32) -> Self {
        let (none, same) = ([0.0; D], [1.0; D]);
        Self {
            source,
            axis_sign: same,
            shift: none,
            velocity_sign: same,
            velocity_shift: none,
            stress_sign: same,
            mirrors: [None; D],
        }
    }

    /// Image in the mirror `plane`, which has the given number.
    pub(crate) fn flipped(mut self, number: u32, plane: &FlatWall<D>) -> Self {
        let axis = plane.axis;
        self.mirrors[axis] = Some(number);
        self.axis_sign[axis] = -1.0;
        if plane.contact == WallContact::NoSlip {
            self.velocity_sign = self.velocity_sign.map(|c| -c);
        } else {
            self.velocity_sign[axis] = -self.velocity_sign[axis];
            self.stress_sign[axis] = -1.0;
        }
        self.apply_mirror(plane);
        self
    }

    /// Sets displacement and velocity of the image to those of its last mirror.
    pub(crate) fn apply_mirror(&mut self, plane: &FlatWall<D>) {
        let (axis, pace) = (plane.axis, plane.mean_velocity());
        self.shift[axis] = 2.0 * plane.face();
        if plane.contact == WallContact::NoSlip {
            self.velocity_shift = std::array::from_fn(|c| 2.0 * pace[c] - self.velocity_shift[c]);
        } else {
            self.velocity_shift[axis] = 2.0 * pace[axis] - self.velocity_shift[axis];
        }
    }
}

/// Periodic axis of the domain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeriodicAxis {
    /// The axis.
    pub axis: usize,
    /// Lower end (m).
    pub low: f64,
    /// Upper end (m).
    pub high: f64,
}
