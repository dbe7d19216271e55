//! Obstacles of any orientation (sheet: sph §2.13).

use colluvium_case::{Case, Method, Solver};
use colluvium_sph::Sph;
use colluvium_testkit::{advance_steps, case_with, read_case, scalar_output, start_solver, vectors};
use serde_json::{Value, json};

/// Elastic block that slides on a floor or an obstacle; `more` adds keys to the case.
fn sliding(more: &Value) -> Case {
    let text = json!({
        "title": "block", "space": "plane-strain", "gravity": [0, -9.81],
        "domain": { "min": [-1, -1], "max": [3, 2] },
        "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.2 } },
        "bodies": [{ "name": "block", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [0.6, 0.3] },
            "velocity": { "kind": "uniform", "value": [0.4, -0.05] } }],
        "stages": [{ "name": "slide", "duration": 0.5 }],
        "methods": { "sph": { "spacing": 0.05 } }
    });
    case_with(text, more)
}

fn floor(wall: &Value) -> Value {
    json!({ "boundaries": [{ "name": "floor", "side": "y-min", "position": 0, "wall": wall }] })
}

fn plane(wall: &Value) -> Value {
    json!({ "obstacles": [{ "name": "floor", "wall": wall, "shape": { "kind": "plane", "point": [0, 0], "normal": [0, 2] } }] })
}

#[test]
fn an_axis_aligned_plane_acts_as_a_wall_of_particles() {
    let particles = json!({ "smooth_wall": "particles", "rough_wall": "particles" });
    for wall in [
        json!({ "kind": "smooth" }),
        json!({ "kind": "rough" }),
        json!({ "kind": "frictional", "friction_coefficient": 0.3 }),
    ] {
        let velocities = |case: &Value| {
            let mut case = case.clone();
            case["methods"] = json!({ "sph": { "spacing": 0.05, "smooth_wall": particles["smooth_wall"] } });
            let mut solver = start_solver(&Sph, &sliding(&case));
            // First steps only: later the dummy sites behind the plane follow the particles, and the wall particles do not.
            for _ in 0..3 {
                solver.step(1e-5).unwrap();
            }
            vectors(&solver.snapshot(), "velocity").to_vec()
        };
        let (walled, held) = (velocities(&floor(&wall)), velocities(&plane(&wall)));
        let mut moved = 0.0f64;
        for (a, b) in walled.iter().zip(&held) {
            for c in 0..2 {
                assert!((a[c] - b[c]).abs() < 1e-7, "{wall}: {a:?} {b:?}");
            }
            moved = moved.max((a[1] + 0.05).abs());
        }
        assert!(moved > 1e-4, "the floor pushes: {moved}");
    }
}

/// Block with its lattice along a plane inclined by `angle` degrees, with the folder of its points.
fn slope(angle: f64, friction: f64) -> (tempfile::TempDir, Value) {
    let (sin, cos) = angle.to_radians().sin_cos();
    let turned = |x: f64, y: f64| [cos * x + sin * y, -sin * x + cos * y];
    let list: String = (0..12 * 6)
        .map(|k| turned(0.05 * (f64::from(k % 12) + 0.5), 0.05 * (f64::from(k / 12) + 0.5)))
        .map(|[x, y]| format!("{x}, {y}, 0.0025\n"))
        .collect();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("points.csv");
    std::fs::write(&file, format!("x (m), y (m), volume (m2)\n{list}")).unwrap();
    let corners: Vec<_> = [(0.0, 0.0), (0.6, 0.0), (0.6, 0.3), (0.0, 0.3)]
        .map(|(x, y)| turned(x * 1.001 - 3e-4, y * 1.001 - 3e-4))
        .to_vec();
    let case = sliding(&json!({
        "domain": { "min": [-1, -3], "max": [4, 2] },
        "bodies": [{ "name": "block", "material": "m", "shape": { "kind": "polygon", "vertices": corners },
            "points": { "file": file.to_str().unwrap() } }],
        "obstacles": [{ "name": "slope", "wall": { "kind": "frictional", "friction_coefficient": friction },
            "shape": { "kind": "ground-line", "points": [turned(-2.0, 0.0), turned(5.0, 0.0)] } }],
        "stages": [{ "name": "slide", "duration": 0.5, "gravity_ramp": 0.1 }]
    }));
    (folder, serde_json::from_str(&case.to_json()).unwrap())
}

