//! Single grains: flight, collisions, slopes, rolling (sheet: dem §5, B1 to B3, B6 to B8).

use colluvium_case::Solver;
use colluvium_case::measure::ScalarOutput;
use colluvium_dem::{disks, spheres};
use colluvium_testkit::assert_near;
use serde_json::json;

use crate::single_grains::{Scene, begun, floor, linear};

fn reading(readings: &[ScalarOutput], name: &str) -> f64 {
    readings.iter().find(|(own, ..)| own == name).unwrap().2
}

#[test]
fn a_disk_in_free_flight_is_exact_for_any_step() {
    let mut scene = Scene::new(linear(1e6, 0.0, 0.5, 0.0)).disk([0.0, 0.0], 0.5, [1.0, 2.0], 0.0);
    scene.gravity = vec![0.0, -9.81];
    let mut solver = scene.solver();
    let mut time = 0.0;
    let limit = solver.limit().dt;
    for dt in [1.0, 0.4, 0.7].map(|share| share * limit).into_iter().cycle().take(300) {
        solver.step(dt).unwrap();
        time += dt;
    }
    let x = solver.snapshot().positions[0];
    assert_near(x[0], time, 1e-12);
    assert_near(x[1], 2.0 * time - 0.5 * 9.81 * time * time, 1e-12);
}

/// Coefficient of restitution of a head-on collision of disks of these masses, with `steps` steps to `π/ω₀`.
fn restitution(pair: &serde_json::Value, masses: [f64; 2], steps: f64, phase: f64) -> f64 {
    let radius = |mass: f64| 0.5 * mass.sqrt();
    let [a, b] = masses.map(radius);
    let (stiffness, reduced): (f64, f64) = (1e6, masses[0] * masses[1] / (masses[0] + masses[1]));
    let dt = std::f64::consts::PI / (stiffness / reduced).sqrt() / steps;
    let gap = (2.0 + phase) * dt;
    let scene =
        Scene::new(pair.clone()).disk([-a - gap, 0.0], a, [1.0, 0.0], 0.0).disk([b, 0.0], b, [0.0, 0.0], 0.0);
    let mut solver = scene.solver();
    for _ in 0..(3.0 * steps) as usize {
        solver.step(dt).unwrap();
    }
    let budget = solver.totals();
    assert_near(budget.momentum[0], masses[0], 1e-12);
    let v = solver.snapshot().vectors("velocity").unwrap().to_vec();
    v[1][0] - v[0][0]
}

#[test]
fn restitution_is_that_of_the_damping_ratio() {
    for (ratio, clamp, exact) in
        [(0.1, false, 0.729_248), (0.5, false, 0.163_034), (0.1, true, 0.744_079), (0.5, true, 0.298_436)]
    {
        let mut pair = linear(1e6, ratio, 0.5, 0.0);
        pair["normal"]["clamp"] = json!(clamp);
        assert_near(restitution(&pair, [1.0, 1.0], 200.0, 0.3), exact, 5e-3);
        let errors =
            [0.0, 0.25, 0.5, 0.75].map(|phase| (restitution(&pair, [1.0, 3.0], 1000.0, phase) - exact).abs());
        assert_near(errors.into_iter().fold(0.0, f64::max), 0.0, 1.5e-3);
    }
    assert_near(restitution(&linear(1e6, 0.0, 0.5, 0.0), [1.0, 1.0], 200.0, 0.4), 1.0, 1e-3);
    // The simulated restitution is the prescribed one.
    let pair = json!({ "normal": { "law": "linear", "stiffness": 1e6, "restitution": 0.7 } });
    assert_near(restitution(&pair, [1.0, 1.0], 1000.0, 0.1), 0.7, 1e-3);
}

