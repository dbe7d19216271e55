//! Saturated bodies against closed forms (sheet: mpm ), and the solver's invariants with two phases.

use colluvium_case::{Case, Method, StepLimit};
use colluvium_mpm::Mpm;
use colluvium_testkit::{
    CaseBuilder, advance_steps, assert_same_after_restart, assert_same_on_threads, case_with, read_case,
    scalars, solve, start_solver, stresses, take_steps, vectors, with_keys,
};
use serde_json::{Value, json};

/// A saturated column of 1 m that fills the domain: grains 2650, porosity 0.4.
fn saturated_column() -> CaseBuilder {
    CaseBuilder::new("1d", &[0.0], &[1.0])
        .elastic("m", 1590.0, 1e7, 0.0)
        .body(json!({
            "name": "b", "material": "m", "shape": { "kind": "box", "min": [0], "max": [1] },
            "pore_fluid": { "porosity": 0.4, "intrinsic_permeability": 1.019367991845056e-10 }
        }))
        .stage("s", 1.0)
        .options("mpm", json!({ "cell_size": 0.1, "points_per_cell": 1, "shape": "linear" }))
}

#[test]
fn drag_equalises_the_phase_velocities_and_conserves_momentum() {
    // w decays as (1 - a dt)^N, a = n rho g / ((1-n) rho_S k); momentum stays. In one and in three dimensions.
    let fluid = |speed: Vec<f64>| {
        json!({ "porosity": 0.4, "intrinsic_permeability": 1.019367991845056e-10,
                "velocity": { "kind": "uniform", "value": speed } })
    };
    let line = saturated_column()
        .with(json!({
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.3], "max": [0.7] },
                         "pore_fluid": fluid(vec![0.02]) }]
        }))
        .build();
    let block = saturated_column().with(json!({
        "space": "3d", "domain": { "min": [0, 0, 0], "max": [1, 1, 1] }, "gravity": [0, 0, 0],
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.3, 0.3, 0.3], "max": [0.7, 0.7, 0.7] },
                     "pore_fluid": fluid(vec![0.02, -0.01, 0.03]) }],
        "methods": { "mpm": { "cell_size": 0.1 } }
    })).build();
    let rate = 0.4 * 1990.0 * 9.81 / (1590.0 * 1e-3);
    for case in [line, block] {
        let mut solver = start_solver(&Mpm, &case);
        let start = solver.totals();
        let dt = 1e-5;
        take_steps(&mut *solver, 40, dt);
        let snapshot = solver.snapshot();
        let (solid, liquid) = (vectors(&snapshot, "velocity"), vectors(&snapshot, "liquid_velocity"));
        let keep = (1.0 - rate * dt).powi(40);
        for (v, w) in solid.iter().zip(&liquid) {
            for (c, initial) in
                vectors(&start_solver(&Mpm, &case).snapshot(), "liquid_velocity")[0].iter().enumerate()
            {
                assert!((w[c] - v[c] - initial * keep).abs() < 1e-12, "{v:?}, {w:?}");
            }
        }
        let end = solver.totals();
        for c in 0..3 {
            assert!((end.momentum[c] - start.momentum[c]).abs() < 1e-10 * start.mass);
        }
        assert!((start.mass / start.liquid.unwrap().mass - 1990.0 / 400.0).abs() < 1e-12);
    }
}

#[test]
fn water_seeps_through_a_held_skeleton_at_the_rate_of_darcy() {
    // a wall over the whole column holds the grains and is permeable to water; gravity is a gradient of 1.
    let case = saturated_column().with(json!({
        "gravity": [-9.81],
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0], "max": [1] },
                     "pore_fluid": { "porosity": 0.4, "permeability": 1e-3 } }],
        "boundaries": [{ "side": "x-min", "position": 1.0, "wall": { "kind": "rough" }, "drained": true }],
        "stages": [{ "name": "s", "duration": 2e-3 }]
    })).build();
    for (duration, tolerance) in [(2e-4, 0.03), (5e-3, 1e-3)] {
        let mut case = case.clone();
        case.stages[0].duration = duration;
        case.output.measures = Some(duration / 100.0);
        let report = solve(&Mpm, &case);
        let exact = -1e-3 / 0.4 * (1.0 - (-0.4 * 9.81 * duration / 1e-3f64).exp());
        for (v, w) in
            vectors(&report.snapshot, "velocity").iter().zip(vectors(&report.snapshot, "liquid_velocity"))
        {
            assert_eq!(v[0], 0.0);
            // Explicit drag is of first order in a dt, about 0.05 here with a step a row; the steady flux is exact.
            assert!((w[0] / exact - 1.0).abs() < tolerance, "{} instead of {exact} at {duration}", w[0]);
        }
    }
}

