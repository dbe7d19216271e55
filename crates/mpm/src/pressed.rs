//! What a point knows of the obstacles that it presses on (docs/theory/mpm.md, obstacles).

use colluvium_points::columns::Raw;

/// A point of a body whose obstacles act on points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pressed<const D: usize> {
    /// Half the width of the point (m).
    pub half: f64,
    /// Distance from a surface below which the point presses on it (m): `half`, or less where the point began nearer and has not
    /// been farther away since.
    pub reach: f64,
    /// How far it may go from where it was last looked at before it can come within `half` of a surface (m).
    pub free: f64,
    /// How far obstacles could have come when it was last looked at (m).
    pub swept: f64,
    /// Its displacement when it was last looked at (m).
    pub seen: [f64; D],
    /// Elastic slip along the surface (m).
    pub spring: [f64; D],
    /// Number plus one of the obstacle that holds it, which is one that nothing lifts off; zero for none.
    pub bond: u32,
    /// Force of the obstacles on it in the step (N).
    pub force: [f64; D],
}

impl<const D: usize> Pressed<D> {
    /// A point of no width that has not been looked at.
    pub const NEW: Self = Self {
        half: 0.0,
        reach: 0.0,
        free: 0.0,
        swept: 0.0,
        seen: [0.0; D],
        spring: [0.0; D],
        bond: 0,
        force: [0.0; D],
    };
}

/// Numbers of a point, beside three vectors and its bond.
const SCALARS: usize = 4;

impl<const D: usize> Raw for Pressed<D> {
    const BYTES: usize = <[f64; SCALARS]>::BYTES + 3 * <[f64; D]>::BYTES + u32::BYTES;

    fn put(self, out: &mut Vec<u8>) {
        [self.half, self.reach, self.free, self.swept].put(out);
        [self.seen, self.spring, self.force].put(out);
        self.bond.put(out);
    }

    fn get(bytes: &[u8]) -> Self {
        let (numbers, bytes) = bytes.split_at(<[f64; SCALARS]>::BYTES);
        let (vectors, bond) = bytes.split_at(3 * <[f64; D]>::BYTES);
        let [half, reach, free, swept] = Raw::get(numbers);
        let [seen, spring, force] = Raw::get(vectors);
        Self { half, reach, free, swept, seen, spring, bond: Raw::get(bond), force }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_comes_back_from_its_bytes() {
        let point = Pressed::<2> {
            half: 0.5,
            reach: 0.25,
            free: -1.0,
            swept: 2.0,
            seen: [1.0, 2.0],
            spring: [3.0, 4.0],
            bond: 3,
            force: [5.0, 6.0],
        };
        let mut bytes = Vec::new();
        point.put(&mut bytes);
        assert_eq!((bytes.len(), Pressed::get(&bytes)), (Pressed::<2>::BYTES, point));
    }
}
