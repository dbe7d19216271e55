//! Obstacles on the nodes, and cases at the coordinates of a map.

use colluvium_case::{Case, Method, RunOptions, Solver, run};
use colluvium_mpm::Mpm;
use colluvium_testkit::{advance_steps, read_case, start_solver};
use serde_json::{Value, json};

/// A block above a slope of straight pieces, in the coordinates of a map with a zero at `at` (m), which are whole.
fn slope(at: [f64; 2]) -> Value {
    let p = |x: f64, y: f64| json!([decimal(x, at[0]), decimal(y, at[1])]);
    let elastic =
        json!({ "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.3 });
    json!({
        "title": "slope", "space": "plane-strain", "gravity": [0, -9.81], "materials": { "m": elastic },
        "domain": { "min": p(0.0, 0.0), "max": p(3.0, 2.0) },
        "bodies": [{ "name": "block", "material": "m", "shape": { "kind": "box", "min": p(0.3, 1.3), "max": p(0.9, 1.7) } }],
        "obstacles": [{
            "name": "ground", "wall": { "kind": "frictional", "friction_coefficient": 0.4 },
            "shape": { "kind": "ground-line", "points": [p(-0.1, 1.2), p(1.1, 1.1), p(2.3, 0.3), p(3.7, 0.2)] }
        }],
        "stages": [{ "name": "slide", "duration": 0.5 }],
        "methods": { "mpm": { "cell_size": 0.1 } }
    })
}

/// The number whose decimals are those of the sum.
fn decimal(x: f64, by: f64) -> f64 {
    format!("{:.1}", x + by).parse().unwrap()
}

#[test]
fn a_run_in_map_coordinates_is_bit_identical_to_the_run_at_zero() {
    let here = read_case(&slope([0.0; 2]));
    let mut on_map = slope([5e5, 5e6]);
    on_map["domain"]["origin"] = json!([5e5, 5e6]);
    let there = read_case(&on_map);
    let state = |case: &Case| {
        let mut solver = start_solver(&Mpm, case);
        advance_steps(&mut *solver, 400);
        (solver.snapshot(), solver.totals())
    };
    assert_eq!(state(&here), state(&there));
    let [shown, plain] = [&there, &here]
        .map(|case| run(case, Mpm.build(case).unwrap(), &RunOptions::default()).unwrap().snapshot.positions);
    for (a, b) in shown.iter().zip(&plain) {
        assert!(*a == [b[0] + 5e5, b[1] + 5e6, b[2]], "{a:?}, {b:?}");
    }
}

#[test]
fn points_penetrate_node_obstacles_by_less_than_a_tenth_cell() {
    let case = read_case(&slope([0.0; 2]));
    let standing = case.placed_obstacles::<2>().unwrap();
    let mut solver = start_solver(&Mpm, &case);
    let mut deepest = 0.0f64;
    while solver.time() < 1.0 {
        advance_steps(&mut *solver, 20);
        for x in solver.snapshot().positions {
            let gap = standing[0].surface.gap(&[x[0], x[1]], 1.0).unwrap();
            deepest = deepest.min(gap.distance);
        }
    }
    assert!(deepest > -0.01, "a tenth of a cell: {deepest}");
}

#[test]
fn points_in_obstacles_and_unsupported_options_are_rejected_by_path() {
    let problem = |pointer: &str, value: Value| {
        let mut case = slope([0.0; 2]);
        let (above, key) = pointer.rsplit_once('/').unwrap();
        case.pointer_mut(above).unwrap()[key] = value;
        Mpm.build(&read_case(&case)).map(|_| ()).unwrap_err().to_string()
    };
    let deep = json!({ "kind": "box", "min": [0.3, 1.0], "max": [0.9, 1.4] });
    let found = problem("/bodies/0/shape", deep);
    assert!(
        found.starts_with("bodies[0].shape: the point at [0.3") && found.contains("\"ground\""),
        "{found}"
    );
    let raster = json!({ "kind": "raster", "file": "no.asc" });
    let found = problem("/obstacles/0/shape", raster);
    assert!(found.starts_with("obstacles[0].shape.file: "), "{found}");
    assert!(found.contains("no.asc: cannot be read"), "{found}");
    let ball =
        json!({ "kind": "extruded", "vertices": [[0, 0], [1, 0], [0, 1]], "axis": 0, "from": 0, "to": 1 });
    let mut case = slope([0.0; 2]);
    case["obstacles"][0]["shape"] = ball;
    let found = Case::from_json(&case.to_string()).unwrap_err().to_string();
    assert!(found.starts_with("obstacles[0].shape: is a shape of 3 dimensions, the space has 2"), "{found}");
    assert!(
        problem("/methods/mpm", json!({ "cell_size": 0.1, "transfer": "xpic" }))
            .starts_with("methods.mpm.transfer")
    );
    assert!(problem("/obstacles/0/wall/adhesion", json!(10)).starts_with("obstacles[0].wall.adhesion: mpm"));
}

#[test]
fn reactions_equal_the_momentum_loss_and_are_bit_identical_after_a_restart() {
    for fixed in ["force", "momentum"] {
        let mut value = slope([0.0; 2]);
        value["bodies"][0]["velocity"] = json!({ "kind": "uniform", "value": [1.0, -1.0] });
        value["measures"] = json!({ "push": { "kind": "reaction", "target": "ground" } });
        value["methods"]["mpm"]["fixed_nodes"] = json!(fixed);
        let case = read_case(&value);
        let mut solver = start_solver(&Mpm, &case);
        let start = solver.totals();
        advance_steps(&mut *solver, 300);
        let mut again = start_solver(&Mpm, &case);
        again.restore(&mut solver.checkpoint_bytes().unwrap().as_slice()).unwrap();
        again.begin_stage(0, 0.0).unwrap();
        for solver in [&mut solver, &mut again] {
            advance_steps(&mut **solver, 300);
            let (end, push) = (solver.totals(), solver.reaction("ground").unwrap());
            let weight = -9.81 * end.mass * solver.time();
            let scale = weight.abs() + 1e-3;
            // The impulse of gravity less the gain of momentum is the impulse on the ground.
            for (axis, came) in [(0, 0.0), (1, weight)] {
                let lost = start.momentum[axis] + came - end.momentum[axis];
                let off = (push.impulse[axis] - lost).abs() / scale;
                assert!(off < 1e-10, "{fixed}, axis {axis}: {lost} and {push:?}");
            }
            assert!(push.impulse[1] < 0.0, "down: {push:?}");
        }
        assert_eq!(solver.reaction("ground"), again.reaction("ground"));
        let bits = |solver: &dyn Solver| -> Vec<u64> {
            solver.scalar_outputs().iter().map(|reading| reading.2.to_bits()).collect()
        };
        assert_eq!(bits(&*solver), bits(&*again));
    }
}

#[test]
fn friction_dissipates_the_energy_that_a_thrown_block_loses() {
    let mut value = slope([0.0; 2]);
    value["obstacles"][0]["shape"] = json!({ "kind": "plane", "point": [0, 1], "normal": [0, 1] });
    value["obstacles"][0]["wall"]["friction_coefficient"] = json!(0.3);
    value["bodies"][0]["shape"] = json!({ "kind": "box", "min": [0.3, 1.0], "max": [1.1, 1.2] });
    value["bodies"][0]["velocity"] = json!({ "kind": "uniform", "value": [1.5, 0.0] });
    // In equilibrium from the start: a bouncing block has intermittent friction, which excites oscillations.
    value["bodies"][0]["stress"] = json!({ "kind": "k0", "surface": 1.2, "coefficient": 0.43 });
    value["materials"]["m"]["youngs_modulus"] = json!(1e7);
    let case = read_case(&value);
    let mut solver = start_solver(&Mpm, &case);
    let start = solver.totals();
    // It stops after v/(μ g) = 0.51 s.
    while solver.time() < 0.4 {
        solver.step(0.4 - solver.time()).unwrap();
    }
    let readings = solver.scalar_outputs();
    let friction = readings.iter().find(|(name, ..)| name == "obstacles.friction").unwrap().2;
    let end = solver.totals();
    let places = solver.snapshot().positions;
    let distance = places.iter().map(|x| x[0]).sum::<f64>() / places.len() as f64 - 0.7;
    // The nodes on the floor move 2.4 % slower than the block, with linear functions 2.2 %: why has not been found.
    let exact = 0.3 * 9.81 * end.mass * distance;
    assert!((friction / exact - 1.0).abs() < 0.05, "{friction} for {exact}");
    let lost = start.momentum[0].powi(2) / (2.0 * start.mass) - end.momentum[0].powi(2) / (2.0 * end.mass);
    assert!((friction / lost - 1.0).abs() < 0.05, "{friction} for {lost}");
}
