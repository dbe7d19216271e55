//! Sheets under fluid pressure, and cyclic paths and paths of constant volume, in space (sheet: dem §3.7, §3.8).

use std::f64::consts::FRAC_PI_6;

use colluvium_case::{Case, Solver};
use colluvium_dem::{DemSolver, spheres};
use colluvium_testkit::{assert_near, read_case, scalar_output};
use serde_json::{Value, json};

use crate::single_grains::{Scene, begun, linear};

fn to(solver: &mut DemSolver<3, 3>, time: f64) {
    while solver.time() < time * (1.0 - 1e-12) {
        let dt = (time - solver.time()).min(solver.limit().dt);
        solver.step(dt).unwrap();
    }
}

/// Single sphere at a place, and a sheet of grains at the given places, which a fluid presses towards it.
fn sheet(places: &[[f64; 3]], sphere: [f64; 3], membrane: &Value) -> Result<DemSolver<3, 3>, String> {
    sheet_between(places, sphere, membrane, &json!({}), &json!([]))
}

/// Sphere and sheet between walls that the stage presses.
fn sheet_between(
    places: &[[f64; 3]],
    sphere: [f64; 3],
    membrane: &Value,
    pressed: &Value,
    walls: &Value,
) -> Result<DemSolver<3, 3>, String> {
    let folder = tempfile::tempdir().unwrap();
    let lines: Vec<String> = places.iter().map(|[x, y, z]| format!("{x},{y},{z},0.1")).collect();
    std::fs::write(folder.path().join("sheet.csv"), format!("x,y,z,volume\n{}\n", lines.join("\n"))).unwrap();
    let mut scene = Scene::new(linear(1e6, 0.0, 0.5, 0.3)).sphere(sphere, 0.3, [0.0; 3], [0.0; 3]);
    scene.gravity = vec![0.0; 3];
    let mut value = scene.json();
    value["bodies"].as_array_mut().unwrap().push(json!({
        "name": "sheet", "material": "grain", "points": { "file": "sheet.csv" },
        "shape": { "kind": "difference", "from": { "kind": "box", "min": [-1.5, -1.5, -1], "max": [3.5, 3.5, 2] },
                   "cut": { "kind": "ball", "centre": sphere, "radius": 0.31 } }
    }));
    value["boundaries"] = walls.clone();
    value["methods"]["dem"]["stages"] =
        json!({ "all": { "membranes": { "sheet": membrane }, "walls": pressed } });
    let case = Case::from_value(&value, folder.path()).unwrap();
    spheres(&case).map(begun).map_err(|error| error.to_string())
}

#[test]
fn membrane_force_in_space_is_pressure_times_the_area_vector_of_its_rim() {
    // Three rows of four, bent within; the rim is a tilted rectangle of 3 m by 2 m.
    let place = |row: usize, column: usize| {
        let bulge = if row == 1 && (column == 1 || column == 2) { 0.4 } else { 0.0 };
        [column as f64, row as f64, 0.5 * row as f64 + bulge]
    };
    let places: Vec<[f64; 3]> = (0..3).flat_map(|row| (0..4).map(move |column| place(row, column))).collect();
    for side in [-1.0, 1.0] {
        let membrane = json!({ "pressure": 20.0, "against": "grain 0", "columns": 4 });
        let mut solver = sheet(&places, [1.5, 1.0, 0.5 + 8.0 * side], &membrane).unwrap();
        let time = 1e-3;
        to(&mut solver, time);
        // The area vector of the rim is (3, 0, 0) × (0, 2, 1), for any shape of the sheet within.
        let then = time - solver.limit().dt;
        let momentum = solver.totals().momentum;
        for (momentum, area) in momentum.into_iter().zip([0.0, -3.0, 6.0]) {
            assert_near(momentum / (20.0 * then), area * side, 0.05 * 6.0);
        }
        // A grain at a corner has a quarter of one flat piece, (1, 0, 0) × (0, 1, 1/2), bent up by the bulge at its far corner:
        // half of (1, 1, 0.5 + 0.4) × (-1, 1, 0.5).
        let v = solver.snapshot().vectors("velocity").unwrap()[1];
        let mass = 0.1 * 4.0 / std::f64::consts::PI;
        for (v, area) in v.into_iter().zip([0.5 * (0.5 - 0.9), 0.5 * (-0.9 - 0.5), 0.5 * (1.0 + 1.0)]) {
            assert_near(v * mass / (20.0 * time), 0.25 * area * side, 1e-3);
        }
        assert_near(scalar_output(&solver, "energy_error"), 0.0, 1e-6);
    }
}