/// The column between two impermeable walls, the upper one moving in.
fn closed(scheme: &str, volumetric: &str) -> Case {
    saturated_column().with(json!({
        "boundaries": [{ "side": "x-min", "wall": { "kind": "smooth" } },
                       { "side": "x-max", "wall": { "kind": "smooth" }, "velocity": [-1e-3] }],
        "methods": { "mpm": { "cell_size": 1, "points_per_cell": 1, "shape": "linear", "stress_update": scheme,
                              "volumetric_strain": volumetric } }
    })).build()
}

#[test]
fn undrained_compression_splits_stress_by_the_stiffness_of_the_phases() {
    // one confined element between impermeable walls.
    for scheme in ["musl", "usl", "usf"] {
        for volumetric in ["point", "cell-average"] {
            let mut solver = start_solver(&Mpm, &closed(scheme, volumetric));
            take_steps(&mut *solver, 10, 1e-6);
            let snapshot = solver.snapshot();
            let strain = -1e-3 * 1e-5;
            let pressure = scalars(&snapshot, "pore_pressure")[0];
            assert!((pressure / (-2.15e9 / 0.4 * strain) - 1.0).abs() < 1e-6, "{pressure}");
            let total = snapshot.tensors("total_stress").unwrap()[0][0];
            assert!((total / ((1e7 + 2.15e9 / 0.4) * strain) - 1.0).abs() < 1e-6, "{total}");
            // All faces are shut: the two phases move as one, and so does the liquid's mass.
            let liquid = solver.totals().liquid.unwrap();
            assert!((liquid.mass - 400.0).abs() < 1e-5, "{}", liquid.mass);
        }
    }
}

#[test]
fn undrained_radial_compression_splits_stress_by_the_stiffness_of_the_phases() {
    // A-23 with a mantle that moves in: strains along the radius and around the axis are alike.
    for (scheme, volumetric, mesh) in [
        ("musl", "point", false),
        ("usl", "cell-average", false),
        ("musl", "nodal", false),
        ("usl", "nodal", true),
    ] {
        let wall = |side: &str| json!({ "side": side, "wall": { "kind": "smooth" } });
        let mut mantle = wall("x-max");
        mantle["velocity"] = json!([-1e-3, 0]);
        let mut mpm = json!({ "cell_size": 1, "shape": "linear", "stress_update": scheme, "volumetric_strain": volumetric });
        if mesh {
            mpm["mesh"] = json!({ "kind": "box" });
        }
        let cylinder = saturated_column().with(json!({
            "space": "axisymmetric", "domain": { "min": [0, 0], "max": [1, 1] }, "gravity": [0, 0],
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 1] },
                         "pore_fluid": { "porosity": 0.4, "intrinsic_permeability": 1.019367991845056e-10 } }],
            "boundaries": [mantle, wall("y-min"), wall("y-max")], "methods": { "mpm": mpm }
        })).build();
        let mut solver = start_solver(&Mpm, &cylinder);
        take_steps(&mut *solver, 10, 1e-6);
        let (snapshot, strain) = (solver.snapshot(), -1e-3 * 1e-5);
        let water = 2.15e9 / 0.4 * 2.0 * strain;
        for (pressure, total) in
            scalars(&snapshot, "pore_pressure").iter().zip(snapshot.tensors("total_stress").unwrap())
        {
            assert!((pressure / -water - 1.0).abs() < 1e-6, "{scheme}, {volumetric}, {mesh}: {pressure}");
            for (place, skeleton) in [(0, 1e7), (1, 0.0), (2, 1e7)] {
                let exact = water + skeleton * strain;
                assert!(
                    (total.0[place] / exact - 1.0).abs() < 1e-6,
                    "{scheme}, {volumetric}, {mesh}: {total:?}"
                );
            }
        }
    }
}

