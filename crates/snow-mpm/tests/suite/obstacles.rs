//! Obstacles on the nodes (sheet: snow-mpm §3.7).

use colluvium_case::Solver;
use colluvium_snow_mpm::SnowMpm;
use colluvium_testkit::cases::{advance_to, begin, changed};
use serde_json::{Value, json};

use crate::common::{reading, refused, velocities};

/// Down the plane, which falls by 30 degrees.
const DOWN: [f64; 2] = [0.866_025_403_784_438_6, -0.5];

const GRAVITY: f64 = 9.81;

/// A block on a plane along no axis (sheet: snow-mpm V15).
fn block_on_plane(wall: &Value) -> Value {
    json!({
        "title": "block on a plane", "space": "plane-strain", "gravity": [0, -GRAVITY],
        "domain": { "min": [0, 0], "max": [4, 3] },
        "materials": { "m": { "model": "linear-elastic", "strain_measure": "hencky", "density": 400, "youngs_modulus": 1e6, "poissons_ratio": 0.3 } },
        "bodies": [{ "name": "block", "material": "m", "shape": { "kind": "polygon",
            "vertices": [[0.519_615, 2.1], [1.385_641, 1.6], [1.635_641, 2.033_013], [0.769_615, 2.533_013]] } }],
        "obstacles": [{ "name": "plane", "wall": wall,
            "shape": { "kind": "plane", "point": [0, 2.4], "normal": [-DOWN[1], DOWN[0]] } }],
        // Dropped at once, an elastic block bounces, and slips while it is light.
        "stages": [
            { "name": "settle", "duration": 0.5, "gravity_ramp": 0.3, "damping": 0.5 },
            { "name": "slide", "duration": 0.6 }
        ],
        "methods": { "snow-mpm": { "cell_size": 0.05 } }
    })
}

/// After settling: mean acceleration down the plane (m/s²), way down it (m), and work of walls over that of gravity.
fn slid(wall: &Value) -> [f64; 3] {
    let case = changed(block_on_plane(wall), &json!({}));
    let mut solver = begin(&SnowMpm, &case);
    let works = |solver: &dyn Solver| ["work_of_walls", "work_of_gravity"].map(|name| reading(solver, name));
    let mean = |all: &[[f64; 3]]| {
        all.iter().map(|v| v[0] * DOWN[0] + v[1] * DOWN[1]).sum::<f64>() / all.len() as f64
    };
    advance_to(&mut *solver, 0.5);
    solver.end_stage(&case.stages[0]).unwrap();
    solver.begin_stage(1, 0.5).unwrap();
    let (start, before) = (solver.snapshot(), works(&*solver));
    advance_to(&mut *solver, 1.1);
    let (end, after) = (solver.snapshot(), works(&*solver));
    let way = mean(&end.positions) - mean(&start.positions);
    let rate = (mean(&velocities(&end)) - mean(&velocities(&start))) / (end.time - start.time);
    [rate, way, (after[0] - before[0]) / (after[1] - before[1])]
}

#[test]
fn a_block_slides_on_a_plane_along_no_axis_by_coulombs_law() {
    let [rate, ..] = slid(&json!({ "kind": "frictional", "friction_coefficient": 0.3 }));
    let exact = GRAVITY * (0.5 - 0.3 * DOWN[0]);
    let [_, way, _] = slid(&json!({ "kind": "frictional", "friction_coefficient": 0.7 }));
    assert!((rate / exact - 1.0).abs() < 5e-3, "{rate} for {exact}");
    assert!(way.abs() < 1e-3, "{way}");
}

#[test]
fn a_smooth_plane_takes_nothing_of_what_slides() {
    let [rate, _, work] = slid(&json!({ "kind": "smooth" }));
    let exact = 0.5 * GRAVITY;
    assert!((rate / exact - 1.0).abs() < 1e-3, "{rate} for {exact}");
    assert!(work.abs() < 5e-3, "{work}");
}

#[test]
fn what_lies_in_an_obstacle_or_adheres_to_it_is_refused_where_it_stands() {
    let mut case = block_on_plane(&json!({ "kind": "rough" }));
    case["bodies"][0]["shape"] = json!({ "kind": "box", "min": [0.5, 2.0], "max": [1.0, 2.5] });
    let error = refused(&case);
    assert!(
        error.starts_with("bodies[0].shape: the point at [0.5") && error.contains("\"plane\""),
        "{error}"
    );
    let wall = json!({ "kind": "frictional", "friction_coefficient": 0.3, "adhesion": 10 });
    let error = refused(&block_on_plane(&wall));
    assert!(error.starts_with("obstacles[0].wall.adhesion: snow-mpm"), "{error}");
}
