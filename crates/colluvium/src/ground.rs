//! Obstacles of a case as pictures show them.

use std::path::Path;

use colluvium_points::Surface;
use contour::ContourBuilder;

use crate::case::{Case, Standing};
use crate::plots::{Ground, Heights, within};

/// Samples along the longer side of the domain: lines in a plane.
const FINE: f64 = 300.0;
/// Nodes along the longer side of the domain: ground in space.
const COARSE: f64 = 96.0;

/// [`ground`] of the case in the folder of a run.
pub fn of_run(folder: &Path) -> Ground {
    match Case::load(&folder.join("case.json")) {
        Ok(case) => ground(&case),
        Err(errors) => Ground { missing: format!("obstacles: {}", errors.first()), ..Ground::default() },
    }
}

/// The obstacles of a case that stand still, over its domain and at coordinates of the map: as lines in a plane, and in space as
/// ground seen from above, against gravity.
pub fn ground(case: &Case) -> Ground {
    let still = case.obstacles.iter().filter(|obstacle| obstacle.motion.is_none()).count();
    let mut ground = match (still, case.dimension()) {
        (0, _) | (_, 0 | 1) => Ok(Ground::default()),
        (_, 2) => case.standing::<2>().map(|standing| in_plane(case, &standing)),
        _ => case.standing::<3>().map(|standing| in_space(case, &standing)),
    }
    .unwrap_or_else(|error| Ground { missing: format!("obstacles: {error}"), ..Ground::default() });
    if still < case.obstacles.len() && ground.missing.is_empty() {
        "obstacles that move".clone_into(&mut ground.missing);
    }
    ground
}

fn surfaces<'s, const D: usize>(
    standing: &'s [Standing<'_, D>],
) -> impl Iterator<Item = &'s dyn Surface<D>> + use<'s, D> {
    standing.iter().filter(|one| one.obstacle.motion.is_none()).map(|one| &*one.surface)
}

