//! Options of contacts and stages against closed forms (sheet: dem §2.7, §2.9, §3.1).

use colluvium_case::{Method, Solver};
use colluvium_dem::{Dem, disks, spheres};
use colluvium_testkit::{assert_near, read_case, scalar_output};
use serde_json::{Value, json};

use crate::single_grains::{Scene, begun, linear};

#[test]
fn a_modulus_of_the_grains_gives_a_stiffness_that_grows_with_them() {
    let (modulus, overlap) = (3e6, 1e-4);
    let mut pair = linear(1.0, 0.0, 0.5, 0.0);
    pair["normal"] = json!({ "law": "linear", "grain_modulus": modulus, "damping_ratio": 0 });
    for [a, b] in [[0.5, 0.3], [0.25, 0.15], [0.4, 0.4]] {
        let force = 2.0 * modulus * a * b / (a + b) * overlap;
        let apart = a + b - overlap;
        let flat =
            Scene::new(pair.clone()).disk([0.0; 2], a, [0.0; 2], 0.0).disk([apart, 0.0], b, [0.0; 2], 0.0);
        let mut flat = flat.solver();
        flat.step(1e-9).unwrap();
        assert_near(flat.contacts().first().unwrap().normal / force, 1.0, 1e-6);
        let solid = Scene::new(pair.clone()).sphere([0.0; 3], a, [0.0; 3], [0.0; 3]).sphere(
            [apart, 0.0, 0.0],
            b,
            [0.0; 3],
            [0.0; 3],
        );
        let mut solid = solid;
        solid.gravity = vec![0.0; 3];
        let mut solid = begun(spheres(&solid.case()).unwrap());
        solid.step(1e-9).unwrap();
        assert_near(solid.contacts().first().unwrap().normal / force, 1.0, 1e-6);
    }
}

/// Position after `time` (s) of a disk with this initial velocity under this gravity and local damping of 0.3.
fn thrown(form: &str, velocity: [f64; 2], gravity: [f64; 2], time: f64) -> [f64; 3] {
    let mut scene = Scene::new(linear(1e6, 0.0, 0.5, 0.0)).disk([0.0; 2], 0.5, velocity, 0.0);
    scene.gravity = gravity.to_vec();
    scene.options = json!({ "stages": { "all": { "damping_form": form } } });
    let mut value: Value = scene.json();
    value["stages"] = json!([{ "name": "all", "duration": 100, "damping": 0.3 }]);
    let mut solver = begun(disks(&read_case(&value)).unwrap());
    let count = (time / solver.limit().dt).ceil();
    for _ in 0..count as usize {
        solver.step(time / count).unwrap();
    }
    solver.snapshot().positions[0]
}

#[test]
fn local_damping_opposes_motion_by_component_or_by_the_force_vector() {
    let (velocity, gravity, time): ([f64; 2], [f64; 2], f64) = ([-1.0, -5.0], [1.0, -9.81], 0.1);
    let place = |accelerations: [f64; 2]| -> [f64; 2] {
        std::array::from_fn(|c| velocity[c] * time + 0.5 * accelerations[c] * time * time)
    };
    // Along x the grain moves against gravity, along y and in total with it.
    for (form, exact) in [
        ("components", place([1.3 * gravity[0], 0.7 * gravity[1]])),
        ("vector", place([0.7 * gravity[0], 0.7 * gravity[1]])),
    ] {
        let x = thrown(form, velocity, gravity, time);
        assert_near(x[0], exact[0], 1e-10);
        assert_near(x[1], exact[1], 1e-10);
    }
}

#[test]
fn the_unbalanced_force_is_that_of_grains_over_that_of_contacts() {
    let row = |count: usize| {
        let mut scene = Scene::new(linear(1e4, 0.0, 0.5, 0.0));
        for k in 0..count {
            scene = scene.disk([k as f64 * 0.9998, 0.0], 0.5, [0.0; 2], 0.0);
        }
        let mut solver = scene.solver();
        solver.step(1e-9).unwrap();
        solver.equilibrium().unwrap().unbalanced_force
    };
    // Only the two end grains are out of balance, by the force of one contact.
    assert_near(row(2), 1.0, 1e-6);
    assert_near(row(3), (2.0f64 / 3.0).sqrt(), 1e-6);
    assert_near(row(8), 0.5, 1e-6);
    // No force acts on a single grain.
    assert_near(row(1), 0.0, 1e-12);
}

