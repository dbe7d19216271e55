//! Runs of rigid bodies that move freely.

use serde_json::{Value, json};

use crate::{Runs, SCHEMES, block, crash, elastic, merged, mpm};

/// A rigid block that spins, above a bed that deforms or beside walls, or alone.
fn tumbling(space: &str, meets: &str) -> Value {
    let d = if space == "3d" { 3 } else { 2 };
    let of = |values: [f64; 3]| values[..d].to_vec();
    let (low, high) = (of([0.1, 0.105, 0.1]), of([0.25, 0.205, 0.2]));
    let spin = [[0.0, -6.0, 3.0], [6.0, 0.0, -5.0], [-3.0, 5.0, 0.0]];
    let gradient: Vec<_> = spin[..d].iter().map(|row| &row[..d]).collect();
    let mut rigid = block("r", &low, &high, &[]);
    rigid["rigid"] = json!(true);
    rigid["velocity"] = json!({ "kind": "linear", "value": of([0.4, -1.0, 0.1]), "origin": of([0.175, 0.155, 0.15]), "gradient": gradient });
    let mut bodies = vec![rigid];
    if meets == "bed" {
        bodies.push(block("b", &of([0.05, 0.0, 0.05]), &of([0.35, 0.1, 0.25]), &of([0.0; 3])));
    }
    let moment = if d == 3 { json!([1, 2, 3]) } else { json!([3]) };
    let motion = json!({ "of": "r", "velocity": vec![json!(null); d], "force": of([5.0, 1.0, 2.0]), "moment": moment, "turns": true });
    merged(
        crash(space),
        &json!({ "materials": { "m": elastic() }, "bodies": bodies,
                 "boundaries": [{ "side": "y-min", "position": if meets == "walls" { 0.1 } else { 0.0 },
                                  "wall": { "kind": "frictional", "friction_coefficient": 0.3 } }],
                 "stages": [{ "name": "s", "duration": 10, "damping": 0.1, "motions": [motion] }] }),
    )
}

/// Adds them.
pub fn add(runs: &mut Runs) {
    for space in ["plane-strain", "3d"] {
        for meets in ["nothing", "bed", "walls"] {
            let case = tumbling(space, meets);
            // Without a bed there is no stress to update.
            let schemes = if meets == "bed" { &SCHEMES[..] } else { &SCHEMES[2..] };
            for scheme in schemes {
                let options = mpm(&json!({ "stress_update": scheme, "time_step": 1e-3 }));
                runs.insert(format!("mpm rigid {space} {meets} {scheme}"), merged(case.clone(), &options));
            }
        }
    }
    for space in ["plane-strain", "3d"] {
        for meets in ["nothing", "bed", "walls"] {
            let mut case = tumbling(space, meets);
            case["methods"] = json!({ "sph": { "spacing": 0.025 } });
            runs.insert(format!("sph rigid {space} {meets}"), case);
        }
    }
    let law = json!([{ "bodies": ["r", "b"], "friction_coefficient": 0.3, "test": "gap" }]);
    let rubs = merged(
        tumbling("plane-strain", "bed"),
        &mpm(&json!({ "contacts": law, "mass_scaling": 2, "time_step": 1e-3 })),
    );
    runs.insert("mpm rigid contact".into(), rubs.clone());
    let slowed = json!({ "stages": [{ "name": "s", "duration": 10, "rayleigh_damping": 5, "motions": rubs["stages"][0]["motions"] }] });
    runs.insert("mpm rigid rayleigh".into(), merged(rubs, &slowed));
}
