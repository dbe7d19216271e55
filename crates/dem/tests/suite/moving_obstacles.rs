//! Obstacles with prescribed motion (sheet: dem §2.10, wall types).

use std::f64::consts::PI;

use colluvium_case::{Case, Method, Solver};
use colluvium_dem::{Dem, disks, spheres};
use colluvium_testkit::{read_case, scalar_output};
use serde_json::{Value, json};

use crate::single_grains::{Scene, begun, linear};

const STIFFNESS: f64 = 1e6;

fn to(solver: &mut dyn Solver, time: f64) {
    while solver.time() < time - 1e-9 {
        solver.step(time - solver.time()).unwrap();
    }
}

/// Disk of mass 1 kg and radius 0.5 m at rest on a floor that moves along x at 1 m/s, with friction 0.2.
fn belt(motion: &Value) -> Value {
    let mut scene =
        Scene::new(linear(STIFFNESS, 0.2, 0.5, 0.5)).disk([0.0, 0.5 - 9.81e-6], 0.5, [0.0; 2], 0.0);
    scene.gravity = vec![0.0, -9.81];
    let mut value = scene.json();
    value["obstacles"] = json!([{ "name": "belt", "motion": motion,
        "shape": { "kind": "plane", "point": [0, 0], "normal": [0, 1] },
        "wall": { "kind": "frictional", "friction_coefficient": 0.2 } }]);
    value
}

#[test]
fn a_disk_on_a_belt_slips_until_it_rolls_at_a_third_of_its_speed() {
    let mut solver = begun(disks(&read_case(&belt(&json!({ "velocity": [1, 0] })))).unwrap());
    // It slips for v / (3 μ g) = 0.17 s: its surface gains the acceleration 3 μ g, its centre μ g.
    to(&mut solver, 0.1);
    let early = solver.snapshot().positions[0][0];
    assert!((early / (0.5 * 0.2 * 9.81 * 0.01) - 1.0).abs() < 0.01, "{early}");
    to(&mut solver, 0.5);
    let start = solver.snapshot().positions[0][0];
    to(&mut solver, 1.0);
    let speed = (solver.snapshot().positions[0][0] - start) / 0.5;
    assert!((speed - 1.0 / 3.0).abs() < 2e-4, "{speed}");
    // Friction transmits μ m g over v times the slip time, m v²/3; half of it is dissipated.
    let work = scalar_output(&solver, "work.boundaries");
    assert!((work - 1.0 / 3.0).abs() < 2e-3, "{work}");
    let heat = scalar_output(&solver, "dissipated.friction");
    assert!((heat - 1.0 / 6.0).abs() < 2e-3, "{heat}");
    assert!(scalar_output(&solver, "energy_error").abs() < 1e-3);
}

#[test]
fn a_floor_that_rises_with_a_ramp_lifts_a_disk_by_its_displacement() {
    let motion = json!({ "velocity": [0, 0.5], "start": 0.2, "ramp": 1 });
    let mut solver = begun(disks(&read_case(&belt(&motion))).unwrap());
    to(&mut solver, 2.2);
    let height = solver.snapshot().positions[0][1] - (0.5 - 9.81e-6);
    assert!((height - 0.75).abs() < 1e-5, "{height}");
    let work = scalar_output(&solver, "work.boundaries");
    assert!((work / (9.81 * 0.75 + 0.5 * 0.25) - 1.0).abs() < 1e-3, "{work}");
}

#[test]
fn a_sphere_on_a_turntable_orbits_at_two_sevenths_of_its_rate() {
    let (rate, radius) = (2.0, 0.5);
    let around = 2.0 / 7.0 * rate;
    // At (1, 0) with velocity (0, 0.4): the table below moves at (0, 2), so that r ω_y = 0 and r ω_x = v - 2 of rolling.
    let (x, speed) = (1.0, 0.4);
    let volume = 4.0 / 3.0 * PI * 0.125;
    let mut scene = Scene::new(linear(1e7, 0.2, 0.5, 0.5));
    let sunk = scene.density * volume * 9.81 / 1e7;
    scene.gravity = vec![0.0, 0.0, -9.81];
    // Surface velocity at the foot: v + ω × (-r e_z) = (-r ω_y, v + r ω_x).
    let spin = [(rate * x - speed) / radius, 0.0, 0.0];
    scene = scene.sphere([x, 0.0, radius - sunk], radius, [0.0, speed, 0.0], spin);
    let mut value = scene.json();
    value["obstacles"] = json!([{ "name": "table",
        "shape": { "kind": "box", "min": [-9, -9, -1], "max": [9, 9, 0] },
        "motion": { "rotation": rate.to_degrees(), "centre": [0, 0, -0.5], "axis": [0, 0, 3] },
        "wall": { "kind": "frictional", "friction_coefficient": 0.8 } }]);
    let mut solver = begun(spheres(&read_case(&value)).unwrap());
    to(&mut solver, 0.5 * PI / around);
    let place = solver.snapshot().positions[0];
    let wide = speed / around;
    let (dx, dy) = (place[0] - (x - wide), place[1] - wide);
    assert!(dx.hypot(dy) < 0.01 * wide, "{place:?}, not {:?}", [x - wide, wide]);
    assert!(scalar_output(&solver, "energy_error").abs() < 1e-3);
}

