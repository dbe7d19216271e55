//! Obstacles with prescribed motion, on the nodes and on the points (docs/theory/mpm.md, obstacles).

use colluvium_case::{Case, Method};
use colluvium_mpm::Mpm;
use colluvium_testkit::{advance_exactly_to, case_with, read_case, scalar_output, start_solver};
use serde_json::{Value, json};

use crate::obstacles::penalty_obstacles::{GRAVITY, block, frictional, on_floor};

const BOTH: [&str; 2] = ["nodes", "points"];

#[test]
fn a_moving_floor_accelerates_a_block_by_coulomb_friction() {
    for form in BOTH {
        belt(form);
    }
}

fn belt(form: &str) {
    let mut value = block(&frictional(0.3));
    value["methods"]["mpm"]["obstacles"] = json!(form);
    value["obstacles"][0]["motion"] = json!({ "velocity": [0.5, 0.0] });
    value["stages"] = json!([{ "name": "belt", "duration": 1 }]);
    value["materials"]["m"]["youngs_modulus"] = json!(1e7);
    let case = read_case(&value);
    let mut solver = start_solver(&Mpm, &case);
    advance_exactly_to(&mut *solver, 0.1);
    let speed = solver.totals().momentum[0] / 180.0;
    assert!((speed / (0.3 * GRAVITY * 0.1) - 1.0).abs() < 0.03, "{form}: {speed}");
    advance_exactly_to(&mut *solver, 1.0);
    let speed = solver.totals().momentum[0] / 180.0;
    assert!((speed - 0.5).abs() < 0.01, "{form}: {speed}");
    // The belt pays for the block's energy and as much for friction.
    let work = scalar_output(&*solver, "obstacles.work");
    let kinetic = 0.5 * 180.0 * 0.25;
    assert!((work / (2.0 * kinetic) - 1.0).abs() < 0.03, "{form}: {work} {kinetic}");
    let friction = scalar_output(&*solver, "obstacles.friction");
    assert!((friction / kinetic - 1.0).abs() < 0.05, "{form}: {friction} {kinetic}");
}

#[test]
fn a_rotating_table_lifts_the_block_on_it() {
    for form in BOTH {
        table(form);
    }
}

/// The floor turns by 10 degrees about a place under the block, within a second after a start of 0.1 s.
fn table(form: &str) {
    let mut value = block(&json!({ "kind": "rough" }));
    value["methods"]["mpm"]["obstacles"] = json!(form);
    value["obstacles"][0]["motion"] =
        json!({ "rotation": 20.0, "centre": [0.6, 0.5], "start": 0.1, "ramp": 1.0 });
    value["stages"] = json!([{ "name": "turn", "duration": 1.1, "damping": 0.3 }]);
    let case = read_case(&value);
    let mut solver = start_solver(&Mpm, &case);
    advance_exactly_to(&mut *solver, 1.1);
    let (sine, cosine) = 10f64.to_radians().sin_cos();
    let snapshot = solver.snapshot();
    let displacement = snapshot.field("displacement").unwrap();
    let colluvium_case::FieldData::Vector(displacements) = &displacement.data else { panic!("no vectors") };
    for (x, displacement) in snapshot.positions.iter().zip(displacements) {
        let from = [x[0] - displacement[0] - 0.6, x[1] - displacement[1] - 0.5];
        let exact = [cosine * from[0] - sine * from[1], sine * from[0] + cosine * from[1]];
        let apart = (x[0] - 0.6 - exact[0]).hypot(x[1] - 0.5 - exact[1]);
        assert!(apart < 0.01, "{form}: {apart} at {x:?}");
    }
}

