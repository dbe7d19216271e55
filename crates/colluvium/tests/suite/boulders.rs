//! Rigid boulders that fall, slide and roll on a raster in three dimensions, alike in MPM and SPH.

use std::path::Path;

use colluvium::case::{Case, Method, Snapshot, Solver};
use colluvium::mpm::Mpm;
use colluvium::points::Raster;
use colluvium::points::surface::HeightField;
use colluvium::sph::Sph;
use colluvium_testkit::write_ascii_grid;
use serde_json::{Value, json};

const METHODS: [&dyn Method; 2] = [&Mpm, &Sph];
const GRAVITY: f64 = 9.81;
/// Width of the points (m).
const WIDTH: f64 = 0.05;
/// Time step of both methods (s).
const STEP: f64 = 5e-4;
/// Steps between two samples.
const SAMPLE_STEPS: usize = 20;

/// Heights (m) of the nodes of a raster, 0.2 m apart.
type Heights = fn(f64, f64) -> f64;

/// Heights (m) of a plane that falls by 0.4 along x and by 0.3 along y: its slope is one half.
fn plane(x: f64, y: f64) -> f64 {
    -0.4 * x - 0.3 * y
}

/// Heights (m) of a slope of 30° that ends on level ground, with bumps across.
fn hillside(x: f64, y: f64) -> f64 {
    0.577 * (1.2 - x).max(0.0) + 0.02 * (3.0 * y).sin() * (2.0 * x).cos()
}

fn ground(heights: Heights) -> HeightField {
    HeightField::new(Raster::from_function([21, 16], [-0.8, -1.4], [0.2, 0.2], heights)).unwrap()
}

/// Case of a free boulder on the ground of a raster file.
fn boulder_on_ground(file: &Path, shape: &Value, friction: f64) -> Case {
    let case = json!({
        "title": "boulder", "space": "3d", "domain": { "min": [-0.8, -1.4, -2], "max": [3.2, 1.6, 2] }, "gravity": [0, 0, -GRAVITY],
        "materials": { "rock": { "model": "linear-elastic", "density": 2500, "youngs_modulus": 1e7, "poissons_ratio": 0.2 } },
        "bodies": [{ "name": "boulder", "material": "rock", "rigid": true, "shape": shape }],
        "obstacles": [{ "name": "ground", "shape": { "kind": "raster", "file": file.display().to_string() },
                        "wall": { "kind": "frictional", "friction_coefficient": friction } }],
        "stages": [{ "name": "s", "duration": 2,
                     "motions": [{ "target": "boulder", "velocity": [null, null, null], "turns": true }] }],
        "methods": { "sph": { "spacing": WIDTH, "time_step": STEP },
                     "mpm": { "cell_size": 2.0 * WIDTH, "time_step": STEP, "obstacles": "points" } }
    });
    Case::from_json(&case.to_string()).unwrap()
}

/// Sampled state of a boulder.
#[derive(Clone, Copy, Debug)]
struct BoulderSample {
    time: f64,
    /// Centre of mass (m).
    centre: [f64; 3],
    /// Velocity (m/s).
    velocity: [f64; 3],
    /// Kinetic energy and that of its weight (J).
    energy: f64,
    /// Depth of its lowest corner in the ground (m).
    depth: f64,
    /// Angle of rotation, 0 to π (rad).
    turned: f64,
}

/// Unit vectors along the axes at the start, rotated with the points.
fn axes(start: &Snapshot, now: &Snapshot) -> [[f64; 3]; 3] {
    // A point with a neighbour along each axis.
    let near = |from: &[f64; 3], axis: usize| {
        let is = |x: &[f64; 3]| {
            (0..3).all(|c| (x[c] - from[c] - if c == axis { WIDTH } else { 0.0 }).abs() < 1e-6)
        };
        start.positions.iter().position(is)
    };
    let found = start.positions.iter().enumerate().find_map(|(k, x)| {
        let [a, b, c] = [0, 1, 2].map(|axis| near(x, axis));
        Some((k, [a?, b?, c?]))
    });
    let (k, to) = found.unwrap();
    to.map(|n| std::array::from_fn(|c| (now.positions[n][c] - now.positions[k][c]) / WIDTH))
}

fn sample(solver: &dyn Solver, start: &Snapshot, ground: &HeightField) -> BoulderSample {
    let now = solver.snapshot();
    let (count, axes) = (now.positions.len() as f64, axes(start, &now));
    let mean =
        |values: &[[f64; 3]]| std::array::from_fn(|c| values.iter().map(|v| v[c]).sum::<f64>() / count);
    let (mut depth, half) = (f64::NEG_INFINITY, 0.5 * WIDTH);
    for x in &now.positions {
        for corner in 0..8 {
            let off = |c: usize| {
                (0..3).map(|a| if corner >> a & 1 == 0 { -half } else { half } * axes[a][c]).sum::<f64>()
            };
            let at: [f64; 3] = std::array::from_fn(|c| x[c] + off(c));
            depth = depth.max(ground.height(at[0], at[1]).unwrap() - at[2]);
        }
    }
    let budget = solver.budget().unwrap();
    BoulderSample {
        time: solver.time(),
        centre: mean(&now.positions),
        velocity: mean(now.vectors("velocity").unwrap()),
        energy: budget.kinetic + budget.potential,
        depth,
        turned: (0.5 * ((0..3).map(|c| axes[c][c]).sum::<f64>() - 1.0)).clamp(-1.0, 1.0).acos(),
    }
}

