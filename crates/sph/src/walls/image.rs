//! Images of particles in mirrors and across the ends of periods.

use super::plane::{Contact, Plane};
use crate::particles::Matrix;

/// An image of a particle in mirrors and periods: `x' = flip x + shift`, `v' = turn v + lift`, `σ' = B σ B` with
/// `B = diag bend`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Image<const D: usize> {
    /// The particle.
    pub source: u32,
    /// -1 along the axes that are mirrored.
    pub flip: [f64; D],
    /// Twice the coordinate of the mirror, or a period.
    pub shift: [f64; D],
    /// Sign of the velocity: of smooth mirrors `flip`, of rough ones -1 along every axis.
    pub turn: [f64; D],
    /// Twice the velocity of the mirror (m/s).
    pub lift: [f64; D],
    /// Sign of the axes for stress: of smooth mirrors `flip`, of rough ones 1, which keep it.
    pub bend: [f64; D],
    /// Number of the mirror across each axis that is mirrored.
    pub(super) across: [Option<u32>; D],
}

impl<const D: usize> Image<D> {
    /// The velocity gradient of the image of a particle with the gradient `l` (1/s).
    #[inline]
    pub fn gradient(&self, l: &Matrix<D>) -> Matrix<D> {
        std::array::from_fn(|a| std::array::from_fn(|b| self.turn[a] * l[a][b] * self.flip[b]))
    }

    /// The particle itself.
    pub(super) fn of(source: u32) -> Self {
        let (none, same) = ([0.0; D], [1.0; D]);
        Self { source, flip: same, shift: none, turn: same, lift: none, bend: same, across: [None; D] }
    }

    /// The image in the mirror `plane` of this number.
    pub(super) fn flipped(mut self, number: u32, plane: &Plane<D>) -> Self {
        let axis = plane.axis;
        self.across[axis] = Some(number);
        self.flip[axis] = -1.0;
        if plane.contact == Contact::NoSlip {
            self.turn = self.turn.map(|c| -c);
        } else {
            self.turn[axis] = -self.turn[axis];
            self.bend[axis] = -1.0;
        }
        self.carry(plane);
        self
    }

    /// What the place and the velocity of its last mirror do to it.
    pub(super) fn carry(&mut self, plane: &Plane<D>) {
        let (axis, pace) = (plane.axis, plane.pace());
        self.shift[axis] = 2.0 * plane.face();
        if plane.contact == Contact::NoSlip {
            self.lift = std::array::from_fn(|c| 2.0 * pace[c] - self.lift[c]);
        } else {
            self.lift[axis] = 2.0 * pace[axis] - self.lift[axis];
        }
    }
}

/// An axis along which the domain repeats itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Period {
    /// The axis.
    pub axis: usize,
    /// Lower end (m).
    pub low: f64,
    /// Upper end (m).
    pub high: f64,
}