/// Disks in a pan with a rotating paddle, a cross of two bars.
fn stirred() -> Case {
    let mut value = Scene::new(linear(1e6, 0.2, 0.5, 0.5)).disk([0.0, 0.0], 1.0, [0.0; 2], 0.0).json();
    value["domain"] = json!({ "min": [-3, -3], "max": [3, 3] });
    value["gravity"] = json!([0, -9.81]);
    value["bodies"] = json!([{ "name": "heap", "material": "grain",
        "shape": { "kind": "box", "min": [-2.5, -2.5], "max": [2.5, -0.6] } }]);
    value["boundaries"] = json!(["x-min", "x-max", "y-min", "y-max"].map(|side| json!({ "side": side,
        "wall": { "kind": "frictional", "friction_coefficient": 0.5 } })));
    let motion = json!({ "rotation": 60, "centre": [0, 0], "start": 0.5, "ramp": 0.5 });
    let bar = |a: f64, b: f64| {
        json!({ "name": format!("bar {a}"), "motion": motion, "wall": { "kind": "frictional", "friction_coefficient": 0.3 },
            "shape": { "kind": "polygon", "vertices": [[-a, -b], [a, -b], [a, b], [-a, b]] } })
    };
    value["obstacles"] = json!([bar(2.4, 0.1)]);
    value["methods"]["dem"]["bodies"] = json!({});
    value["methods"]["dem"]["grains"] = json!({ "grain": { "density": 100,
        "diameter": { "distribution": "uniform", "min": 0.12, "max": 0.18 },
        "fill": { "kind": "lattice", "packing": "square", "jitter": 0.01 } } });
    read_case(&value)
}

#[test]
fn the_work_of_a_paddle_is_in_the_energy_balance() {
    let mut solver = begun(disks(&stirred()).unwrap());
    to(&mut solver, 3.0);
    let work = scalar_output(&solver, "work.boundaries");
    assert!(work > 20.0, "{work}");
    let error = scalar_output(&solver, "energy_error");
    assert!(error.abs() < 0.01, "{error}");
}

#[test]
fn a_restart_with_a_moving_obstacle_is_bit_identical() {
    let case = stirred();
    let walk = |solver: &mut dyn Solver, count: usize| {
        for _ in 0..count {
            let dt = solver.limit().dt;
            solver.step(dt).unwrap();
        }
    };
    let mut whole = begun(disks(&case).unwrap());
    to(&mut whole, 0.9);
    let saved = whole.checkpoint_bytes().unwrap();
    walk(&mut whole, 200);
    let mut again = Dem.build(&case).unwrap();
    again.restore(&mut saved.as_slice()).unwrap();
    again.begin_stage(0, 0.0).unwrap();
    walk(&mut *again, 200);
    assert_eq!(whole.checkpoint_bytes().unwrap(), again.checkpoint_bytes().unwrap());
}

#[test]
fn reaction_of_a_belt_has_the_force_and_moment_of_the_disk_on_it() {
    let mut solver = begun(disks(&read_case(&belt(&json!({ "velocity": [1, 0] })))).unwrap());
    to(&mut solver, 0.1);
    let (x, reaction) = (solver.snapshot().positions[0], solver.reaction("belt").unwrap());
    let [along, across, _] = reaction.force;
    assert!(
        (across / -9.81 - 1.0).abs() < 0.01 && (along / across - 0.2).abs() < 1e-9,
        "{:?}",
        reaction.force
    );
    // The force acts at the contact of disk and belt: its lever arm is 2 m about a point 2 m behind, and 0.5 m about the centre.
    let of = |about: [f64; 3]| reaction.moment_about(&about).unwrap()[2];
    assert!((of([x[0] - 2.0, 0.0, 0.0]) / (2.0 * across) - 1.0).abs() < 1e-3);
    assert!((of([x[0], x[1], 0.0]) / (0.5 * along) - 1.0).abs() < 1e-2);
    let saved = solver.checkpoint_bytes().unwrap();
    let mut again = begun(disks(&read_case(&belt(&json!({ "velocity": [1, 0] })))).unwrap());
    again.restore(&mut saved.as_slice()).unwrap();
    assert_eq!(again.reaction("belt"), Some(reaction));
}
