//! Loads that follow the surface, periodic and absorbing sides, excavation (sheet: mpm §2.11).

use colluvium_case::{Budget, Case, FieldData, Method, Solver};
use colluvium_mpm::Mpm;
use serde_json::{Value, json};

use crate::common::{advance_to, begin, case_with, scalars, solve, stresses, vectors, with_keys};

/// An elastic block in a box without gravity; `more` replaces or adds keys.
#[allow(clippy::needless_pass_by_value, reason = "`case(json!(…))` reads well")]
fn case(more: Value) -> Case {
    case_with(
        json!({
            "title": "test", "space": "plane-strain", "domain": { "min": [0, 0], "max": [1, 1] }, "gravity": [0, 0],
            "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0.3 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.35, 0.35], "max": [0.65, 0.65] } }],
            "stages": [{ "name": "s", "duration": 1.0 }],
            "methods": { "mpm": { "cell_size": 0.05 } }
        }),
        &more,
    )
}

/// Force on the whole body in the next step (N).
fn force(solver: &mut dyn Solver) -> [f64; 2] {
    let (before, dt) = (solver.totals().momentum, solver.limit().dt);
    solver.step(dt).unwrap();
    let after = solver.totals().momentum;
    [(after[0] - before[0]) / dt, (after[1] - before[1]) / dt]
}

#[test]
fn a_pressure_turns_with_the_surface_and_a_traction_does_not() {
    // A quarter turn in a second.
    let rate = std::f64::consts::FRAC_PI_2;
    let spin = json!({ "kind": "linear", "value": [0, 0], "origin": [0.5, 0.5], "gradient": [[0, -rate], [rate, 0]] });
    let body = json!([{ "name": "b", "material": "m", "velocity": spin,
                        "shape": { "kind": "box", "min": [0.35, 0.35], "max": [0.65, 0.65] } }]);
    let loads = [
        (json!({ "kind": "pressure", "body": "b", "side": "x-max", "value": 10 }), [0.0, -3.0]),
        (json!({ "kind": "traction", "body": "b", "side": "x-max", "value": [-10, 0] }), [-3.0, 0.0]),
    ];
    for scheme in ["usf", "usl", "musl"] {
        for (load, exact) in &loads {
            let options = json!({ "cell_size": 0.05, "stress_update": scheme });
            let case = case(json!({ "bodies": body, "loads": [load], "methods": { "mpm": options } }));
            let mut solver = begin(&case);
            let start = force(&mut *solver);
            assert!((start[0] + 3.0).abs() < 0.02 && start[1].abs() < 0.02, "{start:?}");
            advance_to(&mut *solver, 1.0);
            let end = force(&mut *solver);
            assert!((end[0].hypot(end[1]) - 3.0).abs() < 0.05, "{scheme}: {end:?}");
            // Next to a free surface the lumped mass of a node does not lie at the node, and the spin that its points
            // feel is weaker: the surface lags behind by up to a fifth.
            assert!(
                (0..2).all(|c| (end[c] - exact[c]).abs() < 1.1),
                "{scheme}: {end:?} instead of {exact:?}"
            );
        }
    }
}

#[test]
fn each_load_of_a_body_grows_over_its_own_ramp() {
    let load = |side: &str, value: Value, ramp: f64| json!({ "kind": "traction", "body": "b", "side": side, "value": value, "ramp": ramp });
    let case = case(json!({
        "loads": [load("x-max", json!([10, 0]), 0.1), load("y-max", json!([0, 20]), 0.4)],
        "stages": [{ "name": "s", "duration": 0.2 }]
    }));
    let momentum = solve(&case).end.momentum;
    // 3 N and 6 N at full load: 3 × (0.2 - 0.05) and 6 × 0.2² / (2 × 0.4), but for the last part of the step.
    assert!(
        (momentum[0] / 0.45 - 1.0).abs() < 0.02 && (momentum[1] / 0.3 - 1.0).abs() < 0.02,
        "{momentum:?}"
    );
}

