//! Polygons in a plane.

/// Area, positive where the corners go round counter-clockwise.
pub fn signed_area(vertices: &[[f64; 2]]) -> f64 {
    let next = vertices.iter().cycle().skip(1);
    0.5 * vertices.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<f64>()
}

/// Coordinates along `axis` at which the line through `point` parallel to it may cross an edge.
pub fn polygon_crossings(vertices: &[[f64; 2]], point: &[f64], axis: usize) -> Vec<f64> {
    let (across, at) = (1 - axis, point[1 - axis]);
    let mut all = Vec::new();
    for (a, b) in vertices.iter().zip(vertices.iter().cycle().skip(1)) {
        if a[across].min(b[across]) > at || a[across].max(b[across]) < at {
            continue;
        }
        if a[across] == b[across] {
            all.extend([a[axis], b[axis]]);
        } else {
            let share = (at - a[across]) / (b[across] - a[across]);
            all.push(a[axis] + share * (b[axis] - a[axis]));
        }
    }
    all
}

/// Two ends.
pub type Edge = ([f64; 2], [f64; 2]);

/// Whether two edges cross within both.
pub fn edges_cross(a: Edge, b: Edge) -> bool {
    let side =
        |e: Edge, p: [f64; 2]| (e.1[0] - e.0[0]) * (p[1] - e.0[1]) - (e.1[1] - e.0[1]) * (p[0] - e.0[0]);
    side(a, b.0) * side(a, b.1) < 0.0 && side(b, a.0) * side(b, a.1) < 0.0
}

/// Crossing-number test; a point on an edge counts as inside.
pub fn polygon_contains(vertices: &[[f64; 2]], point: &[f64]) -> bool {
    let (x, y) = (point[0], point[1]);
    let mut inside = false;
    for (a, b) in vertices.iter().zip(vertices.iter().cycle().skip(1)) {
        let cross = (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
        let between = |u: f64, v: f64, w: f64| u.min(v) <= w && w <= u.max(v);
        if cross == 0.0 && between(a[0], b[0], x) && between(a[1], b[1], y) {
            return true;
        }
        if (a[1] > y) != (b[1] > y) && x < (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]) + a[0] {
            inside = !inside;
        }
    }
    inside
}
