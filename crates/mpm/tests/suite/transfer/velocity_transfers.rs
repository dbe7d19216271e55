//! Transfers of velocity, damping and mass scaling against the statements of the MPM sheet.

use colluvium_case::{Budget, Case, Method, RunOptions, RunReport, Solver, run};
use colluvium_mpm::Mpm;
use colluvium_testkit::{
    CaseBuilder, advance_steps, assert_same_after_restart, assert_same_on_threads, read_case, scalar_output,
    solve, start_solver, vectors, with_keys,
};
use serde_json::{Value, json};

/// Square of 2 m and an elastic material. The test adds bodies, stages and options.
fn square() -> CaseBuilder {
    CaseBuilder::plane_strain([0.0, 0.0], [2.0, 2.0]).elastic("m", 1000.0, 1e5, 0.0)
}

/// A spinning and stretching block, free.
pub fn spinning(options: &Value) -> Case {
    let mut mpm = json!({ "cell_size": 0.1, "courant": 0.3 });
    for (key, value) in options.as_object().unwrap() {
        mpm[key] = value.clone();
    }
    square().with(json!({
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0.7, 0.8], "max": [1.3, 1.2] },
                     "velocity": { "kind": "linear", "value": [0.3, -0.2], "origin": [1.0, 1.0],
                                   "gradient": [[0.2, -1.0], [1.5, -0.1]] } }],
        "stages": [{ "name": "s", "duration": 1 }],
        "methods": { "mpm": mpm }
    })).build()
}

/// Factor of a step on a mode `sin x` on a line with one point in the middle of each cell of 1 m, at the points far from the ends, without
/// stress.
fn factor(options: &Value) -> f64 {
    let mut mpm = json!({ "cell_size": 1, "points_per_cell": 1, "shape": "linear", "stress_update": "usl" });
    for (key, value) in options.as_object().unwrap() {
        mpm[key] = value.clone();
    }
    let case = square()
        .with(json!({
            "space": "1d", "domain": { "min": [0], "max": [80] }, "gravity": [0],
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [1], "max": [79] },
                         "velocity": { "kind": "sine", "amplitude": [1], "wave_vector": [1] } }],
            "stages": [{ "name": "s", "duration": 1 }],
            "methods": { "mpm": mpm }
        }))
        .build();
    let mut solver = start_solver(&Mpm, &case);
    let before = vectors(&solver.snapshot(), "velocity");
    solver.step(1e-6).unwrap();
    let after = vectors(&solver.snapshot(), "velocity");
    let factors = (35..45).map(|p| after[p][0] / before[p][0]);
    let (low, high) = factors.fold((f64::INFINITY, 0f64), |(low, high), f| (low.min(f), high.max(f)));
    assert!(high - low < 1e-9, "{options}: the mode keeps its shape, {low} to {high}");
    low
}

#[test]
fn modes_are_damped_by_the_factors_of_the_sheet() {
    // cos²(1/2) and 1 - (1 - λ)^m, A-03.
    let pic = 0.770151;
    let table = [
        (json!({}), 1.0),
        (json!({ "flip": 0 }), pic),
        (json!({ "flip": 0.25 }), 0.25 + 0.75 * pic),
        (json!({ "transfer": "xpic", "xpic_order": 1 }), pic),
        (json!({ "transfer": "xpic" }), 0.947170),
        (json!({ "transfer": "xpic", "xpic_order": 3 }), 1.0 - (1.0 - pic) * (1.0 - pic) * (1.0 - pic)),
        (json!({ "transfer": "xpic", "xpic_order": 20 }), 1.0),
    ];
    for (options, expected) in table {
        let found = factor(&options);
        assert!((found - expected).abs() < 2e-6, "{options}: {found}, {expected}");
    }
}

#[test]
fn extended_pic_of_order_one_is_pic() {
    for scheme in ["usf", "usl", "musl"] {
        let pic = solve(&Mpm, &spinning(&json!({ "stress_update": scheme, "flip": 0 })));
        let xpic =
            solve(&Mpm, &spinning(&json!({ "stress_update": scheme, "transfer": "xpic", "xpic_order": 1 })));
        let pairs = vectors(&pic.snapshot, "velocity").into_iter().zip(vectors(&xpic.snapshot, "velocity"));
        for (a, b) in pairs {
            assert!((a[0] - b[0]).abs() + (a[1] - b[1]).abs() < 1e-9, "{scheme}: {a:?}, {b:?}");
        }
    }
}

