//! Periodic domains.

use colluvium_case::{Case, Method};
use colluvium_mpm::Mpm;
use colluvium_testkit::{
    advance_to, assert_same_after_restart, assert_same_on_threads, read_case, scalars, solve, start_solver,
    vectors,
};
use serde_json::{Value, json};

use crate::boundary::elastic_block;

/// A block that flies through periodic sides, and is crushed a little meanwhile by its own velocity.
fn drifting(shape: &str, transfer: &str, shrink: f64) -> Case {
    let motion = json!({ "kind": "linear", "value": [3.0, -2.0], "origin": [0.5, 0.5],
                         "gradient": [[-shrink, 0], [0, shrink]] });
    elastic_block()
        .with(json!({
            "domain": { "min": [0, 0], "max": [1, 1], "periodic": ["x", "y"] },
            "bodies": [{ "name": "b", "material": "m", "velocity": motion,
                         "shape": { "kind": "box", "min": [0.35, 0.35], "max": [0.65, 0.65] } }],
            "stages": [{ "name": "s", "duration": 0.7 }],
            "methods": { "mpm": { "cell_size": 0.05, "shape": shape, "transfer": transfer } }
        }))
        .build()
}

#[test]
fn a_body_passes_periodic_sides_unchanged() {
    for (shape, transfer) in [("linear", "flip"), ("ugimp", "flip"), ("cpgimp", "tpic"), ("ugimp", "xpic")] {
        let report = solve(&Mpm, &drifting(shape, transfer, 0.0));
        let snapshot = &report.snapshot;
        for ((v, u), x) in vectors(snapshot, "velocity")
            .iter()
            .zip(vectors(snapshot, "displacement"))
            .zip(&snapshot.positions)
        {
            assert!((v[0] - 3.0).abs() < 1e-11 && (v[1] + 2.0).abs() < 1e-11, "{shape}: {v:?}");
            assert!((u[0] - 2.1).abs() < 1e-11 && (u[1] + 1.4).abs() < 1e-11, "{shape}: {u:?}");
            assert!(x[..2].iter().all(|x| (0.0..=1.0).contains(x)));
        }
        assert!(scalars(snapshot, "deviatoric_stress").iter().all(|q| *q < 1e-5), "{shape}");
    }
}

#[test]
fn results_do_not_depend_on_the_position_of_the_periodic_side() {
    // A crushed block that rests in the middle of the domain, and one that begins across the seam.
    for shape in ["linear", "ugimp"] {
        let budgets = [0.0, 0.5].map(|seam: f64| {
            let mut case = drifting(shape, "flip", 0.2);
            let motion = json!({ "kind": "sine", "amplitude": [0.05, 0.0], "wave_vector": [2.0 * std::f64::consts::PI, 0] });
            let block = |low: f64, high: f64| json!({ "kind": "box", "min": [low, 0.35], "max": [high, 0.65] });
            let (low, high) = (0.35 + seam, 0.65 + seam);
            let pieces = if seam == 0.0 { vec![block(low, high)] } else { vec![block(low, 1.0), block(0.0, high - 1.0)] };
            let phase = 360.0 * -seam;
            case.bodies = pieces
                .into_iter()
                .enumerate()
                .map(|(number, shape)| {
                    let mut motion = motion.clone();
                    motion["phase"] = json!(phase);
                    serde_json::from_value(json!({
                        "name": format!("b{number}"), "material": "m", "shape": shape, "velocity": motion
                    }))
                    .unwrap()
                })
                .collect();
            case.stages[0].duration = 0.05;
            solve(&Mpm, &case).end
        });
        let [whole, cut] = budgets;
        assert!((whole.kinetic / cut.kinetic - 1.0).abs() < 1e-9, "{shape}: {whole:?}, {cut:?}");
        assert!((whole.elastic / cut.elastic - 1.0).abs() < 1e-9, "{shape}: {whole:?}, {cut:?}");
    }
}

#[test]
fn periodic_runs_are_the_same_on_any_thread_and_after_a_restart() {
    let case = drifting("ugimp", "flip", 0.5);
    assert_same_on_threads(&Mpm, &case, "drifting block");
    assert_same_after_restart(&Mpm, &case, |solver| {
        let end = if solver.time() < 0.3 { 0.3 } else { 0.5 };
        advance_to(solver, end);
    });
}

#[test]
fn unsupported_periodic_domains_are_rejected_by_key() {
    let refused = |options: Value| {
        let mut case = drifting("ugimp", "flip", 0.0);
        case.methods.insert("mpm".into(), options);
        Mpm.plan(&case).unwrap_err().to_string()
    };
    assert!(refused(json!({ "cell_size": 0.05, "shape": "quadratic" })).starts_with("domain.periodic"));
    assert!(refused(json!({ "cell_size": 0.5 })).starts_with("domain.periodic"));
    let mut text: Value = serde_json::from_str(&drifting("ugimp", "flip", 0.0).to_json()).unwrap();
    text["boundaries"] = json!([{ "side": "x-min", "wall": { "kind": "smooth" } }]);
    assert!(Case::from_json(&text.to_string()).unwrap_err().to_string().contains("boundaries[0].side"));
    text["boundaries"] = json!([]);
    text["domain"]["periodic"] = json!(["z"]);
    assert!(Case::from_json(&text.to_string()).unwrap_err().to_string().contains("domain.periodic[0]"));
}

#[test]
fn work_and_rest_of_a_periodic_column_do_not_depend_on_its_width() {
    // Nodes of both ends are one node.
    for (shape, fluid) in [("linear", false), ("ugimp", false), ("cpgimp", false), ("ugimp", true)] {
        let found = [5, 10].map(|cells| {
            let width = 0.1 * f64::from(cells);
            let mut text = json!({
                "title": "test", "space": "plane-strain", "gravity": [0, -10],
                "domain": { "min": [0, 0], "max": [width, 1.2], "periodic": ["x"] },
                "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e5, "poissons_ratio": 0.2 } },
                "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [width, 1] } }],
                "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } }],
                "stages": [{ "name": "s", "duration": 1, "equilibrium": { "unbalanced_force": 1e-9, "kinetic_energy": 1e-9 } }],
                "methods": { "mpm": { "cell_size": 0.1, "shape": shape, "courant": 0.3 } }
            });
            if fluid {
                text["bodies"][0]["pore_fluid"] = json!({ "porosity": 0.4, "permeability": 1e-2, "bulk_modulus": 1e7 });
            }
            let mut solver = start_solver(&Mpm, &read_case(&text));
            let start = solver.totals().potential;
            (0..200).for_each(|_| { solver.step(1e-4).unwrap(); });
            let fallen = start - solver.totals().potential;
            let work = solver.scalar_outputs().iter().find(|(name, ..)| name == "external_work").unwrap().2;
            // Water that leaves does not take its points along.
            assert!(fluid || (work / fallen - 1.0).abs() < 0.02, "{shape}, {cells}: {work} for {fallen}");
            let rest = solver.equilibrium().unwrap();
            [work / width, rest.unbalanced_force, rest.kinetic_ratio]
        });
        for (narrow, wide) in found[0].iter().zip(&found[1]) {
            assert!((narrow / wide - 1.0).abs() < 1e-9, "{shape}, {fluid}: {found:?}");
        }
    }
}
