//! Depth-integrated SPH through case files: rejected input, threads, restarts, mass balance.

use colluvium_case::Method;
use colluvium_depth_sph::DepthSph;
use colluvium_testkit::{advance_steps, hash_after, read_case, refusal, start_solver};
use serde_json::{Value, json};

/// Column of sand behind a wall, 2 m long and 1 m high, on a rough floor.
fn column() -> Value {
    json!({
        "title": "column", "space": "plane-strain",
        "domain": { "min": [0, 0], "max": [10, 2] }, "gravity": [0, -9.81],
        "materials": { "sand": {
            "model": "mohr-coulomb", "density": 1600, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 30
        } },
        "bodies": [{ "name": "column", "material": "sand", "shape": { "kind": "box", "min": [0, 0], "max": [2, 1] } }],
        "boundaries": [{ "side": "x-min", "wall": { "kind": "smooth" } }, { "side": "y-min", "wall": { "kind": "rough" } }],
        "stages": [{ "name": "release", "duration": 3 }],
        "methods": { "depth-sph": { "spacing": 0.05 } }
    })
}

/// Heap of grains and water on a plane in three dimensions, with columns of pore pressure.
fn heap() -> Value {
    json!({
        "title": "heap", "space": "3d",
        "domain": { "min": [0, 0, 0], "max": [20, 10, 5] }, "gravity": [3, 0, -9.3],
        "materials": { "debris": {
            "model": "mohr-coulomb", "density": 1990, "youngs_modulus": 1e7, "poissons_ratio": 0.3, "friction_angle": 30
        } },
        "bodies": [{ "name": "heap", "material": "debris", "velocity": { "kind": "uniform", "value": [1, 0.2, 0] },
            "shape": { "kind": "box", "min": [1, 3], "max": [5, 7] } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }, { "side": "z-min", "wall": { "kind": "rough" } }],
        "stages": [{ "name": "release", "duration": 1 }],
        "methods": { "depth-sph": { "spacing": 0.5, "phases": "two", "mixture": {
                "grain_density": 2650, "porosity": 0.4, "drag": { "law": "anderson", "settling_velocity": 0.05 } },
            "column": { "cells": 8, "consolidation": 0.05, "excess_ratio": 0.8 } } }
    })
}

fn fix(mut value: Value) -> Value {
    value["bodies"][0]["shape"] = json!({ "kind": "box", "min": [1, 3, 0], "max": [5, 7, 1.5] });
    value
}

#[test]
fn a_column_of_sand_spreads_and_stops_without_losing_mass() {
    let mut solver = start_solver(&DepthSph, &read_case(&column()));
    let before = solver.totals();
    assert!((before.mass - 3200.0).abs() < 1e-9, "{}", before.mass);
    while solver.time() < 3.0 {
        let dt = solver.limit().dt;
        solver.step(dt).unwrap();
    }
    let after = solver.totals();
    assert_eq!(after.mass, before.mass);
    assert!(after.kinetic < 1e-9, "it has stopped: {} J", after.kinetic);
    let snapshot = solver.snapshot();
    let front = snapshot.positions.iter().map(|x| x[0]).fold(0.0, f64::max);
    // Depth-averaged sand of 30° spreads by about two heights over tan φ.
    assert!((3.0..5.0).contains(&front), "{front}");
    let slope = |pair: &[(f64, f64)]| (pair[0].1 - pair[1].1) / (pair[1].0 - pair[0].0);
    let depth = snapshot.scalars("depth").unwrap();
    let mut surface: Vec<(f64, f64)> =
        snapshot.positions.iter().zip(depth).map(|(x, h)| (x[0], *h)).collect();
    surface.sort_by(|a, b| a.0.total_cmp(&b.0));
    let inner = &surface[3..surface.len() - 4];
    let steepest = inner.windows(2).map(slope).fold(0.0, f64::max);
    assert!(steepest < 32f64.to_radians().tan(), "no deposit is steeper than its friction: {steepest}");
}

#[test]
fn the_result_is_the_same_on_any_number_of_threads() {
    for value in [column(), fix(heap())] {
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut solver = start_solver(&DepthSph, &read_case(&value));
                advance_steps(solver.as_mut(), 30);
                solver.snapshot().hash()
            })
        };
        assert_eq!(run(1), run(3));
    }
}

