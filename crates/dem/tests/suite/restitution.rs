//! Restitution at the default step is the prescribed one (sheet: dem §2.3, §2.8).

use colluvium_case::Solver;
use colluvium_dem::{DemSolver, spheres};
use colluvium_testkit::assert_near;
use serde_json::{Value, json};

use crate::single_grains::{Scene, begun};

/// Collision partner of a sphere of radius 2 mm, head-on at 1 m/s: a sphere of this radius (m), or a wall.
#[derive(Clone, Copy, Debug)]
enum Meets {
    Sphere(f64),
    Wall,
}

const RADIUS: f64 = 0.002;

/// Coefficient of restitution of a collision that begins after `gap` (m), in steps of these shares of the default one.
fn restitution(pair: &Value, meets: Meets, gap: f64, (velocity, shares): (&str, &[f64])) -> f64 {
    let mut scene =
        Scene::new(pair.clone()).sphere([0.0, 0.0, RADIUS + gap], RADIUS, [0.0, 0.0, -1.0], [0.0; 3]);
    match meets {
        Meets::Sphere(radius) => {
            scene = scene.sphere([0.0, 0.0, -radius], radius, [0.0; 3], [0.0; 3]);
        }
        Meets::Wall => {
            scene.boundaries =
                json!([{ "side": "z-min", "name": "floor", "position": 0, "wall": { "kind": "smooth" } }]);
        }
    }
    (scene.density, scene.gravity, scene.half) = (2500.0, vec![0.0; 3], 0.1);
    scene.options = json!({ "velocity": velocity });
    let mut solver: DemSolver<3, 3> = begun(spheres(&scene.case()).unwrap());
    let mut shares = shares.iter().cycle();
    while solver.time() < 0.008 {
        let dt = solver.limit().dt;
        solver.step(shares.next().unwrap() * dt).unwrap();
    }
    let v = solver.snapshot().vectors("velocity").unwrap().to_vec();
    v[0][2] - v.get(1).map_or(0.0, |v| v[2])
}

fn pair_of_restitution(law: &str, restitution: f64, clamp: bool) -> Value {
    let mut normal = json!({ "law": law, "restitution": restitution, "clamp": clamp });
    let more = match law {
        "linear" => json!({ "stiffness": 1e4 }),
        // Overlaps of up to a quarter of the radius.
        _ => json!({ "youngs_modulus": 1e6, "poissons_ratio": 0.4 }),
    };
    normal.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    json!({ "normal": normal })
}

#[test]
fn restitution_is_the_prescribed_one_at_the_default_step() {
    for law in ["linear", "hertz"] {
        for clamp in [true, false] {
            for value in [1.0, 0.8, 0.3, 0.1, 0.05] {
                let pair = pair_of_restitution(law, value, clamp);
                for meets in [Meets::Sphere(RADIUS), Meets::Sphere(0.0007), Meets::Wall] {
                    // Steps begin at different times relative to the first contact; in the last two cases it is at the end of a step.
                    let gaps = [1.1e-4, 1.26e-4, 1.43e-4, 1.71e-4, 1e-4, 2e-4];
                    let found = gaps.map(|gap| restitution(&pair, meets, gap, ("lagged", &[1.0])));
                    let holds = found.iter().all(|own| (own - value).abs() < 5e-3);
                    assert!(holds, "{law}, clamp {clamp}, {meets:?}: {found:?} for {value}");
                }
            }
        }
    }
}