/// Two points in each cell of 0.1 m of a line, with opposite velocities of 1 m/s, which vanish on the grid.
fn null_space_motion(options: &Value) -> Box<dyn Solver> {
    let all = json!({ "cell_size": 0.1, "shape": "linear", "transfer": "xpic", "courant": 0.3 });
    square()
        .with(json!({
            "space": "1d", "domain": { "min": [0], "max": [1], "periodic": ["x"] }, "gravity": [0],
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0], "max": [1] },
                         "velocity": { "kind": "formula", "value": ["sin(TAU*x/0.1)"] } }],
            "stages": [{ "name": "s", "duration": 1 }],
            "methods": { "mpm": with_keys(all, options) }
        }))
        .start(&Mpm)
}

#[test]
fn null_space_velocities_decay_in_the_residual_time() {
    // For any step and scheme.
    for scheme in ["usf", "usl", "musl"] {
        for step in [1e-3, 2.5e-4] {
            for (order, transfer) in [(1, "xpic"), (2, "xpic"), (5, "xpic"), (2, "flip")] {
                let options = json!({ "residual_time": 0.05, "stress_update": scheme, "xpic_order": order, "transfer": transfer });
                let mut solver = null_space_motion(&options);
                let start = vectors(&solver.snapshot(), "velocity");
                while solver.time() < 0.1 - 1e-9 {
                    solver.step(step).unwrap();
                }
                for (v, v0) in vectors(&solver.snapshot(), "velocity").iter().zip(&start) {
                    let exact = v0[0] * (-2.0f64).exp();
                    assert!((v[0] - exact).abs() < 1e-9, "{options}, {step}: {} for {exact}", v[0]);
                }
                let grid_velocity = vectors(&solver.snapshot(), "grid_velocity");
                assert!(grid_velocity.iter().all(|v| v[0].abs() < 1e-9), "what moves them");
                assert!(solver.totals().momentum[0].abs() < 1e-12 * solver.totals().mass);
            }
        }
    }
}

#[test]
fn a_residual_time_keeps_momentum_and_nearly_all_rotation() {
    let end = |case: &Case| {
        let mut solver = start_solver(&Mpm, case);
        let before = solver.totals();
        while solver.time() < 1.0 {
            solver.step(1.0).unwrap();
        }
        (before, solver.totals())
    };
    let slow = json!({ "transfer": "xpic", "residual_time": 0.3 });
    let (before, flip) = end(&spinning(&json!({})));
    let (_, relaxed) = end(&spinning(&slow));
    let (_, same) = end(&spinning(&json!({ "residual_time": 0.3 })));
    assert_eq!(same.kinetic.to_bits(), relaxed.kinetic.to_bits(), "that of flip");
    for c in 0..2 {
        assert!((relaxed.momentum[c] - before.momentum[c]).abs() < 1e-10 * before.mass);
    }
    let turn = |budget: &Budget| budget.angular_momentum[2] / before.angular_momentum[2];
    // 1.050 and 1.026: the grid represents only part of the rotation of a block of 6 × 4 cells.
    assert!((turn(&relaxed) - turn(&flip)).abs() < 0.03, "{} for {}", turn(&relaxed), turn(&flip));
}

/// A column of sand 0.2 m × 0.2 m that collapses and comes to rest.
fn collapsed(options: &Value) -> RunReport {
    let all = json!({ "cell_size": 0.02 });
    let wall = |side: &str, kind: &str| json!({ "side": side, "wall": { "kind": kind } });
    solve(
        &Mpm,
        &read_case(&json!({
            "title": "column", "space": "plane-strain", "domain": { "min": [0, 0], "max": [1.2, 0.3] }, "gravity": [0, -9.81],
            "materials": { "m": { "model": "drucker-prager", "density": 1600, "youngs_modulus": 1e6, "poissons_ratio": 0.3,
                                  "friction_angle": 30, "matching": "plane-strain" } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [0.2, 0.2] } }],
            "boundaries": [wall("x-min", "smooth"), wall("y-min", "rough")],
            "stages": [{ "name": "s", "duration": 1.5 }],
            "methods": { "mpm": with_keys(all, options) }
        })),
    )
}

