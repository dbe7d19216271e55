//! Consistent mass: frequencies, momentum, bits, walls.

use std::f64::consts::PI;

use colluvium_case::Case;
use colluvium_mpm::Mpm;
use colluvium_testkit::{assert_same_on_threads, case_with, read_case, solve, vectors, with_keys};
use serde_json::{Value, json};

/// Frequency (rad/s) of the first mode of a bar of 13 cells with two points each, as the momentum shows it.
fn frequency(more: &Value) -> f64 {
    let options = with_keys(
        json!({ "cell_size": 25.0 / 13.0, "shape": "linear", "stress_update": "usl", "courant": 0.1 }),
        more,
    );
    let text = json!({
        "title": "bar", "space": "1d", "domain": { "min": [0], "max": [25] }, "gravity": [0],
        "materials": { "m": { "model": "linear-elastic", "density": 1, "youngs_modulus": 100, "poissons_ratio": 0 } },
        "bodies": [{ "name": "bar", "material": "m", "shape": { "kind": "box", "min": [0], "max": [25] },
                     "velocity": { "kind": "sine", "amplitude": [1e-5], "wave_vector": [PI / 50.0] } }],
        "boundaries": [{ "side": "x-min", "wall": { "kind": "rough" } }],
        "stages": [{ "name": "s", "duration": 42 }], "output": { "measures": 0.05 },
        "methods": { "mpm": options }
    });
    let report = solve(&Mpm, &read_case(&text));
    let momentum = report.table.pairs("time", "momentum.x").unwrap();
    let zeros: Vec<f64> = momentum
        .windows(2)
        .filter(|w| w[0].1 * w[1].1 < 0.0)
        .map(|w| w[0].0 + (w[1].0 - w[0].0) * w[0].1 / (w[0].1 - w[1].1))
        .collect();
    PI * (zeros.len() - 1) as f64 / (zeros[zeros.len() - 1] - zeros[0])
}

#[test]
fn consistent_mass_overestimates_the_frequency_of_a_bar_and_lumped_mass_underestimates_it() {
    // Two points at a quarter and three quarters of a cell give M the rows (3, 10, 3)/16 ρh, so that of a mode of wave
    // number β, with x = cos βh, M has (5 + 3x)/8 of the mass and the stiffness is 2 (1 - x) E/h. Lumped, the points have the
    // acceleration interpolated from the grid, ω² = 2 (c/h)² (1 - x)(5 + 3x)/8; consistent, ω² = 2 (c/h)² (1 - x) 8/(5 + 3x).
    let h = 25.0 / 13.0;
    let x = (PI / 50.0 * h).cos();
    let stiffness = 2.0 * (10.0 / h) * (10.0 / h) * (1.0 - x);
    let mass_share = (5.0 + 3.0 * x) / 8.0;
    let (exact, lumped, consistent) =
        (PI / 5.0, (stiffness * mass_share).sqrt(), (stiffness / mass_share).sqrt());
    assert!(lumped < exact && exact < consistent);
    let found = frequency(&json!({}));
    assert!((found / lumped - 1.0).abs() < 1e-4 && found < exact, "lumped: {found} for {lumped}");
    let found = frequency(&json!({ "mass": "consistent" }));
    assert!((found / consistent - 1.0).abs() < 1e-4 && found > exact, "consistent: {found} for {consistent}");
}

/// Ball that rotates and oscillates in a box without external forces.
fn ball(space: &str, shape: &str) -> Case {
    let dimension = if space == "3d" { 3 } else { 2 };
    let pick = |v: [f64; 3]| v[..dimension as usize].to_vec();
    // A ball moves into empty cells: the share from which the step is safe.
    let share = 3f64.powi(-dimension);
    let dimension = dimension as usize;
    let gradient: Vec<Vec<f64>> = [[1.0, 0.4, 0.1], [-0.8, -1.0, 0.2], [0.3, 0.1, 0.5]][..dimension]
        .iter()
        .map(|row| pick(*row))
        .collect();
    read_case(&json!({
        "title": "ball", "space": space, "domain": { "min": pick([0.0; 3]), "max": pick([1.0; 3]) }, "gravity": pick([0.0; 3]),
        "materials": { "m": { "model": "neo-hookean", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.25 } },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "ball", "centre": pick([0.5; 3]), "radius": 0.25 },
                     "velocity": { "kind": "linear", "value": pick([0.3, -0.2, 0.1]), "origin": pick([0.5; 3]),
                                   "gradient": gradient } }],
        "stages": [{ "name": "s", "duration": 0.02 }],
        "methods": { "mpm": { "cell_size": 0.1, "shape": shape, "stress_update": "usl", "mass": "consistent",
                              "lumped_share": share } }
    }))
}

#[test]
fn momentum_of_a_free_body_is_conserved_with_consistent_mass() {
    for (space, shape) in [("plane-strain", "ugimp"), ("3d", "ugimp"), ("plane-strain", "quadratic")] {
        let report = solve(&Mpm, &ball(space, shape));
        for c in 0..3 {
            let change = report.end.momentum[c] - report.start.momentum[c];
            assert!(change.abs() < 1e-10 * report.start.mass, "{space}, {shape}: {change}");
        }
        let spin = (report.end.angular_momentum[2] / report.start.angular_momentum[2] - 1.0).abs();
        assert!(spin < 1e-2, "{space}, {shape}: {spin}");
    }
}

#[test]
fn bits_are_the_same_on_one_and_two_threads_with_consistent_mass() {
    for (space, shape) in [("plane-strain", "ugimp"), ("3d", "ugimp")] {
        let case = ball(space, shape);
        assert_same_on_threads(&Mpm, &case, &format!("{space}, {shape}"));
    }
}

#[test]
fn moving_walls_accelerate_a_block_at_rest_and_leave_a_comoving_one_unchanged() {
    // Both side walls move: no force acts on a block that moves with them, and a block at rest is accelerated.
    for (own, least) in [(0.3, 0.0), (0.0, 1e-3)] {
        let wall = |side: &str| json!({ "side": side, "wall": { "kind": "smooth" }, "velocity": [0.3, 0] });
        let report = solve(
            &Mpm,
            &case_with(
                serde_json::from_str(&ball("plane-strain", "linear").to_json()).unwrap(),
                &json!({
                    "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0.3], "max": [1, 0.7] },
                                 "velocity": { "kind": "uniform", "value": [own, 0] } }],
                    "stages": [{ "name": "s", "duration": 1e-3 }],
                    "boundaries": [wall("x-min"), wall("x-max")]
                }),
            ),
        );
        let largest_change =
            vectors(&report.snapshot, "velocity").iter().map(|v| (v[0] - own).abs()).fold(0.0, f64::max);
        assert!(largest_change >= least && (own == 0.0 || largest_change < 1e-11), "{own}: {largest_change}");
    }
}
