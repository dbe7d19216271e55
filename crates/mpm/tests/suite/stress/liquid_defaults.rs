//! Liquids with default options.

use colluvium_mpm::Mpm;
use colluvium_testkit::taylor_green::{energy_ratio, taylor_green_case};
use colluvium_testkit::{read_case, solve, start_solver, take_steps, vectors, with_keys};
use serde_json::json;

#[test]
fn vortices_of_a_liquid_keep_their_energy_without_options() {
    let case = taylor_green_case(1.0, &json!({ "mpm": { "cell_size": 0.04 } }));
    // Fifty points along the box with two a cell; liquids have three by default.
    let kept = energy_ratio(&solve(&Mpm, &case).snapshot, 1.0);
    assert!((kept - 1.0).abs() < 0.2, "{kept}");
}

/// A drop and a block that turn apart from each other: the drop moves as with `tpic`, the block as with `flip`.
#[test]
fn liquid_and_block_in_separate_velocity_fields_have_transfers_of_their_own() {
    let part = |name: &str, x: f64| {
        let velocity = ["-2*(y-0.5)+0.3*sin(9*x)".to_owned(), format!("2*(x-{})+0.3*cos(7*y)", x + 0.3)];
        json!({ "name": name, "material": name, "shape": { "kind": "box", "min": [x, 0.2], "max": [x + 0.6, 0.8] },
                "velocity": { "kind": "formula", "value": velocity } })
    };
    let run = |more: serde_json::Value| {
        let contacts = json!([{ "bodies": ["drop", "block"], "friction_coefficient": 0 }]);
        let mpm = with_keys(json!({ "cell_size": 0.1, "points_per_cell": 2, "contacts": contacts }), &more);
        let case = read_case(&json!({
            "title": "apart", "space": "plane-strain", "domain": { "min": [0, 0], "max": [3, 1] }, "gravity": [0, 0],
            "materials": {
                "drop": { "model": "newtonian-fluid", "density": 1000, "bulk_modulus": 1e5, "viscosity": 1, "cavitation_strength": 1e9 },
                "block": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e5, "poissons_ratio": 0.2 } },
            "bodies": [part("drop", 0.2), part("block", 2.2)],
            "stages": [{ "name": "s", "duration": 1 }],
            "methods": { "mpm": mpm }
        }));
        let mut solver = start_solver(&Mpm, &case);
        take_steps(&mut *solver, 40, 2e-3);
        let snapshot = solver.snapshot();
        let velocities = vectors(&snapshot, "velocity");
        [0, 1].map(|body| {
            let of_body = velocities.iter().zip(&snapshot.bodies).filter(|(_, own)| **own == body);
            of_body.map(|(v, _)| *v).collect::<Vec<_>>()
        })
    };
    let [drop, block] = run(json!({}));
    let surface = |transfer: &str| json!({ "transfer": transfer, "free_surface": 0.7 });
    let [affine, of_affine] = run(surface("tpic"));
    let [of_flip, plain] = run(surface("flip"));
    assert!(drop == affine && drop != of_flip, "the drop");
    assert!(block == plain && block != of_affine, "the block");
}