#[test]
fn a_restored_run_is_bit_identical() {
    for value in [column(), fix(heap())] {
        let mut whole = start_solver(&DepthSph, &read_case(&value));
        advance_steps(whole.as_mut(), 20);
        let bytes = whole.checkpoint_bytes().unwrap();
        let mut again = start_solver(&DepthSph, &read_case(&value));
        again.restore(&mut &bytes[..]).unwrap();
        again.begin_stage(0, 0.0).unwrap();
        assert_eq!(again.snapshot().hash(), whole.snapshot().hash());
        advance_steps(whole.as_mut(), 105);
        advance_steps(again.as_mut(), 105);
        assert_eq!(again.snapshot().hash(), whole.snapshot().hash());
        assert!(again.restore(&mut &bytes[..bytes.len() - 9]).is_err());
    }
}

#[test]
fn two_phases_keep_their_masses_and_stay_together() {
    let mut solver = start_solver(&DepthSph, &read_case(&fix(heap())));
    let before = solver.totals();
    assert!((before.mass / (24.0 * 1990.0) - 1.0).abs() < 1e-12, "{}", before.mass);
    advance_steps(solver.as_mut(), 60);
    let after = solver.totals();
    assert_eq!(after.mass, before.mass);
    let liquid = after.liquid.unwrap();
    assert!((liquid.mass / 9600.0 - 1.0).abs() < 1e-12, "{}", liquid.mass);
    // Drag of this strength leaves a slip of a few per cent.
    let solid = (after.momentum[0] - liquid.momentum[0]) / (after.mass - liquid.mass);
    let fluid = liquid.momentum[0] / liquid.mass;
    assert!((fluid / solid - 1.0).abs() < 0.1, "{fluid} {solid}");
}

#[test]
fn momentum_is_along_the_bed_of_an_obstacle_and_grows_as_that_of_a_mass_point() {
    let (angle, friction) = (30f64.to_radians(), 0.3);
    let at = |x: f64, above: f64| [x, 3.0 - x * angle.tan() + above];
    let mut solver = start_solver(
        &DepthSph,
        &read_case(&json!({
            "title": "layer on a plane", "space": "plane-strain", "gravity": [0, -9.81],
            "domain": { "min": [-2, -5], "max": [12, 5] },
            "materials": { "sand": { "model": "mohr-coulomb", "density": 2000, "youngs_modulus": 1e7, "poissons_ratio": 0.3,
                                     "friction_angle": 40, "cohesion": 0 } },
            "bodies": [{ "name": "layer", "material": "sand", "shape": { "kind": "polygon",
                         "vertices": [at(1.0, -0.01), at(3.0, -0.01), at(3.0, 0.02), at(1.0, 0.02)] } }],
            "obstacles": [{ "name": "bed", "shape": { "kind": "plane", "point": [0, 3], "normal": [angle.sin(), angle.cos()] },
                            "wall": { "kind": "frictional", "friction_coefficient": friction } }],
            "stages": [{ "name": "slide", "duration": 1 }],
            "methods": { "depth-sph": { "spacing": 0.05 } }
        })),
    );
    advance_steps(solver.as_mut(), 100);
    let totals = solver.totals();
    let [x, y, _] = totals.momentum;
    assert!((y / x + angle.tan()).abs() < 1e-9, "{y} {x}");
    let size = x.hypot(y) / totals.mass;
    let exact = 9.81 * (angle.sin() - friction * angle.cos()) * solver.snapshot().time;
    assert!((size / exact - 1.0).abs() < 0.01, "{size} for {exact}");
}

/// Two halves of the heap, the first with more water.
fn halves() -> Value {
    let mut value = fix(heap());
    value["materials"]["wet"] = value["materials"]["debris"].clone();
    value["materials"]["wet"]["density"] = json!(1825);
    let mut wet = value["bodies"][0].clone();
    (wet["name"], wet["material"]) = (json!("wet"), json!("wet"));
    wet["shape"]["max"][0] = json!(3);
    value["bodies"][0]["shape"]["min"][0] = json!(3);
    value["bodies"].as_array_mut().unwrap().insert(0, wet);
    value["methods"]["depth-sph"]["mixture"]["porosities"] = json!({ "wet": 0.5 });
    value["methods"]["depth-sph"]["basal"] = json!({ "model": "coulomb", "friction_angle": 30 });
    value
}

