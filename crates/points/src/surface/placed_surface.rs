//! Surface that is rotated and translated.

use std::sync::Arc;

use crate::surface::vector::{difference, dot};
use crate::surface::{ContactQuery, NearestPoint, Surface};

/// Rigid transform of body coordinates `X` to space: `rotation X + translation`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidTransform<const D: usize> {
    /// Rotation matrix, row by row.
    pub rotation: [[f64; D]; D],
    /// Position of the body's origin in space (m).
    pub translation: [f64; D],
}

impl<const D: usize> Default for RigidTransform<D> {
    fn default() -> Self {
        Self {
            rotation: std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j)))),
            translation: [0.0; D],
        }
    }
}

impl<const D: usize> RigidTransform<D> {
    /// Rotation by `angle` (radians) about `centre` (m): counter-clockwise in 2D, about `axis` by the right-hand rule in 3D. The axis need
    /// not be a unit vector; a zero axis gives no rotation. One dimension has no rotation.
    pub fn rotation_about(centre: [f64; D], axis: [f64; 3], angle: f64) -> Self {
        let axis = if D == 2 { [0.0, 0.0, 1.0] } else { axis };
        let Some(n) = crate::surface::vector::unit(&axis).filter(|_| D > 1) else { return Self::default() };
        let (sine, cosine) = angle.sin_cos();
        let skew = [[0.0, -n[2], n[1]], [n[2], 0.0, -n[0]], [-n[1], n[0], 0.0]];
        let rotation: [[f64; D]; D] = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let same = f64::from(u8::from(i == j));
                cosine * same + sine * skew[i][j] + (1.0 - cosine) * n[i] * n[j]
            })
        });
        let mut frame = Self { rotation, translation: [0.0; D] };
        let turned = frame.to_space(&centre);
        frame.translation = difference(&centre, &turned);
        frame
    }

    /// Transform followed by a translation by `offset` (m).
    pub fn shifted(mut self, offset: &[f64; D]) -> Self {
        self.translation = std::array::from_fn(|c| self.translation[c] + offset[c]);
        self
    }

    /// Composition: this transform, followed by `next`.
    pub fn followed_by(&self, next: &Self) -> Self {
        let rotation = std::array::from_fn(|i| {
            std::array::from_fn(|j| (0..D).map(|k| next.rotation[i][k] * self.rotation[k][j]).sum())
        });
        Self { rotation, translation: next.to_space(&self.translation) }
    }

    /// Position in space of the body coordinates `local` (m).
    pub fn to_space(&self, local: &[f64; D]) -> [f64; D] {
        std::array::from_fn(|c| dot(&self.rotation[c], local) + self.translation[c])
    }

    /// Body coordinates of the position `x` (m) in space.
    pub fn to_body(&self, x: &[f64; D]) -> [f64; D] {
        let from = difference(x, &self.translation);
        std::array::from_fn(|c| (0..D).map(|i| self.rotation[i][c] * from[i]).sum())
    }

    /// Direction in space of a direction in body coordinates.
    pub fn rotate(&self, direction: &[f64; D]) -> [f64; D] {
        std::array::from_fn(|c| dot(&self.rotation[c], direction))
    }
}

/// Surface that is rotated and translated.
#[derive(Clone, Debug)]
pub struct PlacedSurface<const D: usize> {
    /// Surface in body coordinates.
    pub surface: Arc<dyn Surface<D>>,
    /// Transform from body coordinates to space.
    pub transform: RigidTransform<D>,
}

impl<const D: usize> PlacedSurface<D> {
    /// Nearest point in space, from the one in the coordinates of the surface.
    fn to_space(&self, local: &NearestPoint<D>) -> NearestPoint<D> {
        NearestPoint {
            normal: self.transform.rotate(&local.normal),
            position: self.transform.to_space(&local.position),
            ..*local
        }
    }
}

impl<const D: usize> Surface<D> for PlacedSurface<D> {
    fn contains(&self, x: &[f64; D]) -> bool {
        self.surface.contains(&self.transform.to_body(x))
    }

    fn gap(&self, x: &[f64; D], reach: f64) -> Option<NearestPoint<D>> {
        self.surface.gap(&self.transform.to_body(x), reach).map(|local| self.to_space(&local))
    }

    fn query_contacts(&self, x: &[f64; D], radius: f64, found: &mut ContactQuery<D>) {
        let before = found.len();
        self.surface.query_contacts(&self.transform.to_body(x), radius, found);
        for place in found.contacts_since_mut(before) {
            *place = self.to_space(place);
        }
    }

    fn bounds(&self) -> ([f64; D], [f64; D]) {
        let (low, high) = self.surface.bounds();
        if low.iter().chain(&high).any(|c| c.is_infinite()) {
            let unturned = self.transform.rotation == RigidTransform::<D>::default().rotation;
            return if unturned {
                let shift =
                    |corner: [f64; D]| std::array::from_fn(|c| corner[c] + self.transform.translation[c]);
                (shift(low), shift(high))
            } else {
                ([f64::NEG_INFINITY; D], [f64::INFINITY; D])
            };
        }
        let mut around = ([f64::INFINITY; D], [f64::NEG_INFINITY; D]);
        for number in 0..1usize << D {
            let corner = std::array::from_fn(|c| if number >> c & 1 == 0 { low[c] } else { high[c] });
            let x = self.transform.to_space(&corner);
            for c in 0..D {
                around.0[c] = around.0[c].min(x[c]);
                around.1[c] = around.1[c].max(x[c]);
            }
        }
        around
    }

    fn arc_length(&self, x: &[f64; D]) -> Option<f64> {
        self.surface.arc_length(&self.transform.to_body(x))
    }
}
