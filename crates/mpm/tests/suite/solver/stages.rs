//! Loads, walls and bodies that begin or end with a stage.

use colluvium_case::{RunReport, Solver};
use colluvium_mpm::Mpm;
use colluvium_testkit::{solve, start_solver};
use serde_json::{Value, json};

use crate::solver::elastic_block;

#[test]
fn a_load_starts_with_its_stage_and_continues_in_later_stages() {
    let case = elastic_block().with(json!({
        "loads": [{ "kind": "traction", "body": "b", "side": "x-max", "value": [200, -50], "stage": "pull" }],
        "stages": [{ "name": "wait", "duration": 0.01 }, { "name": "pull", "duration": 0.02 }, { "name": "on", "duration": 0.01 }],
        "output": { "measures": 0.01 }
    })).build();
    let report = solve(&Mpm, &case);
    let momentum = report.table.pairs("time", "momentum.x").unwrap();
    assert!(momentum[1].1 == 0.0 && momentum[1].0 == 0.01, "none before: {momentum:?}");
    // Area 0.4 m × 1 m, 0.03 s.
    assert!((report.end.momentum[0] - 200.0 * 0.4 * 0.03).abs() < 1e-10);
    assert!((report.end.momentum[1] + 50.0 * 0.4 * 0.03).abs() < 1e-10);
    // A restart in a later stage keeps the start time of the load.
    let mut whole = start_solver(&Mpm, &case);
    let to = |solver: &mut dyn Solver, stage: usize, end: f64| {
        solver.begin_stage(stage, solver.time()).unwrap();
        while solver.time() < end - 1e-12 {
            let dt = solver.limit().dt.min(end - solver.time());
            solver.step(dt).unwrap();
        }
    };
    to(&mut *whole, 0, 0.01);
    to(&mut *whole, 1, 0.03);
    let saved = whole.checkpoint_bytes().unwrap();
    let mut again = start_solver(&Mpm, &case);
    again.restore(&mut saved.as_slice()).unwrap();
    to(&mut *whole, 2, 0.04);
    to(&mut *again, 2, 0.04);
    assert_eq!(again.snapshot().hash(), whole.snapshot().hash());
}

#[test]
fn a_removed_wall_releases_a_block_and_a_removed_body_has_no_points() {
    let solve_with = |second: Value| {
        elastic_block().with(json!({
            "bodies": [
                { "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0.3], "max": [0.5, 0.7] },
                  "velocity": { "kind": "uniform", "value": [0.5, 0] } },
                { "name": "away", "material": "m", "shape": { "kind": "box", "min": [0.8, 0.8], "max": [0.9, 0.9] } }
            ],
            "boundaries": [{ "name": "gate", "side": "x-max", "position": 0.5, "wall": { "kind": "smooth" } }],
            "stages": [{ "name": "held", "duration": 0.01 }, second]
        })).solve(&Mpm)
    };
    let held = solve_with(json!({ "name": "still held", "duration": 0.02 }));
    let free = solve_with(json!({
        "name": "free", "duration": 0.02, "remove_boundaries": ["gate"], "remove_bodies": ["away"]
    }));
    assert!(free.snapshot.bodies.iter().all(|body| *body == 0), "one body is left");
    let front = |report: &RunReport| {
        let of_block =
            report.snapshot.positions.iter().zip(&report.snapshot.bodies).filter(|(_, b)| **b == 0);
        of_block.map(|(x, _)| x[0]).fold(0.0, f64::max)
    };
    // Released, the front moves at about the speed the block came with.
    assert!(front(&free) - front(&held) > 0.5 * 0.5 * 0.02, "{} and {}", front(&free), front(&held));
}
