//! Rigid geometry of the obstacles of a case for pictures.

use std::ops::Range;
use std::path::Path;

use colluvium_points::Surface;
use contour::ContourBuilder;

use crate::case::description::ObstacleMotion;
use crate::case::run::changed_inputs;
use crate::case::{Case, PlacedObstacle};
use crate::output::run_pictures::read_case_value;
use crate::plots::{Heights, MovingLines, MovingSurface, RigidGeometry, clip_line};

/// Number of samples along the longer side of the domain, for surface lines in a plane.
const SAMPLES_IN_PLANE: f64 = 300.0;
/// Number of nodes along the longer side of the domain, for the ground in space.
const NODES_IN_SPACE: f64 = 96.0;
/// Number of times at which the part of a moving body inside the domain is determined.
const MOTION_SAMPLES: usize = 64;
/// Largest distance beyond the domain, over the size of the domain, at which a moving body is drawn.
const MAX_DISTANCE_DRAWN: f64 = 2.0;

/// [`rigid_geometry`] of the case in the folder of a run; empty where its files have changed since the run.
pub fn rigid_geometry_of_run(folder: &Path) -> RigidGeometry {
    // A case without obstacles needs neither its files nor its libraries.
    if read_case_value(folder).is_ok_and(|case| case["obstacles"].as_array().is_none_or(Vec::is_empty)) {
        return RigidGeometry::default();
    }
    match case_of_run(folder) {
        Ok(case) => rigid_geometry(&case),
        Err(problem) => {
            RigidGeometry { missing: format!("obstacles: {problem}"), ..RigidGeometry::default() }
        }
    }
}

/// Case in the folder of a run with the files that it names.
///
/// # Errors
/// When one of the files is missing or has changed since the run, with its name.
pub fn case_of_run(folder: &Path) -> Result<Case, String> {
    let case = Case::from_file(&folder.join("case.json")).map_err(|errors| errors.first().to_string())?;
    let changed = changed_inputs(folder, &case).unwrap_or_default();
    match changed.first() {
        Some(file) => Err(format!("{file} has changed since the run")),
        None => Ok(case),
    }
}

/// Obstacles of a case over its domain in map coordinates. In a plane they are lines; in space, static ones are heights of the ground and
/// moving ones surfaces.
pub fn rigid_geometry(case: &Case) -> RigidGeometry {
    if case.obstacles.is_empty() {
        return RigidGeometry::default();
    }
    match case.dimension() {
        0 | 1 => Ok(RigidGeometry::default()),
        2 => case.placed_obstacles::<2>().map(|standing| plane_geometry(case, &standing)),
        _ => case.placed_obstacles::<3>().map(|standing| space_geometry(case, &standing)),
    }
    .unwrap_or_else(|error| RigidGeometry {
        missing: format!("obstacles: {error}"),
        ..RigidGeometry::default()
    })
}

