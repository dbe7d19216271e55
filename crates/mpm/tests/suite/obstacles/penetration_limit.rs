//! Penetration limit: points too fast for the penalty springs are stopped before the obstacle (docs/theory/mpm.md, obstacles).

use colluvium_case::{Case, Solver};
use colluvium_mpm::Mpm;
use colluvium_testkit::{read_case, scalar_output, start_solver};
use serde_json::{Value, json};

/// A layer of sand of two points thrown at a floor with a bump, faster than its waves run (24 m/s).
fn thrown(options: &Value, wall: &Value) -> Case {
    let sand = json!({
        "model": "mohr-coulomb", "density": 1600, "youngs_modulus": 7e5, "poissons_ratio": 0.3, "friction_angle": 32
    });
    let mut value = json!({
        "title": "thrown", "space": "plane-strain", "gravity": [0, -9.81], "materials": { "sand": sand },
        "domain": { "min": [0, 0], "max": [6, 4] },
        "bodies": [{
            "name": "layer", "material": "sand", "velocity": { "kind": "uniform", "value": [5.0, -30.0] },
            "shape": { "kind": "box", "min": [1.0, 1.6], "max": [3.0, 1.8] }
        }],
        "obstacles": [{
            "name": "floor", "wall": wall,
            "shape": { "kind": "ground-line", "points": [[-1, 0.9], [1.3, 0.95], [1.9, 1.2], [2.4, 0.9], [7, 1.05]] }
        }],
        "stages": [{ "name": "fall", "duration": 0.1 }],
        "methods": { "mpm": { "cell_size": 0.2, "points_per_cell": 2, "obstacles": "points" } }
    });
    for (key, option) in options.as_object().unwrap() {
        value["methods"]["mpm"][key] = option.clone();
    }
    read_case(&value)
}

fn frictional() -> Value {
    json!({ "kind": "frictional", "friction_coefficient": 0.4 })
}

/// Total energy (J), with the energy transferred to obstacles.
fn energy(solver: &dyn Solver) -> f64 {
    let budget = solver.totals();
    let own = budget.kinetic + budget.elastic + budget.potential;
    let took = ["obstacles.friction", "obstacles.stored", "obstacles.stopped"];
    own + took.into_iter().map(|name| scalar_output(solver, name)).sum::<f64>()
}

/// Runs a case to its end; least distance of a centre from the floor over all steps (m), and by how much the energy comes above that
/// at the start, as a share of that.
fn follow(case: &Case, solver: &mut dyn Solver) -> (f64, f64) {
    let standing = case.placed_obstacles::<2>().unwrap();
    let (start, mut nearest, mut largest_energy) = (energy(solver), f64::INFINITY, 0f64);
    while solver.time() < case.stages[0].duration {
        solver.step(case.stages[0].duration - solver.time()).unwrap();
        for x in solver.snapshot().positions {
            let gap = standing[0].surface.gap(&[x[0], x[1]], 1.0);
            nearest = gap.map_or(nearest, |gap| nearest.min(gap.distance));
        }
        largest_energy = largest_energy.max(energy(solver));
    }
    (nearest, largest_energy / start - 1.0)
}

#[test]
fn point_centres_do_not_penetrate_at_impact_speeds_above_the_wave_speed() {
    for options in [
        json!({ "stress_update": "usl" }),
        json!({ "stress_update": "musl" }),
        json!({ "stress_update": "usf", "shape": "quadratic" }),
        json!({ "shape": "quadratic", "transfer": "apic" }),
        json!({ "shape": "cpgimp" }),
    ] {
        for wall in [frictional(), json!({ "kind": "smooth" }), json!({ "kind": "rough" })] {
            let case = thrown(&options, &wall);
            let mut solver = start_solver(&Mpm, &case);
            let (nearest, rise) = follow(&case, &mut *solver);
            assert!(nearest > 0.0, "{options} {wall}: {nearest}");
            assert!(rise < 1e-3, "{options} {wall}: {rise}");
            assert!(scalar_output(&*solver, "obstacles.stopped") > 0.0);
            assert!(
                !colluvium_testkit::lines(&solver.warnings_at_end()).contains("obstacle"),
                "{:?}",
                solver.warnings_at_end()
            );
        }
    }
}

#[test]
fn a_fast_rising_floor_does_not_pass_the_points_on_it() {
    let mut case = thrown(&json!({}), &frictional());
    case.bodies[0].velocity =
        serde_json::from_value(json!({ "kind": "uniform", "value": [0.0, 0.0] })).unwrap();
    case.obstacles[0].motion = serde_json::from_value(json!({ "velocity": [0, 20] })).unwrap();
    let mut solver = start_solver(&Mpm, &case);
    while solver.time() < 0.05 {
        solver.step(0.05 - solver.time()).unwrap();
    }
    assert!(
        !colluvium_testkit::lines(&solver.warnings_at_end()).contains("obstacle"),
        "{:?}",
        solver.warnings_at_end()
    );
    let work = scalar_output(&*solver, "obstacles.work");
    assert!(work > 0.0 && energy(&*solver) <= work * 1.01, "{work} {}", energy(&*solver));
}

#[test]
fn slow_contact_is_resolved_by_the_penalty_forces_alone() {
    let mut case = thrown(&json!({}), &frictional());
    case.bodies[0].velocity =
        serde_json::from_value(json!({ "kind": "uniform", "value": [1.0, -2.0] })).unwrap();
    case.stages[0].duration = 0.3;
    let mut solver = start_solver(&Mpm, &case);
    let (nearest, _) = follow(&case, &mut *solver);
    assert!(nearest > 0.01, "{nearest}");
    assert_eq!(scalar_output(&*solver, "obstacles.stopped"), 0.0);
}
