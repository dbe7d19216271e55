//! Sheets of sand that slide on floors (docs/theory/mpm.md, walls).

use colluvium_case::{Case, Method};
use colluvium_mpm::Mpm;
use colluvium_testkit::{advance_steps, read_case, start_solver};
use serde_json::{Value, json};

const GRAVITY: f64 = 9.81;
/// Edge of a cell (m).
const CELL: f64 = 0.1;

/// A sheet of sand of so many cells that moves at 1 m/s over a floor without end.
fn sheet(cells: f64, wall: &Value) -> Case {
    let thickness = cells * CELL;
    let sand = json!({ "model": "mohr-coulomb", "density": 1600, "youngs_modulus": 1e6, "poissons_ratio": 0.3, "friction_angle": 35 });
    let text = json!({
        "title": "sheet", "space": "plane-strain", "gravity": [0, -GRAVITY], "materials": { "sand": sand },
        "domain": { "min": [0, 0], "max": [0.4, 1], "periodic": ["x"] },
        "bodies": [{
            "name": "sheet", "material": "sand", "shape": { "kind": "box", "min": [0, 0], "max": [0.4, thickness] },
            "velocity": { "kind": "uniform", "value": [1, 0] }, "stress": { "kind": "k0", "surface": thickness, "coefficient": 0.43 }
        }],
        "boundaries": [{ "side": "y-min", "wall": wall }],
        "stages": [{ "name": "slide", "duration": 0.2 }],
        "methods": { "mpm": { "cell_size": CELL, "points_per_cell": if cells < 1.0 { 4 } else { 2 } } }
    });
    read_case(&text)
}

/// Deceleration (m/s²).
fn deceleration(case: &Case) -> f64 {
    let mut solver = start_solver(&Mpm, case);
    let mut samples = Vec::new();
    for time in [0.03, 0.12] {
        while solver.time() < time {
            advance_steps(&mut *solver, 1);
        }
        let totals = solver.totals();
        samples.push((solver.time(), totals.momentum[0] / totals.mass));
    }
    let [(begin, from), (end, to)] = samples[..] else { panic!() };
    (from - to) / (end - begin)
}

#[test]
fn a_frictional_wall_slows_thin_sheets_and_a_rough_one_causes_a_warning() {
    let slope = 35f64.to_radians().sin();
    let wall = json!({ "kind": "frictional", "friction_coefficient": slope });
    for cells in [0.5, 1.0, 2.0, 4.0] {
        let found = deceleration(&sheet(cells, &wall));
        assert!((found / (GRAVITY * slope) - 1.0).abs() < 0.05, "{cells} cells: {found}");
        let warnings = Mpm.plan(&sheet(cells, &json!({ "kind": "rough" }))).unwrap().warnings;
        let short = format!(
            "sheet is {cells:.1} cells thick. Its friction is {:.0} % too small",
            50.0 / cells.max(0.5)
        );
        assert!(warnings.iter().any(|one| one.text.contains(&short)), "{warnings:?}");
    }
    let thick = Mpm.plan(&sheet(6.0, &json!({ "kind": "rough" }))).unwrap().warnings;
    assert!(!thick.iter().any(|one| one.text.contains("rough floor")), "{thick:?}");
}