#[test]
fn the_restitution_of_elastic_spheres_does_not_depend_on_the_speed() {
    for speed in [0.1, 10.0] {
        let pair = json!({ "normal": {
            "law": "hertz", "youngs_modulus": 7e9, "poissons_ratio": 0.3, "restitution": 0.7, "clamp": false
        } });
        let mut scene = Scene::new(pair)
            .sphere([-0.0051, 0.0, 0.0], 0.005, [speed, 0.0, 0.0], [0.0; 3])
            .sphere([0.0051, 0.0, 0.0], 0.005, [0.0; 3], [0.0; 3]);
        (scene.density, scene.gravity, scene.half) = (2500.0, vec![0.0; 3], 10.0);
        scene.options = json!({ "time_step": 2e-8, "skin": 0.5 });
        let mut solver = begun(spheres(&scene.case()).unwrap());
        for _ in 0..((0.00045 / speed + 2e-4) / 2e-8) as usize {
            solver.step(2e-8).unwrap();
        }
        let v = solver.snapshot().vectors("velocity").unwrap().to_vec();
        assert_near((v[1][0] - v[0][0]) / speed, 0.7, 5e-3);
        assert_near(reading(&solver.scalar_outputs(), "energy_error"), 0.0, 5e-3);
    }
}

#[test]
fn a_bouncing_disk_loses_energy_by_its_dashpot_alone() {
    let mut scene = Scene::new(
        json!({ "normal": { "law": "linear", "stiffness": 1e7, "restitution": 0.5 } }),
    )
    .disk([0.0, 1.5], 0.5, [0.0, 0.0], 0.0);
    scene.gravity = vec![0.0, -9.81];
    scene.boundaries = floor(&json!({ "kind": "smooth" }));
    let mut solver = scene.solver();
    let dt = std::f64::consts::PI / 1e7f64.sqrt() / 400.0;
    let (mut apex, mut rising) = (0.0f64, false);
    let fall = (2.0f64 / 9.81).sqrt();
    while solver.time() < 1.9 * fall {
        solver.step(dt).unwrap();
        if solver.time() > 1.05 * fall {
            let y = solver.snapshot().positions[0][1];
            rising |= y > apex;
            apex = apex.max(y);
        }
        for _ in 0..200 {
            solver.step(dt).unwrap();
        }
    }
    assert!(rising);
    assert_near(apex - 0.5, 0.25, 0.0025);
    assert_near(reading(&solver.scalar_outputs(), "energy_error"), 0.0, 2e-3);
}

/// Oblique impact on a wall at unit normal speed: velocity along the wall and spin times radius afterwards.
fn oblique(sphere: bool, friction: f64, across: f64, restitution: f64, psi: f64) -> (f64, f64) {
    let mut pair = linear(1e6, 0.0, across, 0.0);
    pair["normal"] = json!({ "law": "linear", "stiffness": 1e6, "restitution": restitution });
    let (r, wall) = (0.5, json!({ "kind": "frictional", "friction_coefficient": friction }));
    let dt = std::f64::consts::PI / 1e3 / 2000.0;
    let mut scene = Scene::new(pair);
    scene.boundaries = floor(&wall);
    let y = r + 3.3 * dt;
    let after = |solver: &mut dyn Solver| {
        solver.begin_stage(0, 0.0).unwrap();
        for _ in 0..2600 {
            solver.step(dt).unwrap();
        }
        let snapshot = solver.snapshot();
        let spin = match snapshot.scalars("spin") {
            Some(spin) => spin[0],
            None => snapshot.vectors("spin").unwrap()[0][2],
        };
        (snapshot.vectors("velocity").unwrap()[0][0], spin * r)
    };
    if sphere {
        scene.density = 6.0 / std::f64::consts::PI;
        scene.gravity = vec![0.0; 3];
        after(&mut spheres(&scene.sphere([0.0, y, 0.0], r, [psi, -1.0, 0.0], [0.0; 3]).case()).unwrap())
    } else {
        after(&mut disks(&scene.disk([0.0, y], r, [psi, -1.0], 0.0).case()).unwrap())
    }
}

