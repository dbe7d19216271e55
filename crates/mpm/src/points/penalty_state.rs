//! State of the penalty contact of a point with obstacles (docs/theory/mpm.md, obstacles).

use colluvium_points::struct_of_arrays::FixedBytes;

/// Contact state of a point with obstacles on points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PenaltyState<const D: usize> {
    /// Half the width of the point (m).
    pub half_width: f64,
    /// Distance from a surface below which the penalty acts (m): `half_width`, or less for a point that started closer to the surface and
    /// has not moved away since.
    pub penalty_distance: f64,
    /// Distance that the point may move after the last search before a surface can be within `half_width` (m).
    pub free_distance: f64,
    /// Largest displacement of obstacles at the last search (m).
    pub obstacle_displacement: f64,
    /// Displacement of the point at the last search (m).
    pub last_search_displacement: [f64; D],
    /// Elastic slip along the surface (m).
    pub spring: [f64; D],
    /// Number of the bonded obstacle plus one; zero for none.
    pub bond: u32,
    /// Force of the obstacles on the point in the step (N).
    pub force: [f64; D],
}

impl<const D: usize> PenaltyState<D> {
    /// State of a point of no width before its first search.
    pub const NEW: Self = Self {
        half_width: 0.0,
        penalty_distance: 0.0,
        free_distance: 0.0,
        obstacle_displacement: 0.0,
        last_search_displacement: [0.0; D],
        spring: [0.0; D],
        bond: 0,
        force: [0.0; D],
    };
}

/// Number of scalars of a point, beside three vectors and its bond.
const SCALARS: usize = 4;

impl<const D: usize> FixedBytes for PenaltyState<D> {
    const BYTE_COUNT: usize = <[f64; SCALARS]>::BYTE_COUNT + 3 * <[f64; D]>::BYTE_COUNT + u32::BYTE_COUNT;

    fn append_bytes(self, out: &mut Vec<u8>) {
        [self.half_width, self.penalty_distance, self.free_distance, self.obstacle_displacement]
            .append_bytes(out);
        [self.last_search_displacement, self.spring, self.force].append_bytes(out);
        self.bond.append_bytes(out);
    }

    fn from_bytes(bytes: &[u8]) -> Self {
        let (numbers, bytes) = bytes.split_at(<[f64; SCALARS]>::BYTE_COUNT);
        let (vectors, bond) = bytes.split_at(3 * <[f64; D]>::BYTE_COUNT);
        let [half_width, penalty_distance, free, swept] = FixedBytes::from_bytes(numbers);
        let [last_search_displacement, spring, force] = FixedBytes::from_bytes(vectors);
        Self {
            half_width,
            penalty_distance,
            free_distance: free,
            obstacle_displacement: swept,
            last_search_displacement,
            spring,
            bond: FixedBytes::from_bytes(bond),
            force,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_penalty_state_is_recovered_from_its_bytes() {
        let point = PenaltyState::<2> {
            half_width: 0.5,
            penalty_distance: 0.25,
            free_distance: -1.0,
            obstacle_displacement: 2.0,
            last_search_displacement: [1.0, 2.0],
            spring: [3.0, 4.0],
            bond: 3,
            force: [5.0, 6.0],
        };
        let mut bytes = Vec::new();
        point.append_bytes(&mut bytes);
        assert_eq!((bytes.len(), PenaltyState::from_bytes(&bytes)), (PenaltyState::<2>::BYTE_COUNT, point));
    }
}