/// Most of the motion of the points of a deposit is in the null space of the grid: it decays in the residual time, and the deposit stays at
/// rest.
#[test]
fn a_deposit_comes_to_rest_with_a_residual_time() {
    let share = |report: &RunReport, field: &str| {
        let all = vectors(&report.snapshot, field);
        all.iter().filter(|v| v[0].hypot(v[1]) > 0.05).count() as f64 / all.len() as f64
    };
    let front = |report: &RunReport| {
        let mut x: Vec<f64> = report.snapshot.positions.iter().map(|x| x[0]).collect();
        x.sort_by(f64::total_cmp);
        x[x.len() * 99 / 100]
    };
    let (flip, relaxed) = (collapsed(&json!({})), collapsed(&json!({ "residual_time": 0.14 })));
    assert!(share(&flip, "velocity") > 0.05 && share(&flip, "grid_velocity") < 0.02);
    assert!(share(&relaxed, "velocity") < 0.011, "{}", share(&relaxed, "velocity"));
    // 7 % less: the velocity of a point relative to its neighbours is damped in flight.
    assert!((front(&relaxed) / front(&flip) - 1.0).abs() < 0.1, "{} {}", front(&relaxed), front(&flip));
    let is_warned = |report: &RunReport| {
        report
            .warnings_at_end
            .iter()
            .any(|remark| remark.text.contains("set methods.mpm.residual_time to about"))
    };
    assert!(
        is_warned(&flip) && !is_warned(&relaxed),
        "{:?} {:?}",
        flip.warnings_at_end,
        relaxed.warnings_at_end
    );
}

/// Two blocks of one cell that fly ahead of a heap.
#[test]
fn detached_points_cause_a_warning() {
    let block = |name: &str, min: [f64; 2], max: [f64; 2]| json!({ "name": name, "material": "m", "shape": { "kind": "box", "min": min, "max": max } });
    let heap = [
        block("heap", [0.0, 0.0], [1.0, 1.0]),
        block("near", [1.2, 0.0], [1.3, 0.1]),
        block("far", [1.8, 0.0], [1.9, 0.1]),
    ];
    let of = |count: usize| {
        square().with(json!({
            "gravity": [0, -1], "bodies": heap[..count], "boundaries": [{ "side": "y-min", "wall": { "kind": "smooth" } }],
            "stages": [{ "name": "s", "duration": 1e-3 }], "methods": { "mpm": { "cell_size": 0.1 } }
        })).solve(&Mpm)
        .warnings_at_end
        .iter().map(|warning| warning.text.clone()).collect::<String>()
    };
    assert!(!of(1).contains("detached"), "{}", of(1));
    assert!(
        of(3).contains("8 of 408 points are detached") && of(3).contains("The farthest is at [1.8"),
        "{}",
        of(3)
    );
}

/// With steps that follow the speed of sound.
#[test]
fn extended_pic_without_a_residual_time_causes_a_warning_for_many_steps() {
    let is_warned = |gravity: f64, options: Value| {
        let mut case = spinning(&with_keys(json!({ "transfer": "xpic" }), &options));
        case.gravity = vec![0.0, -gravity];
        Mpm.plan(&case)
            .unwrap()
            .warnings
            .iter()
            .map(|warning| warning.text.clone())
            .collect::<String>()
            .contains("xpic removes the motion that the grid does not represent")
    };
    assert!(
        is_warned(0.1, json!({}))
            && !is_warned(0.1, json!({ "residual_time": 1.0 }))
            && !is_warned(0.0, json!({}))
    );
    assert!(!is_warned(0.1, json!({ "transfer": "flip" })));
}

