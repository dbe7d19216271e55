//! Pluviation: grains that enter during a run (sheet: dem §3.8).

use colluvium_case::{Method, Solver};
use colluvium_dem::{Dem, disks, spheres};
use colluvium_testkit::{read_case, scalar_output};
use serde_json::{Value, json};

use crate::single_grains::{Scene, begun, linear};

/// Grains of 0.08 to 0.12 m that enter at the top of a box 2 m wide at 1 m/s, at a mass rate `rate` (kg/s).
fn rained(dimension: usize, rate: f64) -> Value {
    let none = vec![0.0; dimension];
    let mut scene = Scene::new(linear(2e7, 0.3, 0.5, 0.5));
    scene.grains.push((none.clone(), 1.0, none.clone(), vec![0.0; if dimension == 2 { 1 } else { 3 }]));
    let mut value = scene.json();
    let up = dimension - 1;
    let along = |axis: usize, height: f64| {
        let mut x = vec![axis as f64; dimension];
        x[up] = height;
        x
    };
    let mut down = none.clone();
    down[up] = -1.0;
    value["domain"] = json!({ "min": none, "max": along(2, 4.0) });
    value["gravity"] = json!(down.iter().map(|c| 9.81 * c).collect::<Vec<f64>>());
    value["bodies"] = json!([{ "name": "rain", "material": "grain",
        "shape": { "kind": "box", "min": along(0, 3.0), "max": along(2, 3.9) },
        "velocity": { "kind": "uniform", "value": down } }]);
    let sides = ["x-min", "x-max", "y-min", "y-max", "z-min", "z-max"];
    value["boundaries"] = json!(
        sides[..2 * dimension]
            .iter()
            .map(|side| json!({ "side": side,
        "wall": { "kind": "frictional", "friction_coefficient": 0.5 } }))
            .collect::<Vec<Value>>()
    );
    value["methods"]["dem"]["bodies"] =
        json!({ "rain": { "rain": { "rate": rate, "start": 0.1, "end": 1.1 } } });
    value["methods"]["dem"]["grains"] = json!({ "grain": { "density": 2000,
        "diameter": { "distribution": "uniform", "min": 0.08, "max": 0.12 } } });
    value
}

fn to(solver: &mut dyn Solver, time: f64) {
    while solver.time() < time - 1e-9 {
        solver.step(time - solver.time()).unwrap();
    }
}

#[test]
fn pluviation_adds_the_prescribed_mass_in_its_interval_and_the_energy_balance_closes() {
    for (dimension, rate) in [(2, 1500.0), (3, 300.0)] {
        let case = read_case(&rained(dimension, rate));
        let mut solver: Box<dyn Solver> = Dem.build(&case).unwrap();
        solver.begin_stage(0, 0.0).unwrap();
        assert_eq!(solver.point_count(), 0);
        to(&mut *solver, 0.1);
        assert_eq!(solver.point_count(), 0);
        to(&mut *solver, 0.6);
        let half = solver.totals().mass;
        // Behind by less than the mass of the largest grain.
        let grain = 2000.0 * if dimension == 2 { 0.0036 * std::f64::consts::PI } else { 9.1e-4 };
        assert!(half <= 0.5 * rate && half > 0.5 * rate - 1.01 * grain, "{half}");
        to(&mut *solver, 3.0);
        let all = solver.totals().mass;
        assert!(all <= rate && all > rate - 1.01 * grain, "{all}");
        // All entered at 1 m/s.
        assert!((scalar_output(&*solver, "energy.entered") / (0.5 * all) - 1.0).abs() < 1e-9);
        assert!(scalar_output(&*solver, "energy_error").abs() < 0.01);
        let ids = solver.snapshot().ids;
        assert!(ids.iter().enumerate().all(|(k, id)| *id == k as u64));
        assert!(solver.warning().is_none_or(|text| !text.text.contains("cannot enter")));
    }
}

#[test]
fn a_restart_during_pluviation_is_bit_identical() {
    let case = read_case(&rained(2, 1500.0));
    let mut whole = begun(disks(&case).unwrap());
    to(&mut whole, 0.7);
    let saved = whole.checkpoint_bytes().unwrap();
    let walk = |solver: &mut dyn Solver| {
        for _ in 0..500 {
            let dt = solver.limit().dt;
            solver.step(dt).unwrap();
        }
    };
    walk(&mut whole);
    let mut again = Dem.build(&case).unwrap();
    again.restore(&mut saved.as_slice()).unwrap();
    again.begin_stage(0, 0.0).unwrap();
    walk(&mut *again);
    assert_eq!(whole.checkpoint_bytes().unwrap(), again.checkpoint_bytes().unwrap());
}

#[test]
fn a_full_pluviation_region_delays_grains_with_a_warning() {
    let mut value = rained(2, 20000.0);
    value["bodies"][0]["velocity"] = json!({ "kind": "uniform", "value": [0, 0] });
    let mut solver = begun(disks(&read_case(&value)).unwrap());
    to(&mut solver, 0.3);
    let warning = solver.warning().unwrap();
    assert!(warning.text.contains("of body \"rain\" cannot enter"), "{warning}");
}

#[test]
fn invalid_pluviation_is_refused_by_path() {
    let refused = |change: &dyn Fn(&mut Value)| {
        let mut value = rained(2, 1500.0);
        change(&mut value);
        disks(&read_case(&value)).map(|_| ()).unwrap_err().to_string()
    };
    let rate = refused(&|value| value["methods"]["dem"]["bodies"]["rain"]["rain"]["rate"] = json!(-1));
    assert!(rate.starts_with("methods.dem.bodies.rain.rain.rate: -1 must be finite and positive"), "{rate}");
    let end = refused(&|value| value["methods"]["dem"]["bodies"]["rain"]["rain"]["end"] = json!(0.05));
    assert!(end.starts_with("methods.dem.bodies.rain.rain.end: must come after the start"), "{end}");
    let sizes = refused(&|value| value["methods"]["dem"]["grains"]["grain"] = json!({ "density": 2000 }));
    assert!(sizes.starts_with("methods.dem.grains.grain.diameter: is missing"), "{sizes}");
    assert!(spheres(&read_case(&rained(3, 300.0))).is_ok());
}
