//! Bar in tension with a localisation band: the band length is the cell size (sheet: constitutive §2.16).

use colluvium_case::Case;
use colluvium_mpm::Mpm;
use colluvium_testkit::cohesive_bar::{
    self, ENERGY, LENGTH, PULL_SPEED, WEAK_STRENGTH_RATIO, cohesive_material,
};
use colluvium_testkit::{read_case, start_solver};
use serde_json::{Value, json};

/// A bar of so many cells with a weak one in its middle, held on the left and pulled on the right.
fn bar(cells: u32, mpm: &Value) -> Case {
    let cell = LENGTH / f64::from(cells);
    let part = |name: &str, material: &str, from: f64, to: f64| json!({ "name": name, "material": material, "shape": { "kind": "box", "min": [from], "max": [to] } });
    let (near, far) = (f64::from(cells / 2) * cell, f64::from(cells / 2 + 1) * cell);
    let mut methods = json!({ "cell_size": cell, "points_per_cell": 2 });
    methods.as_object_mut().unwrap().extend(mpm.as_object().unwrap().clone());
    read_case(&json!({
        "title": "bar", "space": "1d", "gravity": [0], "domain": { "min": [-4.0 * cell], "max": [LENGTH + 4.0 * cell] },
        "materials": { "strong": cohesive_material(1.0, ENERGY), "weak": cohesive_material(WEAK_STRENGTH_RATIO, ENERGY) },
        "bodies": [part("near", "strong", -2.0 * cell, near), part("middle", "weak", near, far),
                   part("far", "strong", far, LENGTH + 2.0 * cell)],
        "patches": [
            { "name": "left", "region": { "kind": "box", "min": [-4.0 * cell], "max": [0] } },
            { "name": "right", "region": { "kind": "box", "min": [LENGTH], "max": [LENGTH + 4.0 * cell] } }],
        "stages": [{ "name": "pull", "duration": 20, "motions": [
            { "target": "left", "velocity": [0] }, { "target": "right", "velocity": [PULL_SPEED] }] }],
        "methods": { "mpm": methods }
    }))
}

/// Work of the end over the fracture energy.
fn work_over_energy(case: &Case) -> f64 {
    cohesive_bar::work_over_energy(&mut *start_solver(&Mpm, case), &(0.1 * LENGTH..0.35 * LENGTH))
}

#[test]
fn a_bar_in_tension_dissipates_its_fracture_energy() {
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
