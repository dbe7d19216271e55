//! Grains at rest (sheet: dem §5, B5, B9) and bonds (B15).

use colluvium_case::{DatasetGeometry, FieldData, FrameRequest, Solver};
use colluvium_dem::disks;
use colluvium_testkit::{assert_near, read_case};
use serde_json::json;

use crate::single_grains::{Scene, begun, floor, linear};

#[test]
fn a_static_column_has_the_overlaps_of_its_weight() {
    let (count, stiffness) = (10, 1e6);
    let mut scene = Scene::new(linear(stiffness, 0.4, 0.5, 0.0));
    for k in 0..count {
        scene = scene.disk([0.0, 0.5 + f64::from(k)], 0.5, [0.0, 0.0], 0.0);
    }
    scene.gravity = vec![0.0, -9.81];
    scene.boundaries = floor(&json!({ "kind": "smooth" }));
    let mut value = scene.json();
    value["stages"] = json!([{ "name": "all", "duration": 100, "damping": 0.5 }]);
    let case = read_case(&value);
    let mut solver = begun(disks(&case).unwrap());
    let dt = solver.limit().dt;
    for _ in 0..40_000 {
        solver.step(dt).unwrap();
    }
    let top = solver.snapshot().positions[count as usize - 1][1];
    assert_near((9.5 - top) / 5.3955e-4, 1.0, 1e-6);
    assert_near(solver.reaction("floor").unwrap().force[1] / (-9.81 * f64::from(count)), 1.0, 1e-6);
}

/// Whether two disks on the floor support a third one after gravity has increased.
fn stands(grain: f64, wall: f64) -> bool {
    let mut scene = Scene::new(linear(1e6, 0.3, 0.5, grain))
        .disk([-0.5, 0.5], 0.5, [0.0, 0.0], 0.0)
        .disk([0.5, 0.5], 0.5, [0.0, 0.0], 0.0)
        .disk([0.0, 0.5 + 0.75f64.sqrt()], 0.5, [0.0, 0.0], 0.0);
    scene.gravity = vec![0.0, -9.81];
    scene.boundaries = floor(&json!({ "kind": "frictional", "friction_coefficient": wall }));
    let mut value = scene.json();
    value["stages"] = json!([{ "name": "all", "duration": 10, "gravity_ramp": 3.0 }]);
    let case = read_case(&value);
    let mut solver = begun(disks(&case).unwrap());
    let dt = solver.limit().dt;
    while solver.time() < 9.0 {
        solver.step(dt).unwrap();
    }
    solver.snapshot().positions[2][1] > 1.3
}

#[test]
fn a_pile_of_three_disks_is_stable_above_the_critical_friction() {
    let (grain, wall) = (2.0 - 3f64.sqrt(), (2.0 - 3f64.sqrt()) / 3.0);
    assert!(stands(1.03 * grain, 1.03 * wall));
    assert!(!stands(0.97 * grain, 2.0 * wall));
    assert!(!stands(2.0 * grain, 0.97 * wall));
}

#[test]
fn a_bonded_cantilever_bends_as_a_beam() {
    let (n, d, rotation, shear) = (10u32, 1.0, 1e3, 1e4);
    // Radius 0.5: area 1, second moment 2/3 · 0.125.
    let bond = json!({
        "normal_stiffness": rotation / (2.0 / 3.0 * 0.125), "shear_stiffness": shear, "gap": 0.01
    });
    let mut pair = linear(1e-3, 0.0, 0.5, 0.0);
    pair["bond"] = bond;
    let mut scene = Scene::new(pair);
    for k in 0..=n {
        scene = scene.disk([f64::from(k) * d, 0.0], 0.5, [0.0, 0.0], 0.0);
    }
    // The load is the weight of the last grain alone: the others have negligible weight.
    let mut value = scene.json();
    let load = 1e-3;
    value["gravity"] = json!([0, -load]);
    value["materials"]["tip"] = value["materials"]["grain"].clone();
    value["bodies"][n as usize]["material"] = json!("tip");
    let dem = &mut value["methods"]["dem"];
    dem["grains"]["grain"]["density"] = json!(1e-2 * 4.0 / std::f64::consts::PI);
    dem["grains"]["tip"] = json!({ "density": 4.0 / std::f64::consts::PI, "fill": { "kind": "single" } });
    let mut with_tip = dem["pairs"][0].clone();
    with_tip["between"] = json!(["grain", "tip"]);
    let mut own = with_tip.clone();
    own["between"] = json!(["tip", "tip"]);
    own.as_object_mut().unwrap().remove("bond");
    dem["pairs"].as_array_mut().unwrap().extend([with_tip, own]);
    dem["bodies"]["grain 0"]["held"] = json!(true);
    value["stages"] = json!([{ "name": "all", "duration": 1e4, "damping": 0.7 }]);
    let case = read_case(&value);
    let mut solver = begun(disks(&case).unwrap());
    let dt = solver.limit().dt;
    for _ in 0..400_000 {
        solver.step(dt).unwrap();
    }
    let tip = solver.snapshot().vectors("displacement").unwrap()[n as usize][1];
    // Weight of the chain: a hundredth of the load at each grain.
    let own: f64 = (1..n).map(|k| beam(k, n, rotation, shear)).sum::<f64>() * load * 1e-2;
    let expected = load * beam(n, n, rotation, shear) + own;
    assert_near(load * beam(n, n, rotation, shear), 3.335e-4, 1e-8);
    assert_near(tip / -expected, 1.0, 2e-3);
}