#[test]
fn a_cohesive_contact_breaks_at_its_tensile_strength_and_dissipates_its_spring_energy() {
    let (stiffness, force) = (1e6, 50.0);
    // Masses are 1 kg: half the relative motion's energy must exceed that of the spring where it breaks.
    let lost: f64 = 0.5 * force * force / stiffness;
    let least = (2.0 * lost / 0.5).sqrt();
    let parted = |speed: f64| {
        let mut pair = linear(stiffness, 0.0, 0.5, 0.0);
        pair["adhesion"] = json!({ "kind": "cohesive", "tension": 2.0 * force, "shear": 0 });
        let scene = Scene::new(pair).disk([0.0; 2], 0.5, [-0.5 * speed, 0.0], 0.0).disk(
            [1.0 - 1e-7, 0.0],
            0.5,
            [0.5 * speed, 0.0],
            0.0,
        );
        let mut solver = scene.solver();
        for _ in 0..8000 {
            solver.step(1e-6).unwrap();
        }
        solver
    };
    let free = parted(1.4 * least);
    let v = free.snapshot().vectors("velocity").unwrap().to_vec();
    assert_near((v[1][0] - v[0][0]) / least, (1.4f64 * 1.4 - 1.0).sqrt(), 1e-2);
    assert_near(scalar_output(&free, "dissipated.bonds") / lost, 1.0, 1e-2);
    let bound = parted(0.9 * least);
    assert_near(scalar_output(&bound, "dissipated.bonds"), 0.0, 1e-12);
    let x = bound.snapshot().positions.clone();
    assert!(x[1][0] - x[0][0] < 1.0 + force / stiffness);
}

/// Velocity along x that a disk of 1 kg and 0.5 m reaches in a time (s) on a held one below that moves at 0.5 m/s: pressed by its weight of
/// 10 N, with a cohesive shear strength of 10 N and friction of 0.3.
fn dragged(fragile: bool, cohesive: bool, time: f64) -> f64 {
    let stiffness = 1e6;
    let mut pair = linear(stiffness, 0.0, 0.5, 0.3);
    if cohesive {
        pair["adhesion"] = json!({ "kind": "cohesive", "tension": 100, "shear": 20, "fragile": fragile });
    }
    let mut scene = Scene::new(pair).disk([0.0; 2], 0.5, [0.5, 0.0], 0.0).disk(
        [0.0, 1.0 - 10.0 / stiffness],
        0.5,
        [0.0; 2],
        0.0,
    );
    scene.gravity = vec![0.0, -10.0];
    scene.options = json!({ "bodies": { "grain 0": { "held": true } } });
    let mut solver = scene.solver();
    while solver.time() < time {
        solver.step(1e-6).unwrap();
    }
    solver.snapshot().vectors("velocity").unwrap()[1][0]
}

#[test]
fn a_cohesive_contact_slips_at_its_shear_strength_and_a_fragile_one_breaks_there() {
    // While it slips the force is cohesion plus friction, 10 + 3 N; after the cohesion has broken only 3 N remain.
    let force =
        |fragile, cohesive| (dragged(fragile, cohesive, 6e-4) - dragged(fragile, cohesive, 1e-4)) / 5e-4;
    assert_near(force(false, true), 13.0, 0.1);
    assert_near(force(true, true), 3.0, 0.1);
    assert_near(force(true, false), 3.0, 0.1);
    // The fragile contact transmitted its strength until it broke.
    assert!(dragged(true, true, 1e-4) > dragged(true, false, 1e-4) + 1e-5);
}

#[test]
fn contact_parameters_that_mixing_does_not_derive_cause_a_warning() {
    let warnings = |more: Value, unlike: Option<Value>| {
        let mut value = Scene::new(linear(1e6, 0.1, 0.5, 0.5))
            .disk([0.0, 0.6], 0.5, [0.0; 2], 0.0)
            .disk([1.7, 0.6], 0.5, [0.0; 2], 0.0)
            .disk([2.8, 0.6], 0.5, [0.0; 2], 0.0)
            .json();
        value["materials"]["other"] = value["materials"]["grain"].clone();
        for body in 1..3 {
            value["bodies"][body]["material"] = json!("other");
        }
        let dem = &mut value["methods"]["dem"];
        dem["mix"] = json!(true);
        dem["grains"]["other"] = dem["grains"]["grain"].clone();
        let mut like = dem["pairs"][0].clone();
        like["between"] = json!(["other", "other"]);
        like.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        let pairs = dem["pairs"].as_array_mut().unwrap();
        pairs.push(like);
        if let Some(mut unlike) = unlike {
            unlike["between"] = json!(["grain", "other"]);
            pairs.push(unlike);
        }
        let warnings = Dem.plan(&read_case(&value)).unwrap().warnings;
        warnings
            .into_iter()
            .filter(|messages| messages.text.starts_with("methods.dem.mix: "))
            .collect::<Vec<_>>()
    };
    let rolling = json!({ "rolling": { "friction": 0.1 } });
    let bond = json!({ "bond": { "normal_stiffness": 1e6, "shear_stiffness": 1e6, "gap": 0.5 } });
    let adhesion = json!({ "adhesion": { "kind": "cohesive", "tension": 4000, "shear": 2000 } });
    for (more, key) in [(&rolling, "rolling"), (&bond, "bond"), (&adhesion, "adhesion")] {
        let messages = warnings(more.clone(), None);
        let own = format!(
            "grains of \"grain\" and \"other\" have no {key} between them, although those of \"other\" have it"
        );
        assert!(messages.len() == 1 && messages[0].text.contains(&own), "{key}: {messages:?}");
        // A pair that is given is not mixed.
        assert!(warnings(more.clone(), Some(linear(1e6, 0.1, 0.5, 0.5))).is_empty(), "{key}");
    }
    assert!(warnings(json!({}), None).is_empty());
}