/// Where distances from the surfaces change their sign.
fn in_plane(case: &Case, standing: &[Standing<'_, 2>]) -> Ground {
    let (low, high) = (&case.domain.min, &case.domain.max);
    let sides = [high[0] - low[0], high[1] - low[1]];
    let step = sides[0].max(sides[1]) / FINE;
    // Two samples more than the domain needs: rings close along the outermost ones, outside of it.
    let counts = sides.map(|side| (side / step).ceil() as usize + 4);
    let first = [low[0] - 1.5 * step, low[1] - 1.5 * step];
    let (reach, origin) = (3.0 * step, case.origin());
    let window = [0, 1].map(|c| low[c] + origin[c]..high[c] + origin[c]);
    let mut lines = Vec::new();
    for surface in surfaces(standing) {
        let distance = |k: usize| {
            let x = [first[0] + (k % counts[0]) as f64 * step, first[1] + (k / counts[0]) as f64 * step];
            let far = if surface.contains(&x) { -reach } else { reach };
            surface.gap(&x, reach).map_or(far, |gap| gap.distance)
        };
        let values: Vec<f64> = (0..counts[0] * counts[1]).map(distance).collect();
        let builder = ContourBuilder::new(counts[0], counts[1], true).x_step(step).y_step(step);
        // The sample of number 0 lies half a step from the corner at which the rings count from.
        let builder =
            builder.x_origin(first[0] + origin[0] - 0.5 * step).y_origin(first[1] + origin[1] - 0.5 * step);
        let rings = builder.lines(&values, &[0.0]).unwrap_or_default();
        for ring in rings.iter().flat_map(|line| &line.geometry().0) {
            let line = straightened(ring.0.iter().map(|x| [x.x, x.y]), 0.05 * step);
            lines.extend(within(&line, &window));
        }
    }
    Ground { lines, ..Ground::default() }
}

/// A line without the corners that lie within `slack` (m) of the chord of their neighbours.
fn straightened(corners: impl Iterator<Item = [f64; 2]>, slack: f64) -> Vec<[f64; 2]> {
    let mut kept: Vec<[f64; 2]> = Vec::new();
    let mut passed: Vec<[f64; 2]> = Vec::new();
    for corner in corners {
        if let (Some(from), Some(last)) = (kept.last(), passed.last()) {
            let along = [corner[0] - from[0], corner[1] - from[1]];
            let length = along[0].hypot(along[1]).max(f64::MIN_POSITIVE);
            let off =
                |x: &[f64; 2]| ((x[0] - from[0]) * along[1] - (x[1] - from[1]) * along[0]).abs() / length;
            if passed.iter().any(|x| off(x) > slack) {
                kept.push(*last);
                passed.clear();
            }
        }
        if kept.is_empty() { kept.push(corner) } else { passed.push(corner) }
    }
    kept.extend(passed.pop());
    kept
}

/// The highest ground under each node of a lattice.
fn in_space(case: &Case, standing: &[Standing<'_, 3>]) -> Ground {
    let size = |axis: usize| case.gravity[axis].abs();
    let up =
        (0..3).max_by(|a, b| size(*a).total_cmp(&size(*b))).filter(|axis| size(*axis) > 0.0).unwrap_or(2);
    let [a, b] = [[1, 2], [0, 2], [0, 1]][up];
    let (low, high) = (&case.domain.min, &case.domain.max);
    let sides = [high[a] - low[a], high[b] - low[b]];
    let step = sides[0].max(sides[1]) / COARSE;
    let counts = sides.map(|side| (side / step).round().max(1.0) as usize + 1);
    let spacing = [0, 1].map(|c| sides[c] / (counts[c] - 1) as f64);
    let origin = case.origin();
    let top = |k: usize| {
        let mut x = [0.0; 3];
        x[a] = low[a] + (k % counts[0]) as f64 * spacing[0];
        x[b] = low[b] + (k / counts[0]) as f64 * spacing[1];
        x[up] = high[up];
        let heights = surfaces(standing).filter_map(|surface| below(surface, x, up, low[up], 1e-3 * step));
        heights.reduce(f64::max).map_or(f64::NAN, |height| height + origin[up])
    };
    let values = (0..counts[0] * counts[1]).map(top).collect();
    let origin = [low[a] + origin[a], low[b] + origin[b]];
    Ground { heights: Some(Heights { counts, origin, spacing, values }), ..Ground::default() }
}

/// Where a surface is met from `x` down along an axis, by steps as long as nothing is nearer; `None` where that begins in the
/// solid, or nothing is met above `bottom`.
fn below(surface: &dyn Surface<3>, mut x: [f64; 3], up: usize, bottom: f64, close: f64) -> Option<f64> {
    if surface.contains(&x) {
        return None;
    }
    while x[up] >= bottom {
        let gap = surface.gap(&x, f64::INFINITY)?.distance;
        if gap <= close {
            return Some(x[up]);
        }
        x[up] -= gap.max(close);
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn case(space: &str, domain: &serde_json::Value, obstacles: &serde_json::Value) -> Case {
        let (gravity, max) = if space == "3d" {
            (json!([0, 0, -9.81]), json!([100.2, 200.2, 303.9]))
        } else {
            (json!([0, -9.81]), json!([0.2, 3.9]))
        };
        let min: Vec<f64> = if space == "3d" { vec![100.1, 200.1, 303.8] } else { vec![0.1, 3.8] };
        let text = json!({
            "title": "ground", "space": space, "domain": domain, "gravity": gravity,
            "materials": { "sand": { "model": "linear-elastic", "density": 1600, "youngs_modulus": 1e6, "poissons_ratio": 0.3 } },
            "bodies": [{ "name": "sand", "material": "sand", "shape": { "kind": "box", "min": min, "max": max } }],
            "obstacles": obstacles,
            "stages": [{ "name": "fall", "duration": 1 }],
            "methods": { "mpm": { "cell_size": 0.1 } }
        });
        Case::from_json(&text.to_string()).unwrap()
    }

    #[test]
    fn lines_run_along_surfaces_and_what_moves_is_named() {
        let plane = json!({ "name": "slope", "shape": { "kind": "plane", "point": [0, 2], "normal": [1, 2] }, "wall": { "kind": "rough" } });
        let ball = json!({ "name": "ball", "shape": { "kind": "ball", "centre": [3, 3], "radius": 0.4 }, "wall": { "kind": "smooth" },
            "motion": { "velocity": [1, 0] } });
        let found =
            ground(&case("plane-strain", &json!({ "min": [0, 0], "max": [4, 4] }), &json!([plane, ball])));
        assert_eq!(found.missing, "obstacles that move");
        let [line] = &found.lines[..] else { panic!("{:?}", found.lines) };
        let [from, to] = &line[..] else { panic!("a straight line has two corners: {line:?}") };
        let near = |x: &[f64; 2], y: [f64; 2]| (x[0] - y[0]).hypot(x[1] - y[1]) < 2e-3;
        let ends = [[0.0, 2.0], [4.0, 0.0]];
        assert!(
            (near(from, ends[0]) && near(to, ends[1])) || (near(from, ends[1]) && near(to, ends[0])),
            "{line:?}"
        );
    }

    #[test]
    fn heights_are_those_of_the_highest_obstacle() {
        let obstacles = json!([
            { "name": "floor", "shape": { "kind": "plane", "point": [100, 200, 301], "normal": [1, 0, 4] }, "wall": { "kind": "rough" } },
            { "name": "ball", "shape": { "kind": "ball", "centre": [102, 202, 301.5], "radius": 1 }, "wall": { "kind": "smooth" } }
        ]);
        let case = case(
            "3d",
            &json!({ "min": [100, 200, 300], "max": [104, 204, 304], "origin": [100, 200, 300] }),
            &obstacles,
        );
        let heights = ground(&case).heights.unwrap();
        assert_eq!((heights.counts, heights.origin), ([97, 97], [100.0, 200.0]));
        for (k, height) in heights.values.iter().enumerate() {
            let [x, y] = [k % 97, k / 97].map(|i| i as f64 / 24.0);
            let far = (x - 2.0).hypot(y - 2.0);
            let floor = 1.0 - x / 4.0;
            let right = if far < 1.0 { (1.5 + (1.0 - far * far).sqrt()).max(floor) } else { floor };
            // Near the rim of the ball, upright, a way down passes close by.
            if !(0.9..1.001).contains(&far) {
                assert!((height - 300.0 - right).abs() < 2e-4, "{x} {y}: {height} for {right}");
            }
        }
    }
}
