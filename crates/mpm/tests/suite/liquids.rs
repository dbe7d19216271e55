//! Liquids with the options that they get by default.

use serde_json::json;

use crate::common::{changed, scalars, solve, vectors};

/// Vortices that decay as `exp(-2 ν k² t)`, `k² = 2 (2π)²`-fold, without an option but for the resolution.
#[test]
fn vortices_of_a_liquid_keep_their_energy_without_options() {
    let text = json!({
        "title": "vortices", "space": "plane-strain", "domain": { "min": [0, 0], "max": [1, 1], "periodic": ["x", "y"] },
        "gravity": [0, 0],
        "materials": { "m": { "model": "newtonian-fluid", "density": 1000, "bulk_modulus": 1e5, "viscosity": 10,
                              "cavitation_strength": 1e9 } },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 1] },
                     "velocity": { "kind": "formula", "value": ["sin(TAU*x)*cos(TAU*y)", "-cos(TAU*x)*sin(TAU*y)"] } }],
        "stages": [{ "name": "s", "duration": 1 }],
        "methods": { "mpm": { "cell_size": 0.04 } }
    });
    let case = changed(text, &json!({}));
    // A mean square of a quarter in each of two components, half of it in energy, per kg.
    let start = 0.25 * 1000.0;
    let snapshot = solve(&case).snapshot;
    let masses = scalars(&snapshot, "mass");
    let speeds = vectors(&snapshot, "velocity");
    let energy: f64 = masses.iter().zip(&speeds).map(|(m, v)| 0.5 * m * (v[0] * v[0] + v[1] * v[1])).sum();
    let exact = (-4.0 * 0.01 * std::f64::consts::TAU.powi(2)).exp();
    // Fifty points along the box with two a cell; liquids get three.
    assert!((energy / start / exact - 1.0).abs() < 0.2, "{energy} J, {exact}");
}
