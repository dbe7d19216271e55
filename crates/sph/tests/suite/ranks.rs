//! Solver in ranks: bitwise equal results with any number of ranks (sheet: sph §3.9, V-26).

use colluvium_case::{Case, Method, Snapshot, Solver};
use colluvium_sph::Sph;
use colluvium_testkit::{advance_steps, case_with, scalars, start_solver, with_keys};
use serde_json::{Value, json};

/// Heap thrown along a rough floor against a smooth wall, so long that some ranks are not neighbours.
fn heap(options: &Value, more: &Value) -> Case {
    let mut methods = json!({ "spacing": 0.025 });
    for (key, value) in options.as_object().unwrap() {
        methods[key] = value.clone();
    }
    let case = json!({
        "title": "heap", "space": "plane-strain", "domain": { "min": [0, 0], "max": [1.5, 1] }, "gravity": [0, -10],
        "materials": { "m": {
            "model": "drucker-prager", "density": 1000, "youngs_modulus": 1e5, "poissons_ratio": 0.3,
            "friction_angle": 20, "cohesion": 500
        } },
        "bodies": [
            { "name": "lower", "material": "m", "shape": { "kind": "box", "min": [0, 0], "max": [1, 0.1] },
              "velocity": { "kind": "uniform", "value": [-0.3, 0] } },
            { "name": "upper", "material": "m", "shape": { "kind": "box", "min": [0.2, 0.1], "max": [0.6, 0.2] },
              "velocity": { "kind": "uniform", "value": [2, 0] } }
        ],
        "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } }, { "side": "x-min", "wall": { "kind": "smooth" } }],
        "stages": [{ "name": "s", "duration": 1 }],
        "methods": { "sph": methods }
    });
    case_with(case, more)
}

/// Solver of the case in ranks.
fn in_ranks(case: &Case, ranks: u32) -> Box<dyn Solver> {
    let mut case = case.clone();
    case.methods.get_mut("sph").unwrap()["ranks"] = json!(ranks);
    start_solver(&Sph, &case)
}

/// Snapshot without the field of ranks.
fn plain(solver: &dyn Solver) -> Snapshot {
    let mut snapshot = solver.snapshot();
    snapshot.fields.retain(|field| field.name != "rank");
    snapshot
}

fn every_number_agrees(case: &Case, steps: usize, name: &str) {
    let mut alone = start_solver(&Sph, case);
    advance_steps(&mut *alone, steps);
    let expected = plain(&*alone);
    for ranks in [2, 8] {
        let mut solver = in_ranks(case, ranks);
        advance_steps(&mut *solver, steps);
        let found = plain(&*solver);
        assert_eq!(found.positions, expected.positions, "{name}, {ranks} ranks");
        assert_eq!(found.hash(), expected.hash(), "{name}, {ranks} ranks");
        assert_eq!(
            solver.checkpoint_bytes().unwrap(),
            alone.checkpoint_bytes().unwrap(),
            "{name}, {ranks} ranks"
        );
    }
}

/// Returns the solver without ranks after ninety steps; asserts that restarts with another number of ranks reach the same state.
fn restarts_agree(case: &Case, name: &str) -> Box<dyn Solver> {
    let mut whole = start_solver(&Sph, case);
    advance_steps(&mut *whole, 90);
    for (before, after) in [(3, 1), (1, 3), (3, 2)] {
        let mut first = in_ranks(case, before);
        advance_steps(&mut *first, 53);
        let mut then = in_ranks(case, after);
        then.restore(&mut first.checkpoint_bytes().unwrap().as_slice()).unwrap();
        then.begin_stage(0, 0.0).unwrap();
        advance_steps(&mut *then, 37);
        assert_eq!(plain(&*then).hash(), plain(&*whole).hash(), "{name}: {before} ranks, then {after}");
        assert_eq!(
            then.checkpoint_bytes().unwrap(),
            whole.checkpoint_bytes().unwrap(),
            "{name}: {before} ranks, then {after}"
        );
    }
    whole
}