/// Speed along the plane after half a second of sliding, and the largest speed normal to it.
fn slide(angle: f64, friction: f64) -> [f64; 2] {
    let (sin, cos) = angle.to_radians().sin_cos();
    let (folder, text) = slope(angle, friction);
    let mut solver = start_solver(&Sph, &read_case(&text));
    drop(folder);
    while solver.time() < 0.5 {
        advance_steps(&mut *solver, 1);
    }
    let snapshot = solver.snapshot();
    let v = vectors(&snapshot, "velocity");
    let along = v.iter().map(|v| cos * v[0] - sin * v[1]).sum::<f64>() / v.len() as f64;
    let across = v.iter().map(|v| (sin * v[0] + cos * v[1]).abs()).fold(0.0, f64::max);
    [along, across]
}

/// Mean force on the slope between two times (N), mean rate of the block's momentum between them (N), moment about the middle of the block
/// at the end (N m), and mean pressure on the area under the block (Pa).
fn block_on_slope(
    angle: f64,
    friction: f64,
    damping: f64,
    [from, to]: [f64; 2],
) -> ([f64; 2], [f64; 2], f64, f64) {
    let (folder, mut text) = slope(angle, friction);
    let (sin, cos) = angle.to_radians().sin_cos();
    text["measures"] = json!({ "on": { "kind": "reaction", "target": "slope" },
        "under": { "kind": "impact-pressure", "target": "slope", "direction": [-sin, -cos], "area": 0.6 } });
    text["stages"][0]["duration"] = json!(to);
    text["stages"][0]["damping"] = json!(damping);
    let case = read_case(&text);
    let mut solver = start_solver(&Sph, &case);
    drop(folder);
    let mut at = |time: f64| {
        while solver.time() < time {
            advance_steps(&mut *solver, 1);
        }
        let snapshot = solver.snapshot();
        let mean = |of: &[[f64; 3]], c: usize| of.iter().map(|v| v[c]).sum::<f64>() / of.len() as f64;
        let velocity = [0, 1].map(|c| 180.0 * mean(&vectors(&snapshot, "velocity"), c));
        let middle = [0, 1, 2].map(|c| mean(&snapshot.positions, c));
        let readings = colluvium_case::measure::read_solver(&case, &*solver);
        let pressed = readings.iter().find(|(name, ..)| name == "under.impulse").unwrap().2;
        (solver.time(), solver.reaction("slope").unwrap(), velocity, middle, pressed)
    };
    let (start, before, early, _, pressed) = at(from);
    let (end, after, late, middle, pressed_since) = at(to);
    let over = |c: usize, a: &[f64], b: &[f64]| (b[c] - a[c]) / (end - start);
    (
        [0, 1].map(|c| over(c, &before.impulse, &after.impulse)),
        [0, 1].map(|c| over(c, &early, &late)),
        after.moment_about(&middle).unwrap()[2],
        (pressed_since - pressed) / (end - start),
    )
}

/// The reaction on the slope is the weight less the momentum rate of the block. At rest that is the weight, without a moment about the
/// middle; in sliding, friction is the coefficient times the normal force.
#[test]
fn reaction_of_a_slope_equals_the_force_of_the_block_on_it() {
    let weight = 180.0 * 9.81;
    let ([x, y], gained, moment, pressure) =
        block_on_slope(30.0, 1.2 * 30f64.to_radians().tan(), 0.3, [0.4, 0.8]);
    assert!(x.abs() < 0.01 * weight && (y / -weight - 1.0).abs() < 0.01, "{x} {y}: {gained:?}");
    // It acts at the particles, about half a spacing above the slope.
    assert!(moment.abs() < 0.5 * 0.05 * weight, "{moment}");
    let (sin, cos) = 30f64.to_radians().sin_cos();
    assert!((pressure / (weight * cos / 0.6) - 1.0).abs() < 0.01, "{pressure}");
    let ([x, y], [gained_x, gained_y], ..) = block_on_slope(30.0, 0.3, 0.0, [0.2, 0.5]);
    let off = [x + gained_x, y + gained_y + weight];
    assert!(off.iter().all(|off| off.abs() < 2e-3 * weight), "{off:?}");
    let (along, normal) = (cos * x - sin * y, -sin * x - cos * y);
    assert!((along / normal / 0.3 - 1.0).abs() < 0.01, "{along} {normal}");
}

