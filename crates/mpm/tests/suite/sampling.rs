//! Points in rows along the sides of a body.

use std::f64::consts::PI;

use colluvium_case::Case;
use serde_json::{Value, json};

use crate::common::solve;

fn mass(space: &str, shape: &Value) -> f64 {
    let text = json!({
        "title": "rows", "space": space, "domain": { "min": [0, 0], "max": [4, 4] }, "gravity": [0, 0],
        "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e7, "poissons_ratio": 0.25 } },
        "bodies": [{ "name": "b", "material": "m", "sampling": "fitted", "shape": shape }],
        "stages": [{ "name": "s", "duration": 1e-3 }],
        "methods": { "mpm": { "cell_size": 0.25 } }
    });
    solve(&Case::from_json(&text.to_string()).unwrap()).end.mass
}

/// Areas of patches add up to that of the body, and with their centres to the volume of a ring (Pappus): the closed forms to
/// round-off.
#[test]
fn fitted_points_have_the_mass_of_the_body() {
    let ball = |radius: f64| json!({ "kind": "ball", "centre": [2, 2], "radius": radius });
    let ring = json!({ "kind": "difference", "from": ball(1.5), "cut": ball(0.6) });
    let plane = mass("plane-strain", &ring) / (1e3 * PI * (2.25 - 0.36));
    assert!((plane - 1.0).abs() < 1e-12, "{plane}");
    let torus = mass("axisymmetric", &ball(1.0)) / (1e3 * PI * 2.0);
    assert!((torus - 1.0).abs() < 1e-12, "{torus}");
}