#[test]
fn water_seeps_towards_a_well_as_the_logarithm_of_the_radius() {
    // Steady flow through a held ring from 1.5 m, under pressure, to 0.5 m: p = p_0 ln(r/0.5)/ln 3, and r n v_L is the same
    // everywhere. Strains are shared: v/r is not linear, so that pressure differences of points within a cell, to
    // which the nodes are insensitive, would grow without bound.
    let wall = |side: &str| json!({ "side": side, "wall": { "kind": "smooth" } });
    let ring = saturated_column().with(json!({
        "space": "axisymmetric", "domain": { "min": [0.5, 0], "max": [1.5, 0.05] }, "gravity": [0, 0],
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.5, 0], "max": [1.5, 0.05] },
                     "pore_fluid": { "porosity": 0.4, "intrinsic_permeability": 1.019367991845056e-10 } }],
        "boundaries": [{ "side": "x-min", "position": 1.5, "wall": { "kind": "rough" }, "drained": true },
                       wall("y-min"), wall("y-max")],
        "loads": [{ "kind": "pore-pressure", "body": "b", "side": "x-max", "value": 1000 }],
        "stages": [{ "name": "s", "duration": 0.05 }],
        "methods": { "mpm": { "cell_size": 0.05, "shape": "linear", "volumetric_strain": "cell-average" } }
    })).build();
    let report = solve(&Mpm, &ring);
    let (pressure, velocity) =
        (scalars(&report.snapshot, "pore_pressure"), vectors(&report.snapshot, "liquid_velocity"));
    let flux = -1e-3 / 9810.0 * 1000.0 / 3f64.ln();
    for (x, p) in report.snapshot.positions.iter().zip(&pressure) {
        let exact = 1000.0 * (x[0] / 0.5).ln() / 3f64.ln();
        // The load acts on the layer of points a quarter of a cell inside, and their cell has part of it.
        assert!(x[0] > 1.45 || (p - exact).abs() < 0.03 * 1000.0, "{p} for {exact} at {x:?}");
    }
    // Velocity differences of points from the onset of the flow, to which the nodes are insensitive, remain: the mean is compared.
    let discharge = |(x, v): (&[f64; 3], &[f64; 3])| 0.4 * v[0] * x[0];
    let mean =
        report.snapshot.positions.iter().zip(&velocity).map(discharge).sum::<f64>() / velocity.len() as f64;
    assert!((mean / flux - 1.0).abs() < 0.02, "{mean} for {flux}");
}

#[test]
fn a_saturated_column_in_balance_stays_at_rest() {
    // hydrostatic water, the skeleton under its buoyant weight; centred points are in discrete balance.
    for integration in ["points", "mixed"] {
        let case = saturated_column().with(json!({
            "gravity": [-9.81],
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0], "max": [1] },
                         "stress": { "kind": "k0", "surface": 1.0, "coefficient": 0.0 },
                         "pore_fluid": { "porosity": 0.4, "permeability": 1e-3,
                                         "pressure": { "kind": "hydrostatic", "surface": 1.0 } } }],
            "boundaries": [{ "side": "x-min", "wall": { "kind": "rough" } }],
            "stages": [{ "name": "s", "duration": 10, "equilibrium": { "unbalanced_force": 1e-9, "kinetic_energy": 1e-9 } }],
            "methods": { "mpm": { "cell_size": 0.05, "points_per_cell": 1, "shape": "linear", "integration": integration } }
        })).build();
        let mut solver = start_solver(&Mpm, &case);
        advance_steps(&mut *solver, 10_000);
        let snapshot = solver.snapshot();
        for field in ["velocity", "liquid_velocity"] {
            assert!(vectors(&snapshot, field).iter().all(|v| v[0].abs() < 1e-6), "{field}");
        }
        let (pressure, stress) = (scalars(&snapshot, "pore_pressure"), stresses(&snapshot));
        for ((x, p), s) in snapshot.positions.iter().zip(&pressure).zip(&stress) {
            let depth = 1.0 - x[0];
            assert!((p / (9810.0 * depth) - 1.0).abs() < 1e-6);
            assert!((s[0] / (-0.6 * 1650.0 * 9.81 * depth) - 1.0).abs() < 1e-6);
        }
        assert!(solver.equilibrium().unwrap().unbalanced_force < 1e-9, "{integration}");
    }
}

