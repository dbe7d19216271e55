//! Flat wall.

use crate::config::TimeHistory;

/// Contact condition of a wall along its face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WallContact {
    /// No slip.
    NoSlip,
    /// Free slip.
    FreeSlip,
    /// Coulomb friction with this coefficient; no tension.
    Friction(f64),
}

/// Flat wall: a half space that material cannot enter.
#[derive(Clone, Debug, PartialEq)]
pub struct FlatWall<const D: usize> {
    /// Index into `Case::boundaries`.
    pub boundary: usize,
    /// Axis normal to the face.
    pub axis: usize,
    /// Coordinate of the face at time zero (m).
    pub position: f64,
    /// Whether the wall is above its face, with material below.
    pub is_upper: bool,
    /// Velocity of the wall (m/s), to be multiplied by the time history; its normal component moves the face.
    pub velocity: [f64; D],
    /// Time history of the factor on the velocity; constant if absent.
    pub history: Option<TimeHistory>,
    /// Mean factor over the step.
    pub factor: f64,
    /// Displacement of the face along its axis since time zero (m).
    pub displacement: f64,
    /// Contact condition along the face.
    pub contact: WallContact,
}

impl<const D: usize> FlatWall<D> {
    /// Coordinate of the face (m).
    #[inline]
    pub fn face(&self) -> f64 {
        self.position + self.displacement
    }

    /// Mean velocity over the step (m/s).
    #[inline]
    pub fn mean_velocity(&self) -> [f64; D] {
        self.velocity.map(|v| self.factor * v)
    }

    /// Coordinate of the face at `time` (m).
    pub fn face_at(&self, time: f64) -> f64 {
        self.position + self.displacement_between(0.0, time)
    }

    /// Displacement of the face between two times (m): the integral of its velocity.
    pub(crate) fn displacement_between(&self, start: f64, end: f64) -> f64 {
        let elapsed = self.history.as_ref().map_or(end - start, |history| history.integral(start, end));
        self.velocity[self.axis] * elapsed
    }

    /// Distance of `x` from the face, positive outside of the wall (m).
    #[inline]
    pub fn distance(&self, x: &[f64; D]) -> f64 {
        let along = x[self.axis] - self.face();
        if self.is_upper { -along } else { along }
    }
}
