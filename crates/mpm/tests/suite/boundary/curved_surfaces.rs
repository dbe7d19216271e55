//! Loads on curved surfaces against closed forms.

use std::f64::consts::PI;

use colluvium_case::{Case, Method};
use colluvium_mpm::Mpm;
use colluvium_testkit::{read_case, solve, vectors};
use serde_json::{Value, json};

const MODULUS: f64 = 1e6;
const POISSON: f64 = 0.25;

/// One elastic body of 1000 kg/m³ alone.
fn loaded_body(space: &str, shape: &Value, load: &Value, stage: &Value) -> Case {
    let side = if space == "3d" { json!([1, 1, 1]) } else { json!([1.2, 1.2]) };
    let opposite: Vec<f64> = side.as_array().unwrap().iter().map(|x| -x.as_f64().unwrap()).collect();
    let mut load = load.clone();
    (load["kind"], load["body"]) = (json!("surface"), json!("b"));
    read_case(&json!({
        "title": "test", "space": space, "domain": { "min": opposite, "max": side }, "gravity": vec![0; opposite.len()],
        "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": MODULUS, "poissons_ratio": POISSON } },
        "bodies": [{ "name": "b", "material": "m", "shape": shape }], "loads": [load], "stages": [stage],
        "methods": { "mpm": { "cell_size": 0.1 } }
    }))
}

/// Lamé's ring under a pressure from within: `u = (1 + ν) p a² ((1 - 2ν) r + b²/r) / (E (b² - a²))` in plane strain.
#[test]
fn a_ring_under_internal_pressure_expands_by_lames_solution() {
    let ball = |radius: f64| json!({ "kind": "ball", "centre": [0, 0], "radius": radius });
    let (inner, outer, pressure): (f64, f64, f64) = (0.5, 1.0, 1e3);
    let ring = json!({ "kind": "difference", "from": ball(outer), "cut": ball(inner) });
    let load = json!({ "pressure": pressure, "within": ball(0.75), "ramp": 0.3, "ramp_shape": "cosine" });
    let stage = json!({ "name": "s", "duration": 0.6, "damping": 0.3 });
    let mut text: Value =
        serde_json::from_str(&loaded_body("plane-strain", &ring, &load, &stage).to_json()).unwrap();
    text["methods"]["mpm"] = json!({ "cell_size": 0.05, "shape": "ugimp" });
    let snapshot = solve(&Mpm, &read_case(&text)).snapshot;
    let scale = (1.0 + POISSON) * pressure * inner.powi(2) / (MODULUS * (outer.powi(2) - inner.powi(2)));
    for (from, to) in [(0.55, 0.65), (0.7, 0.8), (0.85, 0.95)] {
        let (mut found, mut exact) = (0.0, 0.0);
        for (x, u) in snapshot.positions.iter().zip(vectors(&snapshot, "displacement")) {
            let start = [x[0] - u[0], x[1] - u[1]];
            let radius = start[0].hypot(start[1]);
            if (from..to).contains(&radius) {
                found += (u[0] * start[0] + u[1] * start[1]) / radius;
                exact += scale * ((1.0 - 2.0 * POISSON) * radius + outer.powi(2) / radius);
            }
        }
        assert!((found / exact - 1.0).abs() < 0.05, "from {from} to {to} m: {}", found / exact);
    }
}

/// A shear about the axis of a cylinder acts on its curved face alone, with the moment 2 π R² L τ.
#[test]
fn a_shear_about_the_axis_twists_a_cylinder() {
    let (radius, height, shear) = (0.5, 1.0, 100.0);
    let shape =
        json!({ "kind": "cylinder", "base": [0, -0.5, 0], "axis": 1, "radius": radius, "height": height });
    let load = json!({ "shear": shear, "axis": [0, 3, 0] });
    let report = solve(&Mpm, &loaded_body("3d", &shape, &load, &json!({ "name": "s", "duration": 0.02 })));
    let exact = 2.0 * PI * radius * radius * height * shear * 0.02;
    // Points carry it up to half their width within the face.
    let ratio = report.end.angular_momentum[1] / exact;
    assert!((0.9..1.0).contains(&ratio), "{ratio}");
    assert!(report.end.momentum.iter().all(|p| p.abs() < 1e-7), "{:?}", report.end.momentum);
}

#[test]
fn a_part_of_a_surface_on_which_nothing_lies_is_refused() {
    let within = json!({ "kind": "ball", "centre": [0, 0], "radius": 0.2 });
    let shape = json!({ "kind": "ball", "centre": [0, 0], "radius": 0.5 });
    let load = json!({ "pressure": 1, "within": within });
    let case = loaded_body("plane-strain", &shape, &load, &json!({ "name": "s", "duration": 1 }));
    let error = Mpm.build(&case).err().unwrap();
    assert!(error.to_string().contains("loads[0].within"), "{error}");
}