/// The column of 1 m under a plate, whose name is `lid`, that moves in by 1 mm/s.
fn under_a_plate(drained: bool, more: &Value) -> Case {
    let plate = saturated_column().with(json!({
        "domain": { "min": [0], "max": [1.2] },
        "boundaries": [{ "side": "x-min", "wall": { "kind": "smooth" } }],
        "patches": [{ "name": "lid", "region": { "kind": "box", "min": [1], "max": [1.2] }, "moves": true, "drained": drained }],
        "stages": [{ "name": "s", "duration": 1, "motions": [{ "target": "lid", "velocity": [-1e-3] }] }],
        "measures": { "force": { "kind": "reaction", "target": "lid" } }
    })).build();
    case_with(serde_json::to_value(&plate).unwrap(), more)
}

#[test]
fn a_plate_compresses_both_phases_as_a_wall_does() {
    // A-23 by a patch: all faces are shut.
    for scheme in ["musl", "usl", "usf"] {
        let plate = under_a_plate(
            false,
            &json!({ "domain": { "min": [0], "max": [2] },
                     "methods": { "mpm": { "cell_size": 1, "points_per_cell": 1, "shape": "linear", "stress_update": scheme } } }),
        );
        let mut solvers = [start_solver(&Mpm, &plate), start_solver(&Mpm, &closed(scheme, "point"))];
        for solver in &mut solvers {
            take_steps(&mut **solver, 10, 1e-6);
        }
        let pressures = solvers.each_ref().map(|solver| scalars(&solver.snapshot(), "pore_pressure")[0]);
        assert!((pressures[0] / pressures[1] - 1.0).abs() < 1e-6, "{scheme}: {pressures:?}");
        // Force of the stresses at the start of the last step, of the strains by then.
        let strain = if scheme == "usf" { 1e-3 * 1e-5 } else { 1e-3 * 9e-6 };
        let force = solvers[0].reaction("lid").unwrap().force[0];
        assert!((force / ((1e7 + 2.15e9 / 0.4) * strain) - 1.0).abs() < 1e-6, "{scheme}: {force}");
    }
}

#[test]
fn a_porous_plate_expels_the_pore_water() {
    // Compressed by 1 %; then the skeleton carries the whole load (H²/c_v is 1 s), or the water most of it for all time.
    let stages = |damping: f64| {
        json!([
            { "name": "press", "duration": 0.2, "motions": [{ "target": "lid", "velocity": [-0.05], "ramp": 0.04 }] },
            { "name": "rest", "duration": 2, "damping": damping, "motions": [{ "target": "lid", "velocity": [0] }] },
            { "name": "hold", "duration": 1, "damping": damping, "motions": [{ "target": "lid", "velocity": [0] }],
              "equilibrium": { "unbalanced_force": 1e-6, "kinetic_energy": 1e-3 } }
        ])
    };
    let strain = -(1.0 - 0.05 * 0.18f64).ln();
    let body = json!([{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0], "max": [1] },
                        "pore_fluid": { "porosity": 0.4, "intrinsic_permeability": 1.019367991845056e-10, "bulk_modulus": 1e8 } }]);
    for scheme in ["musl", "usf"] {
        for (drained, modulus) in [(true, 1e7), (false, 1e7 + 1e8 / 0.4)] {
            let report = solve(
                &Mpm,
                &under_a_plate(
                    drained,
                    &json!({ "stages": stages(if drained { 0.0 } else { 0.3 }), "bodies": body,
                         "methods": { "mpm": { "cell_size": 0.2, "points_per_cell": 2, "stress_update": scheme } } }),
                ),
            );
            let impulses = report.table.pairs("time", "force.impulse.x").unwrap();
            let [first, last] = [impulses[impulses.len() / 2], impulses[impulses.len() - 1]];
            let force = (last.1 - first.1) / (last.0 - first.0);
            assert!((force / (modulus * strain) - 1.0).abs() < 0.02, "{scheme}, {drained}: {force}");
            let pressure = scalars(&report.snapshot, "pore_pressure").iter().sum::<f64>() / 10.0;
            let exact = if drained { 0.0 } else { 1e8 / 0.4 * strain };
            assert!((pressure - exact).abs() < 0.02 * modulus * strain, "{scheme}, {drained}: {pressure}");
        }
    }
}

