//! Walls that follow a stress (sheet: dem §3.7).

use colluvium_case::{Case, Solver};
use colluvium_dem::{DemSolver, disks};
use colluvium_testkit::near;
use serde_json::{Value, json};

use crate::common::{Scene, begun, linear};

const STIFFNESS: f64 = 1e6;
const DISKS: usize = 3;

/// A stack of disks of radius 0.5 m, without gravity, under a wall that presses with 5 N/m over the 200 m of the domain.
fn stack(start: f64) -> Value {
    let mut scene = Scene::new(linear(STIFFNESS, 0.3, 0.5, 0.5));
    for k in 0..DISKS {
        scene = scene.disk([0.0, 0.5 + k as f64], 0.5, [0.0; 2], 0.0);
    }
    scene.boundaries = json!([
        { "side": "y-min", "name": "floor", "position": 0, "wall": { "kind": "smooth" } },
        { "side": "y-max", "name": "platen", "position": start, "wall": { "kind": "smooth" } }
    ]);
    scene.options = json!({ "stages": { "all": { "walls": { "platen": { "stress": -5, "speed": 0.5, "area": 200 } } } } });
    scene.json()
}

fn solver(value: &Value) -> DemSolver<2, 1> {
    begun(disks(&Case::from_json(&value.to_string()).unwrap()).unwrap())
}

fn reading(solver: &dyn Solver, name: &str) -> f64 {
    solver.readings().into_iter().find(|(own, ..)| own == name).unwrap().2
}

fn to(solver: &mut dyn Solver, time: f64) {
    while solver.time() < time {
        let dt = solver.limit().dt;
        solver.step(dt).unwrap();
    }
}

#[test]
fn a_platen_comes_to_rest_where_the_stack_bears_its_stress() {
    let mut solver = solver(&stack(3.2));
    to(&mut solver, 0.1);
    near(reading(&solver, "wall.platen.position"), 3.15, 1e-3);
    near(reading(&solver, "wall.platen.stress"), 0.0, 1e-12);
    to(&mut solver, 3.0);
    // All of the contacts bear 1000 N.
    let overlap = 1000.0 / STIFFNESS;
    near(reading(&solver, "wall.platen.position"), DISKS as f64 - (DISKS + 1) as f64 * overlap, 1e-7);
    near(reading(&solver, "wall.platen.stress"), -5.0, 1e-4);
    near(solver.reaction("platen").unwrap().force[1], 1000.0, 0.02);
    near(solver.reaction("floor").unwrap().force[1], -1000.0, 0.02);
    // Its work is what the springs hold and the dashpots have taken.
    assert!(reading(&solver, "work.boundaries") > 4.0 * 0.5 * 1000.0 * overlap);
    near(reading(&solver, "energy_error"), 0.0, 2e-3);
}

#[test]
fn a_platen_does_not_turn_round_each_step_where_steps_are_short_for_its_dashpots() {
    let mut value = stack(3.02);
    let step = solver(&value).limit().dt / 20.0;
    value["methods"]["dem"]["time_step"] = json!(step);
    let mut solver = solver(&value);
    to(&mut solver, 1.5);
    let mut before = reading(&solver, "wall.platen.position");
    for _ in 0..50 {
        solver.step(step).unwrap();
        near(reading(&solver, "wall.platen.stress"), -5.0, 1e-3);
        let after = reading(&solver, "wall.platen.position");
        near(after - before, 0.0, 1e-3 * 0.5 * step);
        before = after;
    }
}

#[test]
fn a_run_goes_on_bit_for_bit_while_a_platen_moves() {
    let mut solver = solver(&stack(3.02));
    to(&mut solver, 0.045);
    let saved = solver.saved().unwrap();
    to(&mut solver, 0.1);
    let mut again = self::solver(&stack(3.02));
    again.restore(&mut &saved[..]).unwrap();
    again.begin_stage(0, 0.0).unwrap();
    to(&mut again, 0.1);
    assert_eq!(solver.saved().unwrap(), again.saved().unwrap());
}

#[test]
fn a_platen_that_pulls_or_is_not_there_is_refused() {
    let refused = |change: fn(&mut Value)| {
        let mut value = stack(3.2);
        change(&mut value["methods"]["dem"]["stages"]["all"]["walls"]);
        let case = Case::from_json(&value.to_string()).unwrap();
        disks(&case).map(|_| ()).unwrap_err().to_string()
    };
    let pulls = refused(|walls| walls["platen"]["stress"] = json!(5));
    assert!(pulls.contains("stages.all.walls.platen.stress") && pulls.contains("negative"), "{pulls}");
    let unknown = refused(|walls| walls["plate"] = walls["platen"].clone());
    assert!(unknown.contains("did you mean \"platen\""), "{unknown}");
    let swings = refused(|walls| walls["platen"]["gain"] = json!(0.5));
    assert!(swings.contains("walls.platen.gain"), "{swings}");
}

#[test]
fn a_platen_whose_area_nothing_bounds_needs_it() {
    let mut value = stack(3.2);
    let platen = &mut value["methods"]["dem"]["stages"]["all"]["walls"]["platen"];
    platen.as_object_mut().unwrap().remove("area");
    let refused =
        |value: &Value| disks(&Case::from_json(&value.to_string()).unwrap()).err().unwrap().to_string();
    let error = refused(&value);
    assert!(error.starts_with("methods.dem.stages.all.walls.platen.area: is missing: along x"), "{error}");
    value["methods"]["dem"]["stages"]["all"]["walls"]["platen"]["sleeve"] = json!("grain 0");
    let error = refused(&value);
    assert!(error.contains("platen.sleeve: \"grain 0\" is no body that is a closed membrane"), "{error}");
}