#[test]
fn oblique_impacts_are_those_of_the_table() {
    for (sphere, friction, across, restitution, psi, along, spin) in [
        (false, 0.3, 1.0 / 3.0, 1.0, 0.5, 0.1667, -0.6667),
        (false, 0.3, 1.0 / 3.0, 1.0, 1.5, 0.9, -1.2),
        (false, 0.5, 0.5, 1.0, 1.0, 0.3745, -1.2510),
        (false, 0.5, 0.5, 0.5, 1.0, 0.41, -1.1799),
        (false, 0.5, 0.5, 0.5, 3.0, 2.2782, -1.4436),
        (true, 0.3, 2.0 / 7.0, 1.0, 1.0, 0.4286, -1.4286),
        (true, 0.5, 0.5, 1.0, 1.0, 0.5008, -1.2479),
        (true, 0.5, 0.5, 0.5, 2.0, 1.2988, -1.7529),
    ] {
        let (v, w) = oblique(sphere, friction, across, restitution, psi);
        // A velocity along +x rotates the grain about -z on a wall below it.
        assert!(
            (v - along).abs() < 5e-3 && (w - spin).abs() < 5e-3,
            "{sphere} {psi}: {v} {w} for {along} {spin}"
        );
    }
}

#[test]
fn rolling_resistance_stops_a_disk_where_it_should() {
    let mut pair = linear(1e7, 0.2, 0.5, 0.0);
    pair["rolling"] = json!({ "friction": 0.05, "damping_ratio": 0.3 });
    let mut scene = Scene::new(pair).disk([0.0, 0.5 - 9.81 / 1e7], 0.5, [1.0, 0.0], -2.0);
    scene.gravity = vec![0.0, -9.81];
    scene.boundaries = floor(&json!({ "kind": "rough" }));
    let mut solver = scene.solver();
    let dt = solver.limit().dt;
    while solver.time() < 3.3 {
        solver.step(dt).unwrap();
    }
    let snapshot = solver.snapshot();
    assert_near(snapshot.positions[0][0], 1.52905, 0.0153);
    assert_near(snapshot.vectors("velocity").unwrap()[0][0], 0.0, 2e-3);
    assert_near(reading(&solver.scalar_outputs(), "energy_error"), 0.0, 0.01);
}

#[test]
fn steps_of_a_collision_are_those_of_the_scheme_in_positions() {
    // Sheet: dem §3.4, x(t + Δt) = Δt² f / m + 2 x(t) - x(t - Δt).
    let mut solver = Scene::new(linear(1e5, 0.2, 0.5, 0.5))
        .disk([-0.51, 0.1], 0.5, [1.0, 0.3], 3.0)
        .disk([0.32, -0.1], 0.3, [-0.5, 0.0], -7.0)
        .solver();
    let dt = 1e-4;
    let mut places = vec![solver.snapshot().positions];
    let mut largest = 0.0f64;
    for step in 0..400 {
        solver.step(dt).unwrap();
        let snapshot = solver.snapshot();
        places.push(snapshot.positions.clone());
        if step == 0 {
            continue;
        }
        let (force, mass) = (snapshot.vectors("force").unwrap(), snapshot.scalars("mass").unwrap());
        for i in 0..2 {
            for c in 0..2 {
                let acceleration = force[i][c] / mass[i];
                let [before, now, after] = [0, 1, 2].map(|k| places[step + k - 1][i][c]);
                assert!((after - 2.0 * now + before - dt * dt * acceleration).abs() < 1e-15);
                largest = largest.max(acceleration.abs());
            }
        }
    }
    assert!(largest > 100.0, "they touch: {largest}");
}

/// The impulse of a wall is the change of momentum, for any step lengths, as outputs shorten them.
#[test]
fn the_impulse_of_a_wall_is_the_change_of_momentum_with_steps_of_any_length() {
    let mut scene = Scene::new(linear(1e5, 0.3, 0.5, 0.4)).disk([0.0, 0.501], 0.5, [0.3, -1.0], 0.0);
    scene.boundaries = floor(&json!({ "kind": "rough" }));
    let mut solver = scene.solver();
    let before = solver.budget().unwrap().momentum;
    for number in 0..400 {
        let share = [1.0, 0.1, 0.7, 0.25][number % 4];
        let dt = share * solver.limit().dt;
        solver.step(dt).unwrap();
    }
    let after = solver.budget().unwrap().momentum;
    let impulse = solver.reaction("floor").unwrap().impulse;
    assert!(after[1] > 0.1, "it has rebounded: {after:?}");
    for c in 0..2 {
        let change = after[c] - before[c];
        assert!((impulse[c] + change).abs() < 1e-12, "{impulse:?} for {before:?} to {after:?}");
    }
}