/// What acts on the whole body in the next step: force (N) and moment about the origin (N m).
fn resultants(case: &Case) -> [f64; 3] {
    let mut solver = begin(case);
    let (before, dt) = (solver.totals(), solver.limit().dt);
    solver.step(dt).unwrap();
    let after = solver.totals();
    let force = |c: usize| (after.momentum[c] - before.momentum[c]) / dt;
    [force(0), force(1), (after.angular_momentum[2] - before.angular_momentum[2]) / dt]
}

#[test]
fn a_load_that_varies_along_its_side_has_the_resultants_of_its_profile() {
    let load = |kind: &str, value: Value, axis: &str, side: &str, shares: Value| {
        json!({ "kind": kind, "body": "b",
        "side": side, "value": value, "profile": { "axis": axis, "shares": shares } })
    };
    // Water of 0.2 m beside a block of 0.3 m that stands at y = 0.35 m, 2 kPa at its foot; its load goes through the
    // lowest third. And a strip of 1 kPa between 0.4 and 0.5 m on its top, pulled along as well.
    let water = json!([[0.35, 1], [0.55, 0]]);
    let strip = json!([[0.4, 0], [0.4, 1], [0.5, 1], [0.5, 0]]);
    let table = [
        (
            load("pressure", json!(2e3), "y", "x-max", water.clone()),
            [-200.0, 0.0, 200.0 * (0.35 + 0.2 / 3.0)],
        ),
        (load("traction", json!([-2e3, 0]), "y", "x-max", water), [-200.0, 0.0, 200.0 * (0.35 + 0.2 / 3.0)]),
        (
            load("traction", json!([50, -1e3]), "x", "y-max", strip),
            [5.0, -100.0, -100.0 * 0.45 - 5.0 * (0.65 - 0.0125)],
        ),
    ];
    let grids = [
        json!({ "cell_size": 0.05 }),
        json!({ "cell_size": 0.05, "shape": "quadratic" }),
        json!({ "cell_size": 0.05, "shape": "linear", "mesh": { "kind": "box" } }),
    ];
    let on_nodes = table.iter().filter(|(load, _)| load["kind"] == "traction");
    let on_nodes =
        on_nodes.map(|(load, exact)| (with_keys(load.clone(), &json!({ "applied_to": "nodes" })), *exact));
    for (load, exact) in table.iter().cloned().chain(on_nodes) {
        for options in
            grids.iter().filter(|options| load.get("applied_to").is_none() || options["shape"] != "quadratic")
        {
            let found = resultants(&case(json!({ "loads": [load], "methods": { "mpm": options } })));
            for c in 0..2 {
                assert!((found[c] - exact[c]).abs() < 1e-9, "{options}: {found:?} for {exact:?}");
            }
            // The lumped mass of a node at the surface does not lie at the node, and the points of triangles next to a
            // facet do not lie around its middle.
            let slack = if options.get("mesh").is_some() { 0.05 } else { 0.02 };
            assert!((found[2] / exact[2] - 1.0).abs() < slack, "{options}: {found:?} for {exact:?}");
        }
    }
}

#[test]
fn a_load_on_nodes_is_exact_up_to_the_side() {
    // The points of the last cell, which would carry it, have the stress of all others: of a bar, and of triangles.
    let bar = |space: &str, min: Value, max: Value, value: Value, options: Value| {
        case_with(
            json!({
                "title": "bar", "space": space, "domain": { "min": min, "max": max }, "gravity": vec![0; min.as_array().unwrap().len()],
                "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0 } },
                "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": min, "max": max } }],
                "boundaries": [{ "side": "x-min", "wall": { "kind": "smooth" } }],
                "loads": [{ "kind": "traction", "body": "b", "side": "x-max", "value": value, "applied_to": "nodes", "ramp": 0.1 }],
                "stages": [{ "name": "s", "duration": 10, "damping": 0.5,
                             "equilibrium": { "unbalanced_force": 1e-5, "kinetic_energy": 1e-8 } }],
                "methods": { "mpm": options }
            }),
            &json!({}),
        )
    };
    let linear = || json!({ "cell_size": 0.1, "shape": "linear" });
    for case in [
        bar("1d", json!([0]), json!([1]), json!([-100]), linear()),
        bar("1d", json!([0]), json!([1]), json!([-100]), json!({ "cell_size": 0.1, "shape": "quadratic" })),
        bar("plane-strain", json!([0, 0]), json!([1, 0.3]), json!([-100, 0]), linear()),
        bar(
            "plane-strain",
            json!([0, 0]),
            json!([1, 0.3]),
            json!([-100, 0]),
            with_keys(linear(), &json!({ "mesh": { "kind": "box" } })),
        ),
    ] {
        let report = solve(&case);
        assert!(report.snapshot.time < 10.0, "at rest");
        // Points in the middle of parts of cells do not integrate splines exactly.
        let slack = if case.methods["mpm"]["shape"] == "quadratic" { 5e-3 } else { 1e-3 };
        for (x, stress) in report.snapshot.positions.iter().zip(stresses(&report.snapshot)) {
            assert!((stress[0] / -100.0 - 1.0).abs() < slack, "{} at {x:?}: {}", stress[0], case.to_json());
        }
    }
}

