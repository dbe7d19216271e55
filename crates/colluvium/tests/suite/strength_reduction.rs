//! Loss of strength in bodies whose initial stress is close to yield at full strength.

use colluvium::case::{Case, RunOptions, run_method};
use serde_json::{Value, json};

/// Confined block of sand with nearly the least horizontal stress that its full strength allows, `0.33` of the vertical one at 30 degrees.
fn block(material: &Value, more: &Value) -> Case {
    let mut case = json!({
        "title": "block", "space": "plane-strain",
        "domain": { "min": [0, 0], "max": [0.5, 1] }, "gravity": [0, -9.81],
        "materials": { "sand": material },
        "bodies": [{
            "name": "block", "material": "sand", "shape": { "kind": "box", "min": [0, 0], "max": [0.5, 0.5] },
            "stress": { "kind": "k0", "surface": 0.5, "coefficient": 0.36 }
        }],
        "boundaries": [
            { "side": "x-min", "wall": { "kind": "smooth" } }, { "side": "x-max", "wall": { "kind": "smooth" } },
            { "side": "y-min", "wall": { "kind": "rough" } }
        ],
        "stages": [{ "name": "hold", "duration": 0.005, "damping": 0.5 }],
        "methods": { "mpm": { "cell_size": 0.125 }, "sph": { "spacing": 0.0625 } }
    });
    for (key, value) in more.as_object().expect("an object") {
        case[key] = value.clone();
    }
    Case::from_json(&case.to_string()).expect("a case")
}

fn sand() -> Value {
    json!({ "model": "mohr-coulomb", "density": 1800, "youngs_modulus": 1e6, "poissons_ratio": 0.3, "friction_angle": 30 })
}

/// Methods with options in the block's case: those that integrate the stress of a body.
fn methods() -> impl Iterator<Item = &'static dyn colluvium::case::Method> {
    let named = block(&sand(), &json!({})).methods;
    colluvium::methods().iter().copied().filter(move |method| named.contains_key(method.name()))
}

#[test]
fn weakening_acts_on_initial_stress_outside_the_weakened_yield_surface() {
    let stages = json!({ "stages": [
        { "name": "hold", "duration": 0.005, "damping": 0.5 },
        { "name": "weak", "duration": 0.01, "weakening": { "factor": 2 } }
    ] });
    let undrained =
        json!({ "model": "undrained", "fluid_bulk_modulus": 1e7, "porosity": 0.4, "skeleton": sand() });
    for (material, kind) in [(sand(), "sand"), (undrained, "undrained sand")] {
        for method in methods() {
            let case = block(&material, &stages);
            let report = run_method(method, &case, &RunOptions::default());
            let report = report.unwrap_or_else(|error| panic!("{}, {kind}: {error}", method.name()));
            let stress = report.snapshot.tensors("stress").expect("stresses");
            let pressure = report.snapshot.scalars("pore_pressure");
            let far = |i: &usize| {
                let [x, y, _] = report.snapshot.positions[*i];
                (x - 0.25).hypot(y - 0.15)
            };
            let inside = (0..stress.len()).min_by(|a, b| far(a).total_cmp(&far(b))).expect("a point");
            let water = pressure.map_or(0.0, |pressure| pressure[inside]);
            let [horizontal, vertical] = [0, 1].map(|c| stress[inside].0[c] + water);
            // With half of tan 30 degrees the ratio is at least 0.568; the block has begun to oscillate.
            let ratio = horizontal / vertical;
            assert!((0.55..0.8).contains(&ratio), "{}, {kind}: {ratio}", method.name());
        }
    }
}

#[test]
fn a_search_reaches_factors_whose_reduced_strength_is_below_the_initial_stress() {
    let measures = json!({ "measures": { "safety": {
        "kind": "factor-of-safety", "after": "hold", "duration": 0.5, "damping": 0.7, "height": 0.5, "tolerance": 3
    } } });
    for method in methods() {
        let report = run_method(method, &block(&sand(), &measures), &RunOptions::default());
        let report = report.unwrap_or_else(|error| panic!("{}: {error}", method.name()));
        let factors: Vec<f64> = report.safety["safety"].trials.iter().map(|trial| trial.factor).collect();
        assert_eq!(factors, [0.5, 3.0], "{}", method.name());
    }
}
