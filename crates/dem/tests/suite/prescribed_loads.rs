//! Forces on bodies, membranes, shaking, and cyclic cells (sheet: dem §2.1, §3.7, §3.8).

use std::f64::consts::TAU;

use colluvium_case::{Case, Solver};
use colluvium_dem::{Dem, DemSolver, Shaking, disks};
use colluvium_testkit::{assert_near, read_case, refusal, scalar_output};
use serde_json::{Value, json};

use crate::single_grains::{Scene, begun, linear};

fn to(solver: &mut DemSolver<2, 1>, time: f64) {
    while solver.time() < time * (1.0 - 1e-12) {
        let dt = (time - solver.time()).min(solver.limit().dt);
        solver.step(dt).unwrap();
    }
}

fn solver(value: &Value) -> DemSolver<2, 1> {
    begun(disks(&read_case(value)).unwrap())
}

/// Block of grains of 0.02 m at rest, with another one beside it.
fn blocks() -> Value {
    let mut value = Scene::new(linear(1e6, 0.0, 0.5, 0.3)).disk([0.0; 2], 0.5, [0.0; 2], 0.0).json();
    value["methods"]["dem"]["grains"]["grain"] = json!({ "density": 2500,
        "diameter": { "distribution": "uniform", "min": 0.01, "max": 0.02 },
        "fill": { "kind": "lattice", "packing": "square", "pitch": 0.021 } });
    value["bodies"] = json!([
        { "name": "one", "material": "grain", "shape": { "kind": "box", "min": [0, 0], "max": [0.105, 0.105] } },
        { "name": "two", "material": "grain", "shape": { "kind": "box", "min": [1, 0], "max": [1.105, 0.105] } }
    ]);
    value["methods"]["dem"]["bodies"] = json!({});
    value["gravity"] = json!([0.5, -9.81]);
    value
}

#[test]
fn a_force_on_a_body_accelerates_its_grains_uniformly_and_its_work_is_recorded() {
    let mut value = blocks();
    value["methods"]["dem"]["stages"] = json!({ "all": { "forces": { "two": [3.0, 4.0] } } });
    for velocity in ["lagged", "predicted"] {
        value["methods"]["dem"]["velocity"] = json!(velocity);
        let mut solver = solver(&value);
        to(&mut solver, 0.1);
        let snapshot = solver.snapshot();
        let mass: f64 = (25..50).map(|i| snapshot.scalars("mass").unwrap()[i]).sum();
        let (u, v) = (snapshot.vectors("displacement").unwrap(), snapshot.vectors("velocity").unwrap());
        for i in 0..50 {
            let push = if i < 25 { [0.0; 2] } else { [3.0 / mass, 4.0 / mass] };
            for (c, gravity) in [0.5, -9.81].into_iter().enumerate() {
                let rate = gravity + push[c];
                assert_near(u[i][c], 0.5 * rate * 0.01, 1e-10);
                assert_near(v[i][c], rate * 0.1, 1e-10);
            }
        }
        // At the time of the last forces, a step before.
        let then = 0.1 - solver.limit().dt;
        let displacement = |push: f64, gravity: f64| 0.5 * (gravity + push / mass) * then * then;
        let work = 3.0 * displacement(3.0, 0.5) + 4.0 * displacement(4.0, -9.81);
        assert_near(scalar_output(&solver, "work.forces") / work, 1.0, 1e-2);
        assert_near(scalar_output(&solver, "energy_error"), 0.0, 1e-9);
    }
}

