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
use colluvium_mpm::Mpm;
use colluvium_testkit::{CaseBuilder, advance_to, start_solver};
use serde_json::json;

/// Elastic block in a box without gravity.
pub fn elastic_block() -> CaseBuilder {
    CaseBuilder::plane_strain([0.0, 0.0], [1.0, 1.0])
        .elastic("m", 1000.0, 1e6, 0.3)
        .box_body("b", "m", &[0.35, 0.35], &[0.65, 0.65])
        .stage("s", 1.0)
        .options("mpm", json!({ "cell_size": 0.05 }))
}

pub fn restarts(case: &Case, middle: f64, end: f64) {
    let mut whole = start_solver(&Mpm, case);
    advance_to(&mut *whole, middle);
    let saved = whole.saved().unwrap();
    let mut again = start_solver(&Mpm, case);
    again.restore(&mut saved.as_slice()).unwrap();
    again.begin_stage(0, 0.0).unwrap();
    advance_to(&mut *again, end);
    advance_to(&mut *whole, end);
    assert_eq!(again.snapshot().hash(), whole.snapshot().hash());
}
