//! Convected domains and the total-Lagrangian form: invariants of all shape functions, and the purpose of each.

use colluvium_case::{Method, RunOptions, RunReport, run};
use colluvium_mpm::Mpm;
use colluvium_testkit::{CaseBuilder, advance_to, start_solver, stresses, vectors, with_keys};
use serde_json::{Value, json};

/// Block that flies through a box without gravity.
fn flying_block() -> CaseBuilder {
    CaseBuilder::from_json(json!({
        "title": "test", "space": "plane-strain",
        "domain": { "min": [0, 0], "max": [2, 1] }, "gravity": [0, 0],
        "materials": { "m": { "model": "neo-hookean", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.25 } },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.2, 0.3], "max": [0.6, 0.7] },
                     "velocity": { "kind": "uniform", "value": [6, 1] } }],
        "stages": [{ "name": "s", "duration": 0.2 }],
        "methods": { "mpm": { "cell_size": 0.1 } }
    }))
}

fn largest_stress(report: &RunReport) -> f64 {
    stresses(&report.snapshot).as_flattened().iter().fold(0.0, |a: f64, s| a.max(s.abs()))
}

/// Every shape of this file, as options of the method.
fn options() -> Vec<Value> {
    let option = |shape: &str, formulation: &str| json!({ "cell_size": 0.1, "shape": shape, "formulation": formulation });
    let total = |shape: &str, transfer: &str| json!({ "cell_size": 0.1, "shape": shape, "formulation": "total-lagrangian", "transfer": transfer });
    vec![
        total("quadratic", "apic"),
        total("linear", "tpic"),
        total("quadratic", "tpic"),
        total("linear", "xpic"),
        option("dual-domain", "updated-lagrangian"),
        option("cpdi", "updated-lagrangian"),
        option("cpdi2", "updated-lagrangian"),
        option("linear", "total-lagrangian"),
        option("quadratic", "total-lagrangian"),
    ]
}

#[test]
fn a_body_in_free_flight_through_the_grid_has_no_stress() {
    // sheet: mpm A-04: 12 cells along x, 2 along y.
    for options in options() {
        let report = flying_block().with(json!({ "methods": { "mpm": options } })).solve(&Mpm);
        for u in vectors(&report.snapshot, "displacement") {
            assert!((u[0] - 1.2).abs() < 1e-11 && (u[1] - 0.2).abs() < 1e-11, "{options}: {u:?}");
        }
        // Relative to the modulus.
        assert!(largest_stress(&report) < 1e-9 * 1e6, "{options}: {} Pa", largest_stress(&report));
    }
}

#[test]
fn mass_and_momentum_of_a_free_body_are_conserved() {
    // sheet: mpm A-02.
    for options in options() {
        let report = flying_block().with(json!({
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "ball", "centre": [0.8, 0.5], "radius": 0.25 },
                         "velocity": { "kind": "linear", "value": [0.3, -0.2], "origin": [0.8, 0.5],
                                       "gradient": [[1.0, 0.4], [-0.8, -1.0]] } }],
            "methods": { "mpm": options }
        })).solve(&Mpm);
        assert_eq!(report.end.mass, report.start.mass);
        for c in 0..2 {
            let change = report.end.momentum[c] - report.start.momentum[c];
            assert!(change.abs() < 1e-12 * report.start.mass, "{options}: {change}");
        }
    }
}

#[test]
fn a_block_in_three_dimensions_and_a_bar_keep_their_momentum() {
    for (space, dimension, shape) in
        [("1d", 1, "cpdi"), ("3d", 3, "cpdi"), ("1d", 1, "dual-domain"), ("3d", 3, "dual-domain")]
    {
        let pick = |v: &[f64]| v[..dimension].to_vec();
        let gradient: Vec<Vec<f64>> = (0..dimension)
            .map(|i| (0..dimension).map(|j| if i == j { 2.0 } else { 0.5 }).collect())
            .collect();
        let report = flying_block().with(json!({
            "space": space, "domain": { "min": pick(&[0.0; 3]), "max": pick(&[1.0; 3]) }, "gravity": pick(&[0.0; 3]),
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": pick(&[0.3; 3]), "max": pick(&[0.7; 3]) },
                         "velocity": { "kind": "linear", "value": pick(&[0.3, -0.2, 0.1]), "origin": pick(&[0.5; 3]),
                                       "gradient": gradient } }],
            "stages": [{ "name": "s", "duration": 0.02 }],
            "methods": { "mpm": { "cell_size": 0.1, "shape": shape } }
        })).solve(&Mpm);
        for c in 0..dimension {
            let change = report.end.momentum[c] - report.start.momentum[c];
            assert!(change.abs() < 1e-12 * report.start.mass, "{space}, {shape}: {change}");
        }
        assert!(largest_stress(&report) > 1e3, "{space}, {shape}: it does swing");
    }
}