#[test]
fn saturated_ground_under_open_water_stays_at_rest() {
    // Grains as heavy as water, so that the skeleton bears nothing; water stands 1 m above the ground and beside it, with the
    // pressure of that depth on skeleton and fluid together and on the fluid.
    let load = |kind: &str, side: &str, value: Value, profile: Value| {
        json!({ "kind": kind, "body": "b", "side": side,
        "value": value, "profile": profile, "applied_to": "nodes" })
    };
    let deep = json!({ "axis": "y", "shares": [[0, 2], [2, 0]] });
    let level = json!({ "axis": "x", "shares": [[0, 1], [1, 1]] });
    let ground = |options: Value| {
        case(json!({
            "domain": { "min": [0, 0], "max": [1.2, 1.2] }, "gravity": [0, -10],
            "materials": { "m": { "model": "linear-elastic", "density": 600, "youngs_modulus": 1e6, "poissons_ratio": 0.3 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 1] },
                         "pore_fluid": { "porosity": 0.4, "permeability": 1e-3, "bulk_modulus": 1e8,
                                         "pressure": { "kind": "hydrostatic", "surface": 2 } } }],
            "boundaries": [{ "side": "x-min", "wall": { "kind": "smooth" } }, { "side": "y-min", "wall": { "kind": "smooth" } }],
            "loads": [
                load("traction", "x-max", json!([-1e4, 0]), deep.clone()), load("pore-pressure", "x-max", json!(1e4), deep.clone()),
                load("traction", "y-max", json!([0, -1e4]), level.clone()), load("pore-pressure", "y-max", json!(1e4), level.clone())
            ],
            "stages": [{ "name": "s", "duration": 0.01 }],
            "methods": { "mpm": options }
        }))
    };
    for options in [
        json!({ "cell_size": 0.2, "shape": "linear" }),
        json!({ "cell_size": 0.2, "shape": "linear", "points_per_cell": 3, "mesh": { "kind": "box" } }),
    ] {
        let report = solve(&ground(options.clone()));
        let largest = |name: &str| {
            let speeds = vectors(&report.snapshot, name).into_iter().map(|v| v[0].hypot(v[1]));
            speeds.fold(0.0, f64::max)
        };
        // Without the loads, or with one of them missing, centimetres a second.
        let speeds = ["velocity", "liquid_velocity"].map(largest);
        assert!(speeds.iter().all(|speed| *speed < 1e-9), "{options}: {speeds:?}");
    }
}

#[test]
fn loads_on_nodes_survive_a_restart_and_ask_for_a_side_on_a_grid_line() {
    let load = json!({ "kind": "traction", "body": "b", "side": "x-max", "value": [-100, 20], "applied_to": "nodes", "ramp": 0.3,
                       "profile": { "axis": "y", "shares": [[0.35, 1], [0.65, 0.2]] } });
    let held = json!([{ "side": "x-min", "position": 0.35, "wall": { "kind": "rough" } }]);
    let sound = case(json!({ "loads": [load], "boundaries": held }));
    restarts(&sound, 0.1, 0.2);
    let refused = |options: Value, max: f64| {
        let body = json!([{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.35, 0.35], "max": [max, 0.65] } }]);
        let case = case(json!({ "loads": [load], "bodies": body, "methods": { "mpm": options } }));
        Mpm.build(&case).err().map(|error| error.to_string()).unwrap_or_default()
    };
    assert_eq!(refused(json!({ "cell_size": 0.05 }), 0.65), "");
    for (options, max, words) in [
        (json!({ "cell_size": 0.05 }), 0.625, "12.500000 cells"),
        (json!({ "cell_size": 0.05, "shape": "cubic" }), 0.65, "only on the sides of the domain"),
        (json!({ "cell_size": 0.05, "shape": "cpdi" }), 0.65, "cpdi"),
    ] {
        let problem = refused(options, max);
        assert!(problem.starts_with("loads[0].applied_to") && problem.contains(words), "{problem}");
    }
}

