//! Hashes of the state after short runs of everything that methods can be asked for: a change of code that is not meant to
//! change results leaves them as they are, to the last bit.
//!
//! The manifest is `validation/hashes.csv`. Where results are meant to change, `COLLUVIUM_HASHES=write cargo test -p colluvium
//! --test hashes` writes it anew. Sines and powers are those of the C library, so that the hashes are of 64-bit Linux.

mod elsewhere;
mod flows;
mod grains;
mod options;
mod particles;
mod rigid;
mod snow;

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

use colluvium::case::Case;
use rayon::prelude::*;
use serde_json::{Value, json};

/// Steps of a run.
const STEPS: usize = 40;

/// Runs by name.
type Runs = BTreeMap<String, Value>;

/// `base` with what `more` has, object by object.
fn merged(mut base: Value, more: &Value) -> Value {
    merge(&mut base, more);
    base
}

fn merge(base: &mut Value, more: &Value) {
    match (base.as_object_mut(), more.as_object()) {
        // A material is one of its own.
        (Some(old), Some(new)) if !new.contains_key("model") => {
            for (key, value) in new {
                merge(old.entry(key.clone()).or_insert(Value::Null), value);
            }
        }
        _ => base.clone_from(more),
    }
}

fn soil() -> Value {
    json!({ "model": "drucker-prager", "density": 1000, "youngs_modulus": 1e5, "poissons_ratio": 0.3,
            "friction_angle": 20, "cohesion": 500, "matching": "compression" })
}

