//! Absorbing boundaries.

use colluvium_mpm::Mpm;
use colluvium_testkit::{advance_to, assert_same_after_restart, read_case, solve, start_solver, vectors};
use serde_json::json;

use crate::boundary::elastic_block;

#[test]
fn absorbing_sides_with_springs_survive_a_restart() {
    let case = elastic_block().with(json!({
        "bodies": [{ "name": "b", "material": "m", "velocity": { "kind": "uniform", "value": [0.1, 0.05] },
                     "shape": { "kind": "box", "min": [0.35, 0.35], "max": [0.65, 0.65] } }],
        "boundaries": [{ "side": "x-max", "position": 0.65, "wall": { "kind": "absorbing", "spring_length": 0.3 } }]
    })).build();
    assert_same_after_restart(&Mpm, &case, |solver| {
        let end = if solver.time() < 0.02 { 0.02 } else { 0.04 };
        advance_to(solver, end);
    });
    // The spring brings it back where it was.
    let mut solver = start_solver(&Mpm, &case);
    advance_to(&mut *solver, 1.0);
    let mean = vectors(&solver.snapshot(), "displacement").iter().map(|u| u[0]).sum::<f64>() / 144.0;
    assert!(mean.abs() < 1e-4, "{mean}");
}

#[test]
fn absorbing_sides_stay_uniform_as_points_go_through_a_period() {
    let case = read_case(&json!({
        "title": "test", "space": "plane-strain", "domain": { "min": [0, 0], "max": [1, 2], "periodic": ["x"] }, "gravity": [0, 0],
        "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e5, "poissons_ratio": 0.2 } },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 1] },
                     "velocity": { "kind": "uniform", "value": [1, 0] } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "absorbing" } }],
        "stages": [{ "name": "a", "duration": 0.3 }, { "name": "b", "duration": 0.2 }],
        "methods": { "mpm": { "cell_size": 0.1 } }
    }));
    let snapshot = solve(&Mpm, &case).snapshot;
    let velocities = vectors(&snapshot, "velocity");
    for (x, v) in snapshot.positions.iter().zip(&velocities) {
        let row =
            snapshot.positions.iter().zip(&velocities).filter(|(other, _)| (other[1] - x[1]).abs() < 1e-9);
        assert!(row.into_iter().all(|(_, w)| (0..2).all(|c| (v[c] - w[c]).abs() < 1e-9)), "{v:?} at {x:?}");
    }
}

#[test]
fn absorbing_sides_do_not_depend_on_the_origin_of_displacements() {
    let ends = [json!([]), json!(["displacement"])].map(|reset| {
        let bar = read_case(&json!({
                "title": "test", "space": "1d", "domain": { "min": [0], "max": [2] }, "gravity": [0],
                "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e5, "poissons_ratio": 0 } },
                "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0], "max": [1] },
                             "velocity": { "kind": "uniform", "value": [1] } }],
                "boundaries": [{ "side": "x-min", "wall": { "kind": "absorbing" } }],
                "stages": [{ "name": "a", "duration": 0.05, "reset": reset }, { "name": "b", "duration": 0.05 }],
                "methods": { "mpm": { "cell_size": 0.1 } }
            }));
        solve(&Mpm, &bar).end.momentum[0]
    });
    assert_eq!(ends[0], ends[1]);
}
