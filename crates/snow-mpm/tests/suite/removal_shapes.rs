//! Removal shapes of a case (saw cuts).

use colluvium_case::{Method, Solver};
use colluvium_snow_mpm::SnowMpm;
use colluvium_testkit::{
    advance_steps, advance_to, assert_near, read_case, refusal, scalar_output, start_solver, take_steps,
};
use serde_json::{Value, json};

use crate::bodies::block;

/// The block, 0.6 m by 0.4 m of 400 kg/m³, that moves to the right with 1 m/s, with a saw through its lower quarter.
fn sawn() -> Value {
    let mut case = block(&json!({ "kind": "uniform", "value": [1, 0] }), &json!({}));
    case["removal_shapes"] = json!([{ "name": "saw", "shape": { "kind": "box", "min": [1.5, 0], "max": [1.7, 0.9] }, "velocity": [-4, 0],
        "start": 0.01, "stop": 0.085 }]);
    case
}

#[test]
fn a_saw_removes_the_points_in_its_path_and_records_their_mass_and_energy() {
    let case = read_case(&sawn());
    assert_eq!(SnowMpm.plan(&case).unwrap().warnings, Vec::<colluvium_case::Warning>::new());
    let mut solver = start_solver(&SnowMpm, &read_case(&sawn()));
    let start = solver.totals();
    advance_to(&mut *solver, 0.09);
    let end = solver.totals();
    assert_near(scalar_output(&*solver, "saw.travel"), 0.3, 1e-9);
    // Its edge comes to 1.2 m when the block's has come to 1.385 m; in the block's own coordinates it cuts from 1.115 m on, which
    // takes the four columns of points beyond, and the two rows below 0.9 m.
    let removed_mass = 2.0 * 4.0 * 0.05 * 0.05 * 400.0;
    assert_near(scalar_output(&*solver, "saw.mass"), removed_mass, 1e-9);
    assert_near(start.mass - end.mass, removed_mass, 1e-9);
    assert_near(scalar_output(&*solver, "volume"), 0.6 * 0.4 - removed_mass / 400.0, 1e-9);
    assert_near(scalar_output(&*solver, "saw.energy"), 0.5 * removed_mass, 1e-9);
    assert_near(start.kinetic - end.kinetic, 0.5 * removed_mass, 1e-9);
    assert!(scalar_output(&*solver, "energy_numerical").abs() < 1e-9);
    let snapshot = solver.snapshot();
    let spared = |x: &[f64; 3]| !(x[0] > 1.2 && x[1] < 0.9);
    assert!(snapshot.positions.iter().all(spared));
}

#[test]
fn a_cut_starts_with_its_stage_and_removes_points_of_its_bodies_only() {
    let mut value = sawn();
    value["stages"] = json!([{ "name": "wait", "duration": 0.02 }, { "name": "go", "duration": 0.09 }]);
    value["removal_shapes"][0]["stage"] = json!("go");
    let mut other = value["bodies"][0].clone();
    (other["name"], other["shape"]["min"], other["shape"]["max"]) =
        (json!("other"), json!([1.3, 0.8]), json!([1.4, 1.2]));
    value["bodies"].as_array_mut().unwrap().push(other);
    value["removal_shapes"][0]["bodies"] = json!(["other"]);
    let case = read_case(&value);
    let mut solver = start_solver(&SnowMpm, &read_case(&value));
    advance_to(&mut *solver, 0.02);
    assert_near(scalar_output(&*solver, "saw.mass"), 0.0, 0.0);
    assert_eq!(solver.removal_shape_travel(), [None], "it has not begun");
    solver.end_stage(&case.stages[0]).unwrap();
    solver.begin_stage(1, 0.02).unwrap();
    advance_to(&mut *solver, 0.11);
    assert_near(scalar_output(&*solver, "saw.travel"), 0.3, 1e-9);
    assert_near(scalar_output(&*solver, "saw.mass"), 2.0 * 2.0 * 0.05 * 0.05 * 400.0, 1e-9);
    assert_near(solver.removal_shape_travel()[0].unwrap(), 0.3, 1e-9);
}