/// A saturated block that is thrown against a rough drained floor, beside a dry one.
fn crash(shape: &str, volumetric: &str) -> Case {
    saturated_column().with(json!({
        "space": "plane-strain", "domain": { "min": [0, 0], "max": [1, 1] }, "gravity": [0, -10],
        "materials": { "m": { "model": "drucker-prager", "density": 1590, "youngs_modulus": 1e6, "poissons_ratio": 0.3,
                              "friction_angle": 20, "cohesion": 500 } },
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.3, 0.1], "max": [0.6, 0.4] },
                     "velocity": { "kind": "uniform", "value": [0.2, -1.0] },
                     "pore_fluid": { "porosity": 0.4, "permeability": 0.01, "bulk_modulus": 1e7,
                                     "cavitation_strength": 1e4 } },
                   { "name": "dry", "material": "m", "shape": { "kind": "box", "min": [0.6, 0.1], "max": [0.7, 0.3] } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "frictional", "friction_coefficient": 0.3 } },
                       { "side": "x-min", "wall": { "kind": "smooth" }, "drained": true },
                       { "side": "x-max", "wall": { "kind": "smooth" } }],
        "stages": [{ "name": "s", "duration": 0.12 }],
        "methods": { "mpm": { "cell_size": 0.05, "shape": shape, "volumetric_strain": volumetric, "courant": 0.5 } }
    })).build()
}

#[test]
fn results_are_the_same_on_one_and_two_threads() {
    for (shape, volumetric, integration) in [
        ("ugimp", "point", "points"),
        ("ugimp", "cell-average", "points"),
        ("quadratic", "point", "points"),
        ("linear", "nodal", "mixed"),
    ] {
        let mut case = crash(shape, volumetric);
        case.methods.get_mut("mpm").unwrap()["integration"] = json!(integration);
        assert_same_on_threads(&Mpm, &case, &format!("{shape}, {volumetric}, {integration}"));
    }
}

#[test]
fn a_restored_solver_continues_bit_identically() {
    let case = crash("ugimp", "point");
    assert_same_after_restart(&Mpm, &case, |solver| advance_steps(solver, 137));
}

#[test]
fn options_without_support_for_two_phases_are_rejected_by_key() {
    let refused = |change: &dyn Fn(&mut Case)| {
        let mut case = crash("ugimp", "point");
        change(&mut case);
        Mpm.plan(&case).unwrap_err().to_string()
    };
    let options = [
        ("transfer", json!("tpic")),
        ("transfer", json!("xpic")),
        ("contacts", json!([{ "bodies": ["b", "dry"] }])),
    ];
    for (key, value) in options {
        let problem = refused(&|c| c.methods.get_mut("mpm").unwrap()[key] = value.clone());
        assert!(problem.starts_with(&format!("methods.mpm.{key}")), "{problem}");
    }
}

