use serde_json::{Value, json};

use super::*;

/// Points on a line, of the mass 1 kg each.
pub(crate) fn line(positions: &[f64]) -> Snapshot {
    let count = positions.len();
    Snapshot {
        time: 0.0,
        step: 0,
        ids: (0..count as u64).collect(),
        bodies: vec![0; count],
        positions: positions.iter().map(|&x| [x, 0.5 * x, 0.0]).collect(),
        extents: vec![[0.1; 3]; count],
        fields: vec![Field { name: "mass".into(), unit: "kg", data: FieldData::Scalar(vec![1.0; count]) }],
    }
}

#[test]
fn a_profile_is_the_highest_point_of_each_bin() {
    let heights = profile(&line(&[0.05, 0.15, 0.25]), 0, 1, 0.2);
    let expected = [(0.1, 0.125), (0.3, 0.175)];
    assert_eq!(heights.len(), 2);
    for (found, exact) in heights.iter().zip(expected) {
        assert!((found.0 - exact.0).abs() < 1e-12 && (found.1 - exact.1).abs() < 1e-12);
    }
}

#[test]
fn rigid_bodies_count_only_where_they_are_named() {
    let body = |name: &str, at: f64, rigid: bool| {
        let shape = json!({ "kind": "box", "min": [at, 0], "max": [at + 1.0, 1] });
        json!({ "name": name, "material": "m", "rigid": rigid, "shape": shape })
    };
    let measure = |bodies: Value| {
        let mut measure = json!({ "kind": "front", "side": "x-max", "quantile": 0.5 });
        if !bodies.is_null() {
            measure["bodies"] = bodies;
        }
        measure
    };
    let elastic =
        json!({ "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 });
    let case = json!({
        "title": "plough", "space": "plane-strain", "gravity": [0, -10],
        "domain": { "min": [0, 0], "max": [9, 9] }, "materials": { "m": elastic },
        "bodies": [body("soil", 0.0, false), body("stone", 2.0, false), body("plough", 4.0, true)],
        "stages": [{ "name": "go", "duration": 1 }],
        "measures": {
            "loose": measure(Value::Null),
            "plough": measure(json!(["plough"])),
            "soil": measure(json!(["soil"])),
            "run": { "kind": "run-out", "side": "x-max", "origin": 0, "initial_length": 2, "cell": 9 }
        }
    });
    let case = Case::from_json(&case.to_string()).unwrap();
    let snapshot = Snapshot { bodies: vec![0, 1, 2], ..line(&[0.55, 2.95, 4.95]) };
    let readings = read(&MeasuredState::of_points(&case, &snapshot));
    for (name, exact) in [("loose", 0.6), ("plough", 5.0), ("soil", 0.6), ("run", 0.5)] {
        let found = readings.iter().find(|(n, ..)| n == name).unwrap().2;
        assert!((found - exact).abs() < 1e-12, "{name}: {found} is not {exact}");
    }
    let heights = profile(&counted_points(&case, &snapshot, None), 0, 1, 9.0);
    assert!((heights[0].1 - 1.525).abs() < 1e-12, "the plough is higher: {heights:?}");
}
