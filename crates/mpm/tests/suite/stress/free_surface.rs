//! Free surface of liquids (sheet: mpm §2.18).

use colluvium_case::Method;
use colluvium_mpm::Mpm;
use colluvium_testkit::{advance_to, read_case, start_solver};
use serde_json::json;

#[test]
fn points_on_a_free_surface_carry_no_stress_in_any_step_order() {
    // A strip of half-filled cells: all of its points lie on the surface, and no force acts.
    for scheme in ["usf", "usl", "musl"] {
        let case = read_case(&json!({
            "title": "test", "space": "plane-strain", "domain": { "min": [0, 0], "max": [1, 1] }, "gravity": [0, 0],
            "materials": { "m": { "model": "newtonian-fluid", "density": 1000, "bulk_modulus": 1e5, "viscosity": 1e-3 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.2, 0.4], "max": [0.8, 0.45] },
                         "velocity": { "kind": "linear", "value": [0, 0], "origin": [0.5, 0.5], "gradient": [[-1, 0], [0, 0]] } }],
            "stages": [{ "name": "s", "duration": 0.01 }],
            "methods": { "mpm": { "cell_size": 0.1, "stress_update": scheme, "free_surface": 0.7, "points_per_cell": 2, "transfer": "flip" } }
        }));
        let before = Mpm.build(&case).unwrap().totals().kinetic;
        let mut solver = start_solver(&Mpm, &case);
        advance_to(&mut *solver, 0.01);
        let after = solver.totals().kinetic;
        assert!((after / before - 1.0).abs() < 1e-9, "{scheme}: {before} J, {after} J");
    }
}