#[test]
fn bodies_have_porosities_of_their_own() {
    let mut solver = start_solver(&DepthSph, &read_case(&halves()));
    let liquid = solver.totals().liquid.unwrap();
    // Twelve cubic metres each.
    assert!((liquid.mass / (12e3 * (0.5 + 0.4)) - 1.0).abs() < 1e-12, "{}", liquid.mass);
    advance_steps(solver.as_mut(), 1);
    let snapshot = solver.snapshot();
    let (excess, depth) =
        (snapshot.scalars("excess_pore_pressure").unwrap(), snapshot.scalars("depth").unwrap());
    let liquefaction = snapshot.scalars("liquefaction").unwrap();
    for (x, (wanted, porosity)) in [(2.0, (0, 0.5)), (4.0, (1, 0.4))] {
        let middle = |i: &usize| {
            (snapshot.positions[*i][0] - x).abs() < 0.3 && excess[*i].is_finite() && depth[*i] > 1.4
        };
        let i = (0..excess.len()).find(middle).unwrap();
        assert_eq!(snapshot.bodies[i], wanted);
        // Of the submerged weight over the depth. Sums include a little of the other half; its porosity would make 20 %.
        let exact = (1.0 - porosity) * 1650.0 * 9.3 * depth[i] * liquefaction[i];
        assert!((excess[i] / exact - 1.0).abs() < 0.01, "{} for {exact}", excess[i]);
    }
    let change = |change: &dyn Fn(&mut Value)| {
        let mut value = halves();
        change(&mut value["methods"]["depth-sph"]);
        refusal(&DepthSph, &value)
    };
    let starts = |text: String, start: &str| assert!(text.starts_with(start), "{text}");
    starts(
        change(&|v| v["mixture"]["porosities"]["dry"] = json!(0.2)),
        "methods.depth-sph.mixture.porosities: \"dry\"",
    );
    starts(
        change(&|v| v["mixture"]["porosities"]["wet"] = json!(0.45)),
        "materials.wet.density: 1825 kg/m³ is not",
    );
    starts(change(&|v| v["basal"] = Value::Null), "bodies[1].material: \"debris\" is not");
    let mut fluid = fix(heap());
    fluid["bodies"][0]["pore_fluid"] = json!({ "porosity": 0.4, "permeability": 1e-3 });
    // The material of a body with a pore fluid is its dry skeleton.
    starts(
        refusal(&DepthSph, &fluid),
        "methods.depth-sph.mixture.grain_density: 2650 differs from the value",
    );
}

#[test]
fn unsupported_features_are_refused_by_path() {
    let change = |change: &dyn Fn(&mut Value)| {
        let mut value = column();
        change(&mut value);
        refusal(&DepthSph, &value)
    };
    let starts = |text: String, start: &str| assert!(text.starts_with(start), "{text}");
    starts(change(&|v| v["space"] = json!("axisymmetric")), "space: ");
    starts(change(&|v| v["gravity"] = json!([0, 9.81])), "gravity[1]: ");
    for integration in ["runge-kutta2", "runge-kutta4"] {
        let options = json!({ "integration": integration, "xsph": 0.1 });
        let set = |v: &mut Value| {
            let own = v["methods"]["depth-sph"].as_object_mut().unwrap();
            own.extend(options.as_object().unwrap().clone());
        };
        starts(change(&set), "methods.depth-sph.xsph: ");
    }
    starts(change(&|v| v["boundaries"] = json!([])), "boundaries: there is no bed");
    starts(change(&|v| v["methods"] = json!({})), "methods.depth-sph: is missing");
    starts(
        change(&|v| v["methods"]["depth-sph"]["spacing"] = json!(-1)),
        "methods.depth-sph.spacing: -1 must be positive",
    );
    starts(change(&|v| v["bodies"][0]["shape"]["min"] = json!([0, 0.5])), "bodies[0].shape: there is a gap");
    let model =
        json!({ "model": "linear-elastic", "density": 1600, "youngs_modulus": 1e7, "poissons_ratio": 0.3 });
    starts(change(&|v| v["materials"]["sand"] = model.clone()), "materials.sand.model: ");
    starts(change(&|v| v["methods"]["depth-sph"]["phases"] = json!("two")), "methods.depth-sph.mixture: ");
    for (turbulence, problem) in
        [(json!(500), ""), (json!("none"), ""), (json!("much"), "neither a number nor")]
    {
        let mut value = column();
        value["methods"]["depth-sph"]["basal"] =
            json!({ "model": "voellmy", "friction_angle": 22, "turbulence": turbulence });
        match DepthSph.plan(&read_case(&value)) {
            Ok(_) => assert!(problem.is_empty(), "{turbulence}"),
            Err(error) => assert!(!problem.is_empty() && error.to_string().contains(problem), "{error}"),
        }
    }
    starts(change(&|v| v["methods"]["depth-sph"]["frame"] = json!("nonsense")), "methods.depth-sph.frame");
}

