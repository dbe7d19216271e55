//! State of the contact of a point's pore fluid with obstacles (docs/theory/mpm.md, obstacles).

use colluvium_points::struct_of_arrays::FixedBytes;

/// Contact state of the pore fluid of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoreContactState<const D: usize> {
    /// Seepage displacement of the fluid relative to the skeleton, as a volume over an area, since contact with an obstacle began (m).
    pub seepage_displacement: [f64; D],
    /// Force of the obstacles on the fluid in the step (N), as a pore pressure on the total area.
    pub force: [f64; D],
}

impl<const D: usize> PoreContactState<D> {
    /// State of a point without contact.
    pub const NEW: Self = Self { seepage_displacement: [0.0; D], force: [0.0; D] };

    /// Seepage displacement along a unit normal (m).
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
        let [seepage_displacement, force] = FixedBytes::from_bytes(bytes);
        Self { seepage_displacement, force }
    }
}
