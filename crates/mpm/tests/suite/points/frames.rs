//! Fields of the points in frames.

use colluvium_mpm::Mpm;
use colluvium_testkit::{advance_steps, read_case, start_solver, vectors};
use serde_json::json;

use crate::transfer::velocity_transfers::spinning;

/// The field `grid_velocity` is the displacement of a step over its duration, `velocity` that of the points. The momentum of both is that of
/// the budget; the energy of the budget is that of `velocity`.
#[test]
fn frames_have_the_state_of_the_points_and_the_velocity_of_the_grid() {
    for options in [
        json!({}),
        json!({ "flip": 0.9, "stress_update": "usl" }),
        json!({ "transfer": "xpic", "shape": "quadratic" }),
    ] {
        let mut solver = start_solver(&Mpm, &spinning(&options));
        assert_eq!(
            vectors(&solver.snapshot(), "grid_velocity"),
            vectors(&solver.snapshot(), "velocity"),
            "at the start"
        );
        advance_steps(&mut *solver, 50);
        let before = vectors(&solver.snapshot(), "displacement");
        let dt = solver.step(1.0).unwrap().dt;
        let snapshot = solver.snapshot();
        let [after, grid, own] =
            ["displacement", "grid_velocity", "velocity"].map(|name| vectors(&snapshot, name));
        let budget = solver.totals();
        let mass = budget.mass / after.len() as f64;
        for c in 0..2 {
            for (p, moved) in after.iter().enumerate() {
                assert!((moved[c] - before[p][c] - dt * grid[p][c]).abs() < 1e-14, "{options}");
            }
            for all in [&grid, &own] {
                let sum: f64 = all.iter().map(|v| mass * v[c]).sum();
                assert!((sum - budget.momentum[c]).abs() < 1e-10 * budget.mass, "{options}");
            }
        }
        let energy =
            |all: &[[f64; 3]]| all.iter().map(|v| 0.5 * mass * (v[0] * v[0] + v[1] * v[1])).sum::<f64>();
        assert!((energy(&own) / budget.kinetic - 1.0).abs() < 1e-12, "{options}");
        assert!(energy(&grid) < 0.995 * energy(&own), "{options}: the grid does not see all of the rotation");
    }
    // Affine transfers have one velocity.
    let apic = start_solver(&Mpm, &spinning(&json!({ "transfer": "apic", "shape": "quadratic" }))).snapshot();
    assert!(apic.field("grid_velocity").is_none());
}

/// Closed form of a mode on a line of linear functions with a point in the middle of each cell (sheet: mpm A-03): the transfer to the grid
/// and back leaves cos²(βh/2) of it. The velocity of the points keeps it.
#[test]
fn grid_velocity_of_a_wave_of_sixteen_cells_is_four_percent_too_small() {
    let wave = std::f64::consts::PI / 8.0;
    let case = read_case(&json!({
        "title": "wave", "space": "1d", "domain": { "min": [0], "max": [80] }, "gravity": [0],
        "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e5, "poissons_ratio": 0 } },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [1], "max": [79] },
                     "velocity": { "kind": "sine", "amplitude": [1], "wave_vector": [wave] } }],
        "stages": [{ "name": "s", "duration": 1 }],
        "methods": { "mpm": { "cell_size": 1, "points_per_cell": 1, "shape": "linear", "stress_update": "usl" } }
    }));
    let mut solver = start_solver(&Mpm, &case);
    let start = vectors(&solver.snapshot(), "velocity");
    solver.step(1e-6).unwrap();
    let snapshot = solver.snapshot();
    for (field, exact) in [("velocity", 1.0), ("grid_velocity", (0.5 * wave).cos().powi(2))] {
        let shown = vectors(&snapshot, field);
        for p in 30..50 {
            assert!(
                (shown[p][0] - exact * start[p][0]).abs() < 2e-6,
                "{field}: {} of {}",
                shown[p][0],
                start[p][0]
            );
        }
    }
}