#[test]
fn a_pressure_that_varies_makes_a_stress_that_varies() {
    // Between a smooth wall and a pressure from 1 kPa below to 3 kPa above, with a Poisson's ratio of zero: each fibre
    // bears what presses on it, as in a beam that is bent.
    let report = solve(&case(json!({
        "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e6, "poissons_ratio": 0 } },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0.2], "max": [0.4, 0.8] } }],
        "boundaries": [{ "side": "x-min", "wall": { "kind": "smooth" } }],
        "loads": [{ "kind": "pressure", "body": "b", "side": "x-max", "value": 1e3, "ramp": 0.05,
                    "profile": { "axis": "y", "shares": [[0.2, 1], [0.8, 3]] } }],
        "stages": [{ "name": "s", "duration": 1.0, "damping": 0.3 }]
    })));
    for (x, s) in report.snapshot.positions.iter().zip(stresses(&report.snapshot)) {
        let exact = -1e3 * (1.0 + 2.0 * (x[1] - 0.2) / 0.6);
        // A load is smeared over the outermost cells.
        if x[0] < 0.3 && (0.25..0.75).contains(&x[1]) {
            assert!((s[0] - exact).abs() < 60.0, "{} for {exact} at {x:?}", s[0]);
        }
    }
}

#[test]
fn a_pore_pressure_that_varies_pushes_the_fluid_with_its_mean() {
    // n times the force on the fluid is its momentum: Σ M̄_L a_L = n Σ f_L.
    let text = json!([{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.35, 0.35], "max": [0.65, 0.65] },
                        "pore_fluid": { "porosity": 0.4, "intrinsic_permeability": 1e-6 } }]);
    let load = json!({ "kind": "pore-pressure", "body": "b", "side": "x-min", "value": 1e3,
                       "profile": { "axis": "y", "shares": [[0.35, 0], [0.65, 1]] } });
    let mut solver = begin(&case(json!({ "bodies": text, "loads": [load] })));
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
    let snapshot = solve(&Case::from_json(&text.to_string()).unwrap()).snapshot;
    let Some(FieldData::Tensor(effective)) = snapshot.field("stress").map(|f| &f.data) else {
        panic!("no stress")
    };
    // No total stress: the skeleton swells. After T = 2.5 consolidation lacks 0.3 %. The load is spread over the outermost
    // cell, whose point feels the share of the end node.
    for ((x, pressure), stress) in
        snapshot.positions.iter().zip(scalars(&snapshot, "pore_pressure")).zip(effective)
    {
        let exact = if x[0] < 0.9 { 1e4 } else { 1e5 * (x[0] - 0.9) };
        assert!((pressure / exact - 1.0).abs() < 0.01, "{pressure}");
        assert!((stress.0[0] / exact - 1.0).abs() < 0.01, "{stress:?}");
    }
}