#[test]
fn higher_orders_dissipate_less() {
    let energy = |options: Value| {
        let velocities = vectors(&solve(&Mpm, &spinning(&options)).snapshot, "velocity");
        velocities.iter().map(|v| v[0] * v[0] + v[1] * v[1]).sum::<f64>()
    };
    let orders = [1, 2, 4, 8].map(|order| energy(json!({ "transfer": "xpic", "xpic_order": order })));
    assert!(orders.is_sorted(), "{orders:?}");
}

#[test]
fn affine_transfers_reproduce_an_affine_field() {
    let apic = ["quadratic", "cubic"].map(|shape| ("apic", shape));
    let tpic = ["linear", "ugimp", "cpgimp", "quadratic", "cubic"].map(|shape| ("tpic", shape));
    for (transfer, shape) in apic.into_iter().chain(tpic) {
        for scheme in ["usl", "musl"] {
            let options = json!({ "transfer": transfer, "shape": shape, "stress_update": scheme });
            let mut solver = start_solver(&Mpm, &spinning(&options));
            let before = vectors(&solver.snapshot(), "velocity");
            // No stress yet: the first step moves the points and leaves their velocities.
            solver.step(1e-4).unwrap();
            let after = vectors(&solver.snapshot(), "velocity");
            for (a, b) in before.iter().zip(&after) {
                assert!((a[0] - b[0]).abs() + (a[1] - b[1]).abs() < 1e-12, "{options}: {a:?}, {b:?}");
            }
        }
    }
}

/// The energy of a point includes that of the affine velocity within it: the gradient squared times the second moment of its functions.
#[test]
fn the_kinetic_energy_of_an_affine_field_is_that_of_the_grid() {
    let moments = [
        ("apic", "quadratic", 0.25),
        ("apic", "cubic", 1.0 / 3.0),
        ("tpic", "cubic", 1.0 / 3.0),
        ("tpic", "linear", 3.0 / 16.0),
    ];
    for (transfer, shape, moment) in moments {
        let solver = start_solver(&Mpm, &spinning(&json!({ "transfer": transfer, "shape": shape })));
        let (snapshot, found) = (solver.snapshot(), solver.totals());
        let velocity = vectors(&snapshot, "velocity");
        let motion: f64 = velocity.iter().map(|v| 0.5 * (v[0] * v[0] + v[1] * v[1])).sum();
        let gradient: f64 = [0.2, -1.0, 1.5, -0.1].iter().map(|g| g * g).sum();
        let exact = found.mass * (motion / velocity.len() as f64 + 0.5 * gradient * moment * 0.1 * 0.1);
        assert!(
            (found.kinetic / exact - 1.0).abs() < 1e-12,
            "{transfer}, {shape}: {} {exact}",
            found.kinetic
        );
        let axes: f64 =
            ["x", "y"].map(|axis| scalar_output(&*solver, &format!("kinetic_energy.{axis}"))).iter().sum();
        assert!((axes / exact - 1.0).abs() < 1e-12, "{transfer}, {shape}");
    }
}

#[test]
fn affine_pic_conserves_linear_and_angular_momentum() {
    for shape in ["quadratic", "cubic"] {
        let mut solver = start_solver(
            &Mpm,
            &spinning(&json!({ "transfer": "apic", "shape": shape, "stress_update": "usl" })),
        );
        let before = solver.totals();
        for _ in 0..300 {
            let dt = solver.limit().dt;
            solver.step(dt).unwrap();
        }
        let after = solver.totals();
        let scale = before.mass;
        let turn = (after.angular_momentum[2] - before.angular_momentum[2]).abs() / scale;
        assert!(turn < 1e-10, "{shape}: angular momentum changes by {turn} of the mass");
        for c in 0..2 {
            assert!((after.momentum[c] - before.momentum[c]).abs() < 1e-11 * scale, "{shape}");
        }
        // The same without the moment: a tenth is lost.
        let mut pic =
            start_solver(&Mpm, &spinning(&json!({ "flip": 0, "shape": shape, "stress_update": "usl" })));
        let before = pic.totals().angular_momentum[2];
        for _ in 0..300 {
            let dt = pic.limit().dt;
            pic.step(dt).unwrap();
        }
        let lost = (pic.totals().angular_momentum[2] - before).abs() / scale;
        assert!(lost > 1e3 * turn.max(1e-12), "{shape}: PIC loses {lost}");
    }
}

