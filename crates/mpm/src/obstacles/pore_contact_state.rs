//! What a point knows of the obstacles that its pore fluid presses on (docs/theory/mpm.md, obstacles).

use colluvium_points::struct_of_arrays::FixedBytes;

/// The pore fluid of a point whose obstacles act on points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoreContactState<const D: usize> {
    /// How far the fluid has seeped through the skeleton, as a volume over an area, since the point touched an obstacle (m).
    pub seepage_displacement: [f64; D],
    /// Force of the obstacles on the fluid in the step (N), as that of a pore pressure: on all of the area.
    pub force: [f64; D],
}

impl<const D: usize> PoreContactState<D> {
    /// A point that touches nothing.
    pub const NEW: Self = Self { seepage_displacement: [0.0; D], force: [0.0; D] };

    /// How far the fluid has seeped along a unit normal (m).
    pub fn seepage_along(&self, normal: &[f64; D]) -> f64 {
        (0..D).map(|c| self.seepage_displacement[c] * normal[c]).sum()
    }
}

impl<const D: usize> FixedBytes for PoreContactState<D> {
    const BYTE_COUNT: usize = 2 * <[f64; D]>::BYTE_COUNT;

    fn append_bytes(self, out: &mut Vec<u8>) {
        [self.seepage_displacement, self.force].append_bytes(out);
    }

    fn from_bytes(bytes: &[u8]) -> Self {
        let [seep, force] = FixedBytes::from_bytes(bytes);
        Self { seepage_displacement: seep, force }
    }
}
