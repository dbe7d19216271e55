//! Friction of walls against closed forms (sheet: mpm ).

use colluvium_mpm::Mpm;
use colluvium_testkit::vectors;
use serde_json::json;

use crate::solver::elastic_block;

const FRICTIONS: [&str; 2] = ["impulse", "acceleration"];

#[test]
fn the_stopping_distance_of_a_sliding_block_follows_coulomb_friction() {
    // sheet: mpm A-31: after v0/(μ g), at v0²/(2 μ g); 2 %.
    for friction in FRICTIONS {
        let report = elastic_block().with(json!({
            "domain": { "min": [0, 0], "max": [2, 0.4] }, "gravity": [0, -10],
            "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.2, 0], "max": [0.8, 0.2] },
                         "velocity": { "kind": "uniform", "value": [1, 0] },
                         "stress": { "kind": "k0", "surface": 0.2, "coefficient": 0 } }],
            "boundaries": [{ "side": "y-min", "wall": { "kind": "frictional", "friction_coefficient": 0.2 } }],
            "stages": [{ "name": "slide", "duration": 0.8 }],
            "methods": { "mpm": { "cell_size": 0.05, "shape": "linear", "stress_update": "musl", "wall_friction": friction } }
        })).solve(&Mpm);
        let slid = vectors(&report.snapshot, "displacement");
        let mean = slid.iter().map(|u| u[0]).sum::<f64>() / slid.len() as f64;
        let exact = 1.0 / (2.0 * 0.2 * 10.0);
        assert!((mean / exact - 1.0).abs() < 0.02, "{friction}: {mean} m for {exact} m");
        assert!(report.end.momentum[0].abs() < 0.02 * report.start.momentum[0], "{friction}");
    }
}

#[test]
fn a_block_on_an_incline_slides_or_stays_by_its_friction() {
    // sheet: mpm A-14, on a wall: 30°, a = g (sin θ - μ cos θ) within 3 % of g sin θ, or a drift below 5 mm. Gravity
    // grows from nothing, a t / T, so that the block does not bounce: it slides by a T² / 6.
    let (sin, cos) = 30f64.to_radians().sin_cos();
    for friction in FRICTIONS {
        for (coefficient, duration) in [(0.2, 0.5), (0.4, 0.5), (0.7, 1.0)] {
            let report = elastic_block().with(json!({
                "domain": { "min": [0, 0], "max": [2, 0.8] }, "gravity": [9.81 * sin, -9.81 * cos],
                "materials": { "m": { "model": "linear-elastic", "density": 1500, "youngs_modulus": 1e7, "poissons_ratio": 0 } },
                "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.2, 0], "max": [1.2, 0.5] } }],
                "boundaries": [{ "side": "y-min", "wall": { "kind": "frictional", "friction_coefficient": coefficient } }],
                "stages": [{ "name": "slide", "duration": duration, "gravity_ramp": duration }],
                "methods": { "mpm": { "cell_size": 0.1, "shape": "linear", "stress_update": "musl", "wall_friction": friction } }
            })).solve(&Mpm);
            let slid = vectors(&report.snapshot, "displacement");
            let mean = slid.iter().map(|u| u[0]).sum::<f64>() / slid.len() as f64;
            let distance = |acceleration: f64| acceleration * duration * duration / 6.0;
            let exact = distance(9.81 * (sin - coefficient * cos)).max(0.0);
            let tolerance = if exact > 0.0 { 0.03 * distance(9.81 * sin) } else { 5e-3 };
            assert!((mean - exact).abs() < tolerance, "{friction}, {coefficient}: {mean} m for {exact} m");
        }
    }
}
