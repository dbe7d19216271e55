//! Options that change nothing in the families of cases, each with a run in which it has an effect.

use std::path::Path;

use colluvium_testkit::pairwise::CaseFamily;
use colluvium_testkit::{set_value, write_ascii_grid};
use serde_json::{Value, json};

/// Sets the values of `more`, object by object. A material is replaced as a whole.
fn merged(mut base: Value, more: &Value) -> Value {
    merge(&mut base, more);
    base
}

fn merge(base: &mut Value, more: &Value) {
    match (base.as_object_mut(), more.as_object()) {
        (Some(old), Some(new)) if !new.contains_key("model") => {
            for (key, value) in new {
                merge(old.entry(key.clone()).or_insert(Value::Null), value);
            }
        }
        _ => base.clone_from(more),
    }
}

fn elastic() -> Value {
    json!({ "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e5, "poissons_ratio": 0.25 })
}

fn water() -> Value {
    json!({ "model": "newtonian-fluid", "density": 1000, "bulk_modulus": 1e5, "viscosity": 10 })
}

/// Run, path of an option in it, and a value that changes its result, or whether it is accepted.
pub struct Trial {
    /// Name of the option, with `*` for names.
    pub option: &'static str,
    /// Case of the run.
    pub case: Value,
    /// Path of the option in it.
    pub path: String,
    /// The value.
    pub value: Value,
}

/// All trials; `folder` receives the terrain.
pub fn trials(families: &[CaseFamily], folder: &Path) -> Vec<Trial> {
    let mut all = Vec::new();
    let mut add = |option: &'static str, case: Value, value: Value| {
        let path = option.replace("dem.stages.*", "dem.stages.s").replace("[]", "/0").replace('.', "/");
        let path = format!("/methods/{path}");
        all.push(Trial { option, case, path, value });
    };
    grains(families, &mut add);
    over_terrain(folder, &mut add);
    flows(families, &mut add);
    particles(families, &mut add);
    on_grids(families, &mut add);
    all
}

/// Function that adds an option, a run and a value.
type Add<'a> = dyn FnMut(&'static str, Value, Value) + 'a;

/// Case of some levels of a family, with additional keys.
fn case_of_family(families: &[CaseFamily], family: &str, levels: &[(&str, &str)], more: &Value) -> Value {
    let family = families.iter().find(|own| own.name == family).expect("a family of this name");
    let mut case = family.case(&family.row(levels));
    set_value(&mut case, "/stages/0/duration", &json!(10));
    merged(case, more)
}

fn dem(options: &Value) -> Value {
    json!({ "methods": { "dem": options } })
}

fn grains(families: &[CaseFamily], add: &mut Add<'_>) {
    let run = |levels: &[(&str, &str)], more: Value| case_of_family(families, "dem", levels, &more);
    let averages = json!({ "output": { "grid": 0.1 } });
    add("dem.coarse_graining", run(&[], averages), json!(4.0));
    // Overlaps of the lattice are allowed, and refused.
    add("dem.initial_overlap", run(&[], json!({})), json!(0.01));
    add("dem.mix", run(&[("grains", "two kinds")], json!({})), json!(false));
    let damped = run(&[("options", "damped")], dem(&json!({ "stages": { "s": {} } })));
    add("dem.stages.*.damping_form", damped, json!("vector"));
    let mut grows =
        run(&[("space", "cell in the plane")], dem(&json!({ "stages": { "s": { "growth": 0.5 } } })));
    grows["methods"]["dem"]["stages"]["s"]["cell"] = json!({ "xx": { "rate": -0.5 } });
    add("dem.stages.*.grow_until", grows, json!(1e-3));
    // Tangential springs are those of the stage before.
    let mut pressed = run(&[], dem(&json!({ "stages": { "s": {} } })));
    pressed["stages"] = json!([{ "name": "before", "duration": 10 }, { "name": "s", "duration": 10 }]);
    add("dem.stages.*.reset_contacts", pressed, json!(true));
}

/// A slope of 0.6 with waves that bends to a flat, on a grid of 1 m.
fn terrain(folder: &Path) -> Value {
    let file = folder.join("terrain.asc");
    let level =
        |x: f64, y: f64| 1.0 + 0.6 * (40.0 - x).max(0.0) + 0.3 * (0.9 * x).sin() + 0.2 * (1.3 * y).cos();
    write_ascii_grid(&file, [0.0, 0.0], [61, 21], 1.0, level);
    json!({ "kind": "raster", "file": file.to_str().expect("plain letters") })
}

/// Heap on a bed that an obstacle defines.
fn on_bed(shape: &Value, more: &Value) -> Value {
    let base = json!({
        "title": "heap on a bed", "space": "3d", "gravity": [0, 0, -9.81],
        "domain": { "min": [0, 0, 0], "max": [60, 20, 60] },
        "materials": { "debris": {
            "model": "mohr-coulomb", "density": 2000, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 30
        } },
        "bodies": [{ "name": "heap", "material": "debris", "velocity": { "kind": "uniform", "value": [6, 1, 0] },
            "shape": { "kind": "box", "min": [4, 6, 0], "max": [10, 14, 25] } }],
        "obstacles": [{ "name": "bed", "shape": shape, "wall": { "kind": "frictional", "friction_coefficient": 0.2 } }],
        "stages": [{ "name": "release", "duration": 5 }],
        "methods": { "depth-sph": { "spacing": 1 } }
    });
    merged(base, more)
}