#[test]
fn boundary_pressures_of_the_fluid_need_pores_and_no_shut_wall() {
    let with = |body: &str, walls: Value| {
        let mut text: Value = serde_json::from_str(&case(json!({})).to_json()).unwrap();
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

/// A block that flies through periodic sides, and is crushed a little meanwhile by its own velocity.
fn drifting(shape: &str, transfer: &str, shrink: f64) -> Case {
    let motion = json!({ "kind": "linear", "value": [3.0, -2.0], "origin": [0.5, 0.5],
                         "gradient": [[-shrink, 0], [0, shrink]] });
    case(json!({
        "domain": { "min": [0, 0], "max": [1, 1], "periodic": ["x", "y"] },
        "bodies": [{ "name": "b", "material": "m", "velocity": motion,
                     "shape": { "kind": "box", "min": [0.35, 0.35], "max": [0.65, 0.65] } }],
        "stages": [{ "name": "s", "duration": 0.7 }],
        "methods": { "mpm": { "cell_size": 0.05, "shape": shape, "transfer": transfer } }
    }))
}

#[test]
fn a_body_flies_through_periodic_sides_without_noticing() {
    for (shape, transfer) in [("linear", "flip"), ("ugimp", "flip"), ("cpgimp", "tpic"), ("ugimp", "xpic")] {
        let report = solve(&drifting(shape, transfer, 0.0));
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
fn where_the_seam_lies_makes_no_difference() {
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
            solve(&case).end
        });
        let [whole, cut] = budgets;
        assert!((whole.kinetic / cut.kinetic - 1.0).abs() < 1e-9, "{shape}: {whole:?}, {cut:?}");
        assert!((whole.elastic / cut.elastic - 1.0).abs() < 1e-9, "{shape}: {whole:?}, {cut:?}");
    }
}

#[test]
fn periodic_runs_are_the_same_on_any_thread_and_after_a_restart() {
    let case = drifting("ugimp", "flip", 0.5);
    let hash = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| solve(&case).snapshot.hash())
    };
    assert_eq!(hash(1), hash(2));
    restarts(&case, 0.3, 0.5);
}

#[test]
fn loads_on_nodes_are_the_same_on_any_thread() {
    let load = json!({ "kind": "traction", "body": "b", "side": "x-max", "value": [-100, 20], "applied_to": "nodes", "ramp": 0.05,
                       "profile": { "axis": "y", "shares": [[0.35, 1], [0.65, 0.2]] } });
    let held = json!([{ "side": "x-min", "position": 0.35, "wall": { "kind": "rough" } }]);
    for options in [
        json!({ "cell_size": 0.0125 }),
        json!({ "cell_size": 0.0125, "stress_update": "usl", "shape": "cpgimp" }),
        json!({ "cell_size": 0.0125, "shape": "linear", "mesh": { "kind": "box" } }),
    ] {
        for fluid in
            [Value::Null, json!({ "porosity": 0.4, "intrinsic_permeability": 1e-8, "bulk_modulus": 1e6 })]
        {
            let mut body = json!({ "name": "b", "material": "m",
                                   "shape": { "kind": "box", "min": [0.35, 0.35], "max": [0.65, 0.65] } });
            if !fluid.is_null() {
                body["pore_fluid"] = fluid;
            }
            let case = case(json!({ "loads": [load], "boundaries": held, "bodies": [body],
                                    "stages": [{ "name": "s", "duration": 0.008 }], "methods": { "mpm": options } }));
            let hash = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let report = pool.install(|| solve(&case));
                let budget =
                    [report.end.momentum[0], report.end.kinetic, report.end.elastic].map(f64::to_bits);
                (report.snapshot.hash(), budget)
            };
            let [one, two] = [1, 2].map(hash);
            assert!(f64::from_bits(one.1[0]) < 0.0, "it is pushed");
            assert_eq!(one, two, "{options}");
        }
    }
}

fn restarts(case: &Case, middle: f64, end: f64) {
    let mut whole = begin(case);
    advance_to(&mut *whole, middle);
    let saved = whole.saved().unwrap();
    let mut again = begin(case);
    again.restore(&mut saved.as_slice()).unwrap();
    again.begin_stage(0, 0.0).unwrap();
    advance_to(&mut *again, end);
    advance_to(&mut *whole, end);
    assert_eq!(again.snapshot().hash(), whole.snapshot().hash());
}

#[test]
fn absorbing_sides_with_springs_survive_a_restart() {
    let case = case(json!({
        "bodies": [{ "name": "b", "material": "m", "velocity": { "kind": "uniform", "value": [0.1, 0.05] },
                     "shape": { "kind": "box", "min": [0.35, 0.35], "max": [0.65, 0.65] } }],
        "boundaries": [{ "side": "x-max", "position": 0.65, "wall": { "kind": "absorbing", "spring_length": 0.3 } }]
    }));
    restarts(&case, 0.02, 0.04);
    // The spring brings it back where it was.
    let mut solver = begin(&case);
    advance_to(&mut *solver, 1.0);
    let mean = vectors(&solver.snapshot(), "displacement").iter().map(|u| u[0]).sum::<f64>() / 144.0;
    assert!(mean.abs() < 1e-4, "{mean}");
}

