//! Surface of a body in space as a mesh of quadrilaterals.

use std::collections::HashMap;
use std::ops::Range;

use colluvium_points::Surface;

/// Number of cells along the longest side of the meshed box.
const CELLS_ALONG_LONGEST: f64 = 20.0;

/// Corners (m) and faces of a surface within a window, each face with its corners counter-clockwise as seen from outside; none
/// where the surface does not come into the window.
///
/// The faces lie between cells with their centre in the solid and cells with their centre outside, the corners moved to the nearest point
/// of the surface: closed where the surface is, with rounded edges.
pub(super) fn surface_mesh(
    surface: &dyn Surface<3>,
    window: &[Range<f64>; 3],
) -> (Vec<[f64; 3]>, Vec<[usize; 4]>) {
    let mut shell = (Vec::new(), Vec::new());
    let (low, high) = surface.bounds();
    let ends: [Range<f64>; 3] =
        std::array::from_fn(|c| low[c].max(window[c].start)..high[c].min(window[c].end));
    let longest = ends.iter().map(|side| side.end - side.start).fold(0.0, f64::max);
    if ends.iter().any(|side| side.start > side.end) || longest <= 0.0 {
        return shell;
    }
    let step = longest / CELLS_ALONG_LONGEST;
    // A layer of cells around a bounded body closes it; the window cuts off an unbounded one.
    let first: [f64; 3] = std::array::from_fn(|c| ends[c].start - step);
    let counts: [usize; 3] =
        std::array::from_fn(|c| ((ends[c].end - ends[c].start) / step).round() as usize + 2);
    let place = |node: [usize; 3], shift: f64| -> [f64; 3] {
        std::array::from_fn(|c| first[c] + (node[c] as f64 + shift) * step)
    };
    let solid: Vec<bool> = (0..counts.iter().product())
        .map(|k| surface.contains(&place(cell_coordinates(k, &counts), 0.5)))
        .collect();
    let mut numbers: HashMap<[usize; 3], usize> = HashMap::new();
    for (k, inside) in solid.iter().enumerate() {
        let from = cell_coordinates(k, &counts);
        for c in 0..3 {
            if from[c] + 1 == counts[c] {
                continue;
            }
            let next = k + [1, counts[0], counts[0] * counts[1]][c];
            if solid[next] == *inside {
                continue;
            }
            let mut ring = [[0, 0], [1, 0], [1, 1], [0, 1]];
            if !inside {
                ring.reverse();
            }
            shell.1.push(ring.map(|[u, v]| {
                let mut node = from;
                node[c] += 1;
                node[(c + 1) % 3] += u;
                node[(c + 2) % 3] += v;
                *numbers.entry(node).or_insert_with(|| {
                    let x = place(node, 0.0);
                    shell.0.push(surface.gap(&x, f64::INFINITY).map_or(x, |nearest| nearest.position));
                    shell.0.len() - 1
                })
            }));
        }
    }
    shell
}

/// Indices along the axes of the cell of number `k`, with the first axis varying fastest.
fn cell_coordinates(k: usize, counts: &[usize; 3]) -> [usize; 3] {
    [k % counts[0], k / counts[0] % counts[1], k / (counts[0] * counts[1])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use colluvium_points::surface::{BallSurface, HalfSpace};

    /// Volume within the faces (m³), as the sum of tetrahedra from the origin.
    fn volume((corners, faces): &(Vec<[f64; 3]>, Vec<[usize; 4]>)) -> f64 {
        let det = |a: [f64; 3], b: [f64; 3], c: [f64; 3]| {
            (0..3)
                .map(|i| a[i] * (b[(i + 1) % 3] * c[(i + 2) % 3] - b[(i + 2) % 3] * c[(i + 1) % 3]))
                .sum::<f64>()
        };
        let face = |face: &[usize; 4]| {
            let [a, b, c, d] = face.map(|k| corners[k]);
            (det(a, b, c) + det(a, c, d)) / 6.0
        };
        faces.iter().map(face).sum()
    }

    #[test]
    fn the_surface_mesh_of_a_ball_is_closed_and_has_its_area() {
        let ball = BallSurface::new([1.0, -2.0, 3.0], 0.5, false).unwrap();
        let skin = surface_mesh(&ball, &[-9.0..9.0, -9.0..9.0, -9.0..9.0]);
        for corner in &skin.0 {
            let from: f64 = corner.iter().zip([1.0, -2.0, 3.0]).map(|(x, y)| (x - y) * (x - y)).sum();
            assert!((from.sqrt() - 0.5).abs() < 1e-12);
        }
        // Chords of a twentieth of the diameter lie within the ball by less than a percent.
        let whole = 4.0 / 3.0 * std::f64::consts::PI * 0.125;
        assert!((0.97 * whole..whole).contains(&volume(&skin)), "{} of {whole}", volume(&skin));
        // Each edge of a face belongs to one other face, in the opposite direction.
        let mut sides = std::collections::HashSet::new();
        for face in &skin.1 {
            for k in 0..4 {
                assert!(sides.insert((face[k], face[(k + 1) % 4])));
            }
        }
        assert!(sides.iter().all(|(a, b)| sides.contains(&(*b, *a))));
    }

    #[test]
    fn unbounded_surfaces_are_clipped_to_the_window() {
        let plane = HalfSpace::new([0.0, 0.0, 1.0], [0.0, 0.0, 1.0]).unwrap();
        let (corners, faces) = surface_mesh(&plane, &[0.0..2.0, 0.0..2.0, 0.0..2.0]);
        assert!(faces.len() >= 400 && corners.iter().all(|x| x[2] == 1.0), "{faces:?}");
        assert!(surface_mesh(&plane, &[0.0..2.0, 0.0..2.0, 3.0..4.0]).1.is_empty());
    }
}
