//! Cases that the tests share.

use colluvium_case::{Case, Method, Snapshot, Solver};
use colluvium_snow_mpm::SnowMpm;
use colluvium_testkit::solver_runs as cases;
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
        "methods": { "snow-mpm": cases::with_keys(json!({ "cell_size": 0.1 }), options) }
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
        "methods": { "snow-mpm": cases::with_keys(json!({ "cell_size": 0.04 }), options) }
    })
}

/// A solver at the start of the first stage.
pub fn begun(value: &Value) -> Box<dyn Solver> {
    cases::start_solver(&SnowMpm, &Case::from_json(&value.to_string()).unwrap())
}

/// Why the case is refused.
pub fn refused(value: &Value) -> String {
    match Case::from_json(&value.to_string()) {
        Ok(case) => SnowMpm.plan(&case).unwrap_err().to_string(),
        Err(errors) => errors.to_string(),
    }
}

/// A reading of the solver.
pub fn reading(solver: &dyn Solver, name: &str) -> f64 {
    solver.scalar_outputs().into_iter().find(|(own, ..)| own == name).unwrap().2
}

/// Velocities of the points.
pub fn velocities(snapshot: &Snapshot) -> Vec<[f64; 3]> {
    cases::vectors(snapshot, "velocity")
}