#[test]
fn acceleration_of_a_block_on_a_slope_follows_coulomb_friction() {
    // Gravity increases over 0.1 s: its integral is that of 0.45 s.
    for (angle, share) in [(20.0f64, 0.0), (20.0, 0.6), (35.0, 0.3)] {
        let (sin, tan) = (angle.to_radians().sin(), angle.to_radians().tan());
        let [along, across] = slide(angle, share * tan);
        let exact = 9.81 * sin * (1.0 - share) * 0.45;
        let free = 9.81 * sin * 0.45;
        assert!(((along - exact) / free).abs() < 0.03, "{angle}°, {share}: {along} for {exact}");
        assert!(across < 0.05, "{across}");
    }
    let [along, _] = slide(30.0, 1.2 * 30f64.to_radians().tan());
    assert!(along.abs() < 2e-3, "{along}");
}

#[test]
fn options_without_support_for_obstacles_are_refused_by_path() {
    let problem = |more: &Value| {
        let mut case = plane(&json!({ "kind": "rough" }));
        for (key, value) in more.as_object().unwrap() {
            case[key] = value.clone();
        }
        Sph.build(&sliding(&case)).map(|_| ()).unwrap_err().to_string()
    };
    let summed = problem(&json!({ "methods": { "sph": { "spacing": 0.05, "continuity": "summation" } } }));
    assert!(summed.starts_with("methods.sph.continuity: is not available with obstacles"), "{summed}");
    let deep = json!({ "bodies": [{ "name": "block", "material": "m", "shape": { "kind": "box", "min": [0, -0.2], "max": [0.6, 0.1] } }] });
    let found = problem(&deep);
    assert!(found.starts_with("bodies[0].shape: the point at") && found.contains("\"floor\""), "{found}");
}

#[test]
fn a_block_is_braked_where_an_obstacle_has_a_rough_part() {
    let case = sliding(&json!({
        "domain": { "min": [-1, -1], "max": [4, 2] },
        "bodies": [{ "name": "block", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [0.8, 0.1] },
            "stress": { "kind": "k0", "surface": 0.1, "coefficient": 0.25 },
            "velocity": { "kind": "uniform", "value": [2, 0] } }],
        "obstacles": [{ "name": "floor", "wall": { "kind": "smooth" }, "shape": { "kind": "plane", "point": [0, 0], "normal": [0, 2] },
            "regions": [{ "shape": { "kind": "box", "min": [1], "max": [9] },
                "wall": { "kind": "frictional", "friction_coefficient": 0.3 } }] }],
        "methods": { "sph": { "spacing": 0.025 } }
    }));
    let mut solver = start_solver(&Sph, &case);
    let middle = |solver: &dyn Solver| {
        let places = solver.snapshot().positions;
        places.iter().map(|x| x[0]).sum::<f64>() / places.len() as f64
    };
    while solver.time() < 0.08 {
        advance_steps(&mut *solver, 1);
    }
    let kept = solver.totals().momentum[0] / solver.totals().mass / 2.0;
    assert!((kept - 1.0).abs() < 2e-3, "on the smooth part: {kept}");
    while solver.time() < 1.4 {
        advance_steps(&mut *solver, 1);
    }
    // Over the edge friction grows with the share of the base on the rough part, so that the front stops v²/(2 μ g) + L/2 beyond it.
    let exact = 4.0 / (2.0 * 0.3 * 9.81) + 0.4;
    let displacement = middle(&*solver) + 0.4 - 1.0;
    eprintln!("{displacement} {exact}");
    assert!((displacement / exact - 1.0).abs() < 0.03, "{displacement} for {exact}");
}