#[test]
fn forces_on_held_or_missing_grains_are_refused() {
    let value = blocks();
    let stage = |stage: Value| {
        let mut value = value.clone();
        value["methods"]["dem"]["stages"] = json!({ "all": stage });
        value
    };
    for (own, path) in [
        (
            json!({ "forces": { "tow": [0, 0] } }),
            "methods.dem.stages.all.forces.tow: \"tow\" is not the name of a body; did you mean \"two\"?",
        ),
        (json!({ "forces": { "two": [0] } }), "methods.dem.stages.all.forces.two: must be 2 finite numbers"),
        (
            json!({ "membranes": { "two": { "pressure": 1, "against": "two" } } }),
            "methods.dem.stages.all.membranes.two.against: ",
        ),
        (
            json!({ "membranes": { "two": { "pressure": -1, "against": "one" } } }),
            "methods.dem.stages.all.membranes.two.pressure: -1",
        ),
        (
            json!({ "shaking": { "acceleration": [1], "frequency": 3 } }),
            "methods.dem.stages.all.shaking.acceleration: ",
        ),
        (
            json!({ "shaking": { "acceleration": [1, 0], "frequency": -3 } }),
            "methods.dem.stages.all.shaking.frequency: -3",
        ),
    ] {
        let error = refusal(&Dem, &stage(own));
        assert!(error.starts_with(path), "{error}");
    }
    let mut held = stage(json!({ "forces": { "two": [0, 0] } }));
    held["methods"]["dem"]["bodies"] = json!({ "two": { "held": true } });
    assert!(refusal(&Dem, &held).starts_with("methods.dem.stages.all.forces.two: its grains are held"));
    let mut gone = stage(json!({ "forces": { "two": [0, 0] } }));
    gone["stages"][0]["remove_bodies"] = json!(["two"]);
    assert!(
        refusal(&Dem, &gone)
            .starts_with("methods.dem.stages.all.forces.two: the body \"two\" has been removed")
    );
}

#[test]
fn membrane_force_in_plane_is_pressure_times_the_chord_of_its_grains() {
    let folder = tempfile::tempdir().unwrap();
    // A bent row, and a body on its left or right; from the first grain of the row on, the left is towards negative x.
    let row = [[0.0, 0.0], [0.0, 1.0], [0.5, 1.9], [0.4, 3.0]];
    let lines: Vec<String> = row.iter().map(|[x, y]| format!("{x},{y},0.5")).collect();
    std::fs::write(folder.path().join("row.csv"), format!("x,y,volume\n{}\n", lines.join("\n"))).unwrap();
    for side in [-1.0, 1.0] {
        let mut value =
            Scene::new(linear(1e6, 0.0, 0.5, 0.3)).disk([8.0 * side, 1.0], 0.5, [0.0; 2], 0.0).json();
        let shape = json!({ "kind": "box", "min": [-1, -1], "max": [2, 4] });
        value["bodies"].as_array_mut().unwrap().push(
            json!({ "name": "row", "material": "grain", "shape": shape, "points": { "file": "row.csv" } }),
        );
        value["methods"]["dem"]["stages"] =
            json!({ "all": { "membranes": { "row": { "pressure": 20.0, "against": "grain 0" } } } });
        let mut solver = begun(disks(&Case::from_value(&value, folder.path()).unwrap()).unwrap());
        let time = 1e-3;
        to(&mut solver, time);
        // For any bend the sum is the pressure times the chord, towards the body.
        let momentum = solver.totals().momentum;
        let exact = [20.0 * 3.0 * side, -20.0 * 0.4 * side];
        let then = time - solver.limit().dt;
        for c in 0..2 {
            assert_near(momentum[c] / (exact[c] * then), 1.0, 0.05);
        }
        // The second grain takes half of the two lines beside it, the vectors (0, 1) m and (0.5, 0.9) m.
        let v = solver.snapshot().vectors("velocity").unwrap()[2];
        let mass = 0.5 * 4.0 / std::f64::consts::PI;
        assert_near(v[0] * mass / (20.0 * 0.95 * side * time), 1.0, 1e-3);
        assert_near(v[1] * mass / (-20.0 * 0.25 * side * time), 1.0, 1e-3);
        assert_near(scalar_output(&solver, "energy_error"), 0.0, 1e-6);
    }
}