#[test]
fn an_equilibrium_stage_moves_no_nodes_and_causes_a_warning() {
    let mut value = column();
    value["stages"] = json!([
        { "name": "rest", "duration": 1, "equilibrium": {} },
        { "name": "release", "duration": 1 }
    ]);
    let case = read_case(&value);
    let plan = DepthSph.plan(&case).unwrap();
    assert!(
        plan.warnings.iter().any(|warning| warning.text.starts_with("stages[0]: ")),
        "{:?}",
        plan.warnings
    );
    let mut solver = start_solver(&DepthSph, &read_case(&value));
    let before = solver.snapshot().positions;
    advance_steps(solver.as_mut(), 3);
    assert_eq!(solver.snapshot().positions, before);
    assert_eq!(solver.equilibrium().map(|e| e.kinetic_ratio), Some(0.0));
    // Ten checks in a row, the default of the criterion, fit into the stage.
    assert!(solver.limit().dt * 10.0 * (solver.steps_between_checks() as f64) < 0.5);
}

/// Excess pressure is that of half a step before the output: the change of one step between two outputs is that of a whole step.
#[test]
fn shear_lowers_pore_pressure_of_dense_grains_and_raises_that_of_loose_ones() {
    // Hardly permeable, so that nothing drains in a step; porosity 0.4.
    let run = |critical: f64, steps: usize| {
        let mut value = fix(heap());
        value["bodies"][0]["velocity"]["value"] = json!([5, 0, 0]);
        let options = &mut value["methods"]["depth-sph"];
        options["mixture"]["drag"]["settling_velocity"] = json!(1e-9);
        options["column"] = json!({
            "cells": 8, "excess_ratio": 0.5, "skeleton": { "youngs_modulus": 1e4, "poissons_ratio": 0.3, "confinement": { "kind": "isotropic" } },
            "dilatancy": { "slope": 1.0, "critical_porosity": critical }
        });
        let mut solver = start_solver(&DepthSph, &read_case(&value));
        advance_steps(solver.as_mut(), steps);
        (solver.time(), solver.snapshot())
    };
    let pressure =
        |snapshot: &colluvium_case::Snapshot, i: usize| snapshot.scalars("excess_pore_pressure").unwrap()[i];
    let mut before = 0.0;
    for steps in [1, 2, 3] {
        let [(time, loose), (_, level), (_, dense)] = [0.3, 0.4, 0.5].map(|critical| run(critical, steps));
        // Grains in the middle of the heap, which disturbances of its edge have not reached yet.
        let middle = |i: &usize| {
            let x = level.positions[*i];
            (x[0] - 3.0).abs() < 0.8 && (x[1] - 5.0).abs() < 0.8 && pressure(&level, *i) > 0.0
        };
        let inside: Vec<usize> = (0..level.positions.len()).filter(middle).collect();
        assert!(inside.len() > 4, "grains in the middle: {}", inside.len());
        let apart = |i: &usize| pressure(&loose, *i) - pressure(&dense, *i);
        let found: Vec<f64> = inside.iter().map(apart).collect();
        for i in &inside {
            assert!(
                pressure(&dense, *i) < pressure(&level, *i) && pressure(&level, *i) < pressure(&loose, *i)
            );
        }
        let at = time - 0.5 * (time - before);
        for (number, i) in inside.iter().enumerate() {
            // `K γ' Δn t` with `K = E/(3(1 - 2ν))` and `γ' = 2 v/h`: whatever the porosity, the difference remains.
            let speed = level.vectors("velocity").unwrap()[*i][0];
            let rate = 2.0 * speed / level.scalars("depth").unwrap()[*i];
            let exact = 1e4 / (3.0 * 0.4) * rate * 0.2 * at;
            // Speed and depth change by some per cent in three steps.
            assert!(
                (found[number] / exact - 1.0).abs() < 0.05,
                "{steps} steps: {} for {exact}",
                found[number]
            );
        }
        before = time;
    }
}

