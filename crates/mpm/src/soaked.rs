//! What a point knows of the obstacles that its pore fluid presses on (docs/theory/mpm.md, obstacles).

use colluvium_points::columns::Raw;

/// The pore fluid of a point whose obstacles act on points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Soaked<const D: usize> {
    /// How far the fluid has seeped through the skeleton, as a volume over an area, since the point touched an obstacle (m).
    pub seep: [f64; D],
    /// Force of the obstacles on the fluid in the step (N), as that of a pore pressure: on all of the area.
    pub force: [f64; D],
}

impl<const D: usize> Soaked<D> {
    /// A point that touches nothing.
    pub const NEW: Self = Self { seep: [0.0; D], force: [0.0; D] };

    /// How far the fluid has seeped along a unit normal (m).
    pub fn out(&self, normal: &[f64; D]) -> f64 {
        (0..D).map(|c| self.seep[c] * normal[c]).sum()
    }
}

impl<const D: usize> Raw for Soaked<D> {
    const BYTES: usize = 2 * <[f64; D]>::BYTES;

    fn put(self, out: &mut Vec<u8>) {
        [self.seep, self.force].put(out);
    }

    fn get(bytes: &[u8]) -> Self {
        let [seep, force] = Raw::get(bytes);
        Self { seep, force }
    }
}
