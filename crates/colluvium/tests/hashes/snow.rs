//! Runs of finite-strain MPM.

use serde_json::{Value, json};

use crate::{Runs, merged};

/// A block of snow that is thrown askew on an inclined plane.
fn thrown(space: &str) -> Value {
    let d = match space {
        "1d" => 1,
        "3d" => 3,
        _ => 2,
    };
    let of = |values: [f64; 3]| values[..d].to_vec();
    let plane = json!({ "name": "slope", "wall": { "kind": "frictional", "friction_coefficient": 0.3 },
                        "shape": { "kind": "plane", "point": of([0.2, 0.1, 0.0]), "normal": of([0.3, 1.0, 0.1]) } });
    let floor = json!({ "side": "x-min", "position": 0.1, "wall": { "kind": "rough" } });
    json!({
        "title": "thrown", "space": space,
        "domain": { "min": of([0.0; 3]), "max": of([0.8, 0.6, 0.5]) },
        "gravity": if d == 1 { vec![-9.81] } else { of([0.0, -9.81, 0.0]) },
        "materials": { "m": slab() },
        "bodies": [{ "name": "b", "material": "m", "velocity": { "kind": "uniform", "value": if d == 1 { vec![-3.0] } else { of([1.0, -3.0, 0.4]) } },
                     "shape": { "kind": "box", "min": of([0.2, 0.1, 0.15]), "max": of([0.5, 0.3, 0.3]) } }],
        "boundaries": if d == 1 { json!([floor]) } else { json!([]) },
        "obstacles": if d == 1 { json!([]) } else { json!([plane]) },
        "stages": [{ "name": "s", "duration": 10 }],
        "methods": { "snow-mpm": { "cell_size": 0.05 } }
    })
}

fn slab() -> Value {
    json!({ "model": "cohesive-cam-clay", "density": 250, "youngs_modulus": 1e6, "poissons_ratio": 0.3, "critical_state_slope": 1.2,
            "cohesion_ratio": 0.3, "hardening_factor": 1, "compressive_strength": 8000 })
}

/// Laws by name.
fn laws() -> Vec<(&'static str, Value)> {
    let slab = |more: Value| merged(slab(), &more);
    let weak = |more: Value| {
        let own = json!({ "density": 100, "compressive_strength": 3000, "hardening_factor": 0.02,
                          "hardening": { "kind": "weak-layer", "softening_factor": 50 } });
        merged(slab(own), &more)
    };
    let elastic =
        |model: &str| json!({ "model": model, "density": 400, "youngs_modulus": 1e6, "poissons_ratio": 0.3 });
    let damage = merged(elastic("snow"), &json!({ "youngs_modulus": 1.4e5, "least_plastic_volume": 0.1 }));
    let cone = json!({ "strain_measure": "hencky", "friction_angle": 25, "cohesion": 2000,
        "softening": { "residual_friction_angle": 0, "friction_rate": 0, "residual_cohesion": 0, "cohesion_rate": 50 } });
    let sand = merged(elastic("sand"), &json!({ "friction_angle": 35 }));
    let sand = |more: Value| merged(sand.clone(), &more);
    vec![
        ("slab explicit", slab(json!({ "integration": "explicit" }))),
        ("slab in the plane", slab(json!({ "invariants": "plane" }))),
        ("slab without cohesion", slab(json!({ "cohesion_ratio": 0 }))),
        ("weak layer implicit", weak(json!({}))),
        ("weak layer explicit", weak(json!({ "integration": "explicit" }))),
        ("damage", damage.clone()),
        ("damage of logarithmic strain", merged(damage, &json!({ "elastic_law": "hencky" }))),
        ("cone that softens", merged(elastic("drucker-prager"), &cone)),
        ("sand", sand(json!({ "volume_correction": false }))),
        ("sand that hardens", sand(json!({ "hardening": {} }))),
        ("sand in the plane", sand(json!({ "invariants": "plane" }))),
        ("Hencky", merged(elastic("linear-elastic"), &json!({ "strain_measure": "hencky" }))),
        ("Saint Venant and Kirchhoff", elastic("st-venant-kirchhoff")),
        ("fixed corotated", elastic("fixed-corotated")),
    ]
}

fn put(runs: &mut Runs, space: &str, name: &str, more: &Value) {
    runs.insert(format!("snow-mpm {space} {name}"), merged(thrown(space), more));
}

fn options(options: &Value) -> Value {
    json!({ "methods": { "snow-mpm": options } })
}