#[test]
fn pressure_on_a_sleeve_acts_inwards_with_zero_resultant() {
    // Three rings of six, one above another at 0.7 m, of radius 1 m: the sides of a hexagon are 1 m long.
    let ring = |row: usize| {
        (0..6usize).map(move |k| {
            let (sin, cos) = (2.0 * FRAC_PI_6 * k as f64).sin_cos();
            [cos, sin, 0.7 * row as f64]
        })
    };
    let places: Vec<[f64; 3]> = (0..3).flat_map(ring).collect();
    let membrane = json!({ "pressure": 50.0, "against": "grain 0", "columns": 6, "closed": true });
    let mut solver = sheet(&places, [0.0, 0.0, 7.0], &membrane).unwrap();
    let time = 1e-3;
    to(&mut solver, time);
    let mass = 0.1 * 4.0 / std::f64::consts::PI;
    for c in 0..3 {
        assert_near(solver.totals().momentum[c], 0.0, 1e-12);
    }
    let v = solver.snapshot().vectors("velocity").unwrap().to_vec();
    for k in 0..6usize {
        // The middle ring takes half of the sides below and above, each halved between its ends, as a resultant along the radius.
        let exact = -50.0 * 0.7 * FRAC_PI_6.cos() * time / mass;
        let (sin, cos) = (2.0 * FRAC_PI_6 * k as f64).sin_cos();
        let own = v[1 + 6 + k];
        assert_near((own[0] * cos + own[1] * sin) / exact, 1.0, 1e-3);
        assert_near((own[1] * cos - own[0] * sin) / exact, 0.0, 1e-3);
        assert_near(own[2] / exact, 0.0, 1e-9);
    }
}

#[test]
fn platen_stress_on_a_sleeve_acts_on_the_area_enclosed_by_its_rings() {
    // A single sphere carries it, in the middle of two rings of six, of radius 0.8 and 1.45 m, without pressure.
    let ring = |(radius, z): (f64, f64)| {
        (0..6usize).map(move |k| {
            let (sin, cos) = (2.0 * FRAC_PI_6 * k as f64).sin_cos();
            [radius * cos, radius * sin, z]
        })
    };
    let places: Vec<[f64; 3]> = [(0.8, 0.3), (1.45, 0.3)].into_iter().flat_map(ring).collect();
    let membrane = json!({ "pressure": 0.0, "against": "grain 0", "columns": 6, "closed": true });
    let walls = json!([
        { "side": "z-min", "name": "base", "position": 0.0, "wall": { "kind": "smooth" } },
        { "side": "z-max", "name": "top", "position": 1.5, "wall": { "kind": "smooth" } }
    ]);
    let pressed = json!({ "top": { "stress": -100.0, "speed": 1.0, "sleeve": "sheet" } });
    let mut solver = sheet_between(&places, [0.0, 0.0, 0.75], &membrane, &pressed, &walls).unwrap();
    to(&mut solver, 3.0);
    let area = 0.5 * 1.5 * 3f64.sqrt() * (0.8 * 0.8 + 1.45 * 1.45);
    assert_near(scalar_output(&solver, "wall.top.stress"), -100.0, 0.2);
    assert_near(solver.reaction("top").unwrap().force[2], 100.0 * area, 0.2 * area);
}

/// Ball in a sleeve of rings of eight, with the options of the sleeve.
fn rings(fill: &Value, diameter: f64, membrane: &Value) -> Result<DemSolver<3, 3>, String> {
    let mut scene = Scene::new(linear(1e6, 0.0, 0.5, 0.3)).sphere([0.0, 0.0, 1.0], 0.3, [0.0; 3], [0.0; 3]);
    scene.gravity = vec![0.0; 3];
    scene.boundaries = json!([
        { "side": "z-min", "name": "base", "position": 0.0, "wall": { "kind": "smooth" } },
        { "side": "z-max", "name": "top", "position": 2.0, "wall": { "kind": "smooth" } }
    ]);
    let mut value = scene.json();
    value["materials"]["rubber"] = value["materials"]["grain"].clone();
    let cylinder = |radius: f64| json!({ "kind": "cylinder", "base": [0, 0, 0], "axis": 2, "height": 2, "radius": radius });
    value["bodies"].as_array_mut().unwrap().push(json!({ "name": "sleeve", "material": "rubber",
        "shape": { "kind": "difference", "from": cylinder(1.3), "cut": cylinder(0.9) } }));
    let own = &mut value["methods"]["dem"];
    own["mix"] = json!(true);
    let mut pair = own["pairs"][0].clone();
    pair["between"] = json!(["rubber", "rubber"]);
    own["pairs"].as_array_mut().unwrap().push(pair);
    own["grains"]["rubber"] = json!({ "density": 1000, "fill": fill,
        "diameter": { "distribution": "equal", "value": diameter } });
    own["stages"] = json!({ "all": { "membranes": { "sleeve": membrane } } });
    let case = Case::from_json(&value.to_string()).map_err(|errors| errors.to_string())?;
    spheres(&case).map(begun).map_err(|error| error.to_string())
}

