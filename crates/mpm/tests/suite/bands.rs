//! A bar of cells that a band may cut, pulled apart: the length of a band is that of a cell (sheet: constitutive §2.16).

use colluvium_case::Case;
use serde_json::{Value, json};

use crate::common::{begin, changed, stresses};

/// Young's modulus and tensile strength (Pa), fracture energy (J/m²) and density (kg/m³): the bar is a fourth of `E G/f_t²` long.
const STIFFNESS: f64 = 1e8;
const STRENGTH: f64 = 1e3;
const ENERGY: f64 = 0.04;
const DENSITY: f64 = 1000.0;
/// Length of the bar (m) and speed of its end (m/s), a tenth of `f_t/√(E ρ)`.
const LENGTH: f64 = 1.0;
const PULL: f64 = 0.0003;

/// A bar of so many cells with a weak one in its middle, held on the left and pulled on the right.
fn bar(cells: u32, mpm: &Value) -> Case {
    let cell = LENGTH / f64::from(cells);
    let concrete = |share: f64| {
        json!({
            "model": "double-scale", "density": DENSITY, "youngs_modulus": STIFFNESS, "poissons_ratio": 0,
            "band": { "law": "cohesive-damage", "tensile_strength": share * STRENGTH, "fracture_energy": ENERGY,
                      "stiffness": 1e4 * STRENGTH * STRENGTH / ENERGY }
        })
    };
    let part = |name: &str, material: &str, from: f64, to: f64| json!({ "name": name, "material": material, "shape": { "kind": "box", "min": [from], "max": [to] } });
    let (near, far) = (f64::from(cells / 2) * cell, f64::from(cells / 2 + 1) * cell);
    let mut methods = json!({ "cell_size": cell, "points_per_cell": 2 });
    methods.as_object_mut().unwrap().extend(mpm.as_object().unwrap().clone());
    changed(
        json!({
            "title": "bar", "space": "1d", "gravity": [0], "domain": { "min": [-4.0 * cell], "max": [LENGTH + 4.0 * cell] },
            "materials": { "strong": concrete(1.0), "weak": concrete(0.95) },
            "bodies": [part("near", "strong", -2.0 * cell, near), part("middle", "weak", near, far),
                       part("far", "strong", far, LENGTH + 2.0 * cell)],
            "patches": [
                { "name": "left", "region": { "kind": "box", "min": [-4.0 * cell], "max": [0] } },
                { "name": "right", "region": { "kind": "box", "min": [LENGTH], "max": [LENGTH + 4.0 * cell] } }],
            "stages": [{ "name": "pull", "duration": 20, "motions": [
                { "of": "left", "velocity": [0] }, { "of": "right", "velocity": [PULL] }] }],
            "methods": { "mpm": methods }
        }),
        &json!({}),
    )
}

/// Work of the end over the fracture energy, to six times the opening over which the strength falls to 1/e.
fn work_over_energy(case: &Case) -> f64 {
    let mut solver = begin(case);
    let (mut before, mut sum) = (0.0, 0.0);
    while PULL * solver.time() < 6.0 * ENERGY / STRENGTH {
        let from = solver.time();
        for _ in 0..20 {
            let step = solver.limit().dt;
            solver.step(step).unwrap();
        }
        let snapshot = solver.snapshot();
        let whole = (0.1 * LENGTH)..(0.35 * LENGTH);
        let all = stresses(&snapshot).into_iter().zip(&snapshot.positions);
        let of: Vec<f64> = all.filter(|(_, x)| whole.contains(&x[0])).map(|(s, _)| s[0]).collect();
        let mean = of.iter().sum::<f64>() / of.len() as f64;
        sum += 0.5 * (before + mean) * PULL * (solver.time() - from);
        before = mean;
    }
    sum / ENERGY
}

#[test]
fn a_bar_that_is_pulled_apart_spends_its_fracture_energy() {
    for (shape, cells, points) in [
        ("linear", 21, 2),
        ("ugimp", 21, 2),
        ("ugimp", 41, 3),
        ("cpgimp", 21, 2),
        ("quadratic", 21, 2),
        ("quadratic", 41, 2),
    ] {
        let found = work_over_energy(&bar(cells, &json!({ "shape": shape, "points_per_cell": points })));
        assert!((found - 1.0).abs() < 0.05, "{shape}, {cells} cells, {points} points: {found}");
    }
}