#[test]
fn transfers_are_the_same_on_two_threads_and_after_a_restart() {
    for (transfer, shape) in [("xpic", "ugimp"), ("apic", "cubic"), ("tpic", "cpgimp")] {
        let case = spinning(&json!({ "transfer": transfer, "shape": shape }));
        assert_same_on_threads(&Mpm, &case, &format!("{transfer}, {shape}"));
        assert_same_after_restart(&Mpm, &case, |solver| advance_steps(solver, 40));
    }
}

#[test]
fn stages_have_their_own_share_of_flip() {
    let stages = json!([{ "name": "calm", "duration": 0.1 }, { "name": "flow", "duration": 0.1 }]);
    let table = |options: Value| {
        let mut case = spinning(&options);
        case.stages = serde_json::from_value(stages.clone()).unwrap();
        case
    };
    let kinetic = |case: &Case| {
        let mut solver = start_solver(&Mpm, case);
        [0.1, 0.2].map(|end| {
            solver.begin_stage(usize::from(end > 0.1), solver.time()).unwrap();
            while solver.time() < end - 1e-12 {
                let dt = solver.limit().dt.min(end - solver.time());
                solver.step(dt).unwrap();
            }
            solver.totals().kinetic.to_bits()
        })
    };
    let own = table(json!({ "stage_flip": { "calm": 0.0 } }));
    let [calm, flow] = kinetic(&own);
    let [pic, pic_on] = kinetic(&table(json!({ "flip": 0.0 })));
    let [flip, _] = kinetic(&table(json!({})));
    assert_eq!(calm, pic, "the first stage is PIC");
    assert!(calm != flip && flow != pic_on, "the second is not");
    // The other way round, with the share of the first as that of the case.
    assert_eq!([calm, flow], kinetic(&table(json!({ "flip": 0.0, "stage_flip": { "flow": 1.0 } }))));

    // Taken up again before, at and after the change.
    let snapshots = |cut: Option<usize>| {
        let mut solver = start_solver(&Mpm, &own);
        let mut start = 0.0;
        let mut stage = 0;
        for step in 0..60 {
            if step == 30 {
                (stage, start) = (1, solver.time());
                solver.begin_stage(stage, start).unwrap();
            }
            if cut == Some(step) {
                let mut again = Mpm.build(&own).unwrap();
                again.restore(&mut solver.checkpoint_bytes().unwrap().as_slice()).unwrap();
                again.begin_stage(stage, start).unwrap();
                solver = again;
            }
            solver.step(1e-3).unwrap();
        }
        solver.snapshot().hash()
    };
    let whole = snapshots(None);
    for cut in [10, 30, 45] {
        assert_eq!(snapshots(Some(cut)), whole, "cut after {cut} steps");
    }
}

#[test]
fn transfers_that_do_not_fit_are_refused() {
    let table = [
        (json!({ "transfer": "apic", "shape": "ugimp" }), "methods.mpm.transfer"),
        (json!({ "transfer": "xpic", "xpic_order": 0 }), "methods.mpm.xpic_order"),
        (json!({ "xpic_order": 3 }), "methods.mpm.xpic_order"),
        (json!({ "transfer": "tpic", "residual_time": 3 }), "methods.mpm.residual_time"),
        (json!({ "transfer": "xpic", "residual_time": 0 }), "methods.mpm.residual_time"),
        (json!({ "transfer": "tpic", "flip": 0.5 }), "methods.mpm.flip"),
        (json!({ "transfer": "tpic", "stage_flip": { "s": 0.5 } }), "methods.mpm.stage_flip"),
        (json!({ "stage_flip": { "s": 1.5 } }), "methods.mpm.stage_flip.s"),
        (json!({ "stage_flip": { "t": 0.5 } }), "methods.mpm.stage_flip.t"),
        (json!({ "mass_scaling": 0.5 }), "methods.mpm.mass_scaling"),
    ];
    for (options, path) in table {
        let error = Mpm.plan(&spinning(&options)).unwrap_err().to_string();
        assert!(error.starts_with(path), "{options}: {error}");
    }
}

