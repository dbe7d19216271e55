//! Gauges and discharge lines of depth-integrated SPH.

use colluvium_case::{Case, Method, RunOptions, run};
use colluvium_depth_sph::DepthSph;
use colluvium_testkit::read_case;
use serde_json::{Value, json};

/// Block of water, 12 m by 8 m and 0.5 m deep, that moves along x over a smooth level bed.
fn block() -> Value {
    json!({
        "title": "block", "space": "3d", "gravity": [0, 0, -9.81],
        "domain": { "min": [0, -40, 0], "max": [100, 60, 5] },
        "materials": { "water": {
            "model": "mohr-coulomb", "density": 1000, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 30
        } },
        "bodies": [{ "name": "block", "material": "water", "velocity": { "kind": "uniform", "value": [12, 0, 0] },
            "shape": { "kind": "box", "min": [2, 6, 0], "max": [14, 14, 0.5] } }],
        "boundaries": [{ "side": "z-min", "wall": { "kind": "smooth" } }],
        "stages": [{ "name": "flow", "duration": 4 }],
        "output": { "measures": 0.02 },
        "measures": {
            "middle": { "kind": "gauge", "position": [8, 10] },
            "through": { "kind": "discharge", "from": [8, 0.5], "to": [8, 19.5] },
            "back": { "kind": "discharge", "from": [20, 60], "to": [20, -40] },
            "forth": { "kind": "discharge", "from": [20, -40], "to": [20, 60] }
        },
        "methods": { "depth-sph": { "spacing": 0.5 } }
    })
}

#[test]
fn gauges_give_depth_and_velocity_and_lines_give_discharge() {
    let case = read_case(&block());
    let table = run(&case, DepthSph.build(&case).unwrap(), &RunOptions::default()).unwrap().table;
    let first = |name: &str| table.column(name).unwrap()[0];
    // V31: sums over a lattice are right within 1.1 %.
    assert!((first("middle.depth") / 0.5 - 1.0).abs() < 0.011, "{}", first("middle.depth"));
    assert!((first("middle.velocity.x") - 12.0).abs() < 1e-12 && first("middle.velocity.y").abs() < 1e-12);
    assert!((first("through") / (0.5 * 12.0 * 8.0) - 1.0).abs() < 0.011, "{}", first("through"));
    let (forth, back) = (table.column("forth").unwrap(), table.column("back").unwrap());
    assert!(forth.iter().zip(&back).all(|(a, b)| (a + b).abs() < 1e-9 * a.abs().max(1.0)));
    // The tail goes back at no more than twice the celerity, 4.4 m/s: all of it has passed.
    let times = table.column("time").unwrap();
    let passed: f64 =
        times.windows(2).zip(forth.windows(2)).map(|(t, q)| (t[1] - t[0]) * 0.5 * (q[0] + q[1])).sum();
    assert!(forth.last().unwrap().abs() < 1e-9, "{:?}", forth.last());
    assert!((passed / 48.0 - 1.0).abs() < 0.01, "{passed} m³ of 48 m³");
}

#[test]
fn invalid_gauges_and_lines_are_refused_by_path() {
    let refused = |measure: Value| {
        let mut value = block();
        value["measures"] = json!({ "m": measure });
        Case::from_json(&value.to_string()).unwrap_err().to_string()
    };
    let starts = |text: String, start: &str| assert!(text.starts_with(start), "{text}");
    starts(
        refused(json!({ "kind": "gauge", "position": [1, 2, 3] })),
        "measures.m.position: has 3 coordinates",
    );
    starts(refused(json!({ "kind": "gauge", "position": [1, 99] })), "measures.m.position[1]: 99 is outside");
    starts(
        refused(json!({ "kind": "discharge", "from": [1, 2], "to": [1, 2] })),
        "measures.m.to: must differ from",
    );
}
