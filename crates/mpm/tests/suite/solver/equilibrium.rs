//! States at rest against closed forms.

use colluvium_case::RunReport;
use colluvium_mpm::Mpm;
use colluvium_testkit::{read_case, solve, start_solver, stresses, vectors};
use serde_json::{Value, json};

use crate::solver::elastic_block;

/// Settles a block that fills its box, all sides smooth, under gravity along y.
fn settled(space: &str, corner: &[f64], shape: &str) -> RunReport {
    let dimension = corner.len();
    let sides = ["x-min", "x-max", "y-min", "z-min", "z-max"];
    let walls: Vec<Value> = sides
        .iter()
        .filter(|side| dimension == 3 || !side.starts_with('z'))
        .map(|side| json!({ "side": side, "wall": { "kind": "smooth" } }))
        .collect();
    let mut gravity = vec![0.0; dimension];
    gravity[1] = -10.0;
    let mut high = corner.to_vec();
    high[1] += 0.2;
    elastic_block().with(json!({
        "space": space, "gravity": gravity, "boundaries": walls,
        "domain": { "min": vec![0.0; dimension], "max": high },
        "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e7, "poissons_ratio": 0.25 } },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": vec![0.0; dimension], "max": corner } }],
        "stages": [{ "name": "settle", "duration": 20, "damping": 0.7, "equilibrium": { "unbalanced_force": 1e-5, "kinetic_energy": 1e-5 } }],
        "methods": { "mpm": { "cell_size": 0.1, "shape": shape } }
    })).solve(&Mpm)
}

#[test]
fn stress_under_self_weight_at_rest_is_that_of_an_oedometer() {
    for (space, corner) in
        [("plane-strain", &[0.4, 1.0][..]), ("axisymmetric", &[0.4, 1.0][..]), ("3d", &[0.3, 1.0, 0.3][..])]
    {
        for shape in ["ugimp", "quadratic"] {
            if space == "axisymmetric" && shape == "quadratic" {
                // Two points per cell do not integrate d(r N)/dr of a quadratic exactly near the axis.
                continue;
            }
            let report = settled(space, corner, shape);
            let displacement = vectors(&report.snapshot, "displacement");
            let points = report.snapshot.positions.iter().zip(&displacement).zip(stresses(&report.snapshot));
            for ((x, u), s) in points {
                let vertical = -1000.0 * 10.0 * (1.0 - (x[1] - u[1]));
                // Strain is resolved to a cell: half a cell's weight.
                assert!(
                    (s[1] - vertical).abs() < 0.5 * 1000.0 * 10.0 * 0.1,
                    "{space}, {shape}: {} for {vertical} at {x:?}",
                    s[1]
                );
                for lateral in [s[0], s[2]] {
                    assert!(
                        (lateral - s[1] / 3.0).abs() < 1.0,
                        "{space}, {shape}: lateral {lateral}, vertical {}",
                        s[1]
                    );
                }
            }
        }
    }
}

#[test]
fn the_lower_of_two_layers_starts_with_the_weight_of_both() {
    // 3000 kg/m³ over 1000 kg/m³: the states of both hold still from the start.
    let soil = |density: f64| json!({ "model": "linear-elastic", "density": density, "youngs_modulus": 1e7, "poissons_ratio": 0.25 });
    let k0 = json!({ "kind": "k0", "surface": 0.8, "coefficient": 1.0 / 3.0 });
    let case = elastic_block().with(json!({
        "gravity": [0, -10],
        "materials": { "heavy": soil(3000.0), "light": soil(1000.0) },
        "bodies": [{ "name": "lower", "material": "light", "stress": k0, "shape": { "kind": "box", "min": [0, 0], "max": [1, 0.4] } },
                   { "name": "upper", "material": "heavy", "stress": k0, "shape": { "kind": "box", "min": [0, 0.4], "max": [1, 0.8] } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }, { "side": "x-min", "wall": { "kind": "smooth" } },
                       { "side": "x-max", "wall": { "kind": "smooth" } }],
        "methods": { "mpm": { "cell_size": 0.1, "points_per_cell": 2, "shape": "linear" } }
    })).build();
    let snapshot = start_solver(&Mpm, &case).snapshot();
    for (x, stress) in snapshot.positions.iter().zip(stresses(&snapshot)) {
        let depth = 0.8 - x[1];
        let exact = if depth < 0.4 { -3e4 * depth } else { -1.2e4 - 1e4 * (depth - 0.4) };
        assert!((stress[1] / exact - 1.0).abs() < 1e-9, "{} at {depth} m", stress[1]);
    }
    let moved =
        vectors(&solve(&Mpm, &case).snapshot, "displacement").iter().map(|u| u[1].abs()).fold(0.0, f64::max);
    // Weight of both layers over stiffness, 1.6e4 · 0.8 / 1.2e7, were it not there from the start.
    assert!(moved < 1e-6, "{moved} m");
}

#[test]
fn a_stage_without_external_forces_comes_to_equilibrium() {
    // A hole in ground under stress, without weight.
    let wall = |side: &str| json!({ "side": side, "wall": { "kind": "smooth" } });
    let case = read_case(&json!({
        "title": "test", "space": "plane-strain", "domain": { "min": [0, 0], "max": [1, 1] }, "gravity": [0, 0],
        "materials": { "m": { "model": "linear-elastic", "density": 2000, "youngs_modulus": 1e6, "poissons_ratio": 0.3 } },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 1] },
                     "stress": { "kind": "uniform", "value": [-1e4, -1e4, -1e4, 0, 0, 0] } }],
        "boundaries": [wall("x-min"), wall("x-max"), wall("y-min"), wall("y-max")],
        "stages": [{ "name": "s", "duration": 3, "damping": 0.7, "equilibrium": {},
                     "excavate": [{ "kind": "box", "min": [0.4, 0.4], "max": [0.6, 0.6] }] }],
        "methods": { "mpm": { "cell_size": 0.1 } }
    }));
    let report = solve(&Mpm, &case);
    assert!(report.snapshot.time < 3.0, "{}", report.snapshot.time);
}
