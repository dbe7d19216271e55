//! Bands within particles: the particle's own size is their length (sheet: sph §2.7; constitutive §2.16).

use serde_json::json;

use crate::common::{begin, changed, stresses};

/// Fracture energy (J/m²).
const ENERGY: f64 = 100.0;

/// Area under stress and elongation of a particle (J/m²) in a bar of so many particles per metre that is stretched evenly.
fn area(spacing: f64) -> f64 {
    let rate = 0.02 / spacing;
    let concrete = json!({
        "model": "double-scale", "density": 2400, "youngs_modulus": 3e10, "poissons_ratio": 0,
        "band": { "law": "cohesive-friction", "cohesion": 4.5e6, "tensile_strength": 3e6, "friction_coefficient": 0.6,
                  "opening_energy": ENERGY, "sliding_energy": 1000, "normal_stiffness": 1e18, "shear_stiffness": 1e18 }
    });
    let text = json!({
        "title": "bar", "space": "1d", "gravity": [0], "domain": { "min": [-1], "max": [2] },
        "materials": { "m": concrete },
        "bodies": [{ "name": "bar", "material": "m", "shape": { "kind": "box", "min": [0], "max": [8.0 * spacing] },
                     "velocity": { "kind": "linear", "value": [0], "origin": [0], "gradient": [[rate]] } },
                   { "name": "rest", "material": "m", "shape": { "kind": "box", "min": [1.4], "max": [1.8] } }],
        "stages": [{ "name": "s", "duration": 1 }],
        "methods": { "sph": { "spacing": spacing, "held": ["bar"], "velocity_gradient": "corrected" } }
    });
    let mut solver = begin(&changed(text, &json!({})));
    let (mut before, mut sum) = (0.0, 0.0);
    // Twelve times the opening over which the strength falls to 1/e.
    while rate * spacing * solver.time() < 12.0 * ENERGY / 3e6 {
        let dt = solver.limit().dt;
        solver.step(dt).unwrap();
        let snapshot = solver.snapshot();
        let all = stresses(&snapshot).into_iter().zip(&snapshot.bodies);
        let of_bar: Vec<f64> = all.filter(|(_, body)| **body == 0).map(|(s, _)| s[0]).collect();
        let mean = of_bar.iter().sum::<f64>() / of_bar.len() as f64;
        assert!(of_bar.iter().all(|s| (s - mean).abs() < 1e-3 * 3e6), "{of_bar:?}");
        sum += 0.5 * (before + mean) * rate * spacing * dt;
        before = mean;
    }
    sum
}

#[test]
fn a_band_in_a_particle_spends_the_same_energy_at_any_spacing() {
    for spacing in [0.1, 0.05] {
        let found = area(spacing);
        assert!((found / ENERGY - 1.0).abs() < 0.01, "{spacing} m: {found} J/m²");
    }
}
