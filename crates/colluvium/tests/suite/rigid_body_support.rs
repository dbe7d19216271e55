//! Rigid bodies that rest, slide, tip and fall on walls and obstacles, alike in MPM and SPH.

use colluvium::case::{Case, Method, RunOptions, RunReport, run};
use colluvium::mpm::Mpm;
use colluvium::sph::Sph;
use serde_json::{Value, json};

const METHODS: [&dyn Method; 2] = [&Mpm, &Sph];

/// Level ground in the plane.
#[derive(Clone, Copy, Debug)]
enum Ground {
    /// Wall at a side of the domain.
    Wall,
    /// Obstacle with a level top.
    Obstacle,
    /// Terrain from a raster.
    Raster,
}

/// Measures of a rigid block of `width` by `height` (m) on level ground with a coefficient of friction, under `gravity` (m/s²) for a
/// duration (s).
fn block(
    method: &dyn Method,
    ground: Ground,
    friction: f64,
    [width, height]: [f64; 2],
    (gravity, duration): ([f64; 2], f64),
) -> RunReport {
    let wall = if friction > 0.0 {
        json!({ "kind": "frictional", "friction_coefficient": friction })
    } else {
        json!({ "kind": "smooth" })
    };
    let mut case = json!({
        "title": "block", "space": "plane-strain", "domain": { "min": [-0.4, -0.08], "max": [1.2, 0.8] }, "gravity": gravity,
        "materials": { "rock": { "model": "linear-elastic", "density": 2000, "youngs_modulus": 5e6, "poissons_ratio": 0.2 } },
        "bodies": [{ "name": "block", "material": "rock", "rigid": true,
                     "shape": { "kind": "box", "min": [0, 0], "max": [width, height] } }],
        "stages": [{ "name": "s", "duration": duration, "motions": [{ "target": "block", "velocity": [null, null], "turns": true }] }],
        "measures": {},
        "output": { "measures": 0.02 },
        "methods": { "sph": { "spacing": 0.02, "time_step": 2e-4 },
                     "mpm": { "cell_size": 0.04, "time_step": 2e-4 } }
    });
    let shape = match ground {
        Ground::Wall => Value::Null,
        Ground::Obstacle => json!({ "kind": "plane", "point": [0, 0], "normal": [0, 1] }),
        Ground::Raster => {
            json!({ "kind": "ground-line", "points": [[-0.5, 0], [0.03, 0], [0.5, 0], [1.3, 0]] })
        }
    };
    if shape.is_null() {
        case["boundaries"] = json!([{ "side": "y-min", "position": 0, "wall": wall }]);
    } else {
        case["methods"]["mpm"]["obstacles"] = json!("points");
        case["obstacles"] = json!([{ "name": "ground", "shape": shape, "wall": wall }]);
        case["measures"] = json!({ "bearing": { "kind": "reaction", "target": "ground" } });
    }
    let case = Case::from_json(&case.to_string()).unwrap();
    run(&case, method.build(&case).unwrap(), &RunOptions::default()).unwrap()
}

fn last(report: &RunReport, column: &str) -> f64 {
    *report.table.column(column).unwrap_or_else(|| panic!("no column {column}")).last().unwrap()
}

/// Angle (rad) of a block that tips about its lower corner, after `duration` (s), integrated in small steps: moment of its weight about the
/// corner over its moment of inertia there.
fn tipped([width, height]: [f64; 2], gravity: [f64; 2], duration: f64) -> f64 {
    let inertia = (width * width + height * height) / 3.0;
    let (mut angle, mut spin, steps) = (0.0, 0.0, 20_000);
    let dt = duration / f64::from(steps);
    for _ in 0..steps {
        // From the corner to the centre of mass, turned clockwise.
        let (sin, cos) = f64::sin_cos(angle);
        let (x, y) = (-0.5 * width * cos + 0.5 * height * sin, 0.5 * width * sin + 0.5 * height * cos);
        spin += dt * (gravity[0] * y - gravity[1] * x) / inertia;
        angle += dt * spin;
    }
    angle
}

#[test]
fn a_tall_block_tips_about_its_lower_corner() {
    let (size, gravity, duration) = ([0.2, 0.6], [5.0, -8.66], 0.32);
    let exact = tipped(size, gravity, duration);
    for method in METHODS {
        for ground in [Ground::Wall, Ground::Obstacle, Ground::Raster] {
            let angle = -last(&block(method, ground, 2.0, size, (gravity, duration)), "block.angle");
            assert!((angle / exact - 1.0).abs() < 0.02, "{} {ground:?}: {angle} for {exact}", method.name());
        }
    }
}

#[test]
fn a_block_that_has_tipped_falls_flat_and_comes_to_rest() {
    for method in METHODS {
        for ground in [Ground::Wall, Ground::Obstacle] {
            let table = block(method, ground, 1.2, [0.2, 0.6], ([5.0, -8.66], 0.75));
            let name = method.name();
            let angle = last(&table, "block.angle");
            assert!((angle + std::f64::consts::FRAC_PI_2).abs() < 1e-3, "{name} {ground:?}: {angle}");
            assert!(last(&table, "kinetic_energy") < 1e-6, "{name} {ground:?}");
            // No impact adds energy.
            let total = table.table.column("total_energy").unwrap();
            assert!(total.windows(2).all(|pair| pair[1] < pair[0] + 0.1), "{name} {ground:?}: {total:?}");
        }
    }
}

#[test]
fn sliding_rigid_block_follows_coulomb_friction_and_gives_the_obstacle_reaction_and_friction_work() {
    let (gravity, friction, duration) = ([5.0, -8.66], 0.3, 0.3);
    let mass = 2000.0 * 0.4 * 0.2;
    let rate = gravity[0] + friction * gravity[1];
    for method in METHODS {
        for ground in [Ground::Wall, Ground::Obstacle, Ground::Raster] {
            let (name, table) =
                (method.name(), block(method, ground, friction, [0.4, 0.2], (gravity, duration)));
            let speed = last(&table, "block.velocity.x");
            assert!((speed / (rate * duration) - 1.0).abs() < 5e-3, "{name} {ground:?}: {speed}");
            assert!(last(&table, "block.spin.z").abs() < 1e-3, "{name} {ground:?}");
            if matches!(ground, Ground::Wall) {
                continue;
            }
            let force = [last(&table, "bearing.x"), last(&table, "bearing.y")];
            let exact = [-friction * mass * gravity[1], mass * gravity[1]];
            assert!((0..2).all(|c| (force[c] / exact[c] - 1.0).abs() < 5e-3), "{name}: {force:?} {exact:?}");
            let friction_work = last(&table, "obstacles.friction");
            let work = exact[0] * 0.5 * rate * duration * duration;
            assert!((friction_work / work - 1.0).abs() < 0.02, "{name}: {friction_work} for {work}");
        }
    }
}

#[test]
fn a_rigid_block_rests_on_a_rough_slope_and_slides_on_a_smooth_one() {
    for method in METHODS {
        let speed = |friction: f64| {
            let report = block(method, Ground::Obstacle, friction, [0.4, 0.2], ([5.0, -8.66], 0.3));
            last(&report, "block.velocity.x")
        };
        let [rough, smooth] = [0.7, 0.0].map(speed);
        assert!(rough.abs() < 1e-5 && (smooth - 1.5).abs() < 0.005, "{}: {rough} {smooth}", method.name());
    }
}