#[test]
fn local_damping_is_that_of_one_degree_of_freedom() {
    // One point in one cell, left node held: ω = √(E/ρ)/L. A-17.
    let table = [
        (0.05, 0.951190, 3.144543),
        (0.1, 0.904534, 3.153460),
        (0.5, 0.577350, 3.503991),
        (0.7, 0.420084, 4.072614),
    ];
    for (damping, ratio, half_period) in table {
        let case = square().with(json!({
            "space": "1d", "domain": { "min": [0], "max": [1] }, "gravity": [0],
            "materials": { "m": { "model": "linear-elastic", "density": 1, "youngs_modulus": 1, "poissons_ratio": 0 } },
            "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0], "max": [1] },
                         "velocity": { "kind": "uniform", "value": [1e-7] } }],
            "boundaries": [{ "side": "x-min", "wall": { "kind": "rough" } }],
            "stages": [{ "name": "s", "duration": 20, "damping": damping }],
            "methods": { "mpm": { "cell_size": 1, "points_per_cell": 1, "shape": "linear", "time_step": 1e-3 } }
        })).build();
        let mut solver = start_solver(&Mpm, &case);
        let (mut turns, mut last) = (Vec::new(), (0.0, 1e-7));
        while turns.len() < 3 {
            solver.step(1e-3).unwrap();
            let snapshot = solver.snapshot();
            let (x, v) = (vectors(&snapshot, "displacement")[0][0], vectors(&snapshot, "velocity")[0][0]);
            if v * last.1 < 0.0 {
                let share = last.1 / (last.1 - v);
                turns.push((snapshot.time - 1e-3 * (1.0 - share), last.0 + share * (x - last.0)));
            }
            last = (x, v);
        }
        let periods = [turns[1].0 - turns[0].0, turns[2].0 - turns[1].0];
        let ratios = [-turns[1].1 / turns[0].1, -turns[2].1 / turns[1].1];
        for (found, exact) in
            [(periods[0], half_period), (ratios[0], ratio), (ratios[1], ratio), (periods[1], half_period)]
        {
            assert!((found / exact - 1.0).abs() < 1e-3, "damping {damping}: {found}, {exact}");
        }
    }
}

/// A confined column that settles under its weight.
fn settling(scaling: f64, duration: f64) -> Case {
    square().with(json!({
        "domain": { "min": [0, 0], "max": [0.2, 1.2] }, "gravity": [0, -10],
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [0.2, 1] } }],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } }, { "side": "x-min", "wall": { "kind": "smooth" } },
                       { "side": "x-max", "wall": { "kind": "smooth" } }],
        "stages": [{ "name": "settle", "duration": duration, "damping": 0.7,
                     "equilibrium": { "unbalanced_force": 1e-5, "kinetic_energy": 1e-8 } }],
        "methods": { "mpm": { "cell_size": 0.1, "mass_scaling": scaling } }
    })).build()
}

#[test]
fn mass_scaling_of_100_keeps_the_static_result_with_tenfold_steps() {
    let settled = |scaling: f64| {
        let case = settling(scaling, 1000.0);
        let first = Mpm.plan(&case).unwrap().time_step.dt;
        let report = solve(&Mpm, &case);
        let moved = vectors(&report.snapshot, "displacement");
        (first, moved.iter().map(|u| u[1]).fold(0.0, f64::min))
    };
    let ((dt, plain), (long, scaled)) = (settled(1.0), settled(100.0));
    assert!((long / dt - 10.0).abs() < 1e-9, "steps {dt}, {long}");
    assert!((scaled / plain - 1.0).abs() < 1e-3, "settlements {plain}, {scaled}");
}

#[test]
fn a_stage_without_equilibrium_within_its_duration_fails() {
    let case = settling(1.0, 0.05);
    let error = run(&case, Mpm.build(&case).unwrap(), &RunOptions::default()).unwrap_err().to_string();
    assert!(error.contains("no equilibrium"), "{error}");
}
