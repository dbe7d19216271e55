//! Nearest point of a segment (2D) or a triangle (3D).

use crate::surface::vector::{add_scaled, cross, difference, dot, unit};

/// Feature of a facet on which the nearest point lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FacetFeature {
    /// Interior of the facet.
    Face,
    /// Edge of a triangle between this corner and the next.
    Edge(usize),
    /// Corner of this number.
    Corner(usize),
}

/// Point of the facet with these corners nearest to `x` (m), and the feature on which it lies: of a segment in two dimensions, a triangle
/// in three (Ericson 2005, Real-Time Collision Detection, §5.1.5).
pub(crate) fn nearest_on_facet<const D: usize>(
    corners: &[[f64; D]; D],
    x: &[f64; D],
) -> ([f64; D], FacetFeature) {
    match D {
        2 => nearest_on_segment(corners, x),
        3 => nearest_on_triangle(corners, x),
        _ => (corners[0], FacetFeature::Corner(0)),
    }
}

/// Distance (m) of a position in a plane from a polyline with these corners; infinite with fewer than two corners.
pub fn distance_to_line(line: &[[f64; 2]], x: [f64; 2]) -> f64 {
    let of_piece = |piece: &[[f64; 2]]| {
        let place = nearest_on_facet(&[piece[0], piece[1]], &x).0;
        (x[0] - place[0]).hypot(x[1] - place[1])
    };
    line.windows(2).map(of_piece).fold(f64::INFINITY, f64::min)
}

/// Nearest point of a segment, and whether it is at an end.
fn nearest_on_segment<const D: usize>(corners: &[[f64; D]; D], x: &[f64; D]) -> ([f64; D], FacetFeature) {
    let edge = difference(&corners[1], &corners[0]);
    let t = dot(&difference(x, &corners[0]), &edge) / dot(&edge, &edge);
    if !(t > 0.0) {
        (corners[0], FacetFeature::Corner(0))
    } else if t >= 1.0 {
        (corners[1], FacetFeature::Corner(1))
    } else {
        (add_scaled(&corners[0], t, &edge), FacetFeature::Face)
    }
}

/// Nearest point of a triangle, and whether it is on an edge or a vertex.
fn nearest_on_triangle<const D: usize>(corners: &[[f64; D]; D], x: &[f64; D]) -> ([f64; D], FacetFeature) {
    let [a, b, c] = [&corners[0], &corners[1], &corners[2]];
    let (ab, ac) = (difference(b, a), difference(c, a));
    let from_a = difference(x, a);
    let (d1, d2) = (dot(&ab, &from_a), dot(&ac, &from_a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (*a, FacetFeature::Corner(0));
    }
    let from_b = difference(x, b);
    let (d3, d4) = (dot(&ab, &from_b), dot(&ac, &from_b));
    if d3 >= 0.0 && d4 <= d3 {
        return (*b, FacetFeature::Corner(1));
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return (add_scaled(a, d1 / (d1 - d3), &ab), FacetFeature::Edge(0));
    }
    let from_c = difference(x, c);
    let (d5, d6) = (dot(&ab, &from_c), dot(&ac, &from_c));
    if d6 >= 0.0 && d5 <= d6 {
        return (*c, FacetFeature::Corner(2));
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (add_scaled(a, d2 / (d2 - d6), &ac), FacetFeature::Edge(2));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return (add_scaled(b, t, &difference(c, b)), FacetFeature::Edge(1));
    }
    let share = 1.0 / (va + vb + vc);
    (add_scaled(&add_scaled(a, vb * share, &ab), vc * share, &ac), FacetFeature::Face)
}

/// Unit normal of a facet: to the left of a segment from its first corner to its second; of a triangle, towards the side from which its
/// corners run counter-clockwise. `None` for a facet without extent.
pub(crate) fn facet_normal<const D: usize>(corners: &[[f64; D]; D]) -> Option<[f64; D]> {
    let edge = |k: usize| -> [f64; 3] {
        std::array::from_fn(|c| if c < D { corners[k][c] - corners[0][c] } else { 0.0 })
    };
    let full = match D {
        2 => {
            let e = edge(1);
            [-e[1], e[0], 0.0]
        }
        3 => cross(&edge(1), &edge(2)),
        _ => return None,
    };
    unit::<D>(&std::array::from_fn(|c| full[c]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_nearest_position_on_a_triangle_has_the_minimum_distance(
            corners in proptest::array::uniform3(proptest::array::uniform3(-1.0..1.0f64)),
            x in proptest::array::uniform3(-2.0..2.0f64), shares in proptest::collection::vec((0.0..1.0f64, 0.0..1.0f64), 40),
        ) {
            let (place, _) = nearest_on_facet(&corners, &x);
            let smallest = dot(&difference(&x, &place), &difference(&x, &place));
            for (s, t) in shares {
                let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
                let other: [f64; 3] = std::array::from_fn(|c| {
                    corners[0][c] + s * (corners[1][c] - corners[0][c]) + t * (corners[2][c] - corners[0][c])
                });
                prop_assert!(dot(&difference(&x, &other), &difference(&x, &other)) >= smallest - 1e-12);
            }
        }
    }

    #[test]
    fn a_segment_has_its_normal_on_the_left() {
        assert_eq!(facet_normal(&[[0.0, 0.0], [2.0, 0.0]]), Some([0.0, 1.0]));
        assert_eq!(facet_normal(&[[1.0, 1.0], [1.0, 1.0]]), None);
        assert_eq!(facet_normal(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 3.0, 0.0]]), Some([0.0, 0.0, 1.0]));
    }
}