#[test]
fn what_is_dug_out_is_gone_and_the_rest_goes_on() {
    let case = case(json!({
        "gravity": [0, -10],
        "boundaries": [{ "side": "y-min", "position": 0.35, "wall": { "kind": "rough" } }],
        "loads": [{ "kind": "traction", "body": "b", "side": "y-max", "value": [0, -10] }],
        "stages": [{ "name": "all", "duration": 0.02 },
                   { "name": "dug", "duration": 0.02,
                     "excavate": [{ "kind": "box", "min": [0.5, 0.5], "max": [0.65, 0.65] }] }],
        "methods": { "mpm": { "cell_size": 0.05, "transfer": "xpic" } }
    }));
    let report = solve(&case);
    assert_eq!(report.snapshot.ids.len(), 108);
    assert!((report.end.mass - 67.5).abs() < 1e-9);
    assert!(report.snapshot.positions.iter().all(|x| x[0] < 0.5 || x[1] < 0.5));
    let mut whole = begin(&case);
    whole.step(1e-4).unwrap();
    let start = whole.time();
    whole.begin_stage(1, start).unwrap();
    whole.step(1e-4).unwrap();
    let mut again = begin(&case);
    again.restore(&mut whole.saved().unwrap().as_slice()).unwrap();
    again.begin_stage(1, start).unwrap();
    for solver in [&mut whole, &mut again] {
        solver.step(1e-4).unwrap();
    }
    assert_eq!(again.snapshot().hash(), whole.snapshot().hash());
}

#[test]
fn what_cannot_be_periodic_is_refused_by_name() {
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
fn a_wall_that_lets_go_gives_no_energy_to_what_bounces_off() {
    let ball = json!([{ "name": "b", "material": "m", "shape": { "kind": "ball", "centre": [0.5, 0.3], "radius": 0.2 },
                        "velocity": { "kind": "uniform", "value": [0.5, -2] } }]);
    let smooth = json!({ "side": "y-min", "wall": { "kind": "smooth" }, "separation": true });
    let rubbing = json!({ "side": "y-min", "wall": { "kind": "frictional", "friction_coefficient": 0.3 } });
    for wall in [smooth, rubbing] {
        for scheme in ["usl", "musl"] {
            let options = json!({ "cell_size": 0.05, "stress_update": scheme, "courant": 0.2 });
            let report = solve(&case(json!({
                "bodies": ball, "boundaries": [wall], "stages": [{ "name": "s", "duration": 0.15 }],
                "methods": { "mpm": options }
            })));
            assert!(report.end.momentum[1] > 0.0, "it is on its way up");
            let kept = (report.end.kinetic + report.end.elastic) / report.start.kinetic;
            assert!(kept < 1.01 && kept > 0.7, "{wall}, {scheme}: {kept}");
        }
    }
}

#[test]
fn a_bilateral_wall_bears_what_hangs_on_it_without_friction() {
    let hanging = |bilateral: bool, fluid: Value, options: Value| {
        let mut text = json!({
            "gravity": [0, -10],
            "bodies": [{ "name": "b", "material": "m", "velocity": { "kind": "uniform", "value": [0.5, 0] },
                         "shape": { "kind": "box", "min": [0.35, 0.7], "max": [0.65, 1] } }],
            "boundaries": [{ "side": "y-max", "wall": { "kind": "frictional", "friction_coefficient": 0.5 } }],
            "stages": [{ "name": "s", "duration": 0.1 }],
            "methods": { "mpm": options }
        });
        if bilateral {
            text["boundaries"][0]["wall"]["bilateral"] = json!(true);
        }
        if !fluid.is_null() {
            text["bodies"][0]["pore_fluid"] = fluid;
        }
        solve(&case(text)).end
    };
    let fluid = || json!({ "porosity": 0.4, "intrinsic_permeability": 1e-8, "bulk_modulus": 1e6 });
    for options in [
        json!({ "cell_size": 0.05 }),
        json!({ "cell_size": 0.05, "stress_update": "usl", "wall_friction": "acceleration" }),
        json!({ "cell_size": 0.05, "stress_update": "usf", "fixed_nodes": "momentum", "wall_friction": "acceleration" }),
        json!({ "cell_size": 0.05, "shape": "linear", "mesh": { "kind": "box" } }),
    ] {
        for fluid in [Value::Null, fluid()] {
            let [held, dropped] =
                [true, false].map(|bilateral| hanging(bilateral, fluid.clone(), options.clone()));
            // It swings on its own spring, and in 0.1 s what falls has 1 m/s.
            let speed = |end: &Budget| [end.momentum[0] / end.mass, end.momentum[1] / end.mass];
            assert!(speed(&held)[1].abs() < 0.2, "{options}: {:?}", speed(&held));
            assert!((speed(&dropped)[1] + 1.0).abs() < 0.02, "{options}: {:?}", speed(&dropped));
        }
    }
}

#[test]
fn absorbing_sides_stay_uniform_as_points_go_through_a_period() {
    let case = Case::from_json(
        &json!({
            "title": "test", "space": "plane-strain", "domain": { "min": [0, 0], "max": [1, 2], "periodic": ["x"] }, "gravity": [0, 0],
            "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e5, "poissons_ratio": 0.2 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 1] },
                         "velocity": { "kind": "uniform", "value": [1, 0] } }],
            "boundaries": [{ "side": "y-min", "wall": { "kind": "absorbing" } }],
            "stages": [{ "name": "a", "duration": 0.3 }, { "name": "b", "duration": 0.2 }],
            "methods": { "mpm": { "cell_size": 0.1 } }
        })
        .to_string(),
    )
    .unwrap();
    let snapshot = solve(&case).snapshot;
    let velocities = vectors(&snapshot, "velocity");
    for (x, v) in snapshot.positions.iter().zip(&velocities) {
        let row =
            snapshot.positions.iter().zip(&velocities).filter(|(other, _)| (other[1] - x[1]).abs() < 1e-9);
        assert!(row.into_iter().all(|(_, w)| (0..2).all(|c| (v[c] - w[c]).abs() < 1e-9)), "{v:?} at {x:?}");
    }
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
            let mut solver = begin(&Case::from_json(&text.to_string()).unwrap());
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

