//! Cases of a block and of a ball.

use colluvium_testkit::with_keys;
use serde_json::{Value, json};

/// A block of stiff elastic matter far from all walls, with these options and a velocity.
pub fn block(velocity: &Value, options: &Value) -> Value {
    json!({
        "title": "block", "space": "plane-strain",
        "domain": { "min": [0, 0], "max": [2, 2] }, "gravity": [0, 0],
        "materials": { "m": { "model": "linear-elastic", "strain_measure": "hencky", "density": 400, "youngs_modulus": 1e6, "poissons_ratio": 0.3 } },
        "bodies": [{ "name": "block", "material": "m", "velocity": velocity,
            "shape": { "kind": "box", "min": [0.7, 0.8], "max": [1.3, 1.2] } }],
        "stages": [{ "name": "go", "duration": 0.1 }],
        "methods": { "snow-mpm": with_keys(json!({ "cell_size": 0.1 }), options) }
    })
}

/// A ball of snow that falls on a floor.
pub fn ball(options: &Value) -> Value {
    json!({
        "title": "ball", "space": "plane-strain",
        "domain": { "min": [-1, 0], "max": [1, 0.6] }, "gravity": [0, -9.81],
        "materials": { "snow": {
            "model": "cohesive-cam-clay", "density": 400, "youngs_modulus": 3e6, "poissons_ratio": 0.3,
            "critical_state_slope": 1.2, "cohesion_ratio": 0.3, "hardening_factor": 1, "compressive_strength": 3000 } },
        "bodies": [{ "name": "ball", "material": "snow", "shape": { "kind": "ball", "centre": [0, 0.24], "radius": 0.2 },
            "velocity": { "kind": "uniform", "value": [0, -5] } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } }],
        "stages": [{ "name": "fall", "duration": 0.05 }],
        "methods": { "snow-mpm": with_keys(json!({ "cell_size": 0.04 }), options) }
    })
}