/// Deflection of the last of `n` unit links under a unit load on link `at`.
fn beam(at: u32, n: u32, rotation: f64, shear: f64) -> f64 {
    // Each joint lies half a diameter behind its grain.
    let joint = |k: u32| f64::from(k) - 0.5;
    (1..=at).map(|k| (f64::from(at) - joint(k)) * (f64::from(n) - joint(k)) / rotation + 1.0 / shear).sum()
}

#[test]
fn a_bond_breaks_at_its_strength() {
    let mut pair = linear(1e-6, 0.0, 0.5, 0.0);
    pair["bond"] = json!({ "normal_stiffness": 1e6, "shear_stiffness": 1e6, "tensile_strength": 100.0 });
    let scene =
        Scene::new(pair).disk([-0.5, 0.0], 0.5, [0.0; 2], 0.0).disk([0.5, 0.0], 0.5, [1e-3, 0.0], 0.0);
    let mut value = scene.json();
    for name in ["grain 0", "grain 1"] {
        value["methods"]["dem"]["bodies"][name] = json!({});
    }
    value["methods"]["dem"]["bodies"]["grain 0"]["held"] = json!(true);
    let case = read_case(&value);
    let mut solver = begun(disks(&case).unwrap());
    let mut largest = 0.0f64;
    let dt = 1e-5;
    // Speed 1e-3 m/s, mass 1 kg, stiffness 1e6 N/m: the oscillation reaches 1 N, less than 100 N.
    for _ in 0..2000 {
        solver.step(dt).unwrap();
        largest = solver.contacts().iter().map(|c| -c.normal).fold(largest, f64::max);
    }
    assert_near(largest, 1.0, 2e-3);
    assert_eq!(solver.scalar_outputs().iter().find(|(name, ..)| name == "broken_bonds").unwrap().2, 0.0);
    assert!(
        solver.frame(FrameRequest::Requested).datasets.iter().all(|dataset| dataset.name != "broken-bonds")
    );
    value["bodies"][1]["velocity"]["value"] = json!([0.15, 0.0]);
    value["output"]["contacts"] = json!(true);
    let case = read_case(&value);
    let mut solver = begun(disks(&case).unwrap());
    let mut largest = 0.0f64;
    for _ in 0..2000 {
        solver.step(1e-6).unwrap();
        largest = solver.contacts().iter().map(|c| -c.normal).fold(largest, f64::max);
    }
    assert!(largest > 99.5 && largest <= 100.0, "{largest}");
    let readings = solver.scalar_outputs();
    assert_eq!(readings.iter().find(|(name, ..)| name == "broken_bonds").unwrap().2, 1.0);
    assert_near(readings.iter().find(|(name, ..)| name == "energy_error").unwrap().2, 0.0, 1e-2);
    // The bond is listed as broken, and is so after a restart too.
    let mut again = begun(disks(&case).unwrap());
    again.restore(&mut solver.checkpoint_bytes().unwrap().as_slice()).unwrap();
    for solver in [&solver, &again] {
        let frame = solver.frame(FrameRequest::Requested);
        let broken = frame.datasets.iter().find(|dataset| dataset.name == "broken-bonds").unwrap();
        let DatasetGeometry::Points(points) = &broken.geometry else { panic!("{broken:?}") };
        let [time, first, second] = &broken.fields[..] else { panic!("{broken:?}") };
        let FieldData::Scalar(times) = &time.data else { panic!("{time:?}") };
        assert!(times[0] > 0.0 && times[0] <= solver.time(), "{times:?}");
        assert_eq!((&first.data, &second.data), (&FieldData::Integer(vec![0]), &FieldData::Integer(vec![1])));
        assert!(points.positions[0][0] > 0.0 && points.positions[0][0] < 1e-3, "{points:?}");
    }
}