#[test]
fn absorbing_sides_do_not_mind_where_displacement_is_counted_from() {
    let ends = [json!([]), json!(["displacement"])].map(|reset| {
        let bar = Case::from_json(
            &json!({
                "title": "test", "space": "1d", "domain": { "min": [0], "max": [2] }, "gravity": [0],
                "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e5, "poissons_ratio": 0 } },
                "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0], "max": [1] },
                             "velocity": { "kind": "uniform", "value": [1] } }],
                "boundaries": [{ "side": "x-min", "wall": { "kind": "absorbing" } }],
                "stages": [{ "name": "a", "duration": 0.05, "reset": reset }, { "name": "b", "duration": 0.05 }],
                "methods": { "mpm": { "cell_size": 0.1 } }
            })
            .to_string(),
        )
        .unwrap();
        solve(&bar).end.momentum[0]
    });
    assert_eq!(ends[0], ends[1]);
}

#[test]
fn walls_that_would_leave_their_plane_are_refused() {
    let case = |speed: f64| {
        Case::from_json(
            &json!({
                "title": "test", "space": "1d", "domain": { "min": [0], "max": [1] }, "gravity": [0],
                "materials": { "m": { "model": "linear-elastic", "density": 1000, "youngs_modulus": 1e5, "poissons_ratio": 0.2 } },
                "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0], "max": [1] } }],
                "boundaries": [{ "side": "x-min", "wall": { "kind": "smooth" } },
                               { "side": "x-max", "wall": { "kind": "smooth" }, "velocity": [speed] }],
                "stages": [{ "name": "a", "duration": 1 }],
                "methods": { "mpm": { "cell_size": 0.1 } }
            })
            .to_string(),
        )
        .unwrap()
    };
    for speed in [0.2, -0.2] {
        let error = Mpm.build(&case(speed)).err().unwrap().to_string();
        assert!(
            error.contains("boundaries[1].velocity") && error.contains("rigid body or a patch"),
            "{error}"
        );
    }
    assert!(Mpm.build(&case(0.04)).is_ok());
}
