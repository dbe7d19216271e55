//! Kinematics and invariants (sheet: dem §5, B17).

use colluvium_case::Solver;
use colluvium_dem::disks;
use colluvium_testkit::{assert_near, read_case};
use serde_json::json;

use crate::single_grains::{Scene, linear};

#[test]
fn rolling_grains_and_rigidly_rotating_grains_have_no_slip() {
    let along = |a: [f64; 2], b: [f64; 2], spins: [f64; 2]| {
        let mut scene = Scene::new(linear(1e6, 0.0, 0.5, 0.5)).disk([-1.0, 0.0], 1.0, a, spins[0]).disk(
            [0.5, 0.0],
            0.5,
            b,
            spins[1],
        );
        scene.options = json!({ "lever_arm": "radius" });
        let mut solver = scene.solver();
        for _ in 0..20 {
            solver.step(1e-6).unwrap();
        }
        let contact = solver.contacts().first().unwrap();
        contact.force[1] / contact.force[0]
    };
    // Gears: opposite spins without sliding.
    assert_near(along([0.01, 0.0], [0.0; 2], [1.0, -2.0]), 0.0, 1e-4);
    // Rigid rotation about the contact.
    assert_near(along([0.01, -1.0], [0.0, 0.5], [1.0, 1.0]), 0.0, 1e-4);
    assert!(along([0.01, 0.0], [0.0; 2], [1.0, 1.0]).abs() > 1e-3);
}

#[test]
fn a_colliding_pair_keeps_its_angular_momentum() {
    let scene = Scene::new(linear(1e6, 0.2, 0.5, 0.5)).disk([-0.52, 0.1], 0.5, [1.0, 0.3], 3.0).disk(
        [0.32, -0.1],
        0.3,
        [-0.5, 0.0],
        -7.0,
    );
    let mut solver = scene.solver();
    let start = solver.totals().angular_momentum[2];
    let mut touched = false;
    for _ in 0..2000 {
        let dt = solver.limit().dt;
        solver.step(dt).unwrap();
        touched |= !solver.contacts().is_empty();
        assert_near(solver.totals().angular_momentum[2] / start, 1.0, 1e-12);
    }
    assert!(touched);
}

#[test]
fn a_uniform_velocity_changes_no_force() {
    let after = |drift: [f64; 2]| {
        let scene = Scene::new(linear(1e6, 0.2, 0.5, 0.5))
            .disk([-0.5, 0.1], 0.5, [1.0 + drift[0], 0.3 + drift[1]], 3.0)
            .disk([0.31, -0.1], 0.3, [-0.5 + drift[0], drift[1]], -7.0);
        let mut solver = scene.solver();
        for _ in 0..400 {
            solver.step(1e-5).unwrap();
        }
        let snapshot = solver.snapshot();
        let v = snapshot.vectors("velocity").unwrap().to_vec();
        [v[0][0] - drift[0], v[0][1] - drift[1], snapshot.scalars("spin").unwrap()[1]]
    };
    let (still, moving) = (after([0.0; 2]), after([20.0, -8.0]));
    for c in 0..3 {
        assert_near(moving[c] - still[c], 0.0, 1e-8);
    }
}

#[test]
fn contact_across_a_periodic_boundary_equals_contact_within_the_cell() {
    let after = |shift: f64| {
        let at = |x: f64| {
            let x = x + shift;
            if x > 5.0 { x - 10.0 } else { x }
        };
        let mut scene = Scene::new(linear(1e4, 0.1, 0.5, 0.4))
            .disk([at(-0.52), 0.1], 0.5, [1.0, 0.3], 3.0)
            .disk([at(0.32), -0.1], 0.3, [-0.5, 0.0], -7.0);
        scene.periodic = json!(["x"]);
        scene.half = 5.0;
        let mut solver = scene.solver();
        for _ in 0..600 {
            solver.step(1e-4).unwrap();
        }
        let snapshot = solver.snapshot();
        let v = snapshot.vectors("velocity").unwrap().to_vec();
        [v[0][0], v[0][1], v[1][0], snapshot.scalars("spin").unwrap()[0]]
    };
    let (within, across) = (after(0.0), after(5.0));
    assert!((within[0] - 1.0).abs() > 0.1);
    for c in 0..4 {
        assert_near(across[c], within[c], 1e-9);
    }
}

#[test]
fn work_of_a_cell_includes_sudden_changes_of_its_rate() {
    // Two disks in contact while the cell changes from rest to shear at once, and back to another rate.
    let mut scene = Scene::new(linear(1e4, 0.0, 0.5, 0.4)).disk([-0.49, 0.1], 0.5, [0.2, 0.3], 3.0).disk(
        [0.3, -0.1],
        0.3,
        [-0.1, 0.0],
        -7.0,
    );
    scene.periodic = json!(["x", "y"]);
    scene.half = 2.0;
    scene.options = json!({ "stages": {
        "shear": { "cell": { "xy": { "rate": 5.0 } } },
        "back": { "cell": { "xy": { "rate": -3.0 }, "yy": { "rate": 0.5 } } }
    } });
    let mut case = scene.json();
    case["stages"] = json!([
        { "name": "rest", "duration": 0.02 },
        { "name": "shear", "duration": 0.02 },
        { "name": "back", "duration": 0.02 }
    ]);
    let mut solver = disks(&read_case(&case)).unwrap();
    let dt = 2e-5;
    let reading = |solver: &colluvium_dem::DemSolver<2, 1>, name: &str| {
        solver.scalar_outputs().into_iter().find(|(own, ..)| own == name).unwrap().2
    };
    let mut work = 0.0;
    for stage in 0..3 {
        solver.begin_stage(stage, stage as f64 * 0.02).unwrap();
        for _ in 0..1000 {
            solver.step(dt).unwrap();
        }
        let (came, error) = (reading(&solver, "work.boundaries"), reading(&solver, "energy_balance"));
        assert_near(reading(&solver, "work.stages"), 0.0, 1e-9);
        if stage > 0 {
            assert!((came - work).abs() > 0.1, "a cell that jumps does work");
        }
        // Of the order of the step: no error of the size of a jump remains.
        assert!(error.abs() < 2e-3 * came.abs().max(1.0), "stage {stage}: {error} J of {came} J");
        work = came;
    }
}