#[test]
fn grains_in_a_shaken_box_follow_the_cyclic_acceleration() {
    let mut value = blocks();
    value["gravity"] = json!([0, 0]);
    value["stages"][0]["duration"] = json!(0.4);
    value["methods"]["dem"]["stages"] =
        json!({ "all": { "shaking": { "acceleration": [2.0, 0.0], "frequency": 5.0 } } });
    let mut solver = solver(&value);
    to(&mut solver, 0.33);
    let rate = TAU * 5.0;
    let exact = 2.0 / rate * (0.33 - (rate * 0.33f64).sin() / rate);
    assert_near(solver.snapshot().vectors("displacement").unwrap()[0][0] / exact, 1.0, 1e-4);
    assert_near(scalar_output(&solver, "energy_error"), 0.0, 1e-6);
    // From 5 to 10 Hz in 2 s: mean 7.5 Hz, 15 cycles, of which 5 + 1.25 are in the first half of the time.
    let sweep = Shaking { acceleration: vec![1.0, 0.0], frequency: 5.0, last_frequency: Some(10.0) };
    assert_near(sweep.factor(2.0, 2.0), 0.0, 1e-9);
    assert_near(sweep.factor(1.0, 2.0), (TAU * 6.25).sin(), 1e-12);
}

/// Square lattice of six by six disks in a cell that is periodic along both axes.
fn lattice(cell: &Value) -> Value {
    let mut value = Scene::new(linear(1e4, 0.3, 0.5, 0.0)).disk([0.0; 2], 0.5, [0.0; 2], 0.0).json();
    value["domain"] = json!({ "min": [0, 0], "max": [6, 6], "periodic": ["x", "y"] });
    value["bodies"] = json!([{ "name": "one", "material": "grain", "shape": { "kind": "box", "min": [0, 0], "max": [6, 6] } }]);
    value["methods"]["dem"]["bodies"] = json!({});
    value["methods"]["dem"]["grains"]["grain"] = json!({ "density": 1.0, "diameter": { "distribution": "equal", "value": 1 },
        "fill": { "kind": "lattice", "packing": "square" } });
    value["methods"]["dem"]["stages"] = json!({ "all": { "cell": cell } });
    value
}

#[test]
fn cells_follow_cyclic_strains_and_stresses() {
    let strain = |share: f64| {
        let cell = json!({ "yy": { "cyclic-strain": { "amplitude": -0.01, "period": 0.4 } } });
        let mut solver = solver(&lattice(&cell));
        to(&mut solver, 0.4 * share);
        (scalar_output(&solver, "cell.y") / 6.0).ln()
    };
    // The rate changes at half steps: equal up to the strain of a step.
    for (share, exact) in [(0.25, -0.01), (0.5, 0.0), (0.75, 0.01), (1.0, 0.0)] {
        assert_near(strain(share), exact, 2e-4);
    }
    // Along y the lattice is rows of springs: the stress is the stiffness times the strain, in slow deformation.
    let cell = json!({ "xx": { "rate": 0 },
        "yy": { "cyclic-stress": { "mean": -50, "amplitude": 40, "period": 8 } } });
    let mut solver = solver(&lattice(&cell));
    let mut extremes = (0.0f64, f64::NEG_INFINITY);
    to(&mut solver, 8.0);
    while solver.time() < 16.0 {
        let next = solver.time() + 0.1;
        to(&mut solver, next);
        let stress = scalar_output(&solver, "cell_stress.yy");
        extremes = (extremes.0.min(stress), extremes.1.max(stress));
    }
    assert_near(extremes.0, -90.0, 3.0);
    assert_near(extremes.1, -10.0, 3.0);
    let bad = lattice(&json!({ "yy": { "cyclic-strain": { "amplitude": 0.01, "period": 0 } } }));
    assert!(refusal(&Dem, &bad).starts_with("methods.dem.stages.all.cell.yy: a period of 0 s"));
}