#[test]
fn the_courant_number_without_an_entry_is_that_of_the_criterion() {
    let fast = Mpm.plan(&saturated_column().build()).unwrap().time_step.dt;
    let options =
        json!({ "mpm": { "cell_size": 0.1, "points_per_cell": 1, "shape": "linear", "courant": 0.45 } });
    let slow =
        Mpm.plan(&saturated_column().with(json!({ "methods": options })).build()).unwrap().time_step.dt;
    assert!((fast / slow - 2.0).abs() < 1e-12);
    // USL keeps the default of one phase: beyond it overshoots at free surfaces.
    let options = json!({ "mpm": { "cell_size": 0.1, "points_per_cell": 1, "shape": "linear", "stress_update": "usl" } });
    let last =
        Mpm.plan(&saturated_column().with(json!({ "methods": options })).build()).unwrap().time_step.dt;
    assert!((fast / last - 1.8).abs() < 1e-12);
    // sheet: mpm §2.10, first row.
    assert!((fast / (0.9 * 5.095711e-5) - 1.0).abs() < 2e-7, "{fast}");
}

#[test]
fn the_simple_criterion_limits_the_step_by_undrained_wave_or_drag() {
    let plan = |permeability: f64, more: Value| {
        let options =
            json!({ "cell_size": 0.1, "points_per_cell": 1, "shape": "linear", "step_criterion": "simple" });
        let fluid = json!({ "porosity": 0.4, "intrinsic_permeability": permeability });
        let body = json!([{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0], "max": [1] },
                            "pore_fluid": fluid }]);
        let case = saturated_column()
            .with(json!({ "bodies": body, "methods": { "mpm": with_keys(options, &more) } }))
            .build();
        Mpm.plan(&case).unwrap()
    };
    // sheet: mpm §2.10, first two rows; k of 10⁻³ and 10⁻⁵ m/s. Inertia β slows waves by its root and drag by itself.
    let (wave, drag) = (6.0790e-5, 5.0765e-6);
    for (k, more, exact, limit) in [
        (1e-3, json!({}), 0.5 * wave, StepLimit::ELASTIC_WAVE),
        (1e-3, json!({ "courant": 0.8, "mass_scaling": 4 }), 1.6 * wave, StepLimit::ELASTIC_WAVE),
        (1e-5, json!({}), drag, StepLimit::SEEPAGE_DRAG),
        (1e-5, json!({ "courant": 0.8, "mass_scaling": 4 }), 4.0 * drag, StepLimit::SEEPAGE_DRAG),
    ] {
        let plan = plan(k * 1e-3 / 9.81e3, more);
        assert!((plan.time_step.dt / exact - 1.0).abs() < 1e-4, "{} for {exact}", plan.time_step.dt);
        assert_eq!(plan.time_step.limit, limit);
        assert!(plan.warnings.iter().any(|warning| warning.text.starts_with("methods.mpm.step_criterion")));
    }
    let options = json!({ "mpm": { "cell_size": 0.1, "step_criterion": "simple" } });
    let dry = json!([{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0], "max": [1] } }]);
    let problem = Mpm
        .plan(&saturated_column().with(json!({ "bodies": dry, "methods": options })).build())
        .unwrap_err()
        .to_string();
    assert!(problem.starts_with("methods.mpm.step_criterion: simple is for two phases"), "{problem}");
}

