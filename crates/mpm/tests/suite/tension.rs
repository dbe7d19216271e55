//! Liquids that hang together where real ones open.

use colluvium_case::{Case, Method, RunOptions, run_method};
use colluvium_mpm::Mpm;
use serde_json::{Value, json};

/// A liquid 1 m high whose upper part begins under a tension (Pa), with the strength against that.
fn hanging(tension: f64, strength: f64, gravity: f64) -> Case {
    let water = json!({ "model": "newtonian-fluid", "density": 1000, "bulk_modulus": 1e6, "viscosity": 0.1,
                        "cavitation_strength": strength });
    let stress = json!({ "kind": "uniform", "value": [tension, tension, tension, 0, 0, 0] });
    let text = json!({
        "title": "hanging", "space": "plane-strain", "domain": { "min": [0, 0], "max": [1, 2] }, "gravity": [0, -gravity],
        "materials": { "water": water },
        "bodies": [
            { "name": "calm", "material": "water", "shape": { "kind": "box", "min": [0.2, 0], "max": [0.8, 0.5] } },
            { "name": "torn", "material": "water", "shape": { "kind": "box", "min": [0.2, 0.5], "max": [0.8, 1] },
              "stress": stress }
        ],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }],
        "stages": [{ "name": "s", "duration": 0.002 }],
        "output": { "measures": 0.0005 },
        "methods": { "mpm": { "cell_size": 0.1 } }
    });
    Case::from_json(&text.to_string()).unwrap()
}

fn remarks(case: &Case) -> Vec<String> {
    Mpm.plan(case).unwrap();
    run_method(&Mpm, case, &RunOptions { method: "mpm".into(), ..RunOptions::default() }).unwrap().remarks
}

#[test]
fn a_liquid_in_more_tension_than_its_weight_makes_is_remarked_once() {
    // ρ g h is 5 kPa.
    let found = remarks(&hanging(2e4, 1e5, 10.0));
    let [remark] = found.as_slice() else { panic!("{found:?}") };
    for part in [
        "t = 0 s: 100 % of the liquid \"torn\"",
        "5.000e3 Pa",
        "point ",
        "2.000e4 Pa",
        "materials.water.cavitation_strength",
    ] {
        assert!(remark.contains(part), "{remark}");
    }
    assert!(remarks(&hanging(2e3, 1e5, 10.0)).is_empty(), "less than its weight");
    assert!(remarks(&hanging(0.0, 0.0, 10.0)).is_empty(), "it opens");
    assert!(remarks(&hanging(2e4, 1e5, 0.0)).is_empty(), "nothing to compare with");
}

/// A still liquid 1 m deep on cells of 0.0625 m, its modulus `stiffness` times `ρgH`.
fn still(stiffness: f64, mpm: &Value) -> Case {
    let mut methods = json!({ "cell_size": 0.0625, "points_per_cell": 2 });
    methods.as_object_mut().unwrap().extend(mpm.as_object().unwrap().clone());
    let wall = |side: &str| json!({ "side": side, "wall": { "kind": "smooth" } });
    let text = json!({
        "title": "tank", "space": "plane-strain", "domain": { "min": [0, 0], "max": [1, 1.5] }, "gravity": [0, -10],
        "materials": { "m": { "model": "newtonian-fluid", "density": 1000, "bulk_modulus": 1e4 * stiffness } },
        "bodies": [{ "name": "water", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 1] },
                     "velocity": { "kind": "uniform", "value": [0.01, 0] },
                     "stress": { "kind": "k0", "surface": 1.0, "coefficient": 1 } }],
        "boundaries": [wall("x-min"), wall("x-max"), wall("y-min")],
        "stages": [{ "name": "s", "duration": 2 }], "output": { "measures": 0.05 },
        "methods": { "mpm": methods }
    });
    colluvium_testkit::cases::changed(text, &json!({}))
}