/// The sheet's table of bad input (§7), as far as a case contains it: options, their values, and the key of the error.
fn bad_input() -> Vec<(&'static str, Value, &'static str)> {
    let skeleton = |more: Value| {
        let mut skeleton = json!({ "youngs_modulus": 1e7, "poissons_ratio": 0.3 });
        skeleton.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        json!({ "skeleton": skeleton })
    };
    vec![
        ("mixture", json!({ "grain_density": 0 }), "mixture.grain_density"),
        ("mixture", json!({ "grain_density": 2650, "fluid_density": -1 }), "mixture.fluid_density"),
        ("mixture", json!({ "grain_density": 2650, "porosity": 0 }), "mixture.porosity"),
        (
            "mixture",
            json!({ "grain_density": 2650, "drag": { "law": "anderson", "settling_velocity": 0.1, "exponent": 11 } }),
            "mixture.drag.exponent",
        ),
        (
            "mixture",
            json!({ "grain_density": 2650, "drag": { "law": "darcy", "permeability": 0 } }),
            "mixture.drag.permeability",
        ),
        ("column", skeleton(json!({ "youngs_modulus": -1 })), "column.skeleton.youngs_modulus"),
        ("column", skeleton(json!({ "poissons_ratio": 0.5 })), "column.skeleton.poissons_ratio"),
        (
            "column",
            skeleton(json!({ "confinement": { "kind": "value", "alpha": 0 } })),
            "column.skeleton.confinement.alpha",
        ),
        (
            "column",
            skeleton(json!({ "confinement": { "kind": "lateral", "k0": -0.1 } })),
            "column.skeleton.confinement.k0",
        ),
        ("column", json!({ "consolidation": -1 }), "column.consolidation"),
        ("column", json!({ "consolidation": 1, "cells": 1001 }), "column.cells"),
        ("basal", json!({ "model": "coulomb", "friction_angle": 90 }), "basal"),
        ("basal", json!({ "model": "voellmy", "friction_angle": 10, "turbulence": 0 }), "basal"),
        ("basal", json!({ "model": "coulomb", "friction_angle": -1 }), "basal"),
        ("erosion", json!({ "law": "hungr", "rate": -0.1 }), "erosion.rate"),
        ("drainage", json!({ "kind": "partly", "conductance": 0 }), "drainage.conductance"),
        ("drainage", json!({ "kind": "leaky" }), "drainage"),
        ("smoothing", json!(3.5), "smoothing"),
        ("courant", json!(0), "courant"),
    ]
}

#[test]
fn bad_input_is_refused_under_its_key() {
    for (key, value, path) in bad_input() {
        let mut bad = fix(heap());
        bad["methods"]["depth-sph"][key] = value;
        let problem = refusal(&DepthSph, &bad);
        assert!(problem.starts_with(&format!("methods.depth-sph.{path}")), "{key}: {problem}");
        assert_eq!(problem.lines().count(), 1, "{problem}");
    }
    let mut up = fix(heap());
    up["gravity"] = json!([0, 0, 9.81]);
    assert!(refusal(&DepthSph, &up).starts_with("gravity[2]: "), "{}", refusal(&DepthSph, &up));
    let mut small = fix(heap());
    small["bodies"][0]["shape"] = json!({ "kind": "box", "min": [1.1, 3.1, 0], "max": [1.15, 3.15, 1] });
    assert!(
        refusal(&DepthSph, &small).starts_with("bodies: no body covers a point"),
        "{}",
        refusal(&DepthSph, &small)
    );
}

