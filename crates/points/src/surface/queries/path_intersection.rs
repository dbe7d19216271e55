//! Paths that enter a solid, including solids so thin that the path leaves them on the other side.

use crate::surface::vector::{add_scaled, dot};
use crate::surface::{NearestPoint, Surface};

/// Surface point of a path that enters the solid: the point `now` that is nearest to the start `x` (m), with the signed distance at the end
/// of the displacement `goes` (m). `None` for another path. The solid is tested at this
/// `depth` (m) under the crossing.
pub fn path_enters_solid<const D: usize>(
    surface: &dyn Surface<D>,
    x: &[f64; D],
    goes: &[f64; D],
    now: &NearestPoint<D>,
    depth: f64,
) -> Option<NearestPoint<D>> {
    let closing = dot(goes, &now.normal);
    let distance = now.distance + closing;
    if distance >= 0.0 || now.distance <= 0.0 {
        return None;
    }
    let share = now.distance / -closing;
    let under = std::array::from_fn(|c| x[c] + share * goes[c] - depth * now.normal[c]);
    surface.contains(&under).then_some(NearestPoint { distance, ..*now })
}

/// Whether the solid blocks the straight path between two positions (m), from either end. The solid is tested at this `depth` (m) below its
/// surface.
pub fn solid_blocks_path<const D: usize>(
    surface: &dyn Surface<D>,
    one: &[f64; D],
    other: &[f64; D],
    depth: f64,
) -> bool {
    let leads = |from: &[f64; D], to: &[f64; D]| {
        let goes = add_scaled(to, -1.0, from);
        let now = surface.gap(from, dot(&goes, &goes).sqrt());
        now.is_some_and(|now| path_enters_solid(surface, from, &goes, &now, depth).is_some())
    };
    leads(one, other) || leads(other, one)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::FacettedSurface;

    #[test]
    fn a_thin_plate_blocks_only_paths_that_cross_it() {
        let corners = vec![[-1.0, 0.0], [1.0, 0.0], [1.0, 0.001], [-1.0, 0.001]];
        let plate = FacettedSurface::polygon(&corners).unwrap();
        let between = |one: [f64; 2], other: [f64; 2]| solid_blocks_path(&plate, &one, &other, 1e-5);
        assert!(between([0.0, 0.1], [0.05, -0.1]) && between([0.05, -0.1], [0.0, 0.1]));
        assert!(!between([0.0, 0.1], [0.3, 0.02]), "on one side");
        assert!(!between([1.05, 0.1], [1.05, -0.1]), "beyond its end");
        let now = plate.gap(&[0.0, 0.1], 1.0).unwrap();
        let passed = path_enters_solid(&plate, &[0.0, 0.1], &[0.0, -0.3], &now, 1e-5).unwrap();
        assert_eq!(passed.normal, [0.0, 1.0]);
        assert!((passed.distance + 0.201).abs() < 1e-12, "seen from the side that it came from: {passed:?}");
    }
}