#[test]
fn liquids_at_rest_are_told_of_what_grows_in_them() {
    let told = |stiffness: f64, mpm: &Value| Mpm.plan(&still(stiffness, mpm)).unwrap().warnings.join("\n");
    let soft = "its bulk modulus is less than 200 ρgH, 2.00e6 Pa";
    assert!(told(100.0, &json!({ "shape": "linear" })).contains(soft));
    for (stiffness, mpm) in [
        (250.0, json!({ "shape": "linear" })),
        (100.0, json!({ "shape": "ugimp" })),
        (100.0, json!({ "shape": "linear", "integration": "mixed" })),
        (100.0, json!({ "shape": "quadratic", "volumetric_strain": "cell-average" })),
    ] {
        assert!(!told(stiffness, &mpm).contains("at rest"), "{mpm}");
    }
    let shared = |shape: &str| json!({ "shape": shape, "volumetric_strain": "cell-average" });
    let averages = "methods.mpm.volumetric_strain: in the liquid water at rest";
    assert!(told(250.0, &shared("linear")).contains(averages));
    assert!(
        !told(100.0, &shared("ugimp")).contains(averages) && told(60.0, &shared("ugimp")).contains(averages)
    );
}

/// Averaged volumetric strains of linear functions make energy in a liquid at rest, the own ones of GIMP do not.
#[test]
fn energy_that_grows_of_itself_is_told() {
    let of = |shape: &str, volumetric: &str| {
        let report = colluvium_testkit::cases::solve(
            &Mpm,
            &still(100.0, &json!({ "shape": shape, "volumetric_strain": volumetric })),
        );
        let total = report.table.column("total_energy").unwrap();
        let parts = ["kinetic_energy", "elastic_energy", "potential_energy"]
            .map(|name| report.table.column(name).unwrap());
        for (row, total) in total.iter().enumerate() {
            assert!((parts.iter().map(|part| part[row]).sum::<f64>() - total).abs() < 1e-9 * total.abs());
        }
        report.remarks.join("\n")
    };
    let made = of("linear", "cell-average");
    assert!(made.contains("the total energy has grown by"), "{made}");
    let kept = of("ugimp", "point");
    assert!(!kept.contains("has grown"), "{kept}");
}

/// The most kinetic energy of a run over that of its start.
fn most_energy(case: &Case) -> f64 {
    let report = colluvium_testkit::cases::solve(&Mpm, case);
    let energies = report.table.column("kinetic_energy").unwrap();
    energies.iter().fold(0.0f64, |most, energy| most.max(energy / energies[0]))
}

/// Points of liquids keep a share of their own volumetric strain that grows with their pressure; without it velocities grow by 26/s.
#[test]
fn a_still_liquid_with_shared_strains_makes_no_energy() {
    for volumetric in ["cell-average", "nodal"] {
        for stress_update in ["musl", "usl"] {
            for (gravity, cell) in [(5.0, 0.0625), (10.0, 0.125)] {
                let mpm = json!({ "shape": "ugimp", "volumetric_strain": volumetric, "stress_update": stress_update, "cell_size": cell });
                let mut column = still(100.0, &mpm);
                (column.gravity, column.stages[0].duration) = (vec![0.0, -gravity], 1.0);
                let mut closed = column.clone();
                (closed.gravity, closed.domain.max) = (vec![0.0, 0.0], vec![1.0, 1.0]);
                let pressure = -1e3 * gravity;
                let stress = json!({ "kind": "uniform", "value": [pressure, pressure, pressure, 0, 0, 0] });
                closed.bodies[0].stress = serde_json::from_value(stress).unwrap();
                let lid = json!({ "side": "y-max", "wall": { "kind": "smooth" } });
                closed.boundaries.push(serde_json::from_value(lid).unwrap());
                for case in [column, closed] {
                    let most = most_energy(&case);
                    // Stress last, on eight cells over the depth, is the one that still gains: 1.37 in this time.
                    let bound = if stress_update == "usl" && cell > 0.1 { 1.5 } else { 1.0 + 1e-9 };
                    assert!(most < bound, "{mpm}, {:?} m/s²: {most}", case.gravity);
                }
            }
        }
    }
}