#[test]
fn a_torn_cpdi_domain_fails_the_run_by_name() {
    let case = flying_block().with(json!({
        "materials": { "m": { "model": "neo-hookean", "density": 1000, "youngs_modulus": 1.0, "poissons_ratio": 0.0 } },
        "domain": { "min": [0, 0], "max": [6, 1] },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.2, 0.3], "max": [0.6, 0.7] },
                     "velocity": { "kind": "linear", "value": [6, 0], "origin": [0.4, 0.5], "gradient": [[20, 0], [0, 0]] } }],
        "stages": [{ "name": "s", "duration": 0.6 }],
        "methods": { "mpm": { "cell_size": 0.1, "shape": "cpdi", "stress_update": "usl" } }
    })).build();
    let error = run(&case, Mpm.build(&case).unwrap(), &RunOptions::default()).unwrap_err().to_string();
    assert!(error.contains("corners of a cpdi domain"), "{error}");
}

#[test]
fn quadrilaterals_are_refused_out_of_plane_strain() {
    let case = flying_block()
        .with(
            json!({ "space": "axisymmetric", "methods": { "mpm": { "cell_size": 0.1, "shape": "cpdi2" } } }),
        )
        .build();
    let error = Mpm.build(&case).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("methods.mpm.shape") && error.contains("plane strain"), "{error}");
}

#[test]
fn rigid_rotation_in_the_total_lagrangian_form_keeps_the_shape() {
    // A quarter turn: updated forms cross cells, the reference does not.
    let spin = std::f64::consts::FRAC_PI_2;
    let report = flying_block().with(json!({
        "domain": { "min": [-0.5, -0.5], "max": [0.5, 0.5] },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [-0.3, -0.3], "max": [0.3, 0.3] },
                     "velocity": { "kind": "linear", "value": [0, 0], "origin": [0, 0], "gradient": [[0, -spin], [spin, 0]] } }],
        "stages": [{ "name": "turn", "duration": 1.0 }],
        "methods": { "mpm": { "cell_size": 0.1, "shape": "linear", "formulation": "total-lagrangian" } }
    })).solve(&Mpm);
    for (x, u) in report.snapshot.positions.iter().zip(vectors(&report.snapshot, "displacement")) {
        // The loss of rotation rate by lumped mass appears in the angle; the body keeps its shape.
        let start = [x[0] - u[0], x[1] - u[1]];
        let (radius, now) = (start[0].hypot(start[1]), x[0].hypot(x[1]));
        let angle = (start[0] * x[1] - start[1] * x[0]).atan2(start[0] * x[0] + start[1] * x[1]);
        assert!((now / radius - 1.0).abs() < 0.02, "{x:?} from {start:?}");
        assert!((1.4..1.6).contains(&angle), "{angle} rad");
    }
}

#[test]
fn options_without_support_for_dual_domains_and_consistent_mass_are_rejected_by_path() {
    let wall = json!([{ "side": "y-min", "wall": { "kind": "frictional", "friction_coefficient": 0.3 } }]);
    let lifting = json!([{ "side": "y-min", "wall": { "kind": "smooth" }, "separation": true }]);
    let pressure = json!([{ "kind": "pressure", "body": "b", "side": "y-max", "value": 10 }]);
    let fluid = json!([{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.2, 0.3], "max": [0.6, 0.7] },
                         "pore_fluid": { "porosity": 0.4, "intrinsic_permeability": 1e-10, "bulk_modulus": 1e7 } }]);
    let (dual, heavy) = (
        json!({ "shape": "dual-domain" }),
        json!({ "mass": "consistent", "stress_update": "usl", "lumped_share": 0.2 }),
    );
    let table = [
        (&dual, "loads", pressure, "loads[0].kind"),
        (&dual, "bodies", fluid.clone(), "bodies[0].pore_fluid"),
        (&dual, "domain", json!({ "min": [0, 0], "max": [2, 1], "periodic": ["x"] }), "domain.periodic"),
        (&heavy, "boundaries", wall, "boundaries[0].wall"),
        (&heavy, "boundaries", lifting, "boundaries[0].wall"),
        (&heavy, "bodies", fluid, "bodies[0].pore_fluid"),
        (&heavy, "domain", json!({ "min": [0, 0], "max": [2, 1], "periodic": ["x"] }), "domain.periodic"),
        (
            &heavy,
            "stages",
            json!([{ "name": "s", "duration": 1, "equilibrium": {} }]),
            "stages[0].equilibrium",
        ),
    ];
    for (options, key, value, path) in table {
        let all = with_keys(json!({ "cell_size": 0.1 }), options);
        let case = flying_block().with(json!({ "methods": { "mpm": all }, key: value })).build();
        let error = Mpm.build(&case).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains(path), "{path}: {error}");
    }
}

