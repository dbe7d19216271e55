//! Motions of laws from the grid, and several materials on one grid.

use colluvium_case::{Case, Method};
use colluvium_mpm::Mpm;
use colluvium_testkit::{read_case, solve, start_solver, stresses, vectors};
use serde_json::{Value, json};

/// Edge of the cells (m).
const CELL: f64 = 0.1;

/// One cell of concrete that a band may cut, held on the left and pulled on the right.
fn cell(space: &str, mpm: &Value) -> Case {
    let plane = space != "1d";
    let corner = |x: f64, y: f64| if plane { json!([x, y]) } else { json!([x]) };
    let wall = |side: &str| json!({ "side": side, "wall": { "kind": "smooth" } });
    let sides = if plane { vec![wall("x-min"), wall("y-min"), wall("y-max")] } else { vec![wall("x-min")] };
    let mut methods = json!({ "cell_size": CELL, "shape": "linear" });
    methods.as_object_mut().unwrap().extend(mpm.as_object().unwrap().clone());
    read_case(&json!({
        "title": "band", "space": space, "gravity": corner(0.0, 0.0),
        "domain": { "min": corner(0.0, 0.0), "max": corner(2.0 * CELL, CELL) },
        "materials": { "m": {
            "model": "double-scale", "density": 2400, "youngs_modulus": 3e10, "poissons_ratio": 0,
            "band": { "law": "cohesive-friction", "cohesion": 4.5e6, "tensile_strength": 3e6, "friction_coefficient": 0.6,
                      "opening_energy": ENERGY, "sliding_energy": 1000, "normal_stiffness": 1e18, "shear_stiffness": 1e18 }
        } },
        "bodies": [{ "name": "b", "material": "m",
                     "shape": { "kind": "box", "min": corner(0.0, 0.0), "max": corner(CELL, CELL) } }],
        "boundaries": sides,
        "patches": [{ "name": "grip", "region": { "kind": "box", "min": corner(CELL, 0.0), "max": corner(2.0 * CELL, CELL) } }],
        "stages": [{ "name": "pull", "duration": 1, "motions": [{ "target": "grip", "velocity": corner(PULL, 0.0) }] }],
        "methods": { "mpm": methods }
    }))
}

/// Fracture energy (J/m²).
const ENERGY: f64 = 100.0;
/// Speed of the grip (m/s).
const PULL: f64 = 0.02;

/// Area under mean stress and elongation (J/m²), to twelve times the opening over which the strength falls to 1/e.
fn area(case: &Case) -> f64 {
    let mut solver = start_solver(&Mpm, case);
    let (mut before, mut sum) = (0.0, 0.0);
    while PULL * solver.time() < 12.0 * ENERGY / 3e6 {
        let dt = solver.limit().dt;
        solver.step(dt).unwrap();
        let all = stresses(&solver.snapshot());
        let mean = all.iter().map(|s| s[0]).sum::<f64>() / all.len() as f64;
        sum += 0.5 * (before + mean) * PULL * dt;
        before = mean;
    }
    sum
}

/// The grid carries the resolution: however many points a cell holds, a band across it spends its energy once (sheet: constitutive §2.16,
/// Bui & Nguyen 2021, Fig. 12).
#[test]
fn a_band_across_a_cell_dissipates_its_fracture_energy_once() {
    for points in [1, 2, 3] {
        let options = json!({ "points_per_cell": points });
        let found = area(&cell("1d", &options));
        assert!((found / ENERGY - 1.0).abs() < 0.01, "{points} points: {found} J/m²");
    }
    let found = area(&cell("plane-strain", &json!({ "points_per_cell": 2 })));
    assert!((found / ENERGY - 1.0).abs() < 0.01, "plane: {found} J/m²");
    let found = area(&cell("plane-strain", &json!({ "points_per_cell": 1, "mesh": { "kind": "box" } })));
    assert!((found / ENERGY - 1.0).abs() < 0.01, "triangles: {found} J/m²");
}

