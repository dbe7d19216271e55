//! Prescribed pore pressures on the surface of a body.

use colluvium_case::{Case, FieldData};
use colluvium_mpm::Mpm;
use colluvium_testkit::{read_case, scalars, solve};
use serde_json::{Value, json};

use crate::boundary::elastic_block;

#[test]
fn the_force_of_a_varying_pore_pressure_on_the_fluid_is_its_mean() {
    // n times the force on the fluid is its momentum: Σ M̄_L a_L = n Σ f_L.
    let text = json!([{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.35, 0.35], "max": [0.65, 0.65] },
                        "pore_fluid": { "porosity": 0.4, "intrinsic_permeability": 1e-6 } }]);
    let load = json!({ "kind": "pore-pressure", "body": "b", "side": "x-min", "value": 1e3,
                       "profile": { "axis": "y", "shares": [[0.35, 0], [0.65, 1]] } });
    let mut solver = elastic_block().with(json!({ "bodies": text, "loads": [load] })).start(&Mpm);
    let dt = solver.limit().dt;
    solver.step(dt).unwrap();
    let momentum = solver.totals().liquid.unwrap().momentum;
    // The liquid's share of the points has changed a little by the end of the step.
    assert!((momentum[0] / dt / (0.4 * 150.0) - 1.0).abs() < 1e-3, "{momentum:?}");
}

#[test]
fn water_at_the_boundary_fills_the_pores_with_its_pressure() {
    let text = json!({
        "title": "soak", "space": "1d", "domain": { "min": [0], "max": [1.1] }, "gravity": [0],
        "materials": { "m": { "model": "linear-elastic", "density": 1590, "youngs_modulus": 1e7, "poissons_ratio": 0 } },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0], "max": [1] },
                     "pore_fluid": { "porosity": 0.4, "intrinsic_permeability": 1.019367991845056e-10 } }],
        "boundaries": [{ "side": "x-min", "wall": { "kind": "rough" } }],
        "loads": [{ "kind": "pore-pressure", "body": "b", "side": "x-max", "value": 1e4, "ramp": 0.02 }],
        "stages": [{ "name": "s", "duration": 2.5 }],
        "methods": { "mpm": { "cell_size": 0.1, "points_per_cell": 1, "shape": "linear" } }
    });
    let snapshot = solve(&Mpm, &read_case(&text)).snapshot;
    let Some(FieldData::Tensor(effective)) = snapshot.field("stress").map(|f| &f.data) else {
        panic!("no stress")
    };
    // No total stress: the skeleton swells. After T = 2.5 consolidation lacks 0.3 %. The load is spread over the outermost
    // cell, whose point has the share of the end node.
    for ((x, pressure), stress) in
        snapshot.positions.iter().zip(scalars(&snapshot, "pore_pressure")).zip(effective)
    {
        let exact = if x[0] < 0.9 { 1e4 } else { 1e5 * (x[0] - 0.9) };
        assert!((pressure / exact - 1.0).abs() < 0.01, "{pressure}");
        assert!((stress.0[0] / exact - 1.0).abs() < 0.01, "{stress:?}");
    }
}

#[test]
fn boundary_pressures_of_the_fluid_need_pores_and_no_impermeable_wall() {
    let with = |body: &str, walls: Value| {
        let mut text: Value = serde_json::from_str(&elastic_block().build().to_json()).unwrap();
        text["bodies"][0]["pore_fluid"] = json!({ "porosity": 0.4, "intrinsic_permeability": 1e-10 });
        text["bodies"].as_array_mut().unwrap().push(
            json!({ "name": "dry", "material": "m", "shape": { "kind": "box", "min": [0.65, 0], "max": [0.9, 0.3] } }),
        );
        text["boundaries"] = walls;
        text["loads"] = json!([{ "kind": "pore-pressure", "body": body, "side": "x-min", "value": 10 }]);
        Case::from_json(&text.to_string()).map(|_| ()).map_err(|errors| errors.to_string())
    };
    assert_eq!(with("b", json!([])), Ok(()));
    assert!(with("dry", json!([])).unwrap_err().contains("loads[0].body"));
    let wall = |drained: bool| json!([{ "side": "x-min", "position": 0.35, "wall": { "kind": "smooth" }, "drained": drained }]);
    assert!(with("b", wall(false)).unwrap_err().contains("loads[0].side"));
    assert_eq!(with("b", wall(true)), Ok(()));
}