#[test]
fn v26_results_are_bit_identical_in_any_number_of_ranks() {
    for options in [
        json!({}),
        json!({ "momentum": "rho-rho", "continuity": "volume", "velocity_gradient": "corrected",
                "regularisation": "mls", "tensile": { "kind": "artificial-stress", "strength": 0.5, "exponent": 2.55 } }),
        json!({ "kernel": "wendland-c2", "smoothing": 1.5, "wall_stress": "extrapolated", "regularisation": "shepard",
                "damping": 0.01, "sound_speed": "youngs-modulus" }),
        json!({ "smoothing_length": "density", "symmetrisation": "grad-h", "xsph": 0.3,
                "tensile": { "kind": "artificial-stress", "strength": 0.5, "exponent": 2.55 } }),
        json!({ "smoothing_length": "rate", "symmetrisation": "harmonic", "shifting": 0.5, "wall_guard": 0.01 }),
        json!({ "shifting": 0.5, "wall_stress": "interpolated" }),
        json!({ "rough_wall": "mirror", "velocity_gradient": "corrected", "hourglass_viscosity": 0.5 }),
        json!({ "momentum": "rho-rho", "confining": { "pressure": 100 } }),
        json!({ "smooth_wall": "particles", "wall_velocity": "linear", "stress_diffusion": 0.1 }),
        json!({ "continuity": "summation", "allow_summation": true }),
        json!({ "momentum": "corrected", "tensile": { "kind": "artificial-pressure", "strength": 0.5, "exponent": 4 } }),
    ] {
        every_number_agrees(&heap(&options, &json!({})), 50, &options.to_string());
    }
}

#[test]
fn equilibrium_ratios_are_equal_in_any_number_of_ranks() {
    let settling = json!({ "stages": [{ "name": "s", "duration": 1, "equilibrium": {} }] });
    for options in [json!({}), json!({ "momentum": "rho-rho", "confining": { "pressure": 100 } })] {
        every_number_agrees(&heap(&options, &settling), 60, &format!("at rest, {options}"));
    }
}

/// Periodic domain.
fn periodic() -> Value {
    json!({
        "domain": { "min": [0, 0], "max": [1, 1], "periodic": ["x"] },
        "boundaries": [{ "side": "y-min", "wall": { "kind": "rough" } }]
    })
}

#[test]
fn ranks_exchange_particles_across_periodic_boundaries() {
    for options in [
        json!({}),
        json!({ "momentum": "rho-rho", "confining": { "pressure": 100 } }),
        json!({ "regularisation": "mls", "regularisation_steps": 3, "wall_stress": "extrapolated",
                "velocity_gradient": "corrected", "hourglass_viscosity": 0.5 }),
    ] {
        every_number_agrees(&heap(&options, &periodic()), 60, &format!("periodic, {options}"));
    }
}

/// Floor and wall move back and forth, with corners of the factors within steps.
#[test]
fn walls_of_varying_velocity_are_bit_identical_in_ranks_and_after_a_restart() {
    let floor = |wall: Value| {
        json!({ "boundaries": [
            { "side": "y-min", "wall": wall, "velocity": [0.4, 0.2] },
            { "side": "x-min", "wall": { "kind": "smooth" }, "velocity": [0.5, 0] }
        ] })
    };
    let (rough, rubbing) =
        (json!({ "kind": "rough" }), json!({ "kind": "frictional", "friction_coefficient": 0.3 }));
    for (wall, options) in [
        (&rough, json!({})),
        (&rough, json!({ "wall_velocity": "linear", "smooth_wall": "particles" })),
        (&rough, json!({ "rough_wall": "mirror", "hourglass_viscosity": 0.5 })),
        (&rough, json!({ "wall_stress": "interpolated", "shifting": 0.5 })),
        (&rough, json!({ "wall_stress": "extrapolated" })),
        (&rubbing, json!({})),
    ] {
        let mut options = options;
        options["wall_history"] = json!({
            "y-min": { "times": [0.0003, 0.0101, 0.0207], "factors": [-0.5, 1, 0] },
            "x-min": { "times": [0, 0.0151, 0.0302], "factors": [1, -1, 2] }
        });
        let case = heap(&options, &floor(wall.clone()));
        every_number_agrees(&case, 120, &format!("{wall}, {options}"));
        let mut whole = start_solver(&Sph, &case);
        advance_steps(&mut *whole, 57);
        let mut again = start_solver(&Sph, &case);
        again.restore(&mut whole.checkpoint_bytes().unwrap().as_slice()).unwrap();
        again.begin_stage(0, 0.0).unwrap();
        for solver in [&mut whole, &mut again] {
            advance_steps(&mut **solver, 60);
        }
        assert_eq!(whole.checkpoint_bytes().unwrap(), again.checkpoint_bytes().unwrap(), "{wall}, {options}");
        // Their velocities are neither zero nor constant.
        let constant = heap(&json!({}), &floor(wall.clone()));
        let mut constant = start_solver(&Sph, &constant);
        advance_steps(&mut *constant, 117);
        assert_ne!(whole.snapshot().positions, constant.snapshot().positions);
    }
}

