//! Taylor–Green vortices of a liquid in a periodic box, which decay by viscosity alone.

use std::f64::consts::TAU;

use colluvium_case::{Case, Snapshot};
use serde_json::{Value, json};

use crate::solver_runs::{case_with, scalars, vectors};

/// Density of the liquid (kg/m³).
const DENSITY: f64 = 1000.0;
/// Dynamic viscosity (Pa s).
const VISCOSITY: f64 = 10.0;

/// Case of Taylor–Green vortices with a wavelength of 1 m and a velocity of 1 m/s that decay over `duration` (s).
pub fn taylor_green_case(duration: f64, methods: &Value) -> Case {
    let text = json!({
        "title": "vortices", "space": "plane-strain", "domain": { "min": [0, 0], "max": [1, 1], "periodic": ["x", "y"] },
        "gravity": [0, 0],
        "materials": { "m": { "model": "newtonian-fluid", "density": DENSITY, "bulk_modulus": 1e5, "viscosity": VISCOSITY,
                              "cavitation_strength": 1e9 } },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 1] },
                     "velocity": { "kind": "formula", "value": ["sin(TAU*x)*cos(TAU*y)", "-cos(TAU*x)*sin(TAU*y)"] } }],
        "stages": [{ "name": "s", "duration": duration }],
        "methods": methods
    });
    case_with(text, &json!({}))
}

/// Kinetic energy of the vortices over the exact one. That is `exp(-4 ν k² t)` times the energy of a mean square velocity of 1/2 at the
/// start.
pub fn energy_ratio(snapshot: &Snapshot, duration: f64) -> f64 {
    let (masses, velocities) = (scalars(snapshot, "mass"), vectors(snapshot, "velocity"));
    let energy: f64 =
        masses.iter().zip(&velocities).map(|(m, v)| 0.5 * m * (v[0] * v[0] + v[1] * v[1])).sum();
    energy / (0.25 * DENSITY) / (-4.0 * VISCOSITY / DENSITY * TAU.powi(2) * duration).exp()
}