/// A permeable bed needs columns; a steep bed and an obstacle that no flow reaches give a warning.
#[test]
fn input_without_effect_is_refused_or_causes_a_warning() {
    let region = |low: f64, more: Value| {
        let mut case = fix(heap());
        let mut region = json!({ "shape": { "kind": "box", "min": [low, 2], "max": [low + 1.0, 4] } });
        region.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        case["methods"]["depth-sph"]["regions"] = json!([region]);
        refusal(&DepthSph, &case)
    };
    let start = "methods.depth-sph.regions[0]";
    assert!(region(1.0, json!({})).starts_with(&format!("{start}: has no property of the bed")));
    let beyond = region(101.0, json!({ "basal": { "model": "none" } }));
    assert!(
        beyond.starts_with(&format!(
            "{start}.shape: lies outside the domain: it reaches from 101 to 102 m along x"
        )),
        "{beyond}"
    );
    let mut dry = fix(heap());
    dry["methods"]["depth-sph"] = json!({ "spacing": 0.1, "drainage": { "kind": "atmospheric" } });
    assert!(
        refusal(&DepthSph, &dry)
            .starts_with("methods.depth-sph.drainage: applies only with pore-pressure columns"),
        "{}",
        refusal(&DepthSph, &dry)
    );
    dry["methods"]["depth-sph"] =
        json!({ "spacing": 0.1, "basal": { "model": "coulomb", "friction_angle": 51 } });
    let warnings = DepthSph.plan(&read_case(&dry)).unwrap().warnings;
    assert!(
        warnings.iter().any(|warning| warning.text.contains("basal.friction_angle: 51 degrees")),
        "{warnings:?}"
    );
    dry["gravity"] = json!([0, 0, -9.81]);
    dry["obstacles"] = json!([
        { "name": "ground", "wall": { "kind": "rough" }, "shape": { "kind": "plane", "point": [0, 0, 0], "normal": [0, 0, 1] } },
        { "name": "house", "wall": { "kind": "rough" }, "shape": { "kind": "box", "min": [-9, 1, 0], "max": [-8, 2, 1] } }
    ]);
    let warnings = DepthSph.plan(&read_case(&dry)).unwrap().warnings;
    assert!(
        warnings.iter().any(|warning| warning.text.starts_with(
            "obstacles[1].shape: lies outside the domain and has no effect: it reaches from -9 to -8 m"
        )),
        "{warnings:?}"
    );
}

/// Rotated cells of the search change the order of sums and nothing else.
#[test]
fn search_cells_rotated_with_the_flow_find_the_same_neighbours() {
    let mut along = fix(heap());
    along["bodies"][0]["shape"]["max"][1] = json!(5);
    let mut turned = along.clone();
    turned["methods"]["depth-sph"]["search"] = json!("turned");
    let ran = |value: &Value, steps: usize| {
        let mut solver = start_solver(&DepthSph, &read_case(value));
        advance_steps(solver.as_mut(), steps);
        solver.snapshot()
    };
    let [one, other] = [&along, &turned].map(|value| ran(value, 30));
    assert_ne!(one.hash(), other.hash());
    for (a, b) in one.positions.iter().zip(&other.positions) {
        assert!((0..3).all(|c| (a[c] - b[c]).abs() < 1e-9), "{a:?} {b:?}");
    }
    let mut profile = column();
    profile["methods"]["depth-sph"]["search"] = json!("turned");
    let error = refusal(&DepthSph, &profile);
    assert!(error.starts_with("methods.depth-sph.search: a profile has one axis"), "{error}");
    let hash = |threads, restart| hash_after(&DepthSph, &turned, threads, 40, restart);
    assert_eq!(hash(1, None), hash(3, None));
    assert_eq!(hash(1, None), hash(1, Some(17)));
}