/// Sampled states of a boulder on a raster of these heights.
fn trajectory(
    method: &dyn Method,
    (shape, heights, friction): (&Value, Heights, f64),
    duration: f64,
) -> Vec<BoulderSample> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ground.asc");
    let ground = ground(heights);
    write_ascii_grid(&file, [-0.8, -1.4], [21, 16], 0.2, heights);
    let case = boulder_on_ground(&file, shape, friction);
    let mut solver = method.build(&case).unwrap();
    solver.begin_stage(0, 0.0).unwrap();
    let start = solver.snapshot();
    let mut samples = vec![sample(&*solver, &start, &ground)];
    while solver.time() < duration {
        (0..SAMPLE_STEPS).for_each(|_| {
            solver.step(STEP).unwrap();
        });
        samples.push(sample(&*solver, &start, &ground));
    }
    samples
}

fn size(vector: [f64; 3]) -> f64 {
    vector.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// Velocity (m/s) of a block that slides on the plane by Coulomb's law, `duration` (s) after it had the velocity `from`, in small steps:
/// the driving force has the direction of the slope, friction that of the velocity.
fn slid(from: [f64; 3], friction: f64, duration: f64) -> [f64; 3] {
    let normal = [0.4, 0.3, 1.0].map(|c: f64| c / 1.25f64.sqrt());
    let (mut v, steps) = (from, 1000);
    let dt = duration / f64::from(steps);
    for _ in 0..steps {
        let speed = size(v);
        let pressed = GRAVITY * normal[2];
        v = std::array::from_fn(|c| {
            let driving = pressed * normal[c] - if c == 2 { GRAVITY } else { 0.0 };
            v[c] + dt * (driving - friction * pressed * v[c] / speed)
        });
    }
    v
}

/// Largest rise of kinetic plus potential energy between two samples (J).
fn rise(samples: &[BoulderSample]) -> f64 {
    samples.windows(2).map(|pair| pair[1].energy - pair[0].energy).fold(f64::NEG_INFINITY, f64::max)
}

/// Largest distance between two boulders up to a time (m).
fn apart([one, other]: &[Vec<BoulderSample>; 2], until: f64) -> f64 {
    let far =
        |(a, b): (&BoulderSample, &BoulderSample)| size(std::array::from_fn(|c| a.centre[c] - b.centre[c]));
    one.iter().zip(other).filter(|(sample, _)| sample.time <= until).map(far).fold(0.0, f64::max)
}

#[test]
fn a_cube_falls_on_an_inclined_raster_lies_down_and_slides_by_coulombs_law() {
    let cube = json!({ "kind": "box", "min": [0, 0, 0.05], "max": [0.2, 0.2, 0.25] });
    let friction = 0.2;
    let trajectories = METHODS.map(|method| trajectory(method, (&cube, plane, friction), 0.75));
    for (method, samples) in METHODS.iter().zip(&trajectories) {
        let name = method.name();
        // The boulder has come down on a corner and an edge, and lies flat.
        let [lies, last] = [0.45, 0.75].map(|time| {
            *samples.iter().min_by(|a, b| (a.time - time).abs().total_cmp(&(b.time - time).abs())).unwrap()
        });
        let exact = slid(lies.velocity, friction, last.time - lies.time);
        let gained = std::array::from_fn(|c| last.velocity[c] - lies.velocity[c]);
        let off: [f64; 3] = std::array::from_fn(|c| last.velocity[c] - exact[c]);
        // As for a block in the plane.
        assert!(size(off) < 5e-3 * size(gained), "{name}: {gained:?}, off by {off:?}");
        assert!(rise(samples) < 1e-5 * samples[0].energy, "{name}: {}", rise(samples));
        let deepest = samples.iter().map(|sample| sample.depth).fold(f64::NEG_INFINITY, f64::max);
        assert!(deepest < 1e-4 * WIDTH, "{name}: {deepest}");
    }
    // The impacts begin up to a step apart.
    assert!(apart(&trajectories, 0.75) < 0.01, "{}", apart(&trajectories, 0.75));
}

#[test]
fn a_boulder_rolls_down_a_raster_without_energy_gain_and_equally_in_both_methods() {
    let ball = json!({ "kind": "ball", "centre": [0, 0, 1.1], "radius": 0.2 });
    let trajectories = METHODS.map(|method| trajectory(method, (&ball, hillside, 0.6), 0.9));
    for (method, samples) in METHODS.iter().zip(&trajectories) {
        let (name, first, last) = (method.name(), samples[0], samples[samples.len() - 1]);
        assert!(last.turned > 1.0 && last.centre[0] > 0.8, "{name}: {last:?}");
        assert!(rise(samples) < 1e-5 * first.energy, "{name}: {}", rise(samples));
        // A corner that lands beyond an edge between triangles, undetected by the contact search, is below the ground for a step.
        let deepest = samples.iter().map(|sample| sample.depth).fold(f64::NEG_INFINITY, f64::max);
        assert!(deepest < 0.01 * WIDTH, "{name}: {deepest}");
    }
    // From corner to corner both roll alike, until the boulder tips over a corner to one side or the other.
    assert!(apart(&trajectories, 0.55) < 0.02 * WIDTH, "{}", apart(&trajectories, 0.55));
    assert!(apart(&trajectories, 0.9) < 0.5 * 0.2, "{}", apart(&trajectories, 0.9));
}