#[test]
fn ranks_slip_along_smooth_bodies() {
    let options = json!({ "held": ["upper"], "smooth_bodies": ["upper"], "xsph": 0.2, "hourglass_viscosity": 0.5,
                          "momentum": "corrected" });
    every_number_agrees(&heap(&options, &periodic()), 60, "smooth");
}

#[test]
fn ranks_partition_domains_in_one_and_three_dimensions() {
    let line = json!({
        "space": "1d", "domain": { "min": [0], "max": [10] }, "gravity": [0],
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [1], "max": [3] },
                     "velocity": { "kind": "sine", "amplitude": [0.1], "wave_vector": [3] } }],
        "boundaries": []
    });
    every_number_agrees(&heap(&json!({}), &line), 100, "1d");
    let space = json!({
        "space": "3d", "domain": { "min": [0, 0, 0], "max": [1, 1, 1] }, "gravity": [0, -10, 0],
        "bodies": [{ "name": "b", "material": "m", "shape": { "kind": "box", "min": [0, 0, 0], "max": [0.6, 0.1, 0.15] },
                     "velocity": { "kind": "uniform", "value": [1, 0, 0.3] } }]
    });
    every_number_agrees(&heap(&json!({}), &space), 60, "3d");
}

#[test]
fn particles_migrate_and_ranks_stay_balanced() {
    let case = heap(&json!({}), &json!({}));
    let (mut whole, mut solver) = (start_solver(&Sph, &case), in_ranks(&case, 4));
    advance_steps(&mut *whole, 200);
    let owners = |solver: &dyn Solver| scalars(&solver.snapshot(), "rank");
    advance_steps(&mut *solver, 1);
    let first = owners(&*solver);
    advance_steps(&mut *solver, 199);
    let last = owners(&*solver);
    assert_ne!(first, last);
    let held = (0..4).map(|rank| last.iter().filter(|owner| **owner == f64::from(rank)).count());
    let (smallest, largest) = held.fold((usize::MAX, 0), |(a, b), count| (a.min(count), b.max(count)));
    assert!(largest as f64 <= 1.35 * smallest as f64, "{smallest} to {largest} particles");
    assert_eq!(plain(&*whole).hash(), plain(&*solver).hash());
}

#[test]
fn checkpoints_continue_bit_identically_with_any_number_of_ranks() {
    let options =
        json!({ "hourglass_viscosity": 0.2, "regularisation": "shepard", "wall_stress": "interpolated" });
    restarts_agree(&heap(&options, &periodic()), &options.to_string());
}

#[test]
fn ranks_follow_stages_and_equilibrium() {
    let stages = json!([
        { "name": "settle", "duration": 0.05, "damping": 0.5, "equilibrium": { "unbalanced_force": 1e-9, "kinetic_energy": 1e-9 },
          "reset": ["velocity", "displacement", "state"] },
        { "name": "go", "duration": 0.03, "remove_bodies": ["upper"] }
    ]);
    let case = heap(&json!({}), &json!({ "stages": stages }));
    let run = |ranks: u32| {
        let mut solver = in_ranks(&case, ranks);
        advance_steps(&mut *solver, 100);
        let apart = solver.equilibrium().unwrap();
        solver.end_stage(&case.stages[0]).unwrap();
        let time = solver.time();
        solver.begin_stage(1, time).unwrap();
        advance_steps(&mut *solver, 50);
        (plain(&*solver).hash(), solver.totals(), solver.point_count(), apart)
    };
    let (alone, ranked) = (run(1), run(3));
    assert_eq!((alone.0, alone.1, alone.2), (ranked.0, ranked.1, ranked.2));
    // Sums over ranks have another order.
    let [a, b] = [alone.3, ranked.3].map(|apart| [apart.unbalanced_force, apart.kinetic_ratio]);
    a.iter().zip(b).for_each(|(a, b)| assert!((a - b).abs() <= 1e-12 * a.abs(), "{a} {b}"));
}