#[test]
fn rings_of_a_sleeve_lie_on_the_tube_at_the_grain_spacing() {
    let fill = json!({ "kind": "sleeve", "columns": 8 });
    let membrane = json!({ "pressure": 0.0, "against": "grain 0", "columns": 8, "closed": true });
    let solver = rings(&fill, 0.2, &membrane).unwrap();
    let frame = solver.snapshot();
    let own: Vec<[f64; 3]> =
        (0..frame.ids.len()).filter(|&i| frame.bodies[i] == 1).map(|i| frame.positions[i]).collect();
    // Sides of an octagon of radius 1 m are 0.765 m long: three rings within 2 m.
    assert_eq!(own.len(), 24);
    for (k, x) in own.iter().enumerate() {
        assert_near(x[0].hypot(x[1]), 1.0, 1e-12);
        assert_near(x[2], 2.0 / 3.0 * ((k / 8) as f64 + 0.5), 1e-12);
        let next = own[k / 8 * 8 + (k + 1) % 8];
        assert_near((x[0] - next[0]).hypot(x[1] - next[1]), 2.0 * (std::f64::consts::PI / 8.0).sin(), 1e-12);
    }
    // The octagon, and its prism between the platens.
    assert_near(scalar_output(&solver, "membrane.sleeve.area"), 8f64.sqrt(), 1e-12);
    assert_near(scalar_output(&solver, "membrane.sleeve.volume"), 2.0 * 8f64.sqrt(), 1e-12);
}

#[test]
fn a_restart_of_a_sleeve_with_reordered_grains_is_bit_identical() {
    let fill = json!({ "kind": "sleeve", "columns": 8 });
    let membrane = json!({ "pressure": 200.0, "against": "grain 0", "columns": 8, "closed": true });
    let made = || rings(&fill, 0.2, &membrane).unwrap();
    let mut solver = made();
    let area = scalar_output(&solver, "membrane.sleeve.area");
    to(&mut solver, 0.6);
    assert!(scalar_output(&solver, "membrane.sleeve.area") < 0.8 * area);
    let mut again = made();
    again.restore(&mut &solver.checkpoint_bytes().unwrap()[..]).unwrap();
    assert_eq!(scalar_output(&solver, "membrane.sleeve.area"), scalar_output(&again, "membrane.sleeve.area"));
    again.begin_stage(0, 0.0).unwrap();
    for solver in [&mut solver, &mut again] {
        to(solver, 0.8);
    }
    assert_eq!(solver.checkpoint_bytes().unwrap(), again.checkpoint_bytes().unwrap());
}

#[test]
fn sleeves_that_do_not_fit_their_tube_or_their_membrane_are_refused() {
    let membrane = |columns: usize, closed: bool| json!({ "pressure": 1.0, "against": "grain 0", "columns": columns, "closed": closed });
    let sleeve = |columns: usize| json!({ "kind": "sleeve", "columns": columns });
    for (fill, diameter, membrane, expected) in [
        (sleeve(2), 0.2, membrane(8, true), "2 is less than three grains around a sleeve"),
        (
            sleeve(8),
            0.5,
            membrane(8, true),
            "the diameter of the grains, 0.5 m, is larger than the thickness of the tube",
        ),
        (sleeve(40), 0.2, membrane(40, true), "40 grains of 0.2 m do not fit into a ring"),
        (
            sleeve(8),
            0.2,
            membrane(8, false),
            "filled with rings of 8 grains: set columns to 8 and closed to true",
        ),
        (
            sleeve(8),
            0.2,
            membrane(12, true),
            "filled with rings of 8 grains: set columns to 8 and closed to true",
        ),
    ] {
        let refusal = rings(&fill, diameter, &membrane).err().unwrap();
        assert!(refusal.contains(expected), "{refusal}");
    }
}