fn over_terrain(folder: &Path, add: &mut Add<'_>) {
    let shape = terrain(folder);
    let plain = || on_bed(&shape, &json!({}));
    add("depth-sph.curvature_in_friction", plain(), json!(false));
    add("depth-sph.frame", plain(), json!("small-slope"));
    add("depth-sph.metric", plain(), json!("normal"));
    add("depth-sph.terrain_smoothing", plain(), json!(4));
    let erodes = json!({ "methods": { "depth-sph": { "erosion": { "law": "hungr", "rate": 0.05 } } } });
    add("depth-sph.lower_bed", on_bed(&shape, &erodes), json!(true));
    let line = json!({ "from": [30, 4], "to": [30, 16], "discharge": [[0, 20], [9, 20]] });
    let flows_in = json!({ "methods": { "depth-sph": { "inflows": [line] } } });
    add("depth-sph.inflows[].across", on_bed(&shape, &flows_in), json!("level"));
    // A bed that is not a raster is evaluated at each position.
    let ball = json!({ "kind": "ball", "centre": [5, 10, -20], "radius": 40 });
    add("depth-sph.terrain_spacing", on_bed(&ball, &json!({})), json!(2.7));
    // The flow leaves the terrain within a few steps.
    let leaves = json!({ "bodies": [{ "name": "heap", "material": "debris", "velocity": { "kind": "uniform", "value": [-60, 0, 0] },
        "shape": { "kind": "box", "min": [1, 6, 0], "max": [6, 14, 27] } }] });
    add("depth-sph.leaving_is_an_error", on_bed(&shape, &leaves), json!(true));
}

fn flows(families: &[CaseFamily], add: &mut Add<'_>) {
    let run = |options: Value| {
        case_of_family(families, "depth-sph", &[], &json!({ "methods": { "depth-sph": options } }))
    };
    let sticks = json!({ "basal": { "model": "coulomb", "friction_angle": 15, "cohesion": 2000 } });
    add("depth-sph.basal.cohesion_form", run(sticks), json!("ramms"));
    let dense = json!({ "phases": "two", "mixture": { "grain_density": 2650, "porosity": 0.4,
        "drag": { "law": "anderson", "settling_velocity": 0.05 } } });
    add("depth-sph.mixture.porosity", run(dense), json!(0.45));
    // Against a wall heights increase and lengths decrease.
    let mut jams = run(json!({ "smoothing": 1.2 }));
    jams["gravity"] = json!([-9, -9.3]);
    jams["bodies"][0]["shape"]["min"][0] = json!(0);
    add("depth-sph.shortest_smoothing", jams, json!(0.06));
}

fn particles(families: &[CaseFamily], add: &mut Add<'_>) {
    let run = |levels: &[(&str, &str)], options: Value| {
        case_of_family(families, "sph", levels, &json!({ "methods": { "sph": options } }))
    };
    // Cases that these options permit are refused without them.
    add("sph.allow_pairing", run(&[], json!({ "smoothing": 2.5, "allow_pairing": true })), json!(false));
    let mut summed = run(&[], json!({ "continuity": "summation", "allow_summation": true }));
    summed["materials"]["m"] = water();
    add("sph.allow_summation", summed, json!(false));
    let mut stretched =
        run(&[("walls", "free flight"), ("material", "elastic"), ("stability", "total")], json!({}));
    stretched["bodies"][0]["velocity"] =
        json!({ "kind": "linear", "value": [0, 0], "gradient": [[5, 2], [0, -3]], "origin": [0.15, 0.1] });
    add("sph.formulation", stretched, json!("updated"));
    let mut spreads = run(&[("smoothing length", "density")], json!({}));
    spreads["materials"]["m"] = elastic();
    spreads["bodies"][0]["velocity"] =
        json!({ "kind": "linear", "value": [0, 0], "gradient": [[60, 0], [0, 60]], "origin": [0.15, 0.07] });
    add("sph.smoothing_growth", spreads, json!(1.0));
    add("sph.stress_diffusion_k0", run(&[("stability", "stress diffusion")], json!({})), json!(0.9));
    // Wall particles, which the body hits.
    let mut hits = run(&[("walls", "rough mirror")], json!({ "rough_wall": "particles", "spacing": 0.025 }));
    hits["bodies"][0]["velocity"]["value"] = json!([0, -4]);
    add("sph.wall_guard", hits, json!(1.0));
}

fn on_grids(families: &[CaseFamily], add: &mut Add<'_>) {
    let ground = json!({ "obstacles": [{ "name": "o", "shape": { "kind": "box", "min": [0.1, 0.0], "max": [0.25, 0.1] },
        "wall": { "kind": "frictional", "friction_coefficient": 0.3 } }] });
    let mut falls =
        case_of_family(families, "mpm", &[("material", "elastic"), ("walls", "acceleration")], &ground);
    falls["bodies"][0]["shape"] = json!({ "kind": "box", "min": [0.1, 0.1], "max": [0.25, 0.2] });
    falls["methods"]["mpm"]["obstacles"] = json!("nodes");
    add("mpm.obstacles", falls, json!("points"));
    // At rest on a wall, between both bounds of friction.
    let mut rests = case_of_family(
        families,
        "mpm",
        &[("material", "elastic"), ("walls", "acceleration")],
        &json!({ "gravity": [3.5, -10] }),
    );
    rests["bodies"][0]["velocity"]["value"] = json!([0, 0]);
    add("mpm.static_friction_ratio", rests, json!(1.0));
    let consistent = [("shape", "linear"), ("stress update", "usl"), ("walls", "rough")];
    add("mpm.mass", case_of_family(families, "mpm", &consistent, &json!({})), json!("consistent"));
    let snow = case_of_family(families, "snow-mpm", &[], &json!({}));
    add("snow-mpm.courant_velocity", snow, json!(1e-3));
}
