//! Liquids that hang together where real ones open.

use colluvium_case::{Case, Method, RunOptions, run_method};
use colluvium_mpm::Mpm;
use serde_json::json;

/// A liquid 1 m high whose upper part begins under a tension (Pa), with the strength against that.
fn hanging(tension: f64, strength: f64, gravity: f64) -> Case {
    let water = json!({ "model": "newtonian-fluid", "density": 1000, "bulk_modulus": 1e6, "viscosity": 0.1,
                        "cavitation_strength": strength });
    let stress = json!({ "kind": "uniform", "value": [tension, tension, tension, 0, 0, 0] });
    let text = json!({
        "title": "hanging", "space": "plane-strain", "domain": { "min": [0, 0], "max": [1, 2] }, "gravity": [0, -gravity],
        "materials": { "water": water },
        "bodies": [
            { "name": "calm", "material": "water", "shape": { "kind": "box", "min": [0.2, 0], "max": [0.8, 0.5] } },
            { "name": "torn", "material": "water", "shape": { "kind": "box", "min": [0.2, 0.5], "max": [0.8, 1] },
              "stress": stress }
        ],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }],
        "stages": [{ "name": "s", "duration": 0.002 }],
        "output": { "measures": 0.0005 },
        "methods": { "mpm": { "cell_size": 0.1 } }
    });
    Case::from_json(&text.to_string()).unwrap()
}

fn remarks(case: &Case) -> Vec<String> {
    Mpm.plan(case).unwrap();
    run_method(&Mpm, case, &RunOptions { method: "mpm".into(), ..RunOptions::default() }).unwrap().remarks
}

#[test]
fn a_liquid_in_more_tension_than_its_weight_makes_is_remarked_once() {
    // ρ g h is 5 kPa.
    let found = remarks(&hanging(2e4, 1e5, 10.0));
    let [remark] = found.as_slice() else { panic!("{found:?}") };
    for part in [
        "t = 0 s: 100 % of the liquid \"torn\"",
        "5.000e3 Pa",
        "point ",
        "2.000e4 Pa",
        "materials.water.cavitation_strength",
    ] {
        assert!(remark.contains(part), "{remark}");
    }
    assert!(remarks(&hanging(2e3, 1e5, 10.0)).is_empty(), "less than its weight");
    assert!(remarks(&hanging(0.0, 0.0, 10.0)).is_empty(), "it opens");
    assert!(remarks(&hanging(2e4, 1e5, 0.0)).is_empty(), "nothing to compare with");
}
