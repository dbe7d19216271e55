//! Rayleigh damping against closed forms.

use colluvium_mpm::Mpm;
use colluvium_testkit::vectors;
use serde_json::json;

use crate::solver::elastic_block;

#[test]
fn rayleigh_damping_slows_a_free_body() {
    let report = elastic_block().with(json!({
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.2, 0.3], "max": [0.6, 0.7] },
                     "velocity": { "kind": "uniform", "value": [0.4, -0.2] } }],
        "stages": [{ "name": "s", "duration": 0.1, "rayleigh_damping": 8 }],
        "methods": { "mpm": { "cell_size": 0.1, "time_step": 1e-3 } }
    })).solve(&Mpm);
    for velocity in vectors(&report.snapshot, "velocity") {
        // The force of the mean velocity of a step is that of (1 - ε)/(1 + ε), ε = 0.004.
        let exact = (0.996f64 / 1.004).powi(100);
        assert!((velocity[0] / 0.4 - exact).abs() < 1e-12 && (velocity[1] / -0.2 - exact).abs() < 1e-12);
        assert!((exact / (-0.8f64).exp() - 1.0).abs() < 1e-5);
    }
}

#[test]
fn a_bar_under_rayleigh_damping_is_a_damped_oscillator() {
    // First mode of a bar with one centred point a cell (sheet: mpm A-07). The amplitude of the mode on the grid, and so both
    // the force at the points and the damping, is λ = cos²(βh/2) of it.
    let (length, speed, cells, damping) = (25.0, 10.0, 13.0, 0.2);
    let (beta, h) = (std::f64::consts::PI / (2.0 * length), length / cells);
    let report = elastic_block().with(json!({
        "space": "1d", "domain": { "min": [0], "max": [length] }, "gravity": [0],
        "materials": { "m": { "model": "linear-elastic", "density": 1, "youngs_modulus": 100, "poissons_ratio": 0 } },
        "bodies": [{ "name": "bar", "material": "m", "shape": { "kind": "box", "min": [0], "max": [length] },
                     "velocity": { "kind": "sine", "amplitude": [1e-4], "wave_vector": [beta] } }],
        "boundaries": [{ "side": "x-min", "wall": { "kind": "rough" } }],
        "stages": [{ "name": "vibrate", "duration": 20, "rayleigh_damping": damping }],
        "output": { "measures": 0.1 },
        "methods": { "mpm": { "cell_size": h, "points_per_cell": 1, "shape": "linear", "courant": 0.01 } }
    })).solve(&Mpm);
    let momentum = report.table.pairs("time", "momentum.x").unwrap();
    let decay = 0.5 * damping * (0.5 * beta * h).cos().powi(2);
    let own = speed / h * (beta * h).sin();
    let omega = (own * own - decay * decay).sqrt();
    for (t, p) in &momentum {
        let exact = (-decay * t).exp() * ((omega * t).cos() - decay / omega * (omega * t).sin());
        assert!((p / momentum[0].1 - exact).abs() < 3e-3, "{t} s: {} for {exact}", p / momentum[0].1);
    }
}
