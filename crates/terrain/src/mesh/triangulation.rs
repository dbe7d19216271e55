//! Triangulation of the polygons of a mesh.

use colluvium_points::Outline;

/// Largest distance of corners from the plane of their polygon over its size. Quadrilaterals of rough terrain are warped; their two
/// possible triangulations differ by as much.
const PLANARITY_TOLERANCE: f64 = 0.1;

/// Share of an area that counts as round-off.
const ROUND_OFF: f64 = 1e-9;

/// Difference of two vectors.
fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|c| a[c] - b[c])
}

/// Scalar product of two vectors.
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Vector product of two vectors.
fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|c| {
        let (d, e) = ((c + 1) % 3, (c + 2) % 3);
        a[d] * b[e] - a[e] * b[d]
    })
}

/// Twice the area of a triangle in a plane (m²), positive where its corners run counter-clockwise.
fn double_area(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Triangulates a polygon by ear clipping (Meisters 1975, Polygons have ears). Triangles are indices of its corners (m) and have its sense
/// of rotation. A convex polygon becomes a fan around its first corner.
///
/// # Errors
/// When the polygon is not planar, has no area, or crosses itself.
pub(crate) fn triangulate(corners: &[[f64; 3]]) -> Result<Vec<[usize; 3]>, String> {
    if corners.len() <= 3 {
        return Ok((corners.len() == 3).then_some([0, 1, 2]).into_iter().collect());
    }
    let flat = in_plane(corners)?;
    let next = |k: usize| flat[(k + 1) % flat.len()];
    let area = 0.5 * (0..flat.len()).map(|k| flat[k][0] * next(k)[1] - flat[k][1] * next(k)[0]).sum::<f64>();
    let outline = Outline::new(vec![vec![flat.clone()]]).map_err(|_| CROSSED.to_owned())?;
    // A polygon wound twice, or in both senses, has another area than the signed sum.
    if (outline.area() - area).abs() > 1e-6 * area {
        return Err(CROSSED.to_owned());
    }
    let found = cut_ears(&flat, area);
    let covered: f64 = found.iter().map(|t| 0.5 * double_area(flat[t[0]], flat[t[1]], flat[t[2]])).sum();
    if found.len() + 2 != flat.len() || (covered - area).abs() > 1e-6 * area {
        return Err(
            "is a polygon that cannot be cut into triangles: cut it in the program that wrote it".to_owned()
        );
    }
    Ok(found)
}

/// Message about a polygon of a mesh that cannot be triangulated.
const CROSSED: &str = "is a polygon that crosses itself or has no area: repair it, or cut it into triangles, in the program that wrote it";

/// Corners in the plane of the polygon, in which they run counter-clockwise (m).
fn in_plane(corners: &[[f64; 3]]) -> Result<Vec<[f64; 2]>, String> {
    let from: Vec<[f64; 3]> = corners.iter().map(|x| minus(*x, corners[0])).collect();
    let end = |c: usize, start: f64, pick: fn(f64, f64) -> f64| from.iter().map(|x| x[c]).fold(start, pick);
    let sides: [f64; 3] =
        std::array::from_fn(|c| end(c, f64::NEG_INFINITY, f64::max) - end(c, f64::INFINITY, f64::min));
    let size = dot(sides, sides).sqrt();
    // Newell's normal, whose length is twice the area.
    let mut normal = [0.0; 3];
    for (k, a) in from.iter().enumerate() {
        let part = cross(*a, from[(k + 1) % from.len()]);
        (0..3).for_each(|c| normal[c] += part[c]);
    }
    let length = dot(normal, normal).sqrt();
    if !(length > ROUND_OFF * size * size) {
        return Err(CROSSED.to_owned());
    }
    let normal = normal.map(|c| c / length);
    let heights: Vec<f64> = from.iter().map(|x| dot(*x, normal)).collect();
    let mean = heights.iter().sum::<f64>() / heights.len() as f64;
    let off = heights.iter().map(|height| (height - mean).abs()).fold(0.0, f64::max);
    if off > PLANARITY_TOLERANCE * size {
        return Err(format!(
            "is a polygon whose corners lie up to {off:.3e} m off its plane, more than {PLANARITY_TOLERANCE} of its size, {size:.3e} m: cut it into \
             triangles in the program that wrote it"
        ));
    }
    let axis = (0..3).min_by(|a, b| normal[*a].abs().total_cmp(&normal[*b].abs())).unwrap_or(0);
    let mut other = [0.0; 3];
    other[axis] = 1.0;
    let first = cross(other, normal);
    let long = dot(first, first).sqrt();
    let first = first.map(|c| c / long);
    let second = cross(normal, first);
    Ok(from.iter().map(|x| [dot(*x, first), dot(*x, second)]).collect())
}

/// Triangles cut from a counter-clockwise polygon by ear clipping.
fn cut_ears(flat: &[[f64; 2]], area: f64) -> Vec<[usize; 3]> {
    let mut left: Vec<usize> = (0..flat.len()).collect();
    let (mut found, mut at, mut tried) = (Vec::with_capacity(flat.len() - 2), 1, 0);
    let smallest = ROUND_OFF * area;
    while left.len() > 2 && tried < left.len() {
        let count = left.len();
        let near = [left[(at + count - 1) % count], left[at % count], left[(at + 1) % count]];
        let [a, b, c] = near.map(|k| flat[k]);
        let holds = |k: &&usize| {
            let x = flat[**k];
            let within =
                [(a, b), (b, c), (c, a)].iter().all(|(from, to)| double_area(*from, *to, x) >= -smallest);
            within && x != a && x != b && x != c
        };
        if double_area(a, b, c) > smallest && !left.iter().any(|k| holds(&k)) {
            found.push(near);
            left.remove(at % count);
            at %= count;
            tried = 0;
        } else {
            at = (at + 1) % count;
            tried += 1;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Corners at a constant height, rotated so that corner `first` comes first.
    fn rotated_corners(flat: &[[f64; 2]], first: usize) -> Vec<[f64; 3]> {
        (0..flat.len()).map(|k| flat[(k + first) % flat.len()]).map(|[x, y]| [1e3 + x, y, 0.5 * x]).collect()
    }

    #[test]
    fn triangles_of_a_polygon_cover_it_once_for_any_first_corner() {
        let ell = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let dart = [[1.0, 0.0], [0.0, 2.0], [-1.0, 0.0], [0.0, 0.8]];
        // With corners in straight edges, and with a hole that a slit joins to the rim.
        let straight = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 2.0], [0.0, 2.0]];
        let holed = [
            [0.0, 0.0],
            [4.0, 0.0],
            [4.0, 4.0],
            [0.0, 4.0],
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 3.0],
            [3.0, 3.0],
            [3.0, 1.0],
            [1.0, 1.0],
        ];
        let cases: [(&[[f64; 2]], f64); 4] = [(&ell, 3.0), (&dart, 1.2), (&straight, 4.0), (&holed, 12.0)];
        for (flat, area) in cases {
            for first in 0..flat.len() {
                let corners = rotated_corners(flat, first);
                let found =
                    triangulate(&corners).unwrap_or_else(|why| panic!("{flat:?} from {first}: {why}"));
                assert_eq!(found.len(), flat.len() - 2);
                let plan = |k: usize| [corners[k][0], corners[k][1]];
                let parts = found.iter().map(|t| 0.5 * double_area(plan(t[0]), plan(t[1]), plan(t[2])));
                let sizes: f64 = parts.clone().map(f64::abs).sum();
                assert!(
                    (sizes - area).abs() < 1e-9 && (parts.sum::<f64>().abs() - area).abs() < 1e-9,
                    "{sizes}"
                );
            }
        }
        let square = rotated_corners(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], 0);
        assert_eq!(triangulate(&square), Ok(vec![[0, 1, 2], [0, 2, 3]]));
    }

    #[test]
    fn polygons_that_cross_themselves_are_bent_or_have_no_area_are_refused() {
        let problem = |corners: &[[f64; 3]]| triangulate(corners).unwrap_err();
        let bow = [[0.0, 0.0, 0.0], [2.0, 2.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        assert!(problem(&bow).contains("crosses itself"));
        let twice: Vec<[f64; 3]> = rotated_corners(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], 0).repeat(2);
        assert!(problem(&twice).contains("crosses itself"));
        let bent = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.8], [1.0, 1.0, 0.0], [0.0, 1.0, 0.8]];
        assert!(problem(&bent).contains("off its plane"));
        assert!(
            problem(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 0.0, 0.0]]).contains("has no area")
        );
        assert!(triangulate(&[[0.0; 3]; 5]).is_err() && triangulate(&[[f64::NAN; 3]; 5]).is_err());
        assert_eq!(triangulate(&[[0.0; 3]; 2]), Ok(Vec::new()));
    }
}
