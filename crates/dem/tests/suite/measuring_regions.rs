//! Measuring regions, and excavations that remove grains.

use colluvium_case::Solver;
use colluvium_dem::{DemSolver, disks};
use colluvium_testkit::{assert_near, read_case};
use serde_json::{Value, json};

use crate::single_grains::{Scene, begun, linear};

fn reading(solver: &DemSolver<2, 1>, name: &str) -> f64 {
    solver
        .scalar_outputs()
        .into_iter()
        .find(|(own, _, _)| own == name)
        .map_or(f64::NAN, |(_, _, value)| value)
}

fn to(solver: &mut DemSolver<2, 1>, time: f64) {
    while solver.time() < time {
        let dt = solver.limit().dt.min(time - solver.time());
        solver.step(dt).unwrap();
    }
}

/// Square lattice of six by six disks of 1 m.
fn lattice(periodic: &Value) -> Value {
    let mut value = Scene::new(linear(1e4, 0.3, 0.5, 0.0)).disk([0.0; 2], 0.5, [0.0; 2], 0.0).json();
    value["domain"] = json!({ "min": [0, 0], "max": [6, 6], "periodic": periodic });
    value["bodies"] = json!([{ "name": "one", "material": "grain", "shape": { "kind": "box", "min": [0, 0], "max": [6, 6] } }]);
    value["methods"]["dem"]["bodies"] = json!({});
    value["methods"]["dem"]["grains"]["grain"] = json!({ "density": 1.0, "diameter": { "distribution": "equal", "value": 1 },
        "fill": { "kind": "lattice", "packing": "square" } });
    value
}

#[test]
fn a_large_region_has_the_porosity_and_the_stress_of_the_periodic_cell() {
    let mut value = lattice(&json!(["x", "y"]));
    value["methods"]["dem"]["stages"] =
        json!({ "all": { "cell": { "xx": { "rate": -0.02 }, "yy": { "rate": -0.05 } } } });
    // Many times as wide as the cell: it includes images.
    value["methods"]["dem"]["regions"] = json!({ "all": { "centre": [2.3, 3.1], "radius": 60 } });
    let mut solver = begun(disks(&read_case(&value)).unwrap());
    to(&mut solver, 0.2);
    let whole = reading(&solver, "solid_fraction");
    assert_near((1.0 - reading(&solver, "all.porosity")) / whole, 1.0, 1e-3);
    for axes in ["xx", "yy"] {
        let (own, all) = (
            reading(&solver, &format!("all.stress.{axes}")),
            reading(&solver, &format!("cell_stress.{axes}")),
        );
        assert!(
            all < -10.0 && (own / all - 1.0).abs() < 5e-3,
            "{axes}: {own} in the region, {all} in the cell"
        );
    }
    assert_near(reading(&solver, "all.coordination"), 4.0, 1e-12);
}

#[test]
fn a_region_without_grains_has_no_mean() {
    let mut value = lattice(&json!([]));
    value["methods"]["dem"]["regions"] = json!({ "gap": { "centre": [1, 1], "radius": 0.1 } });
    let solver = begun(disks(&read_case(&value)).unwrap());
    assert_near(reading(&solver, "gap.porosity"), 1.0, 1e-12);
    assert_near(reading(&solver, "gap.grains"), 0.0, 1e-12);
    assert!(reading(&solver, "gap.coordination").is_nan());
    value["methods"]["dem"]["regions"]["gap"]["radius"] = json!(0);
    let error = disks(&read_case(&value)).err().unwrap().to_string();
    assert!(error.starts_with("methods.dem.regions.gap.radius: 0"), "{error}");
    value["methods"]["dem"]["regions"]["gap"] = json!({ "centre": [7, 1], "radius": 0.5 });
    let error = disks(&read_case(&value)).err().unwrap().to_string();
    assert!(
        error.starts_with(
            "methods.dem.regions.gap: lies outside the domain: it reaches from 6.5 to 7.5 m along x, the domain from 0 to 6 m"
        ),
        "{error}"
    );
}

#[test]
fn grains_vanish_from_a_pit_once_its_stage_begins() {
    let mut value = lattice(&json!([]));
    value["stages"] = json!([
        { "name": "rest", "duration": 0.01 },
        { "name": "pit", "duration": 0.01, "excavate": [{ "kind": "box", "min": [2, 3], "max": [4, 6] }] }
    ]);
    let mut solver = begun(disks(&read_case(&value)).unwrap());
    assert_eq!(solver.point_count(), 36);
    to(&mut solver, 0.01);
    let before = solver.totals().mass;
    solver.begin_stage(1, 0.01).unwrap();
    to(&mut solver, 0.011);
    assert_eq!(solver.point_count(), 30);
    assert_near(solver.totals().mass / before, 30.0 / 36.0, 1e-12);
    let snapshot = solver.snapshot();
    assert!(snapshot.positions.iter().all(|x| !(2.0..4.0).contains(&x[0]) || x[1] < 3.0));
}