#[test]
fn sheets_without_complete_rows_of_grains_are_refused() {
    let places: Vec<[f64; 3]> = (0..6).map(|k| [f64::from(k % 3), f64::from(k / 3), 0.0]).collect();
    let membrane = |more: Value| {
        let mut value = json!({ "pressure": 1.0, "against": "grain 0" });
        value.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        value
    };
    for (more, expected) in [
        (json!({}), "columns: is missing"),
        (json!({ "columns": 1 }), "columns: a row needs at least two grains"),
        (json!({ "columns": 2, "closed": true }), "columns: a row needs at least two grains, or three if"),
        (json!({ "columns": 4 }), "columns: the body has 6 grains, which do not form two or more rows of 4"),
        (json!({ "columns": 6 }), "columns: the body has 6 grains, which do not form two or more rows of 6"),
    ] {
        let refusal = sheet(&places, [0.0, 0.0, 5.0], &membrane(more)).err().unwrap();
        assert!(
            refusal.starts_with(&format!("methods.dem.stages.all.membranes.sheet.{expected}")),
            "{refusal}"
        );
    }
}

/// Cubic lattice of four by four by four spheres in a cell that is periodic along all axes.
fn lattice(cell: &Value) -> DemSolver<3, 3> {
    let mut scene = Scene::new(linear(1e4, 0.3, 0.5, 0.0)).sphere([0.0; 3], 0.5, [0.0; 3], [0.0; 3]);
    scene.gravity = vec![0.0; 3];
    let mut value = scene.json();
    value["domain"] = json!({ "min": [0, 0, 0], "max": [4, 4, 4], "periodic": ["x", "y", "z"] });
    value["bodies"] = json!([{ "name": "one", "material": "grain",
        "shape": { "kind": "box", "min": [0, 0, 0], "max": [4, 4, 4] } }]);
    value["methods"]["dem"]["bodies"] = json!({});
    value["methods"]["dem"]["grains"]["grain"] = json!({ "density": 1.0, "diameter": { "distribution": "equal", "value": 1 },
        "fill": { "kind": "lattice", "packing": "square" } });
    value["methods"]["dem"]["stages"] = json!({ "all": { "cell": cell } });
    begun(spheres(&read_case(&value)).unwrap())
}

#[test]
fn an_undrained_path_in_space_keeps_the_volume_and_loads_the_columns_of_a_lattice() {
    let rate: f64 = 5e-4;
    let cell = json!({ "xx": { "rate": 0.5 * rate }, "yy": { "rate": 0.5 * rate }, "zz": { "rate": -rate } });
    let mut solver = lattice(&cell);
    to(&mut solver, 20.0);
    let sides = ["x", "y", "z"].map(|axis| scalar_output(&solver, &format!("cell.{axis}")));
    // Up to the square of the strain in a step, over all steps.
    assert_near(sides.iter().product::<f64>() / 64.0, 1.0, 1e-8);
    let length = (-20.0 * rate).exp();
    assert_near(sides[2] / 4.0 / length, 1.0, 1e-6);
    // One contact in each column: force times branch over the volume of a grain's cube, which is one. Grains along x and y have separated.
    assert_near(scalar_output(&solver, "cell_stress.zz") / (-1e4 * (1.0 - length) * length), 1.0, 2e-3);
    for entry in ["xx", "yy"] {
        assert_near(scalar_output(&solver, &format!("cell_stress.{entry}")), 0.0, 0.1);
    }
}

#[test]
fn a_cell_in_space_follows_a_cyclic_stress() {
    let cell = json!({ "xx": { "rate": 0 }, "yy": { "rate": 0 },
        "zz": { "cyclic-stress": { "mean": -50, "amplitude": 40, "period": 8 } } });
    let mut solver = lattice(&cell);
    let mut extremes = (0.0f64, f64::NEG_INFINITY);
    to(&mut solver, 8.0);
    while solver.time() < 16.0 {
        let next = solver.time() + 0.1;
        to(&mut solver, next);
        let stress = scalar_output(&solver, "cell_stress.zz");
        extremes = (extremes.0.min(stress), extremes.1.max(stress));
    }
    assert_near(extremes.0, -90.0, 3.0);
    assert_near(extremes.1, -10.0, 3.0);
}
