//! Runs of grains.

use serde_json::{Value, json};

use crate::{Runs, merged};

/// Grains on a jittered lattice, a little into each other, thrown against walls.
fn heap(dimension: usize) -> Value {
    let of = |values: [f64; 3]| values[..dimension].to_vec();
    let gravity = if dimension == 2 { vec![0.0, -10.0] } else { vec![0.0, 0.0, -10.0] };
    let floor = if dimension == 2 { "y-min" } else { "z-min" };
    json!({
        "title": "heap", "space": if dimension == 2 { "plane-strain" } else { "3d" },
        "domain": { "min": of([-1.0; 3]), "max": of([2.0, 2.0, 2.0]) },
        "gravity": gravity,
        "materials": { "g": crate::elastic(), "h": crate::elastic() },
        "bodies": [{ "name": "b", "material": "g", "shape": { "kind": "box", "min": of([0.0; 3]), "max": of([1.0, 1.2, 0.8]) },
                     "velocity": { "kind": "uniform", "value": of([0.5, -0.7, -0.3]) } }],
        "boundaries": [{ "side": floor, "position": 0.0, "wall": { "kind": "frictional", "friction_coefficient": 0.4 } },
                       { "side": "x-max", "position": 1.0, "wall": { "kind": "smooth" } },
                       { "side": "x-min", "position": 0.0, "wall": { "kind": "rough" } }],
        "stages": [{ "name": "s", "duration": 10 }],
        "methods": { "dem": { "grains": { "g": { "density": 2000,
            "diameter": { "distribution": "uniform", "min": 0.07, "max": 0.1 },
            "fill": { "kind": "lattice", "packing": "hexagonal", "pitch": 0.087, "jitter": 0.02 } } }, "initial_overlap": 0.3 } }
    })
}

fn linear() -> Value {
    json!({ "between": ["g", "g"], "normal": { "law": "linear", "stiffness": 4e6, "restitution": 0.6 },
            "friction": { "coefficient": 0.4 } })
}

fn hertz() -> Value {
    json!({ "between": ["g", "g"], "normal": { "law": "hertz", "youngs_modulus": 2e9, "poissons_ratio": 0.3, "restitution": 0.6 },
            "friction": { "coefficient": 0.4 } })
}

/// Pairs by name.
fn pairs(dimension: usize) -> Vec<(&'static str, Value)> {
    let rolling = json!({ "rolling": { "friction": 0.1, "damping_ratio": 0.2 } });
    let cohesive = |fragile: bool| json!({ "adhesion": { "kind": "cohesive", "tension": 4000, "shear": 2000, "fragile": fragile, "new_contacts": fragile } });
    let bond = json!({ "bond": { "normal_stiffness": 1e7, "shear_stiffness": 5e6, "tensile_strength": 1e5, "cohesion": 1e5,
                                 "friction_angle": 20, "scatter": 0.3, "gap": 0.02 } });
    let modulus = json!({ "law": "linear", "grain_modulus": 1e8, "damping_ratio": 0.3, "clamp": false });
    let mut all = vec![
        ("linear", linear()),
        ("linear elastic", merged(linear(), &json!({ "normal": { "restitution": 1.0 } }))),
        ("smooth", merged(linear(), &json!({ "friction": { "coefficient": 0 } }))),
        (
            "modulus",
            merged(
                linear(),
                &json!({ "normal": null, "tangential": { "damping_ratio": 0.2, "reset": "spring" } }),
            ),
        ),
        (
            "at rest",
            merged(
                linear(),
                &json!({ "friction": { "at_rest": 0.6 }, "tangential": { "damping_ratio": 0.2 } }),
            ),
        ),
        ("rolling", merged(linear(), &rolling)),
        ("cohesive", merged(linear(), &cohesive(false))),
        ("cohesive fragile", merged(linear(), &cohesive(true))),
        (
            "capillary",
            merged(
                linear(),
                &json!({ "adhesion": { "kind": "capillary", "surface_tension": 200, "volume_ratio": 0.02 } }),
            ),
        ),
        ("bonds", merged(linear(), &bond)),
        ("bonds rolling", merged(merged(linear(), &bond), &rolling)),
        ("hertz", hertz()),
        ("hertz rolling", merged(hertz(), &rolling)),
        ("jkr", merged(hertz(), &json!({ "adhesion": { "kind": "jkr", "work_of_adhesion": 200 } }))),
        (
            "hertz capillary",
            merged(
                hertz(),
                &json!({ "adhesion": { "kind": "capillary", "surface_tension": 200, "volume_ratio": 0.02 } }),
            ),
        ),
    ];
    for (name, pair) in &mut all {
        if *name == "modulus" {
            pair["normal"] = modulus.clone();
        }
    }
    if dimension == 3 {
        let twisting = json!({ "twisting": { "friction": 0.1 } });
        all.push(("twisting", merged(merged(linear(), &rolling), &twisting)));
    }
    all
}

