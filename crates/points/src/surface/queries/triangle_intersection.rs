//! Intersection test of two triangles.

use crate::surface::vector::{cross, difference, dot};

/// Share of the size of a triangle and a segment within which they only touch: the round-off of files in single precision.
const TOUCH_TOLERANCE: f64 = 1e-6;

/// Whether two triangles (m) intersect. Triangles that touch, or lie in one plane, do not.
pub(crate) fn triangles_intersect(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> bool {
    let edges = |t: &[[f64; 3]; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    edges(a).iter().any(|edge| segment_pierces_triangle(edge, b))
        || edges(b).iter().any(|edge| segment_pierces_triangle(edge, a))
}

/// Whether a segment crosses the interior of a triangle.
fn segment_pierces_triangle([from, to]: &[[f64; 3]; 2], [a, b, c]: &[[f64; 3]; 3]) -> bool {
    // Six times the volume of the tetrahedron of a triangle and a position, with a sign by the side.
    let volume = |x: &[f64; 3], y: &[f64; 3], z: &[f64; 3], place: &[f64; 3]| {
        dot(&cross(&difference(y, x), &difference(z, x)), &difference(place, x))
    };
    let size =
        [to, b, c, from].iter().map(|v| difference(v, a)).map(|v| dot(&v, &v)).fold(0.0, f64::max).sqrt();
    let smallest = TOUCH_TOLERANCE * size.powi(3);
    let [before, after] = [from, to].map(|end| volume(a, b, c, end));
    if before.abs() <= smallest || after.abs() <= smallest || (before > 0.0) == (after > 0.0) {
        return false;
    }
    let around = [(a, b), (b, c), (c, a)].map(|(x, y)| volume(from, to, x, y));
    around.iter().all(|v| *v > smallest) || around.iter().all(|v| *v < -smallest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn triangles_intersect_where_an_edge_crosses_and_not_where_they_touch() {
        let floor = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
        let upright = |z: f64, x: f64| [[x, 0.3, z], [x, 0.6, z], [x, 0.4, z + 1.0]];
        assert!(
            triangles_intersect(&floor, &upright(-0.5, 0.5))
                && triangles_intersect(&upright(-0.5, 0.5), &floor)
        );
        assert!(!triangles_intersect(&floor, &upright(0.0, 0.5)), "it stands on it");
        assert!(!triangles_intersect(&floor, &upright(0.1, 0.5)));
        assert!(!triangles_intersect(&floor, &upright(-0.5, 2.5)), "beside it");
        assert!(!triangles_intersect(&floor, &floor.map(|[x, y, z]| [x + 0.1, y + 0.1, z])), "in one plane");
    }
}
