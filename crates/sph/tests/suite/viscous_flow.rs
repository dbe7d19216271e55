//! Viscous flow between rough walls against closed forms (sheet: sph V-21).

use colluvium_case::Case;
use colluvium_sph::Sph;
use colluvium_testkit::{case_with, read_case, solve, vectors};
use serde_json::{Value, json};

/// Viscous liquid between walls at 0 and 1 m; `more` replaces or adds keys, `sph` options.
fn channel(count: u32, more: &Value, sph: &Value) -> Case {
    let spacing = 1.0 / f64::from(count);
    let mut methods = json!({ "spacing": spacing, "viscosity_linear": 0, "kernel": "wendland-c2", "smoothing": 1.5,
        "velocity_gradient": "corrected", "continuity": "volume" });
    for (key, value) in sph.as_object().unwrap() {
        methods[key] = value.clone();
    }
    let wide = 8.0 * spacing;
    let mut text = json!({
        "title": "test", "space": "plane-strain",
        "domain": { "min": [0, 0], "max": [wide, 1], "periodic": ["x"] }, "gravity": [0.001, 0],
        "materials": { "m": { "model": "newtonian-fluid", "density": 1000, "bulk_modulus": 1e5, "viscosity": 150,
                              "cavitation_strength": 1e9 } },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [wide, 1] } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } },
                       { "side": "y-max", "wall": { "kind": "rough" } }],
        "stages": [{ "name": "s", "duration": 6.0 }]
    });
    text["methods"] = json!({ "sph": methods });
    case_with(text, more)
}

/// Largest error of the velocity over its maximum.
fn poiseuille(count: u32, sph: &Value) -> f64 {
    let snapshot = solve(&Sph, &channel(count, &json!({}), sph)).snapshot;
    let exact = |y: f64| 1e-3 / 0.3 * y * (1.0 - y);
    let found = snapshot.positions.iter().zip(vectors(&snapshot, "velocity"));
    found.map(|(x, v)| (v[0] - exact(x[1])).abs() / exact(0.5)).fold(0.0, f64::max)
}

/// The force is discontinuous at a mirror wall, which causes alternating velocities that no gradient of a sum over symmetric neighbours
/// includes: they grow until another resistance acts (sheet: sph §6.27).
#[test]
fn v21_alternating_velocities_need_the_hourglass_viscosity() {
    let mirror = json!({ "rough_wall": "mirror", "hourglass_viscosity": 1 });
    let (coarse, fine) = (poiseuille(20, &mirror), poiseuille(40, &mirror));
    assert!(fine < 0.01 && coarse < 0.02, "{coarse} {fine}");
    let without = poiseuille(20, &json!({ "rough_wall": "mirror" }));
    assert!(without > 0.1, "{without}");
}

#[test]
fn couette_flow_between_rough_mirrors_is_linear() {
    let more = json!({
        "gravity": [0, 0],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } },
                       { "side": "y-max", "wall": { "kind": "rough" }, "velocity": [1e-3, 0] }]
    });
    // The wall starts at once, which causes alternating velocities too.
    let sph = json!({ "rough_wall": "mirror", "hourglass_viscosity": 1 });
    let snapshot = solve(&Sph, &channel(20, &more, &sph)).snapshot;
    for (x, v) in snapshot.positions.iter().zip(vectors(&snapshot, "velocity")) {
        // Remaining transient of the start from rest: 2/π exp(-π² ν t) = 9e-5 of the wall velocity.
        assert!((v[0] - 1e-3 * x[1]).abs() < 1e-6, "{x:?} {v:?}");
    }
}

/// The hourglass viscosity does not affect linear fields, and conserves both momenta.
#[test]
fn the_hourglass_viscosity_conserves() {
    let block = |gradient: Value, strength: f64| {
        let text = json!({
            "title": "test", "space": "plane-strain", "domain": { "min": [-1, -1], "max": [1, 1] }, "gravity": [0, 0],
            "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.25 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "ball", "centre": [0, 0], "radius": 0.4 },
                         "velocity": gradient }],
            "stages": [{ "name": "s", "duration": 0.004 }],
            "methods": { "sph": { "spacing": 0.05, "viscosity_linear": 0, "velocity_gradient": "corrected",
                                  "continuity": "volume", "hourglass_viscosity": strength } }
        });
        read_case(&text)
    };
    let turn = json!({ "kind": "linear", "value": [0, 0], "origin": [0, 0], "gradient": [[0, -5], [5, 0]] });
    let with = solve(&Sph, &block(turn.clone(), 1.0)).end.kinetic;
    let without = solve(&Sph, &block(turn, 0.0)).end.kinetic;
    assert!((with / without - 1.0).abs() < 1e-5, "{with} {without}");
    let wave = json!({ "kind": "sine", "amplitude": [0.0, 0.1], "wave_vector": [40, 0] });
    let report = solve(&Sph, &block(wave.clone(), 1.0));
    let (start, end) = (&report.start, &report.end);
    assert!(end.momentum.iter().zip(&start.momentum).all(|(a, b)| (a - b).abs() < 1e-11 * start.mass));
    let energy = |budget: &colluvium_case::Budget| budget.kinetic + budget.elastic;
    let free = solve(&Sph, &block(wave, 0.0));
    assert!(energy(end) < 0.9 * energy(&free.end), "short waves are damped");
}

/// The viscosity of the liquid is at the bound, or below.
#[test]
fn default_artificial_viscosity_supplements_low_liquid_viscosity_only() {
    // ρ c Δx/100 with c = 10 m/s and Δx = 0.05 m.
    let bound = 1000.0 * 10.0 * 0.05 / 100.0;
    let end = |viscosity: f64, linear: Option<f64>| {
        let mut case = channel(20, &json!({ "stages": [{ "name": "s", "duration": 0.05 }] }), &json!({}));
        let mut materials = serde_json::to_value(&case.materials).unwrap();
        materials["m"]["viscosity"] = json!(viscosity);
        case.materials = serde_json::from_value(materials).unwrap();
        let options = case.methods.get_mut("sph").unwrap().as_object_mut().unwrap();
        options.remove("viscosity_linear");
        if let Some(linear) = linear {
            options.insert("viscosity_linear".to_owned(), json!(linear));
        }
        solve(&Sph, &case).snapshot.hash()
    };
    for (share, linear) in [(1.01, 0.0), (0.99, 0.1)] {
        assert_eq!(end(share * bound, None), end(share * bound, Some(linear)), "{share}");
        assert_ne!(end(share * bound, None), end(share * bound, Some(0.1 - linear)), "{share}");
    }
}