#[test]
fn ranks_are_the_same_on_one_and_two_threads() {
    let case = heap(&json!({}), &json!({}));
    let hash = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut solver = in_ranks(&case, 3);
            advance_steps(&mut *solver, 80);
            solver.snapshot().hash()
        })
    };
    assert_eq!(hash(1), hash(2));
}

#[test]
fn more_ranks_than_particles_are_refused() {
    let case = heap(&json!({ "ranks": 300, "spacing": 0.05 }), &json!({}));
    let error = Sph.plan(&case).unwrap_err().to_string();
    assert!(error.starts_with("methods.sph.ranks: "), "{error}");
}

#[test]
fn obstacle_reactions_and_energies_are_equal_in_any_number_of_ranks() {
    let wall = json!({ "kind": "frictional", "friction_coefficient": 0.4 });
    let ground = json!({ "boundaries": [], "obstacles": [
            { "name": "ground", "wall": wall,
              "shape": { "kind": "ground-line", "points": [[-1, 0.6], [0, 0], [1, 0], [3, 0.2]] } },
            { "name": "gate", "wall": { "kind": "smooth" }, "motion": { "velocity": [-0.5, 0] },
              "shape": { "kind": "box", "min": [1.02, 0.01], "max": [1.1, 0.5] } }
        ],
        "measures": {
            "on_ground": { "kind": "reaction", "target": "ground" },
            "on_gate": { "kind": "reaction", "target": "gate", "about": [1.1, 0] }
        },
        "domain": { "min": [-1, -1], "max": [2, 1] } });
    let case = heap(&json!({}), &ground);
    every_number_agrees(&case, 80, "obstacles");
    // Checkpoints contain the reactions and energies of obstacles.
    let whole = restarts_agree(&case, "obstacles");
    let ranked = {
        let mut solver = in_ranks(&case, 3);
        advance_steps(&mut *solver, 90);
        solver
    };
    for name in ["ground", "gate"] {
        let reaction_of = |solver: &dyn Solver| {
            let reaction = solver.reaction(name).expect("it is measured");
            (reaction.force, reaction.impulse, reaction.moment)
        };
        assert_eq!(reaction_of(&*ranked), reaction_of(&*whole), "{name}");
        assert!(reaction_of(&*whole).1.iter().any(|p| *p != 0.0), "{name} has a reaction");
    }
}

/// A load of constant direction, a follower load on a surface whose parts move between ranks, and one that begins later.
#[test]
fn loads_are_the_same_in_ranks_and_after_a_restart() {
    let loads = json!({ "loads": [
        { "kind": "traction", "body": "upper", "side": "y-max", "value": [400, -200], "ramp": 0.02 },
        { "kind": "surface", "body": "upper", "pressure": 300, "shear": 50 },
        { "kind": "pressure", "body": "lower", "side": "x-max", "value": 500, "ramp": 0.01 }
    ] });
    for options in [
        json!({}),
        json!({ "momentum": "rho-rho", "continuity": "volume", "velocity_gradient": "corrected", "hourglass_viscosity": 0.5 }),
        json!({ "momentum": "rho-rho", "confining": { "pressure": 100 }, "xsph": 0.3 }),
    ] {
        let case = heap(&options, &loads);
        every_number_agrees(&case, 60, &format!("loads, {options}"));
        let whole = restarts_agree(&case, &format!("loads, {options}"));
        let mut without = start_solver(&Sph, &heap(&options, &json!({})));
        advance_steps(&mut *without, 90);
        assert_ne!(whole.snapshot().positions, without.snapshot().positions, "they act");
    }
    let mut later = loads.clone();
    later["loads"][2]["stage"] = json!("go");
    later["stages"] = json!([{ "name": "s", "duration": 1 }, { "name": "go", "duration": 1 }]);
    let case = heap(&json!({}), &later);
    let staged = |ranks: u32| {
        let mut solver = in_ranks(&case, ranks);
        advance_steps(&mut *solver, 50);
        solver.end_stage(&case.stages[0]).unwrap();
        let time = solver.time();
        solver.begin_stage(1, time).unwrap();
        advance_steps(&mut *solver, 50);
        solver.checkpoint_bytes().unwrap()
    };
    assert_eq!(staged(1), staged(3));
    // Forces on the particles of a rank count towards equilibrium.
    let settling =
        with_keys(loads, &json!({ "stages": [{ "name": "s", "duration": 1, "equilibrium": {} }] }));
    every_number_agrees(&heap(&json!({}), &settling), 60, "loads, equilibrium");
}