/// Adds them.
pub fn add(runs: &mut Runs) {
    for space in ["1d", "plane-strain", "3d"] {
        transfers(runs, space);
    }
    for (name, law) in laws() {
        put(runs, "plane-strain", name, &json!({ "materials": { "m": law } }));
        let in_space = ["weak layer explicit", "damage", "cone that softens", "sand"].contains(&name);
        if in_space {
            put(runs, "3d", name, &json!({ "materials": { "m": law } }));
        }
    }
    for space in ["plane-strain", "3d"] {
        obstacles(runs, space);
        cuts(runs, space);
    }
    walls(runs);
    put(
        runs,
        "plane-strain",
        "damping",
        &json!({ "stages": [{ "name": "s", "duration": 10, "damping": 0.3, "gravity_ramp": 0.1 }] }),
    );
    let leaves = json!({ "bodies": [{ "name": "b", "material": "m", "drop_outside": true, "velocity": { "kind": "uniform", "value": [6, 0] },
        "shape": { "kind": "box", "min": [0.6, 0.3], "max": [0.8, 0.5] } }] });
    put(runs, "plane-strain", "leaving", &leaves);
}

/// Functions and what passes velocities between points and nodes.
fn transfers(runs: &mut Runs, space: &str) {
    for shape in ["linear", "quadratic", "cubic"] {
        for transfer in ["apic", "flip"] {
            // Linear functions have no second moment for it.
            if (shape, transfer) != ("linear", "apic") {
                let own = json!({ "shape": shape, "transfer": transfer });
                put(runs, space, &format!("{shape} {transfer}"), &options(&own));
            }
        }
    }
    put(runs, space, "exponential", &options(&json!({ "deformation": "exponential" })));
    put(runs, space, "blend in time", &options(&json!({ "transfer": "flip", "blend_time": 0.01 })));
}

/// What obstacles do on nodes.
fn obstacles(runs: &mut Runs, space: &str) {
    let slope = thrown(space)["obstacles"][0].clone();
    let mut run = |name: &str, key: &str, value: Value| {
        let mut obstacle = slope.clone();
        obstacle[key] = value;
        put(runs, space, &format!("obstacle {name}"), &json!({ "obstacles": [obstacle] }));
    };
    for kind in ["rough", "smooth"] {
        run(kind, "wall", json!({ "kind": kind }));
    }
    let turns = if space == "3d" {
        json!({ "velocity": [0.5, 1, 0], "rotation": 90, "centre": [0.2, 0.1, 0], "axis": [0, 0.2, 1] })
    } else {
        json!({ "velocity": [0.5, 1], "rotation": 90, "centre": [0.2, 0.1] })
    };
    run("moving", "motion", turns);
    let part =
        if space == "3d" { [json!([0.0, 0.0]), json!([0.3, 0.5])] } else { [json!([0.0]), json!([0.3])] };
    let region =
        json!({ "shape": { "kind": "box", "min": part[0], "max": part[1] }, "wall": { "kind": "smooth" } });
    run("of two parts", "regions", json!([region]));
    for kind in ["rough", "smooth"] {
        let mut obstacle = slope.clone();
        (obstacle["wall"], obstacle["separation"]) = (json!({ "kind": kind }), json!(true));
        put(runs, space, &format!("obstacle {kind} separating"), &json!({ "obstacles": [obstacle] }));
    }
}

/// A saw through the lower part of the block.
fn cuts(runs: &mut Runs, space: &str) {
    let d = if space == "3d" { 3 } else { 2 };
    let of = |values: [f64; 3]| values[..d].to_vec();
    let cut = json!({ "name": "saw", "velocity": of([-20.0, 0.0, 1.0]), "start": 0.002,
                      "shape": { "kind": "box", "min": of([0.5, 0.0, 0.0]), "max": of([0.7, 0.22, 0.5]) } });
    put(runs, space, "saw", &json!({ "cuts": [cut] }));
}

/// Walls across an axis.
fn walls(runs: &mut Runs) {
    let kinds = [
        ("rough", json!({ "wall": { "kind": "rough" } })),
        ("rough separating", json!({ "wall": { "kind": "rough" }, "separation": true })),
        ("smooth", json!({ "wall": { "kind": "smooth" } })),
        ("frictional", json!({ "wall": { "kind": "frictional", "friction_coefficient": 0.4 } })),
        (
            "frictional held",
            json!({ "wall": { "kind": "frictional", "friction_coefficient": 0.4, "bilateral": true } }),
        ),
        ("moving", json!({ "wall": { "kind": "smooth" }, "velocity": [0, 2] })),
    ];
    for (name, wall) in kinds {
        let wall = merged(json!({ "side": "y-min", "position": 0.1 }), &wall);
        let more = json!({ "obstacles": [], "boundaries": [wall] });
        put(runs, "plane-strain", &format!("wall {name}"), &more);
    }
}