/// All energies, with those taken by obstacles (J).
fn energy(solver: &dyn Solver) -> f64 {
    let budget = solver.budget().unwrap();
    let took = scalar_output(solver, "obstacles.friction") + scalar_output(solver, "obstacles.stopped");
    budget.kinetic + budget.elastic + budget.potential + took
}

/// Two rows of sand thrown at a floor with a bump, at a speed above their wave speed (24 m/s).
fn thrown(integration: &str, wall: &Value) -> Case {
    sliding(&json!({
        "materials": { "m": { "model": "mohr-coulomb", "density": 1600, "youngs_modulus": 7e5, "poissons_ratio": 0.3,
            "friction_angle": 32 } },
        "bodies": [{ "name": "layer", "material": "m", "shape": { "kind": "box", "min": [0, 0.5], "max": [1, 0.6] },
            "velocity": { "kind": "uniform", "value": [5, -30] } }],
        "obstacles": [{ "name": "floor", "wall": wall,
            "shape": { "kind": "ground-line", "points": [[-2, -0.1], [0.2, 0], [0.4, 0.2], [0.7, -0.05], [5, 0.1]] } }],
        "stages": [{ "name": "fall", "duration": 0.05 }],
        "methods": { "sph": { "spacing": 0.05, "integration": integration } }
    }))
}

#[test]
fn particles_do_not_penetrate_obstacles_and_the_stopping_energy_is_recorded() {
    for integration in [
        "leapfrog",
        "leapfrog-rates",
        "predictor-corrector",
        "velocity-verlet",
        "runge-kutta4",
        "verlet",
        "position-verlet",
    ] {
        for wall in [
            json!({ "kind": "smooth" }),
            json!({ "kind": "rough" }),
            json!({ "kind": "frictional", "friction_coefficient": 0.4 }),
        ] {
            let case = thrown(integration, &wall);
            let standing = case.placed_obstacles::<2>().unwrap();
            let mut solver = start_solver(&Sph, &case);
            let (start, mut nearest, mut largest_energy) = (energy(&*solver), f64::INFINITY, 0.0f64);
            while solver.time() < 0.05 {
                advance_steps(&mut *solver, 1);
                largest_energy = largest_energy.max(energy(&*solver));
                for x in solver.snapshot().positions {
                    let gap = standing[0].surface.gap(&[x[0], x[1]], 1.0);
                    nearest = gap.map_or(nearest, |gap| nearest.min(gap.distance));
                }
            }
            assert!(nearest > 0.0, "{integration} {wall}: {nearest} m");
            assert!(largest_energy < 1.01 * start, "{integration} {wall}: {largest_energy} J of {start}");
            assert!(scalar_output(&*solver, "obstacles.stopped") > 0.01 * start);
        }
    }
}

#[test]
fn friction_work_equals_the_kinetic_energy_loss_of_a_sliding_block() {
    let wall = json!({ "kind": "frictional", "friction_coefficient": 0.3 });
    let mut more = plane(&wall);
    more["stages"] = json!([{ "name": "slide", "duration": 0.1 }]);
    more["bodies"] = json!([{ "name": "block", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [0.6, 0.3] },
        "velocity": { "kind": "uniform", "value": [2, 0] } }]);
    let mut solver = start_solver(&Sph, &sliding(&more));
    let start = solver.budget().unwrap();
    while solver.time() < 0.1 {
        advance_steps(&mut *solver, 1);
    }
    let slower = 2.0 - solver.budget().unwrap().momentum[0] / start.mass;
    let lost = 0.5 * start.mass * (4.0 - (2.0 - slower).powi(2));
    let friction = scalar_output(&*solver, "obstacles.friction");
    assert!(lost > 0.0 && (friction / lost - 1.0).abs() < 0.05, "{friction} J of {lost} J");
    assert_eq!(scalar_output(&*solver, "obstacles.stopped"), 0.0);
}