#[test]
fn options_without_support_for_a_shape_are_rejected_by_key() {
    for (path, options) in [
        ("formulation", json!({ "formulation": "total-lagrangian" })),
        ("integration", json!({ "integration": "mixed" })),
        ("integration", json!({ "integration": "gauss" })),
        ("integration", json!({ "shape": "dual-domain", "integration": "gauss" })),
        ("full_cell", json!({ "shape": "linear", "integration": "gauss", "full_cell": 0.5 })),
        ("shape", json!({ "shape": "dual-domain", "mesh": { "kind": "box" } })),
        ("formulation", json!({ "shape": "dual-domain", "formulation": "total-lagrangian" })),
        ("formulation", json!({ "shape": "cpdi", "formulation": "small-displacement" })),
        ("formulation", json!({ "shape": "cpgimp", "formulation": "small-displacement" })),
        ("volumetric_strain", json!({ "shape": "dual-domain", "volumetric_strain": "nodal" })),
        ("transfer", json!({ "shape": "dual-domain", "transfer": "tpic" })),
        ("stress_update", json!({ "mass": "consistent" })),
        ("transfer", json!({ "mass": "consistent", "stress_update": "usl", "transfer": "xpic" })),
        ("fixed_nodes", json!({ "mass": "consistent", "stress_update": "usl", "fixed_nodes": "momentum" })),
        ("points_per_cell", json!({ "mass": "consistent", "stress_update": "usl", "points_per_cell": 1 })),
        (
            "mesh",
            json!({ "mass": "consistent", "stress_update": "usl", "shape": "linear", "mesh": { "kind": "box" } }),
        ),
        ("lumped_share", json!({ "lumped_share": 0.5 })),
        ("lumped_share", json!({ "mass": "consistent", "lumped_share": 0 })),
        ("lumped_share", json!({ "mass": "consistent", "stress_update": "usl" })),
        (
            "lumped_share",
            json!({ "mass": "consistent", "stress_update": "usl", "shape": "cpgimp", "lumped_share": 0.05 }),
        ),
        ("full_cell", json!({ "shape": "linear", "full_cell": 0.5 })),
        ("full_cell", json!({ "shape": "linear", "integration": "mixed", "full_cell": 1.5 })),
        ("transfer", json!({ "shape": "cpdi", "transfer": "apic" })),
        ("transfer", json!({ "shape": "cpdi2", "transfer": "apic" })),
        ("shape", json!({ "mesh": { "kind": "box" } })),
        ("shape", json!({ "shape": "cpdi", "mesh": { "kind": "box" } })),
    ] {
        let all = with_keys(json!({ "cell_size": 0.1 }), &options);
        let error = Mpm
            .build(&flying_block().with(json!({ "methods": { "mpm": all } })).build())
            .map(|_| ())
            .unwrap_err()
            .to_string();
        assert!(error.contains(&format!("methods.mpm.{path}")), "{options}: {error}");
    }
}

#[test]
fn points_keep_positions_and_report_displacements_in_the_small_displacement_formulation() {
    // A block flies by a fifth of its side, on grid and mesh.
    for options in [
        json!({ "shape": "linear" }),
        json!({ "shape": "quadratic", "stress_update": "usl" }),
        json!({ "shape": "linear", "mesh": { "kind": "box" } }),
    ] {
        let all = with_keys(json!({ "cell_size": 0.25, "formulation": "small-displacement" }), &options);
        let velocity = json!({ "kind": "uniform", "value": [0, -0.1] });
        let case = flying_block().with(json!({
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 1] }, "velocity": velocity }],
            "stages": [{ "name": "s", "duration": 2 }],
            "methods": { "mpm": all }
        })).build();
        let mut solver = start_solver(&Mpm, &case);
        let start = solver.snapshot().positions.clone();
        advance_to(&mut *solver, 1.0);
        let mut again = Mpm.build(&case).unwrap();
        again.restore(&mut solver.checkpoint_bytes().unwrap().as_slice()).unwrap();
        again.begin_stage(0, 0.0).unwrap();
        for solver in [&mut solver, &mut again] {
            advance_to(&mut **solver, 2.0);
        }
        let end = solver.snapshot();
        assert_eq!(end.hash(), again.snapshot().hash(), "{options}: after a restart");
        assert_eq!(end.positions, start, "{options}");
        let displacement = -0.1 * solver.time();
        assert!(
            vectors(&end, "displacement")
                .iter()
                .all(|u| (u[1] - displacement).abs() < 1e-9 && u[0].abs() < 1e-9),
            "{options}"
        );
    }
}