#[test]
fn the_default_step_is_stable_in_every_space() {
    let spaces = [("1d", "x"), ("plane-strain", "y"), ("3d", "z")];
    for (dimension, (space, axis)) in (1..).zip(spaces) {
        // Shut on all sides but the top: otherwise water runs out, and at a high permeability freely.
        let wall = |side: String| json!({ "side": side, "wall": { "kind": "smooth" } });
        let around = ["x", "y"].into_iter().take(dimension - 1);
        let mut walls: Vec<Value> =
            around.flat_map(|a| [wall(format!("{a}-min")), wall(format!("{a}-max"))]).collect();
        walls.push(wall(format!("{axis}-min")));
        let all = |value: f64| vec![value; dimension];
        let up = |value: f64| {
            let mut vector = all(0.0);
            vector[dimension - 1] = value;
            vector
        };
        let mut top = all(0.8);
        top[dimension - 1] = 1.0;
        for (shape, scheme) in [
            ("linear", "musl"),
            ("ugimp", "musl"),
            ("quadratic", "musl"),
            ("ugimp", "usl"),
            ("cpgimp", "usf"),
        ] {
            for permeability in [1e-5, 1e-2, 10.0] {
                let soaked = saturated_column().with(json!({
                    "space": space, "domain": { "min": all(0.0), "max": top }, "gravity": up(-1.0),
                    "materials": { "m": { "model": "linear-elastic", "density": 1590, "youngs_modulus": 1e6, "poissons_ratio": 0.3 } },
                    "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": all(0.0), "max": all(0.8) },
                                 "pore_fluid": { "porosity": 0.4, "permeability": permeability, "bulk_modulus": 1e7 } }],
                    "boundaries": walls,
                    "methods": { "mpm": { "cell_size": 0.2, "shape": shape, "stress_update": scheme } }
                })).build();
                let mut solver = start_solver(&Mpm, &soaked);
                let start = solver.totals();
                advance_steps(&mut *solver, if dimension == 3 { 200 } else { 1000 });
                // It oscillates under its weight, and gains nothing: the fall of 0.8 m bounds it by far.
                let end = solver.totals();
                assert!(
                    end.kinetic < 0.01 * start.mass,
                    "{space}, {shape}, {scheme}, k = {permeability}: {}",
                    end.kinetic
                );
            }
        }
    }
}

#[test]
fn friction_of_a_wall_depends_on_the_effective_stress() {
    // A saturated layer at rest under its weight, under which the floor begins to move: of 19.9 kPa only the 9.9 kPa of the
    // skeleton cause friction.
    let layer = |friction: Value| {
        read_case(&json!({
            "title": "test", "space": "plane-strain", "domain": { "min": [0, 0], "max": [0.5, 1.2], "periodic": ["x"] },
            "gravity": [0, -10],
            "materials": { "m": { "model": "linear-elastic", "density": 1590, "youngs_modulus": 1e6, "poissons_ratio": 0 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [0.5, 1] },
                         "stress": { "kind": "k0", "surface": 1, "coefficient": 0.5 },
                         "pore_fluid": { "porosity": 0.4, "permeability": 1e-3, "density": 1000, "bulk_modulus": 1e8,
                                         "pressure": { "kind": "hydrostatic", "surface": 1 } } }],
            "boundaries": [{ "side": "y-min", "wall": { "kind": "frictional", "friction_coefficient": 0.5 },
                             "velocity": [1, 0] }],
            "stages": [{ "name": "s", "duration": 0.1 }],
            "methods": { "mpm": { "cell_size": 0.1, "wall_friction": friction } }
        }))
    };
    for friction in ["impulse", "acceleration"] {
        let report = solve(&Mpm, &layer(json!(friction)));
        let velocities = vectors(&report.snapshot, "velocity");
        let mean = velocities.iter().map(|v| v[0]).sum::<f64>() / velocities.len() as f64;
        let exact = 0.5 * 10.0 * 990.0 / 1990.0 * 0.1;
        assert!((mean / exact - 1.0).abs() < 0.1, "{friction}: {mean} instead of {exact} m/s");
    }
}

#[test]
fn a_saturated_body_under_traction_reaches_equilibrium() {
    let case = saturated_column().with(json!({
        "loads": [{ "kind": "traction", "body": "b", "side": "x-max", "value": [-1e4] }],
        "boundaries": [{ "side": "x-min", "wall": { "kind": "rough" } }],
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0], "max": [1] },
                     "pore_fluid": { "porosity": 0.4, "intrinsic_permeability": 1.019367991845056e-10, "bulk_modulus": 2e7 } }],
        "stages": [{ "name": "s", "duration": 3, "damping": 0.5, "equilibrium": {} }],
        "methods": { "mpm": { "cell_size": 0.1, "points_per_cell": 2, "shape": "linear" } }
    })).build();
    let report = solve(&Mpm, &case);
    assert!(report.snapshot.time < 3.0, "{}", report.snapshot.time);
    let total = report.snapshot.tensors("total_stress").unwrap();
    // The points of the last cell share its face.
    assert!(total[..18].iter().all(|s| (s[0] / -1e4 - 1.0).abs() < 0.05), "{total:?}");
}
