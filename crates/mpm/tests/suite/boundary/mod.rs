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

use colluvium_testkit::CaseBuilder;
use serde_json::json;

/// Elastic block in a box without gravity.
pub fn elastic_block() -> CaseBuilder {
    CaseBuilder::plane_strain([0.0, 0.0], [1.0, 1.0])
        .elastic("m", 1000.0, 1e6, 0.3)
        .box_body("b", "m", &[0.35, 0.35], &[0.65, 0.65])
        .stage("s", 1.0)
        .options("mpm", json!({ "cell_size": 0.05 }))
}
