//! Wrapping of points that leave a periodic domain.

use rayon::prelude::*;

/// Moves points outside a box with corners `low` and `high` (m) to the opposite end along periodic axes, with the reference positions
/// `origins` of their displacements. Returns whether there were any.
pub fn wrap_into_period<const D: usize>(
    [low, high]: [&[f64; D]; 2],
    periodic: &[bool; D],
    positions: &mut [[f64; D]],
    origins: &mut [[f64; D]],
) -> bool {
    let points = positions.par_iter_mut().zip(origins).map(|(position, origin)| {
        let mut any = false;
        for axis in (0..D).filter(|axis| periodic[*axis]) {
            let shift = match position[axis] {
                x if x < low[axis] => high[axis] - low[axis],
                x if x >= high[axis] => low[axis] - high[axis],
                _ => continue,
            };
            position[axis] = (position[axis] + shift).clamp(low[axis], high[axis]);
            origin[axis] += shift;
            any = true;
        }
        any
    });
    points.reduce(|| false, |a, b| a | b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_wrap_around_a_period_and_keep_their_displacement() {
        let mut positions = [[-0.25, 2.5], [0.5, 0.5], [1.0, -0.5]];
        let mut origins = [[0.25, 2.25], [0.5, 0.0], [0.75, 0.0]];
        assert!(wrap_into_period([&[0.0; 2], &[1.0, 2.0]], &[true, false], &mut positions, &mut origins));
        assert_eq!(positions, [[0.75, 2.5], [0.5, 0.5], [0.0, -0.5]]);
        assert_eq!(origins, [[1.25, 2.25], [0.5, 0.0], [-0.25, 0.0]]);
        assert!(!wrap_into_period([&[0.0; 2], &[1.0, 2.0]], &[true, false], &mut positions, &mut origins));
    }
}
