//! Obstacles thinner than the support of a particle (sheet: sph §2.13).

use colluvium_case::Case;
use colluvium_sph::Sph;
use colluvium_testkit::{advance_steps, advance_to, case_with, start_solver, vectors};
use serde_json::{Value, json};

const SPACING: f64 = 0.05;

/// Blocks above and below a plate whose upper side is `y = 0`, without gravity; `more` adds keys to the case.
fn blocks_beside_plate(thickness: f64, more: &Value) -> Case {
    let part = |name: &str, low: f64, high: f64| json!({ "name": name, "material": "m", "shape": { "kind": "box", "min": [0, low], "max": [0.6, high] } });
    let mut upper = part("upper", 0.0, 0.3);
    upper["velocity"] = json!({ "kind": "uniform", "value": [0.3, -1] });
    let text = json!({
        "title": "plate", "space": "plane-strain", "gravity": [0, 0], "domain": { "min": [-2, -2], "max": [3, 3] },
        "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.2 } },
        "bodies": [upper, part("lower", -0.3 - thickness, -thickness)],
        "obstacles": [{ "name": "plate", "wall": { "kind": "frictional", "friction_coefficient": 0.4 },
            "shape": { "kind": "box", "min": [-1, -thickness], "max": [2, 0] } }],
        "stages": [{ "name": "s", "duration": 1 }],
        "methods": { "sph": { "spacing": SPACING } }
    });
    case_with(text, more)
}

/// Particles of both sides are within each other's support, and the plate separates them.
#[test]
fn impact_on_a_thin_plate_does_not_act_across_it() {
    for ranks in [1, 2] {
        let mut solver = start_solver(
            &Sph,
            &blocks_beside_plate(
                0.1 * SPACING,
                &json!({ "methods": { "sph": { "spacing": SPACING, "ranks": ranks } } }),
            ),
        );
        advance_to(&mut *solver, 0.02);
        let snapshot = solver.snapshot();
        let velocities = vectors(&snapshot, "velocity");
        let of = |body: u32| velocities.iter().zip(&snapshot.bodies).filter(move |(_, own)| **own == body);
        assert!(of(1).all(|(v, _)| *v == [0.0; 3]), "the lower block is at rest");
        assert!(of(0).any(|(v, _)| v[1] > -0.5), "the upper one has hit the plate");
    }
}

/// The block is a hundred times faster than its waves, and the plate is thinner than its path in a step.
#[test]
fn no_particle_flies_through_a_thin_plate_in_a_step() {
    let thickness = 0.01 * SPACING;
    for integration in ["leapfrog", "predictor-corrector", "velocity-verlet", "verlet", "runge-kutta4"] {
        let fast = json!({ "name": "upper", "material": "m", "shape": { "kind": "box", "min": [0, 0.02], "max": [0.6, 0.32] },
            "velocity": { "kind": "uniform", "value": [0.3, -10] } });
        let soft = json!({ "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 10, "poissons_ratio": 0.2 } });
        let mut solver = start_solver(
            &Sph,
            &blocks_beside_plate(
                thickness,
                &json!({ "bodies": [fast], "materials": soft,
                "methods": { "sph": { "spacing": SPACING, "integration": integration, "courant": 0.15 } } }),
            ),
        );
        let mut longest = 0f64;
        while solver.time() < 0.02 {
            let start = solver.time();
            advance_steps(&mut *solver, 1);
            longest = longest.max(10.0 * (solver.time() - start));
        }
        let lowest = solver.snapshot().positions.iter().map(|x| x[1]).fold(f64::INFINITY, f64::min);
        assert!(longest > 10.0 * thickness, "{integration}: {longest} m in a step");
        assert!(lowest > 0.0, "{integration}: at {lowest} m");
    }
}