#[test]
fn motions_of_obstacles_are_checked() {
    let problem = |motion: Value| {
        let mut value = block(&frictional(0.2));
        value["obstacles"][0]["motion"] = motion;
        Case::from_json(&value.to_string()).unwrap_err().to_string()
    };
    assert!(problem(json!({ "velocity": [1] })).starts_with("obstacles[0].motion.velocity: has 1 entries"));
    assert!(problem(json!({ "rotation": 5 })).starts_with("obstacles[0].motion.centre"));
    assert!(problem(json!({ "velocity": [1, 0], "ramp": -1 })).starts_with("obstacles[0].motion.ramp"));
    let refused = |more: Value| {
        let mut value = block(&frictional(0.2));
        value["obstacles"][0]["motion"] = json!({ "velocity": [1, 0] });
        value["methods"]["mpm"] = json!({ "cell_size": 0.1 });
        value["measures"] = json!({});
        Mpm.build(&case_with(value, &more)).map(|_| ()).unwrap_err().to_string()
    };
    let consistent = json!({ "methods": { "mpm": { "cell_size": 0.1, "mass": "consistent", "stress_update": "usl", "shape": "linear", "formulation": "small-displacement" } } });
    let error = refused(consistent);
    assert!(error.starts_with("obstacles[0].motion: with a consistent mass"), "{error}");
}

/// A piston starts at once against a bar without sideways strain: a wave of the stress ρ c V runs into it.
#[test]
fn the_force_of_a_node_piston_is_the_impedance_and_its_work_the_energy() {
    let (speed, modulus) = (0.05f64, 1e6 * 0.8 / (1.2 * 0.6));
    let smooth = |side: &str| json!({ "side": side, "wall": { "kind": "smooth" } });
    let mut value = block(&json!({ "kind": "smooth" }));
    value["gravity"] = json!([0, 0]);
    value["materials"]["m"]["poissons_ratio"] = json!(0.2);
    value["domain"] = json!({ "min": [-0.2, 0], "max": [2.2, 0.2] });
    value["bodies"][0]["shape"] = json!({ "kind": "box", "min": [0, 0], "max": [2, 0.2] });
    value["boundaries"] = json!([smooth("y-min"), smooth("y-max")]);
    value["obstacles"][0]["shape"] = json!({ "kind": "plane", "point": [0, 0], "normal": [1, 0] });
    value["obstacles"][0]["motion"] = json!({ "velocity": [speed, 0] });
    value["stages"] = json!([{ "name": "push", "duration": 0.1 }]);
    value["methods"]["mpm"] = json!({ "cell_size": 0.02 });
    let mut solver = start_solver(&Mpm, &read_case(&value));
    let wave = (modulus / 1000.0f64).sqrt();
    advance_exactly_to(&mut *solver, 0.4 / wave);
    let (first, start) = (solver.reaction("floor").unwrap().impulse, solver.time());
    advance_exactly_to(&mut *solver, 1.6 / wave);
    let last = solver.reaction("floor").unwrap().impulse;
    let force = (last[0] - first[0]) / (solver.time() - start);
    let exact = -1000.0 * wave * speed * 0.2;
    assert!((force / exact - 1.0).abs() < 0.01, "{force} N for {exact} N");
    let budget = solver.budget().unwrap();
    assert!((budget.momentum[0] / -last[0] - 1.0).abs() < 1e-9, "{} {}", budget.momentum[0], last[0]);
    let work = scalar_output(&*solver, "obstacles.work");
    assert!((work / (-last[0] * speed) - 1.0).abs() < 1e-9, "{work} J");
    // Half of it is kinetic, half elastic; a sudden front rings.
    let stored = budget.kinetic + budget.elastic;
    assert!((stored / work - 1.0).abs() < 0.03, "{stored} J of {work} J");
}

#[test]
fn a_node_floor_moving_across_cells_is_bit_identical_on_threads_and_after_restart() {
    let mut value = block(&frictional(0.3));
    value["methods"]["mpm"]["obstacles"] = json!("nodes");
    value["obstacles"][0]["motion"] = json!({ "velocity": [0.8, 0.6], "rotation": 10, "centre": [0.6, 0.5] });
    value["stages"] = json!([{ "name": "lift", "duration": 1 }]);
    let case = read_case(&value);
    let run = |threads: usize, cut: bool| on_floor(&case, [150, 150], threads, cut);
    let whole = run(1, false);
    assert!(whole == run(2, false), "two threads");
    assert!(whole == run(1, true), "restored");
    // The impulse of the floor is the momentum of the block plus the impulse of its weight.
    let (_, totals, reaction, _) = &whole;
    assert!(totals.momentum[1] > 0.0);
    assert!((totals.momentum[0] + reaction.impulse[0]).abs() < 1e-8 * reaction.impulse[0].abs());
}