#[test]
fn restitution_is_the_prescribed_one_in_steps_shortened_by_outputs() {
    // Outputs that steps do not fit into, the last two steps before each of equal length; and steps that halve and double.
    let patterns: [&[f64]; 4] =
        [&[1.0, 1.0, 0.7, 0.7], &[1.0, 0.55, 0.55], &[1.0, 0.5], &[1.0, 0.25, 0.6, 0.9, 0.35]];
    for law in ["linear", "hertz"] {
        for clamp in [true, false] {
            for value in [0.8, 0.3, 0.1] {
                let pair = pair_of_restitution(law, value, clamp);
                for meets in [Meets::Sphere(RADIUS), Meets::Sphere(0.0007), Meets::Wall] {
                    for shares in patterns {
                        let gaps = [1.1e-4, 1.26e-4, 1.43e-4, 1.71e-4, 1e-4, 1.53e-4, 1.64e-4, 2e-4];
                        let found = gaps.map(|gap| restitution(&pair, meets, gap, ("lagged", shares)));
                        let holds = found.iter().all(|own| (own - value).abs() < 5e-3);
                        assert!(holds, "{law}, clamp {clamp}, {meets:?}, {shares:?}: {found:?} for {value}");
                    }
                }
            }
        }
    }
}

#[test]
fn restitution_is_the_prescribed_one_when_overlaps_and_outputs_change_the_step() {
    for clamp in [true, false] {
        for value in [0.8, 0.3, 0.1] {
            let pair = pair_of_restitution("hertz", value, clamp);
            for interval in [1e-4, 1.5e-4, 3.3e-4] {
                for gap in [1e-4, 1.1e-4, 1.23e-4, 1.57e-4] {
                    let mut scene = Scene::new(pair.clone());
                    for side in [1.0, -1.0] {
                        let height = side * (RADIUS + gap);
                        scene = scene.sphere([0.0, 0.0, height], RADIUS, [0.0, 0.0, -side], [0.0; 3]);
                    }
                    (scene.density, scene.gravity, scene.half) = (2500.0, vec![0.0; 3], 0.1);
                    let mut solver: DemSolver<3, 3> = begun(spheres(&scene.case()).unwrap());
                    for output in 1..(4e-3 / interval) as i32 {
                        let end = f64::from(output) * interval;
                        while solver.time() < end - 1e-12 {
                            solver.step(end - solver.time()).unwrap();
                        }
                    }
                    let v = solver.snapshot().vectors("velocity").unwrap().to_vec();
                    let found = 0.5 * (v[0][2] - v[1][2]);
                    let off = (found - value).abs();
                    assert!(off < 5e-3, "clamp {clamp}, every {interval} s, gap {gap}: {found} for {value}");
                }
            }
        }
    }
}

#[test]
fn restitution_is_the_prescribed_one_with_predicted_velocities() {
    for law in ["linear", "hertz"] {
        for value in [0.8, 0.3] {
            let found = restitution(
                &pair_of_restitution(law, value, true),
                Meets::Sphere(RADIUS),
                1.37e-4,
                ("predicted", &[1.0]),
            );
            assert_near(found, value, 5e-3 / value);
        }
    }
}

#[test]
fn given_tangential_springs_and_dashpots_are_used_for_elastic_spheres() {
    // A sphere slides on another under a normal force: only the dashpot, or only the spring, changes its speed.
    let slid = |tangential: Value| {
        let mut pair = pair_of_restitution("hertz", 1.0, true);
        pair["friction"] = json!({ "coefficient": 10 });
        pair["tangential"] = tangential;
        let mut scene = Scene::new(pair)
            .sphere([0.0, 0.0, RADIUS], RADIUS, [0.01, 0.0, -0.1], [0.0; 3])
            .sphere([0.0, 0.0, -RADIUS], RADIUS, [0.0; 3], [0.0; 3]);
        (scene.density, scene.gravity, scene.half) = (2500.0, vec![0.0; 3], 0.1);
        let mut solver = begun(spheres(&scene.case()).unwrap());
        for _ in 0..10 {
            solver.step(1e-5).unwrap();
        }
        solver.snapshot().vectors("velocity").unwrap()[0][0]
    };
    let mindlin = slid(json!({}));
    // Equal spheres: 4 G*/E* = 2 (1 - ν) / (2 - ν).
    assert_near(slid(json!({ "stiffness_ratio": 2.0 * 0.6 / 1.6 })), mindlin, 1e-9);
    assert!(slid(json!({ "stiffness_ratio": 0.2 })) > mindlin + 1e-6);
    assert!(slid(json!({ "damping_ratio": 0.5 })) < mindlin - 1e-6);
}