/// Cells that deform.
fn cells(runs: &mut Runs, dimension: usize) {
    let axes: Vec<&str> = ["x", "y", "z"][..dimension].to_vec();
    let top = [1.0, 1.2, 1.0][..dimension].to_vec();
    let cell = json!({ "domain": { "min": vec![0.0; dimension], "max": top, "periodic": axes }, "boundaries": [], "gravity": vec![0.0; dimension],
        "bodies": [{ "name": "b", "material": "g", "shape": { "kind": "box", "min": vec![0.0; dimension], "max": top } }] });
    let control = json!({ "stages": { "s": { "agitation": 0.1, "cell": { "xx": { "stress": -1e3 }, "yy": { "stress": -1e3 }, "xy": { "rate": 0.5 } } } } });
    let fraction = if dimension == 2 { 0.8 } else { 0.55 };
    for (name, pair) in [("cell", linear()), ("cell hertz", hertz())] {
        let mut case = merged(heap(dimension), &cell);
        let own = merged(json!({ "pairs": [pair] }), &control);
        case["methods"]["dem"] = merged(case["methods"]["dem"].take(), &own);
        case["methods"]["dem"]["grains"]["g"]["fill"] =
            json!({ "kind": "random", "solid_fraction": fraction });
        runs.insert(format!("dem {dimension}d {name}"), case);
    }
}

/// Adds them.
pub fn add(runs: &mut Runs) {
    for dimension in [2, 3] {
        let mut run = |name: &str, pair: &Value, more: &Value, options: &Value| {
            let mut case = merged(heap(dimension), more);
            let own = merged(json!({ "pairs": [pair] }), options);
            case["methods"]["dem"] = merged(case["methods"]["dem"].take(), &own);
            runs.insert(format!("dem {dimension}d {name}"), case);
        };
        let none = json!({});
        for (name, pair) in pairs(dimension) {
            run(name, &pair, &none, &none);
        }
        for (name, options) in [
            ("radius", json!({ "lever_arm": "radius" })),
            ("predicted", json!({ "velocity": "predicted" })),
            ("orientation", json!({ "orientation": true })),
            ("held", json!({ "bodies": { "b": { "held": true } } })),
            ("growth", json!({ "stages": { "s": { "growth": 0.5 } } })),
            ("thin skin", json!({ "skin": 0.02 })),
        ] {
            run(name, &linear(), &none, &options);
            run(&format!("hertz {name}"), &hertz(), &none, &options);
        }
        let damped =
            json!({ "stages": [{ "name": "s", "duration": 10, "damping": 0.2, "rayleigh_damping": 1 }] });
        run("damped", &linear(), &damped, &none);
        // Two kinds, one of them held below.
        let low = [0.0; 3][..dimension].to_vec();
        let (mut high, mut above) = ([1.0, 1.2, 0.8][..dimension].to_vec(), low.clone());
        (high[dimension - 1], above[dimension - 1]) = (0.3, 0.3);
        let top = [1.0, 1.2, 0.8][..dimension].to_vec();
        let two = json!({ "bodies": [
            { "name": "b", "material": "g", "shape": { "kind": "box", "min": low, "max": high } },
            { "name": "c", "material": "h", "shape": { "kind": "box", "min": above, "max": top } }] });
        let kinds = json!({ "grains": { "h": { "density": 1000, "diameter": { "distribution": "uniform", "min": 0.05, "max": 0.09 },
                "fill": { "kind": "lattice", "packing": "square", "pitch": 0.085, "jitter": 0.02 } } },
            "bodies": { "b": { "held": true } } });
        let other = json!({ "between": ["h", "h"], "normal": { "law": "linear", "stiffness": 6e6, "restitution": 0.9 },
                            "friction": { "coefficient": 0.2 }, "rolling": { "friction": 0.05 } });
        let mixed = merged(kinds, &json!({ "mix": true, "pairs": [linear(), other] }));
        run("two kinds", &linear(), &two, &mixed);
        cells(runs, dimension);
    }
    let obstacle = json!({ "obstacles": [{ "name": "o", "shape": { "kind": "box", "min": [0.3, 0.0], "max": [0.6, 0.2] },
                                           "wall": { "kind": "frictional", "friction_coefficient": 0.3 } }] });
    let mut case = merged(heap(2), &obstacle);
    case["methods"]["dem"]["pairs"] = json!([linear()]);
    runs.insert("dem 2d obstacle".into(), case);
}
