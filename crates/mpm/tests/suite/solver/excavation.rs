//! Excavation.

use colluvium_mpm::Mpm;
use colluvium_testkit::{solve, start_solver};
use serde_json::json;

use crate::boundary::elastic_block;

#[test]
fn excavated_points_are_removed_and_the_others_continue() {
    let case = elastic_block()
        .with(json!({
            "gravity": [0, -10],
            "boundaries": [{ "side": "y-min", "position": 0.35, "wall": { "kind": "rough" } }],
            "loads": [{ "kind": "traction", "body": "b", "side": "y-max", "value": [0, -10] }],
            "stages": [{ "name": "all", "duration": 0.02 },
                       { "name": "dug", "duration": 0.02,
                         "excavate": [{ "kind": "box", "min": [0.5, 0.5], "max": [0.65, 0.65] }] }],
            "methods": { "mpm": { "cell_size": 0.05, "transfer": "xpic" } }
        }))
        .build();
    let report = solve(&Mpm, &case);
    assert_eq!(report.snapshot.ids.len(), 108);
    assert!((report.end.mass - 67.5).abs() < 1e-9);
    assert!(report.snapshot.positions.iter().all(|x| x[0] < 0.5 || x[1] < 0.5));
    let mut whole = start_solver(&Mpm, &case);
    whole.step(1e-4).unwrap();
    let start = whole.time();
    whole.begin_stage(1, start).unwrap();
    whole.step(1e-4).unwrap();
    let mut again = start_solver(&Mpm, &case);
    again.restore(&mut whole.checkpoint_bytes().unwrap().as_slice()).unwrap();
    again.begin_stage(1, start).unwrap();
    for solver in [&mut whole, &mut again] {
        solver.step(1e-4).unwrap();
    }
    assert_eq!(again.snapshot().hash(), whole.snapshot().hash());
}
