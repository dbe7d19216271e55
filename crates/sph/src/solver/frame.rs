//! Tests in which a frame of particles moves as prescribed.

use colluvium_case::Case;
use serde_json::json;

use super::*;
use crate::setup;

/// Rate of shear (1/s), which the sheet does not give. The tensile instability grows with time, not with
/// strain: at a tenth of this rate the block clumps before a strain of 0.3.
const RATE: f64 = 1.0;

/// 20 × 20 particles in a frame of five layers, `v_x = ζ y` (sheet V-30).
fn sheared(gradient: &str) -> SphSolver<2> {
    let text = json!({
        "title": "simple shear", "space": "plane-strain",
        "domain": { "min": [-20, -20], "max": [20, 20] }, "gravity": [0, 0],
        "materials": { "m": { "model": "linear-elastic", "density": 2700, "youngs_modulus": 1e7, "poissons_ratio": 0.3 } },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [-7.5, -7.5], "max": [7.5, 7.5] },
                     "velocity": { "kind": "linear", "value": [0, 0], "origin": [0, 0], "gradient": [[0, RATE], [0, 0]] } }],
        "stages": [{ "name": "s", "duration": 10 }],
        "methods": { "sph": { "spacing": 0.5, "velocity_gradient": gradient, "viscosity_linear": 0.1 } }
    });
    let case = Case::from_json(&text.to_string()).unwrap();
    let options = case.method_options("sph").unwrap();
    setup::solver(&case, &options).unwrap()
}

/// As `advance`, with the velocities of the frame prescribed.
fn step(solver: &mut SphSolver<2>, dt: f64) {
    solver.refresh_neighbours().unwrap();
    solver.load_fluxes();
    solver.accelerate(dt);
    solver.kick(dt);
    let p = &mut solver.particles;
    for i in 0..p.len {
        if p.origin[i].iter().any(|c| c.abs() > 5.0) {
            p.velocity[i] = [RATE * p.position[i][1], 0.0];
        }
    }
    solver.find_rates();
    solver.update_stress(dt).unwrap();
    solver.drift(dt).unwrap();
    solver.time += dt;
    solver.step += 1;
    solver.last_step = dt;
    solver.limit_age += 1;
}

/// Mean of the stress over the free particles, over the shear modulus.
fn mean(solver: &SphSolver<2>) -> SymTensor {
    let p = &solver.particles;
    let free: Vec<usize> = (0..p.len).filter(|&i| p.origin[i].iter().all(|c| c.abs() < 5.0)).collect();
    assert_eq!(free.len(), 400);
    let mut sum = SymTensor::ZERO;
    free.iter().for_each(|&i| sum += p.stress[i]);
    sum * (1.0 / 400.0 / (1e7 / 2.6))
}

#[test]
fn v30_simple_shear_follows_the_closed_form_of_the_jaumann_rate() {
    for (gradient, tolerance) in [("corrected", 0.005), ("compatible", 0.02), ("difference", 0.02)] {
        let mut solver = sheared(gradient);
        let mut judged = 0.1;
        while judged < 0.45 {
            let dt = solver.critical_step().dt;
            step(&mut solver, dt);
            let shear = RATE * solver.time;
            if shear >= judged {
                let stress = mean(&solver);
                let (exact, normal) = (shear.sin(), 1.0 - shear.cos());
                assert!((stress.0[3] / exact - 1.0).abs() < tolerance, "{gradient}: {stress:?}, {exact}");
                // The normal stress is a tenth of the shear stress: judged by that scale.
                assert!((stress.0[0] - normal).abs() < tolerance * exact, "{gradient}: {stress:?}, {normal}");
                judged += 0.1;
            }
        }
    }
}
