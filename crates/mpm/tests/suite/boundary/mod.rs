//! Boundary conditions: walls, loads, absorbing and periodic sides, bodies with prescribed or rigid motion (sheet: mpm §2.11).

mod absorbing_boundary;
mod curved_surfaces;
mod free_rigid_bodies;
mod nodal_loads;
mod periodic_domain;
mod pore_pressure_loads;
mod prescribed_motion;
mod surface_loads;
mod thin_sheets;
mod wall_friction;
mod walls;

use colluvium_case::Case;
use serde_json::{Value, json};

use crate::common::{advance_to, begin, case_with};

/// An elastic block in a box without gravity; `more` replaces or adds keys.
#[allow(clippy::needless_pass_by_value, reason = "`case(json!(…))` reads well")]
pub fn case(more: Value) -> Case {
    case_with(
        json!({
            "title": "test", "space": "plane-strain", "domain": { "min": [0, 0], "max": [1, 1] }, "gravity": [0, 0],
            "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.3 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.35, 0.35], "max": [0.65, 0.65] } }],
            "stages": [{ "name": "s", "duration": 1.0 }],
            "methods": { "mpm": { "cell_size": 0.05 } }
        }),
        &more,
    )
}

pub fn restarts(case: &Case, middle: f64, end: f64) {
    let mut whole = begin(case);
    advance_to(&mut *whole, middle);
    let saved = whole.checkpoint_bytes().unwrap();
    let mut again = begin(case);
    again.restore(&mut saved.as_slice()).unwrap();
    again.begin_stage(0, 0.0).unwrap();
    advance_to(&mut *again, end);
    advance_to(&mut *whole, end);
    assert_eq!(again.snapshot().hash(), whole.snapshot().hash());
}