/// A stiff and a soft half of a bar that is pulled: one stress, and strains by their moduli.
#[test]
fn two_materials_share_a_grid_as_bars_in_series_do() {
    let (traction, soft, stiff) = (1000.0, 1e6, 4e6);
    let elastic = |modulus: f64| json!({ "model": "linear-elastic", "density": 1000, "youngs_modulus": modulus, "poissons_ratio": 0 });
    let half = |name: &str, low: f64| json!({ "name": name, "material": name, "shape": { "kind": "box", "min": [low], "max": [low + 0.5] } });
    for shape in ["linear", "ugimp"] {
        let case = read_case(&json!({
            "title": "series", "space": "1d", "gravity": [0], "domain": { "min": [0], "max": [1.2] },
            "materials": { "soft": elastic(soft), "stiff": elastic(stiff) },
            "bodies": [half("soft", 0.0), half("stiff", 0.5)],
            "boundaries": [{ "side": "x-min", "wall": { "kind": "smooth" } }],
            "loads": [{ "kind": "traction", "body": "stiff", "side": "x-max", "value": [traction] }],
            "stages": [{ "name": "pull", "duration": 20, "damping": 0.3,
                         "equilibrium": { "unbalanced_force": 1e-5, "kinetic_energy": 1e-5 } }],
            "methods": { "mpm": { "cell_size": 0.05, "points_per_cell": 2, "shape": shape } }
        }));
        let snapshot = solve(&Mpm, &case).snapshot;
        let displacement = vectors(&snapshot, "displacement");
        for ((x, u), s) in snapshot.positions.iter().zip(&displacement).zip(stresses(&snapshot)) {
            let start = x[0] - u[0];
            // The loaded points and the nodes at the free end share the traction over a cell.
            if start < 0.9 {
                assert!((s[0] / traction - 1.0).abs() < 0.02, "{shape}: {} Pa at {start} m", s[0]);
            }
            let exact = traction * (start.min(0.5) / soft + (start - 0.5).max(0.0) / stiff);
            assert!(
                (u[0] - exact).abs() < 0.02 * traction * 0.5 / soft,
                "{shape}: {} m for {exact} at {start}",
                u[0]
            );
        }
    }
}

#[test]
fn only_laws_that_start_from_the_stress_of_a_point_are_reset() {
    let refused = |change: &dyn Fn(&mut Value)| {
        let mut text = json!({
            "title": "bar", "space": "1d", "domain": { "min": [0], "max": [4] }, "gravity": [0],
            "materials": { "m": { "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0], "max": [3] },
                         "stress": { "kind": "uniform", "value": [7, 0, 0, 0, 0, 0] } }],
            "stages": [{ "name": "s", "duration": 1 }],
            "methods": { "mpm": { "cell_size": 1, "points_per_cell": 3, "shape": "linear", "integration": "mixed",
                                  "mixed_reset": true } }
        });
        change(&mut text);
        let case = read_case(&text);
        Mpm.build(&case).map(|_| ()).map_err(|error| (error.path.clone(), error.problem()))
    };
    assert_eq!(refused(&|_| {}), Ok(()));
    let hyperelastic =
        json!({ "model": "neo-hookean", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 });
    let (path, problem) = refused(&|text| {
        text["materials"]["m"] = hyperelastic.clone();
        text["bodies"][0]["stress"] = json!({ "kind": "none" });
    })
    .unwrap_err();
    assert_eq!(path, "methods.mpm.mixed_reset");
    assert!(problem.contains("\"m\" (neo-hookean)"), "{problem}");
    let two_materials = |text: &mut Value| {
        text["materials"]["other"] = text["materials"]["m"].clone();
        let shape = json!({ "kind": "box", "min": [3], "max": [4] });
        let next = json!({ "name": "next", "material": "other", "shape": shape });
        text["bodies"].as_array_mut().unwrap().push(next);
    };
    let (path, problem) = refused(&two_materials).unwrap_err();
    assert_eq!(path, "methods.mpm.mixed_reset");
    assert!(problem.contains("\"b\" and \"next\""), "{problem}");
    let points = refused(&|text| text["methods"]["mpm"]["integration"] = json!("points"));
    assert_eq!(points.unwrap_err().1, "needs integration mixed or gauss");
}