/// Lines of the obstacles in a plane, in map coordinates; those of moving obstacles relative to their centre.
fn plane_geometry(case: &Case, standing: &[PlacedObstacle<'_, 2>]) -> RigidGeometry {
    let domain = domain_ranges::<2>(case);
    let mut ground = RigidGeometry::default();
    for PlacedObstacle { obstacle, surface, .. } in standing {
        let origin = [case.origin()[0], case.origin()[1]];
        let Some(motion) = &obstacle.motion else {
            ground.lines.extend(surface_lines(&**surface, &domain, origin));
            continue;
        };
        let centre = rotation_centre(motion, &domain);
        ground.moving.push(MovingLines {
            lines: surface_lines(&**surface, &swept_box(case, motion, &domain), centre.map(|x| -x)),
            reference_point: [0, 1].map(|c| origin[c] + centre[c]),
            motion: ObstacleMotion { centre: Vec::new(), ..motion.clone() },
        });
    }
    ground
}

/// Extent of the domain along each axis (m).
fn domain_ranges<const D: usize>(case: &Case) -> [Range<f64>; D] {
    std::array::from_fn(|c| case.domain.min[c]..case.domain.max[c])
}

/// Centre of rotation of a body (m), the lower end of the domain along axes without one.
fn rotation_centre<const D: usize>(motion: &ObstacleMotion, domain: &[Range<f64>; D]) -> [f64; D] {
    std::array::from_fn(|c| motion.centre.get(c).copied().unwrap_or(domain[c].start))
}

/// Box around the part of a moving obstacle that is in the domain at some time, in the coordinates of its initial position.
fn swept_box<const D: usize>(
    case: &Case,
    motion: &ObstacleMotion,
    domain: &[Range<f64>; D],
) -> [Range<f64>; D] {
    let duration: f64 = case.stages.iter().map(|stage| stage.duration).sum();
    let mut passed = domain.clone();
    for sample in 0..=MOTION_SAMPLES {
        let frame = motion.transform::<D>(duration * sample as f64 / MOTION_SAMPLES as f64);
        for corner in 0..1 << D {
            let end = |c: usize| if corner >> c & 1 > 0 { domain[c].end } else { domain[c].start };
            let x = frame.to_body(&std::array::from_fn(end));
            for c in 0..D {
                let largest = MAX_DISTANCE_DRAWN * (domain[c].end - domain[c].start);
                passed[c].start = passed[c].start.min(x[c]).max(domain[c].start - largest);
                passed[c].end = passed[c].end.max(x[c]).min(domain[c].end + largest);
            }
        }
    }
    passed
}

/// Lines at which the distance from a surface is zero, within a window (m) and shifted by `offset` (m).
fn surface_lines(surface: &dyn Surface<2>, window: &[Range<f64>; 2], offset: [f64; 2]) -> Vec<Vec<[f64; 2]>> {
    let sides = [0, 1].map(|c| window[c].end - window[c].start);
    let step = sides[0].max(sides[1]) / SAMPLES_IN_PLANE;
    // Two samples more than the window needs: rings close along the outermost ones, outside it.
    let counts = sides.map(|side| (side / step).ceil() as usize + 4);
    let first = [0, 1].map(|c| window[c].start - 1.5 * step);
    let reach = 3.0 * step;
    let distance = |k: usize| {
        let x = [first[0] + (k % counts[0]) as f64 * step, first[1] + (k / counts[0]) as f64 * step];
        let far = if surface.contains(&x) { -reach } else { reach };
        surface.gap(&x, reach).map_or(far, |gap| gap.distance)
    };
    let values: Vec<f64> = (0..counts[0] * counts[1]).map(distance).collect();
    let builder = ContourBuilder::new(counts[0], counts[1], true).x_step(step).y_step(step);
    // Sample 0 lies half a step from the corner that the rings are relative to.
    let corner = [0, 1].map(|c| first[c] + offset[c] - 0.5 * step);
    let rings = builder.x_origin(corner[0]).y_origin(corner[1]).lines(&values, &[0.0]).unwrap_or_default();
    let window = [0, 1].map(|c| window[c].start + offset[c]..window[c].end + offset[c]);
    let mut lines = Vec::new();
    for ring in rings.iter().flat_map(|line| &line.geometry().0) {
        let line = simplify_line(ring.0.iter().map(|x| [x.x, x.y]), 0.05 * step);
        lines.extend(clip_line(&line, &window));
    }
    lines
}

/// Line without the corners that are within `slack` (m) of the chord of their neighbours.
fn simplify_line(corners: impl Iterator<Item = [f64; 2]>, slack: f64) -> Vec<[f64; 2]> {
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

/// Heights and moving surfaces of the obstacles in space, in map coordinates.
fn space_geometry(case: &Case, standing: &[PlacedObstacle<'_, 3>]) -> RigidGeometry {
    let domain = domain_ranges::<3>(case);
    let mut ground = RigidGeometry { heights: top_heights(case, standing), ..RigidGeometry::default() };
    for PlacedObstacle { obstacle, surface, .. } in standing {
        let Some(motion) = &obstacle.motion else { continue };
        let centre = rotation_centre(motion, &domain);
        let (corners, faces) =
            crate::output::closed_surface::surface_mesh(&**surface, &swept_box(case, motion, &domain));
        ground.shells.push(MovingSurface {
            corners: corners.iter().map(|x| std::array::from_fn(|c| x[c] - centre[c])).collect(),
            faces,
            reference_point: std::array::from_fn(|c| case.origin()[c] + centre[c]),
            motion: ObstacleMotion { centre: Vec::new(), ..motion.clone() },
        });
    }
    ground
}

/// Height of the highest static ground under each node of a lattice; `None` without static obstacles.
fn top_heights(case: &Case, standing: &[PlacedObstacle<'_, 3>]) -> Option<Heights> {
    let still = || standing.iter().filter(|one| one.obstacle.motion.is_none());
    still().next()?;
    let size = |axis: usize| case.gravity[axis].abs();
    let up =
        (0..3).max_by(|a, b| size(*a).total_cmp(&size(*b))).filter(|axis| size(*axis) > 0.0).unwrap_or(2);
    let [a, b] = [[1, 2], [0, 2], [0, 1]][up];
    let (low, high) = (&case.domain.min, &case.domain.max);
    let sides = [high[a] - low[a], high[b] - low[b]];
    let step = sides[0].max(sides[1]) / NODES_IN_SPACE;
    let counts = sides.map(|side| (side / step).round().max(1.0) as usize + 1);
    let spacing = [0, 1].map(|c| sides[c] / (counts[c] - 1) as f64);
    let origin = case.origin();
    let top = |k: usize| {
        let mut x = [0.0; 3];
        x[a] = low[a] + (k % counts[0]) as f64 * spacing[0];
        x[b] = low[b] + (k / counts[0]) as f64 * spacing[1];
        x[up] = high[up];
        let heights = still().filter_map(|one| ray_down(&*one.surface, x, up, low[up], 1e-3 * step));
        heights.reduce(f64::max).map_or(f64::NAN, |height| height + origin[up])
    };
    let values = (0..counts[0] * counts[1]).map(top).collect();
    let origin = [low[a] + origin[a], low[b] + origin[b]];
    Some(Heights { counts, origin, spacing, values })
}

/// Intersection of a surface with a ray from `x` down along an axis, found by steps as long as the distance to the surface. `None` where
/// `x` is in the solid, or the surface is not reached above `bottom`.
fn ray_down(surface: &dyn Surface<3>, mut x: [f64; 3], up: usize, bottom: f64, close: f64) -> Option<f64> {
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
    fn lines_run_along_surfaces_and_move_with_them() {
        let plane = json!({ "name": "slope", "shape": { "kind": "plane", "point": [0, 2], "normal": [1, 2] }, "wall": { "kind": "rough" } });
        let ball = json!({ "name": "ball", "shape": { "kind": "ball", "centre": [6, 3], "radius": 0.4 }, "wall": { "kind": "smooth" },
            "motion": { "velocity": [-3, 0] } });
        let found = rigid_geometry(&case(
            "plane-strain",
            &json!({ "min": [0, 0], "max": [4, 4] }),
            &json!([plane, ball]),
        ));
        let [ball] = &found.moving[..] else { panic!("{:?}", found.moving) };
        assert!(found.missing.is_empty() && !ball.lines.is_empty());
        for at in found.lines_at(0.5).iter().skip(1).flatten() {
            assert!(
                ((at[0] - 4.5).hypot(at[1] - 3.0) - 0.4).abs() < 0.02,
                "it comes in from outside: {at:?}"
            );
        }
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
    fn a_moving_ball_is_drawn_as_a_shell_about_its_centre() {
        let ball = json!({ "name": "ball", "shape": { "kind": "ball", "centre": [106, 202, 302], "radius": 0.5 },
            "wall": { "kind": "smooth" }, "motion": { "velocity": [-3, 0, 0], "rotation": 90, "centre": [106, 202, 302], "axis": [0, 0, 1] } });
        let domain = json!({ "min": [100, 200, 300], "max": [104, 204, 304], "origin": [100, 200, 300] });
        let found = rigid_geometry(&case("3d", &domain, &json!([ball])));
        let [shell] = &found.shells[..] else { panic!("{found:?}") };
        assert!(found.heights.is_none() && found.missing.is_empty() && shell.faces.len() > 600);
        assert!(
            shell.corners.iter().all(|x| (x.iter().map(|x| x * x).sum::<f64>().sqrt() - 0.5).abs() < 1e-9)
        );
        let (at, turned) = shell.pose(1.0);
        for (found, right) in at.iter().zip([103.0, 202.0, 302.0]) {
            assert!((found - right).abs() < 1e-9, "{at:?}");
        }
        assert!((turned[1][0] - 1.0).abs() < 1e-12, "{turned:?}");
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
        let heights = rigid_geometry(&case).heights.unwrap();
        assert_eq!((heights.counts, heights.origin), ([97, 97], [100.0, 200.0]));
        for (k, height) in heights.values.iter().enumerate() {
            let [x, y] = [k % 97, k / 97].map(|i| i as f64 / 24.0);
            let far = (x - 2.0).hypot(y - 2.0);
            let floor = 1.0 - x / 4.0;
            let right = if far < 1.0 { (1.5 + (1.0 - far * far).sqrt()).max(floor) } else { floor };
            // Near the rim of the upright ball, a ray down passes close by.
            if !(0.9..1.001).contains(&far) {
                assert!((height - 300.0 - right).abs() < 2e-4, "{x} {y}: {height} for {right}");
            }
        }
    }
}