fn elastic() -> Value {
    json!({ "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e5, "poissons_ratio": 0.25 })
}

fn water() -> Value {
    json!({ "model": "newtonian-fluid", "density": 1000, "bulk_modulus": 1e5, "viscosity": 10 })
}

fn block(name: &str, min: &[f64], max: &[f64], velocity: &[f64]) -> Value {
    json!({ "name": name, "material": "m", "shape": { "kind": "box", "min": min, "max": max },
            "velocity": { "kind": "uniform", "value": velocity } })
}

/// A block that is thrown against walls, in one to three dimensions or in axisymmetry.
fn crash(space: &str) -> Value {
    let d = match space {
        "1d" => 1,
        "3d" => 3,
        _ => 2,
    };
    let of = |values: [f64; 3]| values[..d].to_vec();
    let corner = if space == "axisymmetric" { [0.0; 3] } else { [0.05, 0.0, 0.05] };
    let walls = if d == 1 {
        json!([{ "side": "x-min", "wall": { "kind": "rough" } }])
    } else {
        json!([{ "side": "y-min", "wall": { "kind": "frictional", "friction_coefficient": 0.3 } },
               { "side": "x-max", "wall": { "kind": "smooth" } }])
    };
    json!({
        "title": "crash", "space": space,
        "domain": { "min": of([0.0; 3]), "max": of([0.4, 0.4, 0.3]) },
        "gravity": if d == 1 { vec![-10.0] } else { of([0.0, -10.0, 0.0]) },
        "materials": { "m": soil() },
        "bodies": [block("b", &of(corner), &of([0.25, 0.15, 0.15]), &of([0.4, -1.0, 0.2]))],
        "boundaries": walls,
        "stages": [{ "name": "s", "duration": 10 }],
        "methods": { "mpm": { "cell_size": 0.05, "courant": 0.3, "node_mass_cutoff": 0.05 } }
    })
}

fn mpm(options: &Value) -> Value {
    json!({ "methods": { "mpm": options } })
}

/// Shape functions and what they are evaluated over, by name.
fn shapes() -> Vec<(&'static str, Value)> {
    vec![
        ("linear", json!({ "shape": "linear" })),
        ("dual-domain", json!({ "shape": "dual-domain" })),
        ("ugimp", json!({ "shape": "ugimp" })),
        ("cpgimp", json!({ "shape": "cpgimp" })),
        ("cpgimp-turning", json!({ "shape": "cpgimp", "domain_stretch": "right-stretch" })),
        ("quadratic", json!({ "shape": "quadratic" })),
        ("cubic", json!({ "shape": "cubic" })),
        ("cpdi", json!({ "shape": "cpdi" })),
        ("cpdi2", json!({ "shape": "cpdi2" })),
        ("total-linear", json!({ "shape": "linear", "formulation": "total-lagrangian" })),
        ("total-quadratic", json!({ "shape": "quadratic", "formulation": "total-lagrangian" })),
        ("mesh", json!({ "shape": "linear", "mesh": { "kind": "box" } })),
    ]
}

const SCHEMES: [&str; 3] = ["usf", "usl", "musl"];

fn fluid() -> Value {
    json!({ "porosity": 0.4, "permeability": 1e-2, "bulk_modulus": 1e6,
            "pressure": { "kind": "hydrostatic", "surface": 0.15 } })
}

/// Every shape with every scheme and transfer, in every space, in one and two phases.
fn schemes(runs: &mut Runs) {
    for (shape, options) in shapes() {
        for scheme in SCHEMES {
            let with = |more: Value| {
                mpm(&merged(merged(options.clone(), &json!({ "stress_update": scheme })), &more))
            };
            for transfer in ["flip", "xpic", "apic", "tpic"] {
                let mut options = json!({ "transfer": transfer });
                if transfer == "flip" {
                    options["flip"] = json!(0.95);
                }
                let case = merged(crash("plane-strain"), &with(options));
                runs.insert(format!("mpm plane {shape} {scheme} {transfer}"), case);
            }
            for space in ["1d", "axisymmetric", "3d"] {
                runs.insert(format!("mpm {space} {shape} {scheme}"), merged(crash(space), &with(json!({}))));
            }
            let spaces: &[&str] = if scheme == "musl" {
                &["1d", "plane-strain", "axisymmetric", "3d"]
            } else {
                &["plane-strain"]
            };
            for space in spaces {
                let mut case = merged(crash(space), &with(json!({ "flip": 0.98 })));
                case["bodies"][0]["pore_fluid"] = fluid();
                if *space == "1d" {
                    case["bodies"][0]["pore_fluid"]["pressure"] = json!({ "kind": "uniform", "value": 100 });
                }
                runs.insert(format!("mpm {space} {shape} {scheme} two phases"), case);
            }
        }
        if shape != "cpdi2" {
            let case = merged(crash("3d"), &mpm(&merged(options, &json!({ "transfer": "apic" }))));
            runs.insert(format!("mpm 3d {shape} apic"), case);
        }
    }
}

/// Two blocks that meet.
fn pair(options: &Value, law: &Value) -> Value {
    let contact = merged(json!({ "bodies": ["lower", "upper"], "friction_coefficient": 0.3 }), law);
    let case = merged(crash("plane-strain"), &mpm(&merged(json!({ "contacts": [contact] }), options)));
    merged(
        case,
        &json!({ "bodies": [block("lower", &[0.1, 0.0], &[0.3, 0.1], &[0.0, 0.0]),
                            block("upper", &[0.1, 0.1], &[0.3, 0.2], &[0.5, -1.0])] }),
    )
}

fn contacts(runs: &mut Runs) {
    for (shape, options) in shapes() {
        for scheme in SCHEMES {
            let options = merged(options.clone(), &json!({ "stress_update": scheme }));
            runs.insert(format!("mpm contact {shape} {scheme}"), pair(&options, &json!({})));
        }
    }
    let gap = json!({ "test": "gap", "adhesion": 100 });
    runs.insert("mpm contact gap adhesion".into(), pair(&json!({}), &gap));
    runs.insert("mpm contact gap xpic".into(), pair(&json!({ "transfer": "xpic" }), &gap));
    let penalty = json!({ "test": "gap", "penalty": { "stiffness": 1e6 } });
    runs.insert("mpm contact penalty".into(), pair(&json!({}), &penalty));
    runs.insert("mpm contact normal".into(), pair(&json!({}), &json!({ "normal": [0, 1] })));
    let mut three = pair(&json!({}), &json!({}));
    three["bodies"].as_array_mut().unwrap().push(block("third", &[0.3, 0.0], &[0.35, 0.1], &[-1.0, 0.0]));
    three["methods"]["mpm"]["contacts"] = json!([
        { "bodies": ["lower", "upper"], "friction_coefficient": 0.3 }, { "bodies": ["third", "lower"], "adhesion": 100 }]);
    runs.insert("mpm contact three".into(), three);
    let mut ring = pair(&json!({}), &json!({}));
    ring["space"] = json!("axisymmetric");
    runs.insert("mpm contact axisymmetric".into(), ring);
}

/// What is averaged over cells.
fn averages(runs: &mut Runs) {
    for (name, options) in [("grid", json!({})), ("mesh", json!({ "mesh": { "kind": "box" } }))] {
        for phases in ["", " two phases"] {
            let mut add = |what: &str, more: Value| {
                let options = merged(merged(options.clone(), &json!({ "shape": "linear" })), &more);
                let mut case = merged(crash("plane-strain"), &mpm(&options));
                if !phases.is_empty() {
                    case["bodies"][0]["pore_fluid"] = fluid();
                }
                runs.insert(format!("mpm {what} {name}{phases}"), case);
            };
            for scheme in SCHEMES {
                add(
                    &format!("cell-average {scheme}"),
                    json!({ "volumetric_strain": "cell-average", "stress_update": scheme }),
                );
                add(&format!("mixed {scheme}"), json!({ "integration": "mixed", "stress_update": scheme }));
            }
            add("nodal", json!({ "volumetric_strain": "nodal" }));
            add("gauss", json!({ "integration": "gauss" }));
            add("mixed reset", json!({ "integration": "mixed", "mixed_reset": true }));
        }
        let options = merged(options, &json!({ "shape": "linear", "free_surface": 0.7 }));
        let case =
            merged(merged(crash("plane-strain"), &mpm(&options)), &json!({ "materials": { "m": water() } }));
        runs.insert(format!("mpm free surface {name}"), case);
    }
    for shape in ["ugimp", "quadratic", "cpdi"] {
        for (kind, scheme) in [("cell-average", "musl"), ("nodal", "usl")] {
            let options = json!({ "shape": shape, "volumetric_strain": kind, "stress_update": scheme });
            runs.insert(
                format!("mpm {kind} {shape} {scheme}"),
                merged(crash("plane-strain"), &mpm(&options)),
            );
        }
        let case = merged(crash("plane-strain"), &mpm(&json!({ "shape": shape, "free_surface": 0.7 })));
        runs.insert(
            format!("mpm free surface {shape}"),
            merged(case, &json!({ "materials": { "m": water() } })),
        );
    }
    for shape in ["linear", "ugimp", "quadratic"] {
        let options =
            json!({ "shape": shape, "mass": "consistent", "stress_update": "usl", "lumped_share": 0.4 });
        let mut case = merged(crash("plane-strain"), &mpm(&options));
        case["boundaries"] = json!([{ "side": "y-min", "wall": { "kind": "rough" } }]);
        runs.insert(format!("mpm consistent {shape}"), case);
    }
}

/// Loads, walls, and what is driven.
fn boundaries(runs: &mut Runs) {
    let mut add = |name: &str, more: Value| {
        runs.insert(
            format!("mpm {name}"),
            merged(merged(crash("plane-strain"), &json!({ "materials": { "m": elastic() } })), &more),
        );
    };
    let load = |kind: &str, value: Value| json!({ "kind": kind, "body": "b", "side": "x-max", "value": value, "ramp": 0.01 });
    for scheme in SCHEMES {
        let options = json!({ "stress_update": scheme });
        add(
            &format!("pressure {scheme}"),
            merged(mpm(&options), &json!({ "loads": [load("pressure", json!(1e3))] })),
        );
        let wet = json!([merged(
            block("b", &[0.05, 0.0], &[0.25, 0.15], &[0.0, 0.0]),
            &json!({ "pore_fluid": fluid() })
        )]);
        let loads = json!([load("pore-pressure", json!(1e3)), load("pressure", json!(2e3))]);
        add(
            &format!("pore pressure {scheme}"),
            merged(mpm(&options), &json!({ "loads": loads, "bodies": wet })),
        );
        let lid = json!([block("b", &[0.0, 0.0], &[0.4, 0.2], &[0.0, 0.0]),
                         { "name": "lid", "material": "m", "shape": { "kind": "box", "min": [0.1, 0.2], "max": [0.3, 0.25] }, "rigid": true }]);
        let press = json!([{ "name": "s", "duration": 10, "motions": [{ "of": "lid", "velocity": [0.1, -0.5], "ramp": 0.02 }] }]);
        add(&format!("lid {scheme}"), merged(mpm(&options), &json!({ "bodies": lid, "stages": press })));
        let patch = json!({ "patches": [{ "name": "foot", "region": { "kind": "box", "min": [0.1, 0.14], "max": [0.2, 0.16] } }],
                            "stages": [{ "name": "s", "duration": 10, "motions": [{ "of": "foot", "velocity": [0, -0.5], "ramp": 0.02 }] }] });
        add(&format!("patch {scheme}"), merged(mpm(&options), &patch));
        add(
            &format!("patch xpic {scheme}"),
            merged(mpm(&merged(options, &json!({ "transfer": "xpic" }))), &patch),
        );
        let wet_patch = merged(patch, &json!({ "bodies": wet }));
        add(
            &format!("patch two phases {scheme}"),
            merged(mpm(&json!({ "stress_update": scheme })), &wet_patch),
        );
    }
    for (shape, options) in shapes() {
        add(
            &format!("traction {shape}"),
            merged(mpm(&options), &json!({ "loads": [load("traction", json!([1e3, 2e2]))] })),
        );
        add(
            &format!("nodal load {shape}"),
            merged(
                mpm(&options),
                &json!({ "loads": [merged(load("traction", json!([1e3, 0])), &json!({ "carrier": "nodes" }))] }),
            ),
        );
        // Splines have no walls within the domain.
        let line = if matches!(shape, "quadratic" | "cubic") { 0.4 } else { 0.25 };
        let absorbing = json!({ "boundaries": [{ "side": "x-max", "position": line, "wall": { "kind": "absorbing", "spring_length": 0.3 } },
                                                { "side": "y-min", "wall": { "kind": "smooth" } }],
                                "bodies": [block("b", &[0.05, 0.0], &[line, 0.15], &[0.4, 0.0])] });
        add(&format!("absorbing {shape}"), merged(mpm(&options), &absorbing));
        let rest = json!({ "stages": [{ "name": "s", "duration": 10, "damping": 0.3, "equilibrium": { "unbalanced_force": 1e-9, "kinetic_energy": 1e-9 } }] });
        add(&format!("equilibrium {shape}"), merged(mpm(&options), &rest));
    }
    let flight = json!({ "domain": { "periodic": ["x"] }, "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } }],
                         "bodies": [block("b", &[0.25, 0.0], &[0.4, 0.15], &[3.0, 0.0])] });
    for shape in ["linear", "ugimp", "cpgimp"] {
        add(&format!("periodic {shape}"), merged(mpm(&json!({ "shape": shape })), &flight));
    }
    add("rayleigh", json!({ "stages": [{ "name": "s", "duration": 10, "rayleigh_damping": 5 }] }));
    add("mass scaling", merged(mpm(&json!({ "mass_scaling": 4, "fixed_nodes": "momentum" })), &json!({})));
    add(
        "acceleration friction",
        mpm(&json!({ "wall_friction": "acceleration", "static_friction_ratio": 1.5 })),
    );
    add("small displacement", mpm(&json!({ "formulation": "small-displacement" })));
    add(
        "dissipation",
        json!({ "materials": { "m": soil() }, "measures": { "lost": { "kind": "dissipation" } } }),
    );
    let wet = json!([merged(
        block("b", &[0.05, 0.0], &[0.25, 0.15], &[0.5, 0.0]),
        &json!({ "pore_fluid": fluid() })
    )]);
    add(
        "absorbing two phases",
        json!({ "bodies": wet, "boundaries": [{ "side": "x-max", "position": 0.25, "wall": { "kind": "absorbing" } }] }),
    );
    add(
        "equilibrium two phases",
        json!({ "bodies": wet,
        "stages": [{ "name": "s", "duration": 10, "damping": 0.3, "equilibrium": { "unbalanced_force": 1e-9, "kinetic_energy": 1e-9 } }] }),
    );
    let leaving =
        merged(block("b", &[0.25, 0.1], &[0.4, 0.2], &[5.0, 0.0]), &json!({ "drop_outside": true }));
    add("leaving", json!({ "bodies": [leaving], "boundaries": [] }));
}

fn runs() -> Runs {
    let mut runs = Runs::new();
    schemes(&mut runs);
    contacts(&mut runs);
    averages(&mut runs);
    boundaries(&mut runs);
    particles::add(&mut runs);
    grains::add(&mut runs);
    flows::add(&mut runs);
    rigid::add(&mut runs);
    snow::add(&mut runs);
    runs
}

/// Hash after a run, or what stopped it; `None` for what the method refuses.
fn outcome(text: &Value) -> Option<String> {
    let case = Case::from_json(&text.to_string()).unwrap_or_else(|error| panic!("{error}: {text}"));
    let name = text["methods"].as_object().unwrap().keys().next().unwrap();
    let mut solver = colluvium::method(name).unwrap().build(&case).ok()?;
    let mut run = || -> Result<String, String> {
        solver.begin_stage(0, 0.0).map_err(|error| format!("stage: {error}"))?;
        for _ in 0..STEPS {
            let dt = solver.limit().dt;
            solver.step(dt).map_err(|error| format!("stopped: {error}"))?;
        }
        Ok(format!("{:016x}", solver.snapshot().hash()))
    };
    Some(run().unwrap_or_else(|reason| reason.replace(['\n', ','], ";")))
}

#[test]
#[cfg(all(target_os = "linux", target_arch = "x86_64", target_env = "gnu"))]
fn results_are_those_of_the_manifest_to_the_last_bit() {
    let mut found = String::from("run,hash\n");
    let outcomes: BTreeMap<_, _> =
        runs().into_par_iter().map(|(name, case)| (name, outcome(&case))).collect();
    for (name, hash) in outcomes {
        if let Some(hash) = hash {
            writeln!(found, "{name},{hash}").unwrap();
        }
    }
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../validation/hashes.csv");
    if std::env::var_os("COLLUVIUM_HASHES").is_some_and(|what| what == "write") {
        std::fs::write(file, found).unwrap();
        return;
    }
    let manifest = std::fs::read_to_string(file).unwrap();
    let expected: BTreeMap<&str, &str> = manifest.lines().filter_map(|line| line.split_once(',')).collect();
    let found: BTreeMap<&str, &str> = found.lines().filter_map(|line| line.split_once(',')).collect();
    let differs = |(name, hash): &(&&str, &&str)| expected.get(**name) != Some(*hash);
    let wrong: Vec<String> = found
        .iter()
        .filter(differs)
        .map(|(name, hash)| format!("{name}: {hash}, not {:?}", expected.get(name)))
        .collect();
    assert!(
        wrong.is_empty() && found.len() == expected.len(),
        "{} of {} runs differ from validation/hashes.csv, which has {}:\n{}",
        wrong.len(),
        found.len(),
        expected.len(),
        wrong.join("\n")
    );
}
