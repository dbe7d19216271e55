//! A step allocates no memory.

use colluvium_case::Case;
use colluvium_mpm::Mpm;
use colluvium_testkit::{CountingAllocator, assert_allocates_nothing};
use serde_json::json;

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

/// A block under traction and gravity on a frictional floor; nothing moves by a cell, so that points
/// need not be sorted.
fn block(shape: &str, scheme: &str, transfer: &str) -> Case {
    let text = json!({
        "title": "allocation", "space": "plane-strain", "domain": { "min": [0, 0], "max": [2, 1] }, "gravity": [0, -1],
        "materials": { "m": { "model": "drucker-prager", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.3,
                              "friction_angle": 20, "cohesion": 100 } },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.1, 0], "max": [1.8, 0.8] } },
                   { "name": "lid", "material": "m", "shape": { "kind": "box", "min": [0.1, 0.8], "max": [1.8, 0.9] } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "frictional", "friction_coefficient": 0.3 } }],
        "loads": [{ "kind": "traction", "body": "b", "side": "y-max", "value": [10, -50], "ramp": 0.1 }],
        "stages": [{ "name": "s", "duration": 1, "damping": 0.1,
                     "equilibrium": { "unbalanced_force": 1e-6, "kinetic_energy": 1e-6 } }],
        "methods": { "mpm": { "cell_size": 0.1, "shape": shape, "stress_update": scheme, "transfer": transfer,
                              "contacts": [{ "bodies": ["b", "lid"], "friction_coefficient": 0.2 }] } }
    });
    Case::from_json(&text.to_string()).unwrap()
}

/// Block of [`block`] with water in its pores.
fn saturated(shape: &str, scheme: &str, volumetric: &str) -> Case {
    let mut case = block(shape, scheme, "flip");
    let fluid = json!({ "porosity": 0.4, "permeability": 0.01, "bulk_modulus": 1e7 });
    case.bodies[0].pore_fluid = Some(serde_json::from_value(fluid).unwrap());
    let options = case.methods.get_mut("mpm").unwrap();
    options["volumetric_strain"] = json!(volumetric);
    options["contacts"] = json!([]);
    case
}

/// The block by itself, with consistent mass.
fn consistent() -> Case {
    let mut case = block("ugimp", "usl", "flip");
    case.bodies.truncate(1);
    case.boundaries[0].wall = colluvium_case::description::Wall::Rough;
    case.stages[0].equilibrium = None;
    let options = case.methods.get_mut("mpm").unwrap();
    options["mass"] = json!("consistent");
    options["lumped_share"] = json!(0.12);
    options["contacts"] = json!([]);
    case
}

// One test, so that no other one allocates meanwhile.
#[test]
fn a_step_allocates_nothing() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        let mut cases = Vec::new();
        for shape in ["linear", "dual-domain", "ugimp", "cpgimp", "quadratic", "cubic"] {
            for scheme in ["usf", "usl", "musl"] {
                let transfer = match shape {
                    "ugimp" => "xpic",
                    "cpgimp" => "tpic",
                    "quadratic" => "apic",
                    _ => "flip",
                };
                cases.push((format!("{shape}, {scheme}"), block(shape, scheme, transfer)));
            }
        }
        for (shape, volumetric) in [("ugimp", "point"), ("linear", "cell-average")] {
            for scheme in ["usl", "musl"] {
                let name = format!("saturated, {shape}, {scheme}, {volumetric}");
                cases.push((name, saturated(shape, scheme, volumetric)));
            }
        }
        cases.push(("consistent mass".to_owned(), consistent()));
        for (name, case) in cases {
            assert_allocates_nothing(&Mpm, &case, 1, &name);
        }
    });
}