#[test]
fn a_restart_during_a_cut_is_bit_identical() {
    let case = read_case(&sawn());
    let mut first = start_solver(&SnowMpm, &read_case(&sawn()));
    advance_to(&mut *first, 0.06);
    assert!(scalar_output(&*first, "saw.mass") > 0.0);
    let saved = first.checkpoint_bytes().unwrap();
    let mut second = SnowMpm.build(&case).unwrap();
    second.restore(&mut saved.as_slice()).unwrap();
    second.begin_stage(0, 0.0).unwrap();
    let before = first.point_count();
    for solver in [&mut first, &mut second] {
        let dt = solver.limit().dt;
        take_steps(&mut **solver, 1, 0.5 * dt);
        advance_steps(&mut **solver, 120);
    }
    assert!(first.point_count() < before);
    assert_eq!(first.checkpoint_bytes().unwrap(), second.checkpoint_bytes().unwrap());
}

#[test]
fn invalid_cuts_are_refused_by_path() {
    let change = |key: &str, to: Value| {
        let mut case = sawn();
        case["removal_shapes"][0][key] = to;
        refusal(&SnowMpm, &case)
    };
    for (error, words) in [
        (change("stop", json!(0.01)), "removal_shapes[0].stop: 0.01 s must be after start, 0.01 s"),
        (change("start", json!(-1)), "removal_shapes[0].start: -1 must not be negative"),
        (
            change("stage", json!("og")),
            "removal_shapes[0].stage: \"og\" is not the name of a stage; did you mean \"go\"?",
        ),
        (
            change("bodies", json!(["rock"])),
            "removal_shapes[0].bodies[0]: \"rock\" is not the name of a body",
        ),
        (
            change("velocity", json!([1])),
            "removal_shapes[0].velocity: has 1 entries, the space has 2 dimensions",
        ),
        (change("name", json!("a saw")), "removal_shapes[0].name: "),
    ] {
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn doubtful_cuts_cause_warnings() {
    let change = |key: &str, to: Value| {
        let mut case = sawn();
        case["removal_shapes"][0][key] = to;
        SnowMpm.plan(&read_case(&case)).unwrap().warnings
    };
    let thin = change("shape", json!({ "kind": "box", "min": [1.5, 0], "max": [1.6, 0.9] }));
    assert!(
        thin.len() == 1 && thin[0].text.starts_with("removal_shapes[0].shape: its smallest width is 0.1"),
        "{thin:?}"
    );
    let away = change("velocity", json!([4, 0]));
    assert!(
        away.len() == 1 && away[0].text.starts_with("removal_shapes[0]: no body that it cuts"),
        "{away:?}"
    );
}

#[test]
fn a_slanted_layer_end_counts_as_uncut_until_the_saw_arrives() {
    // A spike at the block's right end is thinner than points are apart: three bins have none.
    let mut value = sawn();
    value["bodies"][0]["velocity"] = json!({ "kind": "rest" });
    let vertices = json!([[0.7, 0.8], [1.25, 0.8], [1.6, 0.805], [1.25, 0.81], [1.25, 1.2], [0.7, 1.2]]);
    value["bodies"][0]["shape"] = json!({ "kind": "polygon", "vertices": vertices });
    value["measures"] = json!({ "crack": { "kind": "crack-tip", "body": "block", "field": "density", "threshold": 1e9,
        "direction": [-1, 0], "from": [1.6, 0], "bin": 0.1 } });
    let case = read_case(&value);
    let mut solver = start_solver(&SnowMpm, &read_case(&value));
    let tip = |solver: &dyn Solver| colluvium_case::measure::read_solver(&case, solver)[0].2;
    assert_near(tip(&*solver), 0.0, 0.0);
    advance_to(&mut *solver, 0.09);
    assert_near(tip(&*solver), 0.3, 1e-12);
}
